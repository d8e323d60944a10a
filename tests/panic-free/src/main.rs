//! Two fingers' estimators with friction, from a design to the balance of a free object between them and their shapes, and the bus as a master, a device and a
//! listener see it, and one finger's state machines; nothing else. If the linker keeps a panic handler, there is a way to it.

#![no_std]
#![no_main]

mod bus;
mod finger;

use core::hint::black_box;

use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Settings;
use model_core::estimator::{Estimator, EstimatorSettings};
use model_core::grasp::{Course, Grasp, Held, Load, Place, Survey, touches};
use model_core::object::ObjectDesign;
use model_core::size::Rubbing;
use model_core::uncertainty::Uncertainty;

type Fingers = [Estimator<f32, Rubbing>; 2];

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut FINGERS: Fingers = [const { Estimator::EMPTY }; 2];
    // The optimiser knows neither what the estimators were told before nor what becomes of what they say.
    let fingers = black_box(&mut *FINGERS);
    let (mut bus, mut finger) = (bus::Bus::new(), finger::Finger::new());
    loop {
        bus.run();
        finger.run();
        set(fingers);
        tick(fingers);
        balance(fingers);
        bears(fingers);
        shapes(fingers);
    }
}

/// What a gripper does when its settings change.
fn set(fingers: &mut Fingers) {
    static DESIGN: Option<Design> = None;
    let Some(design) = black_box(&DESIGN) else { return };
    for estimator in fingers {
        let how = black_box(Discretisation::estimator(Physics::Extended));
        black_box(estimator.configure(design, &how).is_ok());
        let object = black_box(ObjectDesign::Circle { centre: [0.0; 2], radius: 1.0 });
        black_box(estimator.set_object(object).is_ok());
        black_box(estimator.set_friction(black_box(0.5)).is_ok());
        let _ = black_box(estimator.set_settings(black_box(EstimatorSettings::DEFAULT), black_box(Settings::DEFAULT)));
        black_box(estimator.set_uncertainty(black_box(Uncertainty::DEFAULT)).is_ok());
        black_box(estimator.set_prony(black_box(&[[0.1, 1.0], [0.1, 100.0]])).is_ok());
    }
}

/// What it does in every period of its control loop.
fn tick(fingers: &mut Fingers) {
    for estimator in fingers {
        estimator.set_budget(black_box(3));
        let estimate = estimator.update_after(black_box(0.0), black_box(0.002));
        #[cfg(feature = "can-panic")]
        black_box([0.0, 1.0][usize::from(black_box(estimate.iterations))]);
        black_box(estimate);
        black_box(estimator.go_on(black_box(0.0)));
        black_box(estimator.head_for(black_box(0.0)));
        estimator.forget_path();
    }
}

/// What it does as well where the object is free.
fn balance(fingers: &mut Fingers) {
    let held = fingers.iter_mut().filter_map(|estimator| {
        let object = *estimator.object()?;
        Some(Held { follower: estimator.follower_mut(), mirrored: black_box(false), object })
    });
    let Ok(grasp) = Grasp::resume(held, black_box(Load::default()), black_box(Place::default())) else { return };
    let mut grasp = grasp.with_course(black_box(Course::default()));
    black_box(grasp.release_within(black_box(3)));
    black_box(grasp.advance_within(black_box(&[0.1; 2]), black_box(3)).is_ok());
    black_box(grasp.course());
    let place = black_box(grasp.place());
    drop(grasp);
    for estimator in fingers {
        black_box(estimator.object().map(|object| place.seen(object, black_box(true))));
        black_box(estimator.reread());
    }
}

/// What it finds that their contacts bear.
fn bears(fingers: &Fingers) {
    let mut survey = Survey::<32>::new();
    survey.begin(black_box(1.0), black_box(None));
    for (number, estimator) in fingers.iter().enumerate() {
        let follower = estimator.follower();
        let places = touches(follower, number, black_box(false), black_box([0.0; 2]), black_box(1.0));
        black_box(survey.take_places(places));
    }
    while !black_box(survey.is_idle()) {
        black_box((survey.step(), survey.load()));
    }
}

/// What it tells of the deformed fingers.
fn shapes(fingers: &Fingers) {
    for estimator in fingers {
        let solution = estimator.follower().solution();
        for point in solution.front().chain(solution.back()).chain(solution.lamellae().flatten()) {
            black_box(point);
        }
        for contact in solution.contacts() {
            black_box(contact);
        }
        black_box(solution.coordinate());
    }
}

/// `cargo xtask test` fails if this is in the image.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
