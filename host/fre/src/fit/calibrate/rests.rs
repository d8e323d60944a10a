//! Readings of a motor that rests share one error of the angle, and so do a force and a torque that are read together.
//!
//! Along the times of a material with memory many readings belong to one angle. Its error is one unknown δ more, in standard deviations of
//! the angle, which a row of its own holds near 0. It is eliminated from the normal equations (a Schur complement), so that the
//! parameters' deviations have it in them. Taken as an error of each reading it would seem to average out.
//!
//! With friction what is read after a turn of the motion shares the error of the turn's angle in the same way.

use nalgebra::{DMatrix, DVector};

use super::readings::Readings;

/// A motor that rests may waver by a count of its servo, 0.088°.
const WAVERS_DEG: f64 = 0.1;

/// Which error a reading shares with others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shared {
    /// Its own angle's.
    Own(usize),
    /// The angle's at which the motion turned last, beside an error of its own.
    Turn(usize),
}

impl Shared {
    /// The error's number.
    pub(super) fn error(self) -> usize {
        match self {
            Self::Own(error) | Self::Turn(error) => error,
        }
    }
}

/// Which readings share which error: per run and reading, from 0 through all runs.
pub(super) struct Rests {
    of: Vec<Vec<Option<Shared>>>,
    /// How many there are.
    pub(super) count: usize,
}

impl Rests {
    /// Of runs along their times, of readings of both quantities, and of turns in runs that `rub`.
    pub(super) fn find(runs: &[Readings], rubs: impl Fn(&Readings) -> bool) -> Self {
        let mut count = 0;
        let of = runs.iter().map(|run| {
            let mut places = vec![None; run.readings.len()];
            let mut first = 0;
            for place in 1..places.len() {
                let [begin, now] = [&run.readings[first], &run.readings[place]];
                if now.time_s.is_some() && (begin.angle_deg - now.angle_deg).abs() <= WAVERS_DEG {
                    if places[first].is_none() {
                        places[first] = Some(count);
                        count += 1;
                    }
                    places[place] = places[first];
                } else {
                    first = place;
                }
            }
            for (place, reading) in places.iter_mut().zip(&run.readings) {
                if place.is_none() && reading.force_n.is_some() && reading.torque_nmm.is_some() {
                    *place = Some(count);
                    count += 1;
                }
            }
            let turns = if rubs(run) { run.turns() } else { Vec::new() };
            for &turn in &turns {
                places[turn].get_or_insert_with(|| {
                    count += 1;
                    count - 1
                });
            }
            let turned = |place: usize| turns.iter().rfind(|turn| **turn < place).and_then(|turn| places[*turn]);
            let shared = |(place, own): (usize, &Option<usize>)| {
                own.map(Shared::Own).or_else(|| turned(place).map(Shared::Turn))
            };
            places.iter().enumerate().map(shared).collect()
        });
        Self { of: of.collect(), count }
    }

    /// The error that a reading shares.
    pub(super) fn of(&self, run: usize, reading: usize) -> Option<Shared> {
        self.of.get(run)?.get(reading).copied().flatten()
    }
}

/// Normal equations of the parameters and of the rests' errors, which no row has two of.
pub(super) struct Equations {
    information: DMatrix<f64>,
    slope: DVector<f64>,
    /// Of each error its own information, its slope and what couples it to the parameters.
    rests: Vec<(f64, f64, DVector<f64>)>,
}

impl Equations {
    /// Of so many parameters and errors.
    pub(super) fn new(parameters: usize, rests: usize) -> Self {
        Self {
            information: DMatrix::zeros(parameters, parameters),
            slope: DVector::zeros(parameters),
            rests: vec![(0.0, 0.0, DVector::zeros(parameters)); rests],
        }
    }

    /// Adds a row: its weight, residual and gradients.
    pub(super) fn add(&mut self, weight: f64, residual: f64, gradient: &DVector<f64>, rest: Option<(usize, f64)>) {
        self.information.ger(weight, gradient, gradient, 1.0);
        self.slope.axpy(weight * residual, gradient, 1.0);
        if let Some((rest, by)) = rest
            && let Some((own, slope, coupling)) = self.rests.get_mut(rest)
        {
            *own += weight * by * by;
            *slope += weight * residual * by;
            coupling.axpy(weight * by, gradient, 1.0);
        }
    }

    /// Information and slope of the parameters alone.
    pub(super) fn of_parameters(&self) -> (DMatrix<f64>, DVector<f64>) {
        let (mut information, mut slope) = (self.information.clone(), self.slope.clone());
        for (own, of, coupling) in self.rests.iter().filter(|(own, ..)| *own > 0.0) {
            information.ger(-1.0 / own, coupling, coupling, 1.0);
            slope.axpy(-of / own, coupling, 1.0);
        }
        (information, slope)
    }

    /// A row's gradient less what its rest's error can make of it, and the share of a degree of freedom that the error takes from the row.
    pub(super) fn beside_errors(&self, gradient: &DVector<f64>, rest: Option<(usize, f64)>) -> (DVector<f64>, f64) {
        match rest.and_then(|(rest, by)| Some((self.rests.get(rest)?, by))) {
            Some(((own, _, coupling), by)) if *own > 0.0 => (gradient - coupling * (by / own), by * by / own),
            _ => (gradient.clone(), 0.0),
        }
    }

    /// The step of each error that goes with a step of the parameters.
    pub(super) fn steps(&self, step: &DVector<f64>) -> Vec<f64> {
        let step = |(own, slope, coupling): &(f64, f64, DVector<f64>)| {
            if *own > 0.0 { (slope - coupling.dot(step)) / own } else { 0.0 }
        };
        self.rests.iter().map(step).collect()
    }
}

#[cfg(test)]
mod tests {
    use model_core::object::ObjectDesign;

    use super::*;
    use crate::fit::calibrate::Reading;

    fn run(places: &[[f64; 2]], timed: bool) -> Readings {
        let reading = |&[time, angle_deg]: &[f64; 2]| Reading {
            line: 2,
            angle_deg,
            time_s: timed.then_some(time),
            force_n: Some(1.0),
            torque_nmm: None,
            front_mm: Vec::new(),
        };
        let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
        let readings = places.iter().map(reading).collect();
        Readings { name: "a run".to_owned(), object, friction: 0.0, readings }
    }

    #[test]
    fn a_rest_is_readings_of_nearly_one_angle_one_after_the_other() {
        let places = [[0.0, 0.0], [1.0, 8.0], [2.0, 8.0], [3.0, 7.93], [4.0, 0.0], [5.0, 0.0], [6.0, 8.0]];
        let rests = Rests::find(&[run(&places, true), run(&places[..3], true), run(&places, false)], |_| false);
        let of = |at: usize| -> Vec<Option<usize>> {
            (0..7).map(|reading| rests.of(at, reading).map(Shared::error)).collect()
        };
        assert_eq!(of(0), [None, Some(0), Some(0), Some(0), Some(1), Some(1), None]);
        assert_eq!(of(1)[..3], [None, Some(2), Some(2)]);
        assert!(of(2).iter().all(Option::is_none) && rests.count == 3);
        // A force and a torque of one reading.
        let mut both = run(&places[..2], false);
        both.readings[1].torque_nmm = Some(80.0);
        let rests = Rests::find(&[both], |_| true);
        assert_eq!((rests.of(0, 0), rests.of(0, 1), rests.count), (None, Some(Shared::Own(0)), 1));
    }

    #[test]
    fn with_friction_what_is_read_after_a_turn_shares_its_error() {
        let places = [[0.0, 0.0], [1.0, 8.0], [2.0, 7.5], [3.0, 7.5], [4.0, 6.0], [5.0, 7.0]];
        let rests = Rests::find(&[run(&places, false)], |_| true);
        let of: Vec<_> = (0..6).map(|reading| rests.of(0, reading)).collect();
        let (own, turn) = (|error| Some(Shared::Own(error)), |error| Some(Shared::Turn(error)));
        assert_eq!(of, [None, own(0), turn(0), turn(0), own(1), turn(1)]);
        assert_eq!(Rests::find(&[run(&places, false)], |_| false).count, 0);
    }

    /// The same as solving for everything together.
    #[test]
    fn eliminating_an_error_solves_the_whole_system() {
        let rows = [(0.5, [1.0, 2.0], 0.7), (-1.0, [0.3, -1.0], 0.7), (2.0, [1.5, 0.2], 0.0), (0.0, [0.0, 0.0], 1.0)];
        let (mut equations, mut whole, mut slope) =
            (Equations::new(2, 1), DMatrix::zeros(3, 3), DVector::<f64>::zeros(3));
        for (residual, gradient, by) in rows {
            let rest = (by != 0.0).then_some((0, by));
            equations.add(1.0, residual, &DVector::from_row_slice(&gradient), rest);
            let all = DVector::from_row_slice(&[gradient[0], gradient[1], by]);
            whole.ger(1.0, &all, &all, 1.0);
            slope.axpy(residual, &all, 1.0);
        }
        let expected = whole.clone().lu().solve(&slope).unwrap();
        let (information, rest) = equations.of_parameters();
        let step = information.clone().lu().solve(&rest).unwrap();
        let found = [step[0], step[1], equations.steps(&step)[0]];
        assert!(found.iter().zip(expected.iter()).all(|(a, b): (&f64, &f64)| (a - b).abs() < 1e-12), "{found:?}");
        let covariance = whole.try_inverse().unwrap();
        let own = information.clone().try_inverse().unwrap();
        assert!((covariance[(0, 1)] - own[(0, 1)]).abs() < 1e-12);
        // So do its rows one by one: together they have the parameters' information, and take three degrees of freedom.
        let (mut sum, mut freedom) = (DMatrix::zeros(2, 2), 0.0);
        for (_, gradient, by) in rows {
            let rest = (by != 0.0).then_some((0, by));
            let (gradient, by_error) = equations.beside_errors(&DVector::from_row_slice(&gradient), rest);
            sum.ger(1.0, &gradient, &gradient, 1.0);
            freedom += by_error + (&own * &gradient).dot(&gradient);
        }
        assert!((sum - information).amax() < 1e-12 && (freedom - 3.0).abs() < 1e-12, "{freedom}");
    }
}
