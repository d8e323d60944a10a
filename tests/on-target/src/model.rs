//! The model on the target: the reference rows, the sweep that must equal the PC's, and the solver's hard cases.

#[embedded_test::tests(executor = mps2::Executor::new())]
mod tests {
    use crate::sweep::{self, CASES, Case, closing_and_opening};
    use model_core::design::{Design, DesignError, Profile};
    use model_core::discretise::{Discretisation, DiscretiseError, Physics, Sampling};
    use model_core::equilibrium::Follower;
    use model_core::estimator::Estimator;
    use model_core::object::Motion;
    use model_core::real::Real;
    use model_core::size::{Paper, Reduced, Ribs, Rubbing, Size};
    use model_core::status::Status;
    use mps2::Board;
    use reference_tests::closing::{Closing, LADDER, RIBS_7, UMI};
    use reference_tests::{LadderRow, fea_80, fea_rows, ladder_80, ladder_rows};
    use static_cell::ConstStaticCell;

    include!(concat!(env!("OUT_DIR"), "/on_the_pc.rs"));

    static ESTIMATOR: ConstStaticCell<Estimator<f32, Reduced>> = ConstStaticCell::new(Estimator::EMPTY);
    static RUBBING: ConstStaticCell<Estimator<f32, Rubbing>> = ConstStaticCell::new(Estimator::EMPTY);
    static FULL: ConstStaticCell<Follower<f32, Paper>> = ConstStaticCell::new(Follower::EMPTY);
    static REDUCED: ConstStaticCell<Follower<f32, Reduced>> = ConstStaticCell::new(Follower::EMPTY);
    static RIBS: ConstStaticCell<Follower<f32, Ribs>> = ConstStaticCell::new(Follower::EMPTY);
    static DOUBLE: ConstStaticCell<Follower<f64, Reduced>> = ConstStaticCell::new(Follower::EMPTY);

    #[init]
    fn init() -> Board {
        mps2::init()
    }

    /// Solves a row of `ladder-80.csv` and checks force and tip.
    fn check<T: Real, S: Size>(follower: &mut Follower<T, S>, row: &LadderRow, force_within: f64, tip_within: f64) {
        let design = ladder_80();
        assert!(follower.configure(&design, &row.discretisation()).is_ok());
        follower.set_object(row.object(), Motion::Rotating { axis: design.motor_axis });
        assert!(follower.start(0.0));
        let outcome = follower.follow(row.angle.to_radians());
        assert!(outcome.status == Status::Converged, "{} {}: {}", row.scheme, row.case, outcome.status);
        for i in 0..2 {
            let off = follower.solution().force_world()[i].to_f64() - row.force_world[i];
            assert!(off.abs() < force_within, "{} {}: force off by {off} N", row.scheme, row.case);
            let off = follower.solution().tip()[i].to_f64() - row.tip[i];
            assert!(off.abs() < tip_within, "{} {}: tip off by {off} mm", row.scheme, row.case);
        }
        // Neighbouring nodes without softness share a force in many ways: single precision may pick another set.
        if row.scheme.starts_with("SIMPSON") {
            assert!(
                follower.solution().contacts().count() == row.active_contacts,
                "{} {}: contacts",
                row.scheme,
                row.case
            );
        }
    }

    #[test]
    fn reduced_rows_in_single_precision(_board: Board) {
        let follower = REDUCED.take();
        let rows = ladder_rows().filter(|row| row.scheme.starts_with("SIMPSON"));
        assert!(rows.map(|row| check(follower, &row, 2e-3, 2e-4)).count() == 12);
    }

    #[test]
    fn full_resolution_rows_in_single_precision(_board: Board) {
        let follower = FULL.take();
        let rows = ladder_rows().filter(|row| row.scheme.ends_with("170-20-nodes"));
        assert!(rows.map(|row| check(follower, &row, 1e-2, 1e-3)).count() == 12);
    }

    /// Force and front centreline of the reduced model with the extended physics against finite elements (mesh error 1 %).
    #[test]
    #[timeout(120)]
    fn finite_elements_in_single_precision(_board: Board) {
        let (follower, design) = (REDUCED.take(), fea_80());
        let mut series = "";
        let mut compared = 0;
        for row in fea_rows() {
            let Some((force_within, shape_within)) = row.allowed() else { continue };
            if series != row.series {
                series = row.series;
                assert!(follower.configure(&design, &Discretisation::estimator(Physics::Extended)).is_ok());
                follower.set_object(row.object(), Motion::Rotating { axis: design.motor_axis });
                assert!(follower.start(0.0));
            }
            assert!(follower.follow(row.degrees.to_radians()).status == Status::Converged);
            let [x, y] = follower.solution().force_finger().map(f64::from);
            let error = (x * x + y * y) / (row.force * row.force) - 1.0;
            assert!(0.5 * error.abs() < force_within, "{} {}°: force off by half of {error}", row.series, row.degrees);
            let shape = row.off(|| follower.solution().front().map(|p| p.map(f64::from)));
            assert!(shape < shape_within, "{} {}°: shape off by {shape} mm", row.series, row.degrees);
            compared += 1;
        }
        assert!(compared == 19);
    }

    #[test]
    #[timeout(120)]
    fn reduced_rows_in_double_precision(_board: Board) {
        let follower = DOUBLE.take();
        let rows = ladder_rows().filter(|row| row.scheme.starts_with("SIMPSON") && row.case == "R40-Mid");
        assert!(rows.map(|row| check(follower, &row, 1e-7, 1e-7)).count() == 2);
    }

    /// τ = d(V + ½ ε Σμ²)/dα, by a difference of fourth order: forces, torque and energy belong together on the target too.
    #[test]
    #[timeout(120)]
    fn the_torque_is_the_derivative_of_the_potential(_board: Board) {
        let (follower, design) = (DOUBLE.take(), ladder_80());
        for physics in [Physics::Paper, Physics::Extended] {
            let how = Discretisation::reduced(physics);
            assert!(follower.configure(&design, &how).is_ok());
            follower.set_object(reference_tests::circle_80(45.0), Motion::Rotating { axis: design.motor_axis });
            assert!(follower.start(0.0));
            let (angle, h) = (5.3_f64.to_radians(), 0.002_f64.to_radians());
            assert!(follower.follow(angle).status == Status::Converged);
            let torque = follower.solution().motor_torque();
            let mut potential = |by: f64| {
                assert!(follower.follow(angle + by).status == Status::Converged);
                follower.solution().energy()
                    + follower.solution().contacts().map(|c| 0.5 * follower.softness() * c.force * c.force).sum::<f64>()
            };
            let (near, far) = (potential(h) - potential(-h), potential(2.0 * h) - potential(-2.0 * h));
            let rate = (8.0 * near - far) / (12.0 * h);
            assert!((rate / torque - 1.0).abs() < 1e-6, "{rate} and {torque}");
        }
    }

    #[test]
    #[timeout(120)]
    fn closing_and_opening_equals_the_pc_bit_for_bit(_board: Board) {
        let estimator = ESTIMATOR.take();
        let mut expected = ON_THE_PC.iter();
        for physics in [Physics::Paper, Physics::Extended] {
            for height in sweep::HEIGHTS {
                let mut digest = sweep::DIGEST;
                let lost = closing_and_opening(estimator, physics, height, |numbers| {
                    digest = numbers.into_iter().fold(digest, sweep::mix);
                });
                assert!(lost == 0, "{height} mm: {lost} ticks without a trustworthy estimate");
                assert!(expected.next() == Some(&(digest, lost)), "{height} mm: not the PC's result");
            }
        }
    }

    /// Stated cost of a tick of the campaign by case, instructions: mean in contact and most of all (docs/real-time.md). The count depends
    /// on the compiler a little, on the change a lot.
    const STATED: [(u32, u32); 5] =
        [(50_000, 203_000), (57_000, 245_000), (60_000, 248_000), (122_000, 384_000), (157_000, 679_000)];
    const INSTRUCTIONS_PER_TICK: u32 = 10;

    /// What a case costs in the campaign, and that its forces are those of the PC bit for bit.
    fn costs<S: Size>(estimator: &mut Estimator<f32, S>, case: &Case, expected: u64, [mean, most]: [u32; 2]) {
        let (mut digest, mut sum, mut count, mut worst) = (sweep::DIGEST, 0_u64, 0_u64, 0);
        let sound = sweep::campaign(
            estimator,
            case,
            |work| mps2::cycles::of(work).1 * INSTRUCTIONS_PER_TICK,
            |numbers, touches, cost| {
                digest = numbers.into_iter().fold(digest, sweep::mix);
                worst = cost.max(worst);
                if touches {
                    (sum, count) = (sum + u64::from(cost), count + 1);
                }
            },
        );
        let Case { samples, friction, .. } = case;
        assert!(sound && count > 1000, "{samples} samples, friction {friction}: {count} ticks in contact");
        assert!(digest == expected, "{samples} samples, friction {friction}: not the PC's result");
        let found = (sum / count) as u32;
        defmt::println!(
            "{} samples, friction {}: {} instructions in contact, {} at most",
            samples,
            friction,
            found,
            worst
        );
        assert!(found <= mean + mean / 10, "{samples} samples: {found} instructions on average, stated are {mean}");
        assert!(worst <= most + most / 10, "{samples} samples: {worst} instructions at most, stated are {most}");
    }

    /// What a tick costs, whatever happens to the finger.
    #[test]
    #[timeout(240)]
    fn a_tick_costs_no_more_than_stated(_board: Board) {
        let (estimator, rubbing) = (ESTIMATOR.take(), RUBBING.take());
        for ((case, expected), (mean, most)) in CASES.iter().zip(CAMPAIGN_ON_THE_PC).zip(STATED) {
            if case.friction > 0.0 {
                costs(rubbing, case, expected, [mean, most]);
            } else {
                costs(estimator, case, expected, [mean, most]);
            }
        }
    }

    /// Instructions of a count in contact of a closing and opening finger, mean.
    fn per_count<S: Size>(follower: &mut Follower<f32, S>, closing: &Closing, samples: u8) -> u32 {
        let design = (closing.design)();
        let sampling = Sampling::PerElement(samples);
        let how = Discretisation { sampling, ..Discretisation::reduced(Physics::Extended) };
        assert!(follower.configure(&design, &how).is_ok());
        follower.set_object((closing.object)(), closing.motion(&design));
        assert!(follower.start(0.0));
        let (mut sum, mut count) = (0_u64, 0);
        for position in Closing::ticks(closing.count) {
            let coordinate = f64::from(position) * closing.count.0;
            let (outcome, cycles) = mps2::cycles::of(|| follower.follow(coordinate));
            assert!(outcome.status.is_trustworthy(), "{} at {position}: {}", closing.case, outcome.status);
            if follower.solution().touching() > 0 {
                (sum, count) = (sum + u64::from(cycles * INSTRUCTIONS_PER_TICK), count + 1);
            }
        }
        assert!(count > 200, "{}: {count} counts in contact", closing.case);
        let mean = (sum / count) as u32;
        defmt::println!("{}, {} samples: {} instructions a count", closing.case, samples, mean);
        mean
    }

    /// Ribs that bend: seven at most 1.3 times the hinged finger, a printed finger with fifteen within its bounds (docs/cost.md).
    #[test]
    #[timeout(240)]
    fn ribs_cost_no_more_than_stated(_board: Board) {
        let (hinged, ribs) = (REDUCED.take(), RIBS.take());
        for (samples, most) in [(2, 250_000), (5, 280_000)] {
            let (seven, without) = (per_count(ribs, &RIBS_7, samples), per_count(hinged, &LADDER, samples));
            assert!(seven <= without + without / 10 * 3, "{samples} samples: {seven} and {without}");
            let umi = per_count(ribs, &UMI, samples);
            assert!(umi <= most, "{samples} samples: {umi}");
        }
    }

    #[test]
    fn refusals_and_honest_statuses(_board: Board) {
        let estimator = ESTIMATOR.take();
        assert!(estimator.update(0.1).status == Status::OutOfRange, "no finger yet");
        let refused = |change: &dyn Fn(&mut Design)| {
            let mut design = ladder_80();
            change(&mut design);
            REDUCED_DISCRETISATION.with(&design)
        };
        assert!(refused(&|d| d.front.thickness = Profile::constant(-1.0)));
        assert!(refused(&|d| d.material.youngs_modulus = f64::NAN));
        assert!(refused(&|d| d.hinge.length.clear()));
        assert!(estimator.configure(&ladder_80(), &Discretisation::reduced(Physics::Paper)).is_ok());
        assert!(estimator.update(0.1).status == Status::OutOfRange, "no object yet");
        assert!(estimator.set_object(reference_tests::circle_80(45.0)).is_ok());
        assert!(estimator.update(-0.1).status == Status::NoContact);
        assert!(estimator.update(f64::NAN).status == Status::OutOfRange);
        assert!(estimator.update(3.0).status == Status::OutOfRange);
        // From one open hand to another, however far, costs no more than a tick.
        assert!(estimator.update(-1.2).status == Status::NoContact);
        assert!(estimator.update(-0.1).status == Status::NoContact);
        // A jump of 10° cannot be followed in one tick's iterations: the estimate says so, and catches up.
        let jumped = estimator.update(0.17);
        assert!(!jumped.status.is_trustworthy() && jumped.age > 0);
        let mut ticks = 0;
        while !estimator.update(0.17).status.is_trustworthy() {
            ticks += 1;
            assert!(ticks < 50, "never caught up");
        }
    }

    /// A design is refused with an error of its own.
    struct Refused;
    const REDUCED_DISCRETISATION: Refused = Refused;
    impl Refused {
        fn with(&self, design: &Design) -> bool {
            let error: Result<(), DesignError> = design.validate();
            error.is_err_and(|error| DiscretiseError::from(error) != DiscretiseError::Capacity)
        }
    }
}
