//! The whole grasp: what the fingers' forces come to together.

use crate::{Grasp, Report, Side};

impl Grasp {
    /// Sums up one tick's reports of the fingers, each with its side.
    pub fn of<'a>(fingers: impl Iterator<Item = (&'a Report, Side)>) -> Self {
        let mut whole = Self {
            sequence: 0,
            is_trustworthy: true,
            sum: [0.0; 2],
            squeeze: 0.0,
            balance: 1.0,
            free: None,
            margin: None,
        };
        let (mut to_right, mut to_left, mut all) = (0.0, 0.0, 0.0);
        for (report, side) in fingers {
            let [mut x, y] = report.estimate.force;
            match side {
                Side::Left => to_right += x,
                Side::Right => {
                    to_left += x;
                    x = -x;
                }
            }
            whole.sequence = report.sequence;
            whole.is_trustworthy &= report.estimate.status.is_trustworthy() && report.estimate.age == 0;
            whole.sum[0] += x;
            whole.sum[1] += y;
            all += report.estimate.force_magnitude();
        }
        whole.squeeze = f32::min(to_right, to_left).max(0.0);
        if all > 0.0 {
            let [x, y] = whole.sum.map(f64::from);
            whole.balance = 1.0 - (libm::sqrt(x * x + y * y) / f64::from(all)) as f32;
        }
        whole
    }
}

#[cfg(test)]
mod tests {
    use model_core::estimator::Estimate;
    use model_core::status::Status;

    use super::*;

    fn report(force: [f32; 2], status: Status) -> Report {
        let estimate = Estimate { force, ..Estimate::blank(status) };
        Report { sequence: 3, estimate, ..Report::blank(0) }
    }

    #[test]
    fn two_alike_cancel_and_squeeze() {
        let one = report([4.0, 3.0], Status::Converged);
        let whole = Grasp::of([(&one, Side::Left), (&one, Side::Right)].into_iter());
        assert_eq!((whole.sum, whole.squeeze, whole.is_trustworthy), ([0.0, 6.0], 4.0, true));
        assert!((whole.balance - 0.4).abs() < 1e-6, "6 N of 10 are left");
    }

    #[test]
    fn one_alone_squeezes_nothing() {
        let one = report([4.0, -3.0], Status::Converged);
        let whole = Grasp::of([(&one, Side::Right)].into_iter());
        assert_eq!((whole.sum, whole.squeeze, whole.balance), ([-4.0, -3.0], 0.0, 0.0));
    }

    #[test]
    fn one_bad_estimate_spoils_it() {
        let (good, bad) = (report([4.0, 3.0], Status::Converged), report([4.0, 3.0], Status::Stale));
        assert!(!Grasp::of([(&good, Side::Left), (&bad, Side::Right)].into_iter()).is_trustworthy);
        let none = Grasp::of(core::iter::empty());
        assert_eq!((none.sum, none.balance), ([0.0; 2], 1.0));
    }
}
