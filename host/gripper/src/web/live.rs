//! What the gripper reports, thinned for the eye.

use std::time::{Duration, Instant};

use messages::{Counters, Grasp, Report, Shape};
use serde::Serialize;

use crate::shown::Shown;
use crate::source::{GripMargin, Margins, Setup, Statistics, Told};

/// Frames per second.
const RATE: u32 = 30;
/// Points of a chart between two frames: the least and the greatest force of each are kept, so that no peak is lost.
const POINTS: usize = 2;
/// A margin that is older than this does not count any more.
const MARGIN_LASTS: Duration = Duration::from_millis(500);

/// What became of the gripper since the last frame.
#[derive(Debug)]
pub struct Live {
    cost_hz: u32,
    fingers: Vec<Finger>,
    grasp: Option<Grasp>,
    margins: Margins,
    /// What the grip bears, and when that was found.
    margin: Option<(GripMargin, Instant)>,
    reports: u64,
    /// Reports in the second before the last whole one, and when it began.
    second: (Instant, u64),
    per_second: f64,
    last_told: Instant,
    last_frame: Instant,
    counters: Option<Counters>,
}

#[derive(Debug, Default)]
struct Finger {
    /// Reports since the last frame.
    fresh: Vec<Report>,
    shown: Shown,
    shape: Option<Shape>,
}

/// A picture for the eye.
#[derive(Debug, Serialize)]
pub struct Frame {
    fingers: Vec<Option<FingerFrame>>,
    grasp: Option<GraspFrame>,
    silent_ms: u128,
    closed: bool,
    /// A person leads where a demonstration did.
    paused: bool,
    /// Name and value, in the order in which they are shown.
    counts: Vec<(&'static str, String)>,
}

#[derive(Debug, Serialize)]
struct FingerFrame {
    sequence: u32,
    time_s: f64,
    status: &'static str,
    trustworthy: bool,
    age: u32,
    /// Of the last second's reports.
    untrustworthy_percent: f64,
    phase: String,
    angle_deg: f64,
    goal_deg: f64,
    force_n: f64,
    force_xy_n: [f64; 2],
    /// Of the force's magnitude; none while it is not known.
    deviation_n: Option<f64>,
    /// With friction: between which values the force's magnitude lies; none without friction, and while an end is not known.
    interval_n: Option<[f32; 2]>,
    /// The rib that is near its buckling load, counted from 1, and its part of that load.
    rib: Option<String>,
    /// Centre of the contact, world frame; none without contact.
    centre_mm: Option<[f64; 2]>,
    torque_nmm: f64,
    distance_mm: f64,
    extent_mm: f64,
    current_ma: f64,
    cost: String,
    /// `[time, least force, greatest force, force, angle, goal, trustworthy]`
    points: Vec<[f64; 7]>,
    shape: Option<ShapeFrame>,
}

#[derive(Debug, Serialize)]
struct ShapeFrame {
    status: &'static str,
    trustworthy: bool,
    angle_rad: f32,
    shift_mm: [f32; 2],
    front_mm: Vec<[f32; 2]>,
    back_mm: Vec<[f32; 2]>,
    lamellae_mm: Vec<[[f32; 2]; 2]>,
    /// `[x, y, force x, force y]`
    contacts: Vec<[f32; 4]>,
}

#[derive(Debug, Serialize)]
struct GraspFrame {
    trustworthy: bool,
    sum_n: [f32; 2],
    squeeze_n: f32,
    balance: f32,
    /// Where a free object has come to; none for one that is fixed.
    free: Option<FreeFrame>,
    /// What it bears before the object slips; none while that is not known.
    margin: Option<MarginFrame>,
}

#[derive(Debug, Serialize)]
struct MarginFrame {
    /// In the plane, at equal angles from x of the gripper frame, counter-clockwise.
    along_n: Vec<f64>,
    across_n: f64,
    couple_nmm: f64,
    /// The least one, in the plane or across, and the finger that then slips first.
    weakest_n: f64,
    slips: Option<usize>,
}

#[derive(Debug, Serialize)]
struct FreeFrame {
    status: &'static str,
    shift_mm: [f32; 2],
    turn_deg: f32,
}

impl Live {
    /// For a target with this set-up.
    pub fn new(setup: &Setup) -> Self {
        let now = Instant::now();
        Self {
            cost_hz: setup.cost_hz,
            fingers: Vec::new(),
            grasp: None,
            margins: Margins::new(setup),
            margin: None,
            reports: 0,
            second: (now, 0),
            per_second: 0.0,
            last_told: now,
            last_frame: now,
            counters: None,
        }
    }

    /// Takes what was reported.
    pub fn take(&mut self, told: Told) {
        self.last_told = Instant::now();
        if let Some(margin) = self.margins.take(&told) {
            self.margin = Some((margin, self.last_told));
        }
        match told {
            Told::Report(report) => {
                self.reports += 1;
                let finger = self.finger(report.finger);
                finger.fresh.push(report);
                finger.shown.take(report);
            }
            Told::Shape(shape) => {
                let finger = self.finger(shape.finger);
                finger.shape = Some(*shape);
            }
            Told::Grasp(grasp) => self.grasp = Some(grasp),
            Told::Setup(setup) => self.cost_hz = setup.cost_hz,
            Told::Event(_) => {}
        }
    }

    /// Takes the target's counters.
    pub fn count(&mut self, counters: Counters) {
        self.counters = Some(counters);
    }

    fn finger(&mut self, number: u8) -> &mut Finger {
        let index = usize::from(number).min(messages::FINGERS - 1);
        if self.fingers.len() <= index {
            self.fingers.resize_with(index + 1, Finger::default);
        }
        &mut self.fingers[index]
    }

    /// How long until the next frame is due.
    pub fn due_in(&self) -> Duration {
        (Duration::from_secs(1) / RATE).saturating_sub(self.last_frame.elapsed())
    }

    /// The next frame.
    pub fn frame(&mut self, statistics: &Statistics, closed: bool, paused: bool) -> Frame {
        let now = Instant::now();
        // A late frame does not shift those behind it.
        let period = Duration::from_secs(1) / RATE;
        self.last_frame = if now - self.last_frame < 2 * period { self.last_frame + period } else { now };
        let since = now - self.second.0;
        if since >= Duration::from_secs(1) {
            self.per_second = (self.reports - self.second.1) as f64 / since.as_secs_f64();
            self.second = (now, self.reports);
        }
        let cost_hz = self.cost_hz;
        Frame {
            fingers: self.fingers.iter_mut().map(|finger| finger.frame(cost_hz)).collect(),
            grasp: self.grasp.map(|grasp| GraspFrame {
                trustworthy: grasp.is_trustworthy,
                sum_n: grasp.sum,
                squeeze_n: grasp.squeeze,
                balance: grasp.balance,
                free: grasp.free.map(|free| FreeFrame {
                    status: free.status.word(),
                    shift_mm: free.shift,
                    turn_deg: free.turn.to_degrees(),
                }),
                margin: self.margin.as_ref().filter(|(_, then)| now - *then < MARGIN_LASTS).map(|(margin, _)| {
                    let weakest = margin.weakest();
                    MarginFrame {
                        along_n: margin.along.iter().map(|one| one.bears).collect(),
                        across_n: margin.across.bears,
                        couple_nmm: margin.couple.bears,
                        weakest_n: weakest.bears,
                        slips: weakest.slips,
                    }
                }),
            }),
            silent_ms: self.last_told.elapsed().as_millis(),
            closed,
            paused,
            counts: self.counts(statistics),
        }
    }

    fn counts(&self, statistics: &Statistics) -> Vec<(&'static str, String)> {
        let mut counts = Vec::new();
        let mut add = |name, value: String| counts.push((name, value));
        add("reports a second", format!("{:.0}", self.per_second));
        if let Some(counters) = &self.counters {
            add("loop", format!("{:.0} of {:.0} Hz", counters.rate_hz, counters.chosen_hz));
            add("late ticks", counters.late_ticks.to_string());
            let dropped =
                [counters.dropped_reports, counters.dropped_grasps, counters.dropped_shapes, counters.dropped_events];
            add("dropped by the target", dropped.map(u64::from).iter().sum::<u64>().to_string());
            let bus = [counters.bus_timeouts, counters.bus_damaged, counters.bus_refused, counters.bus_other];
            add("faults on the bus", bus.map(u64::from).iter().sum::<u64>().to_string());
            add("servo lost", counters.servo_losses.to_string());
        }
        add("missing reports", statistics.missing_reports.to_string());
        add("damaged frames", statistics.damaged.to_string());
        add("unread here", statistics.unheard.to_string());
        counts
    }
}

impl Finger {
    fn frame(&mut self, cost_hz: u32) -> Option<FingerFrame> {
        let points = thin(&self.fresh);
        self.fresh.clear();
        let Report { sequence, phase, time_us, estimate, goal, current, cost, .. } = self.shown.report()?;
        let double = |v: [f32; 2]| v.map(f64::from);
        Some(FingerFrame {
            sequence,
            time_s: seconds(time_us),
            status: estimate.status.word(),
            trustworthy: estimate.status.is_trustworthy(),
            age: estimate.age,
            untrustworthy_percent: self.shown.untrustworthy_percent(),
            phase: phase.to_string(),
            angle_deg: f64::from(estimate.motor_angle.to_degrees()),
            goal_deg: f64::from(goal.to_degrees()),
            force_n: f64::from(estimate.force_magnitude()),
            force_xy_n: double(estimate.force),
            deviation_n: estimate.standard_deviation.is_finite().then_some(estimate.standard_deviation.into()),
            interval_n: estimate.interval.map(|interval| interval.magnitude),
            rib: estimate.loaded_rib.map(|loaded| loaded.to_string()),
            centre_mm: (estimate.force != [0.0; 2]).then_some(double(estimate.contact_centre)),
            torque_nmm: f64::from(estimate.torque),
            distance_mm: f64::from(estimate.distance),
            extent_mm: f64::from(estimate.contact_extent),
            current_ma: f64::from(current),
            cost: format!("{:.0} µs, {} it.", 1e6 * f64::from(cost) / f64::from(cost_hz.max(1)), estimate.iterations),
            points,
            shape: self.shape.take().map(ShapeFrame::of),
        })
    }
}

impl ShapeFrame {
    fn of(shape: Shape) -> Self {
        let bars = shape.lamella_front.iter().zip(&shape.lamella_back);
        let contacts = shape.contacts.iter().map(|c| [c.position[0], c.position[1], c.force[0], c.force[1]]);
        Self {
            status: shape.status.word(),
            trustworthy: shape.status.is_trustworthy(),
            angle_rad: shape.motor_angle,
            shift_mm: shape.shift,
            front_mm: shape.front.to_vec(),
            back_mm: shape.back.to_vec(),
            lamellae_mm: bars.map(|(front, back)| [*front, *back]).collect(),
            contacts: contacts.collect(),
        }
    }
}

fn seconds(time_us: u64) -> f64 {
    time_us as f64 * 1e-6
}

/// A few points for many reports, each with the least and the greatest force of those it stands for.
fn thin(reports: &[Report]) -> Vec<[f64; 7]> {
    let size = reports.len().div_ceil(POINTS).max(1);
    reports
        .chunks(size)
        .filter_map(|chunk| {
            let last = chunk.last()?;
            // A tick without a position repeats an old force: left out where there are others.
            let trustworthy = chunk.iter().any(|report| report.estimate.status.is_trustworthy());
            let counts = |report: &&Report| !trustworthy || report.estimate.status.is_trustworthy();
            let forces = chunk.iter().filter(counts).map(|report| f64::from(report.estimate.force_magnitude()));
            Some([
                seconds(last.time_us),
                forces.clone().fold(f64::INFINITY, f64::min),
                forces.clone().fold(f64::NEG_INFINITY, f64::max),
                forces.clone().next_back().unwrap_or_default(),
                f64::from(last.estimate.motor_angle.to_degrees()),
                f64::from(last.goal.to_degrees()),
                f64::from(u8::from(trustworthy)),
            ])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::tests::{gripper, touching};
    use messages::Phase;
    use model_core::estimator::Estimate;
    use model_core::status::Status;

    fn report(sequence: u32, force: f32, status: Status) -> Report {
        Report {
            sequence,
            finger: 0,
            phase: Phase::Moving,
            time_us: 2000 * u64::from(sequence),
            estimate: Estimate { force: [force, 0.0], ..Estimate::blank(status) },
            goal: 0.0,
            position: 0,
            current: 0.0,
            cost: 25,
        }
    }

    #[test]
    fn a_grip_of_two_fingers_shows_what_it_bears_and_nothing_after_half_a_second() {
        let mut live = Live::new(&gripper(0.5, 2));
        live.take(Told::Grasp(Grasp::of(std::iter::empty())));
        live.take(touching(0, 10, Status::Converged));
        let margin = |live: &mut Live| live.frame(&Statistics::default(), false, false).grasp?.margin;
        assert!(margin(&mut live).is_none());
        live.take(touching(1, 11, Status::Converged));
        let shown = margin(&mut live).expect("a margin");
        assert!((shown.across_n - 4.0).abs() < 0.01 && shown.along_n.len() == 24, "{shown:?}");
        assert!(shown.weakest_n <= 4.001 && shown.slips.is_some(), "{shown:?}");
        live.margin.as_mut().unwrap().1 -= MARGIN_LASTS;
        assert!(margin(&mut live).is_none());
    }

    #[test]
    fn thinning_keeps_peaks_and_says_what_is_untrustworthy() {
        let mut live = Live::new(&Setup { cost_hz: 25_000_000, ..gripper(0.0, 1) });
        for sequence in 0..16 {
            let force = if sequence == 5 { 9.0 } else { 1.0 };
            live.take(Told::Report(report(sequence, force, Status::Converged)));
        }
        let frame = live.frame(&Statistics::default(), false, false);
        let finger = frame.fingers[0].as_ref().unwrap();
        assert_eq!((finger.sequence, finger.status, finger.trustworthy), (15, "converged", true));
        assert_eq!(finger.cost, "1 µs, 0 it.");
        assert_eq!(finger.points.len(), 2);
        assert_eq!([finger.points[0][2], finger.points[0][6]], [9.0, 1.0]);
        assert_eq!([finger.points[1][2], finger.points[1][6]], [1.0, 1.0]);
        // A silence.
        for sequence in 100..116 {
            live.take(Told::Report(report(sequence, 1.0, Status::Stale)));
        }
        let frame = live.frame(&Statistics::default(), false, true);
        let finger = frame.fingers[0].as_ref().unwrap();
        assert!(frame.paused);
        assert_eq!((finger.sequence, finger.status, finger.trustworthy), (115, "stale", false));
        assert!(finger.points.len() == 2 && finger.points.iter().all(|point| point[6] == 0.0));
        assert_eq!(finger.untrustworthy_percent, 50.0);
        // Nothing twice.
        let next = live.frame(&Statistics::default(), true, false);
        assert!(next.closed && next.fingers[0].as_ref().unwrap().points.is_empty());
    }
}
