#![allow(missing_docs)]
use model_core::{discretise::*, equilibrium::*, object::*, size::*};
use reference_tests::*;
fn main() {
    let n: u8 = std::env::args().nth(1).map_or(4, |s| s.parse().unwrap());
    let ph = if std::env::args().nth(2).as_deref() == Some("ext") { Physics::Extended } else { Physics::Paper };
    let mut f = Box::new(Follower::<f32, Reduced>::EMPTY);
    let d = ladder_80();
    f.configure(&d, &Discretisation { sampling: Sampling::PerElement(n), ..Discretisation::reduced(ph) }).unwrap();
    f.set_object(circle_80(45.0), Motion::Rotating { axis: d.motor_axis });
    f.start(0.0);
    let mut it = 0;
    let mut ticks = 0;
    for c in (0..=125).chain((1..125).rev()) {
        let o = f.follow(c as f64 * COUNT);
        it += o.iterations;
        ticks += 1;
    }
    println!("{ticks} ticks {it} iterations");
}
