//! What a campaign of faults did to the forces: how many were marked good, and whether those were right.

use std::fmt;

use fre_gripper::servo::Truth;
use messages::Report;

use crate::Bench;

/// Whether a report's force is marked good.
pub fn is_sound(report: &Report) -> bool {
    report.estimate.status.is_trustworthy() && report.estimate.age == 0
}

/// How far the force of a report is from what the finger does in full resolution, on the branch it is on and at the angle
/// where it truly is, its play included; in shares of what is allowed, 5 % or 0.1 N. Above 1 the force is wrong.
fn error(report: &Report, truth: &Truth) -> f64 {
    let ([x, y], [u, v]) = (truth.force, report.estimate.force.map(f64::from));
    (u - x).hypot(v - y) / f64::max(0.05 * x.hypot(y), 0.1)
}

/// The judge of a campaign.
#[derive(Default, Debug)]
pub struct Judge {
    /// Reports seen.
    pub reports: u64,
    /// Those whose force was marked good.
    pub sound: u64,
    /// Those marked good whose force was wrong.
    pub wrong: u64,
    /// The first of them.
    pub first_wrong: Option<(Report, Truth)>,
    /// Sound ones in contact.
    pub touching: u64,
    /// The largest error of a sound one, in shares of what is allowed.
    pub worst: f64,
    /// Ticks in a row without a sound estimate, up to now.
    pub bad: u32,
}

impl Judge {
    /// Looks at one report.
    pub fn look(&mut self, report: &Report, truth: &Truth) {
        self.reports += 1;
        if is_sound(report) {
            self.sound += 1;
            self.bad = 0;
            self.touching += u64::from(report.estimate.force != [0.0; 2]);
            let error = error(report, truth);
            self.worst = self.worst.max(error);
            if error > 1.0 {
                self.wrong += 1;
                self.first_wrong.get_or_insert((*report, *truth));
            }
        } else {
            self.bad += 1;
        }
    }

    /// Part of the reports whose force was marked good.
    pub fn share(&self) -> f64 {
        self.sound as f64 / self.reports as f64
    }

    /// Runs for so many µs and looks at every report.
    pub fn run(&mut self, bench: &mut Bench, us: u64) {
        bench.run_with(us, |report, truth| self.look(report, truth));
    }

    /// That no force marked good was wrong, and the watchdog was always fed.
    ///
    /// # Panics
    /// It is not so.
    pub fn verdict(&self, what: &str, bench: &Bench) {
        let (fast, bite) = bench.longest_fast_us();
        eprintln!("{what}: {self}; longest fast {fast} µs");
        assert_eq!(self.wrong, 0, "{:?}", self.first_wrong);
        assert!(fast < bite, "the watchdog would have bitten after {fast} µs");
    }
}

impl fmt::Display for Judge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} reports, {} sound ({} in contact), {} wrong, the worst {:.2} of what is allowed",
            self.reports, self.sound, self.touching, self.wrong, self.worst
        )
    }
}
