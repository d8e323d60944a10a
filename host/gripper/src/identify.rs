//! What a round object is like, from what a gripper has reported of a closing motion: its height with the radius known, or its
//! radius with the height known ([`model_core::identify`]).
//!
//! The motor's current is the witness: behind the dead zone of its friction, learnt on the free way before the contact, it is
//! proportional to the torque that the object asks for.

use std::collections::BTreeMap;

use messages::{Calibration, Direction, Finger, Mount, Report};
use model_core::discretise::DiscretiseError;
use model_core::equilibrium::Follower;
use model_core::identify::{Identified, IdentifyError, Measurement, Moved, Noise, Unknown, identify};
use model_core::object::ObjectDesign;
use model_core::size::Reduced;
use model_core::status::Status;

use dynamixel::Model;

/// Counts after which the friction of a motion that began has turned around.
const BEGUN: usize = 8;
/// Counts by which a motor at rest may waver.
const STOOD: usize = 2;
/// The torque rises before the rise is reported: so far before that the way is free, rad.
const BEFORE: f64 = 1.5 * std::f64::consts::PI / 180.0;
/// Counts of the free way without which its friction is not known.
const LEAST_FREE: usize = 8;
/// Places of the range at which the contact is looked for, and steps of the motor angle, before anything moves.
const PLACES: u8 = 9;
const STEP: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Standard deviation of a count's torque beyond the noise that was seen: the gears' own, N·mm. An assumption.
const GEARS: f64 = 5.0;
/// Standard deviation of the friction, which changes under load, N·mm. An assumption.
const FRICTION: f64 = 15.0;

/// What one closing motion has shown.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Position of the servo (counts, in closing order), and every current seen there, mA.
    currents: BTreeMap<i64, Vec<f64>>,
    /// Motor angle of the first contact as it was reported, rad.
    touched: Option<f64>,
}

/// What was made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The unknown.
    pub identified: Identified,
    /// The object with it.
    pub object: ObjectDesign,
    /// Torque of the free motion: friction, N·mm.
    pub free: f64,
}

/// Why nothing was found.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The current did not rise.
    #[error("the current did not rise: nothing was met on the way")]
    NothingMet,
    /// The contact is too near the open finger.
    #[error(
        "{counts} counts of free way before the contact at {at_deg:.1}° are too few to know the friction ({LEAST_FREE} are needed, and {BEGUN} to \
         begin with): the finger has to open to {open_deg:.1}°"
    )]
    NoFreeWay {
        /// Counts of the free way.
        counts: usize,
        /// The contact, °.
        at_deg: f64,
        /// How far it has to be open, °.
        open_deg: f64,
    },
    /// The gripper's finger.
    #[error("the finger: {0}")]
    Finger(DiscretiseError),
    /// The measurements.
    #[error("{0}")]
    Unidentified(IdentifyError),
}

/// The motor angle, rad, to which a finger has to open before it closes on an object whose unknown is within a range, mm: the friction of its
/// motor has to be known before the contact. It is the least that any value of the range asks for; none if the finger meets none of them
/// within its own range.
///
/// # Errors
/// The gripper's finger.
pub fn open_angle(
    finger: &Finger,
    mount: &Mount,
    object: ObjectDesign,
    unknown: Unknown,
    range: [f64; 2],
) -> Result<Option<f64>, Error> {
    let mut follower: Box<Follower<f64, Reduced>> = Box::new(Follower::EMPTY);
    follower.configure(&finger.design, &finger.how).map_err(Error::Finger)?;
    let [least, most] = mount.range.map(f64::from);
    let angles = (0..).map(|step| least + f64::from(step) * STEP).take_while(|angle| *angle <= most);
    let contacts = (0..PLACES).filter_map(|place| {
        let value = range[0] + (range[1] - range[0]) * f64::from(place) / f64::from(PLACES - 1);
        follower.set_object(with(object, unknown, value), mount.drive.motion(finger.design.motor_axis));
        let mut meets = |angle: &f64| {
            let coordinate = mount.drive.coordinate(*angle).map(|[coordinate, _]| coordinate);
            coordinate.is_none_or(|coordinate| !follower.begin(coordinate))
        };
        angles.clone().find(&mut meets)
    });
    Ok(contacts.max_by(f64::total_cmp).map(|contact| contact - free_way(mount)))
}

/// How long the free way before a contact has to be, rad.
fn free_way(mount: &Mount) -> f64 {
    let count = Calibration::new(&mount.gear()).count().abs();
    (BEGUN + LEAST_FREE) as f64 * count + BEFORE + f64::from(mount.backlash)
}

impl Motion {
    /// Takes a report of the finger that closes.
    pub fn see(&mut self, report: &Report, mount: &Mount) {
        if report.estimate.status == Status::Stale {
            return;
        }
        let along = match mount.direction {
            Direction::Same => 1,
            Direction::Reversed => -1,
        };
        self.currents.entry(along * i64::from(report.position)).or_default().push(f64::from(report.current));
    }

    /// The first contact was reported, at a motor angle, rad.
    pub fn touch(&mut self, angle: f64) {
        self.touched.get_or_insert(angle);
    }

    /// Positions seen.
    pub fn positions(&self) -> usize {
        self.currents.len()
    }

    /// Finds the unknown within a range, mm.
    ///
    /// # Errors
    /// No contact, no free way before it, or what [`identify`] refuses.
    pub fn identify(
        &self,
        finger: &Finger,
        mount: &Mount,
        object: ObjectDesign,
        unknown: Unknown,
        range: [f64; 2],
    ) -> Result<Found, Error> {
        let touched = self.touched.ok_or(Error::NothingMet)?;
        let calibration = Calibration::new(&mount.gear());
        let along = match mount.direction {
            Direction::Same => 1.0,
            Direction::Reversed => -1.0,
        };
        let motor = mount.servo.and_then(|servo| Model::of(servo.model)).unwrap_or(Model::ASSUMED).motor;
        let per_milliampere = along * f64::from(mount.gear_ratio) * f64::from(motor.torque_constant);
        // At the last positions the motor stands, and may be held by its friction as well.
        let moving = self.currents.len().saturating_sub(STOOD);
        let torques: Vec<(f64, f64, usize)> = self
            .currents
            .iter()
            .take(moving)
            .skip(BEGUN)
            .map(|(position, currents)| {
                let mean = currents.iter().sum::<f64>() / currents.len() as f64;
                let position = (along as i64 * position) as i32;
                (calibration.finger_angle(position), per_milliampere * mean, currents.len())
            })
            .collect();
        let free: Vec<f64> =
            torques.iter().filter(|(angle, ..)| *angle < touched - BEFORE).map(|(_, torque, _)| *torque).collect();
        if free.len() < LEAST_FREE {
            let open_deg = (touched - free_way(mount)).to_degrees();
            return Err(Error::NoFreeWay { counts: free.len(), at_deg: touched.to_degrees(), open_deg });
        }
        let friction = free.iter().sum::<f64>() / free.len() as f64;
        let scatter = free.iter().map(|torque| (torque - friction).powi(2)).sum::<f64>() / (free.len() - 1) as f64;
        let noise = Noise {
            torque: scatter.sqrt().hypot(GEARS),
            offset: (scatter / free.len() as f64).sqrt().hypot(FRICTION),
            angle: calibration.count().abs().hypot(0.25 * f64::from(mount.backlash)),
        };
        let measurements: Vec<Measurement> =
            torques.iter().map(|&(angle, torque, _)| Measurement { angle, torque: torque - friction }).collect();

        let mut follower: Box<Follower<f64, Reduced>> = Box::new(Follower::EMPTY);
        follower.configure(&finger.design, &finger.how).map_err(Error::Finger)?;
        let moved = Moved { drive: mount.drive, axis: finger.design.motor_axis };
        let identified = identify(&mut *follower, &moved, object, unknown, range, &measurements, &noise)
            .map_err(Error::Unidentified)?;
        Ok(Found { identified, object: with(object, unknown, identified.value), free: friction })
    }
}

/// The circle with what was found of it.
fn with(object: ObjectDesign, unknown: Unknown, value: f64) -> ObjectDesign {
    match (object, unknown) {
        (ObjectDesign::Circle { centre, radius }, Unknown::Height) => {
            ObjectDesign::Circle { centre: [centre[0], value], radius }
        }
        (ObjectDesign::Circle { centre, .. }, Unknown::Radius) => ObjectDesign::Circle { centre, radius: value },
        (ObjectDesign::Circle { centre, radius }, Unknown::RadiusBehindSide) => {
            ObjectDesign::Circle { centre: [centre[0] - radius + value, centre[1]], radius: value }
        }
        (other, _) => other,
    }
}

#[cfg(test)]
mod tests {
    use messages::{Phase, Why};
    use model_core::discretise::{Discretisation, Physics};
    use model_core::drive::Drive;
    use model_core::estimator::Estimate;

    use super::*;
    use crate::datasheet::TORQUE_CONSTANT;
    use crate::servo::Load;
    use fre::case::preset;

    /// A reversed motor behind gears, which closes from −6° to 9° on an object.
    const MOUNT: Mount =
        Mount { direction: Direction::Reversed, gear_ratio: 2.0, zero: 3000.0, backlash: 0.002, ..Mount::DEFAULT };
    const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };

    fn report(position: i32, current: f32, status: Status) -> Report {
        Report {
            sequence: 0,
            finger: 0,
            phase: Phase::Held(Why::Asked),
            time_us: 0,
            estimate: Estimate::blank(status),
            goal: 0.0,
            position,
            current,
            cost: 0,
        }
    }

    fn closing(from_deg: f64) -> (Finger, Motion) {
        let design = preset("ladder-80").expect("a preset").expect("a sound one").design;
        let load = Load::of(&design, OBJECT, &Drive::Rotating, &Load::REFERENCE, 12.0).expect("a load");
        let finger = Finger::elastic(design, Discretisation::estimator(Physics::Extended));
        let calibration = Calibration::new(&MOUNT.gear());
        let (mut motion, mut branch) = (Motion::default(), crate::servo::OnBranch::default());
        let [first, last] = [from_deg, 9.0].map(|degrees| calibration.position(degrees.to_radians()));
        for position in (last..=first).rev() {
            let torque = load.at(calibration.finger_angle(position), &mut branch).torque;
            if torque > 45.0 {
                motion.touch(calibration.angle(position));
            }
            // The servo turns against the finger: so does its current, friction included.
            let current = -((torque / 2.0 + 233.0) / (TORQUE_CONSTANT * 1e-3)) as f32;
            for noise in [-4.0, 3.0, 1.0] {
                motion.see(&report(position, current + noise, Status::Converged), &MOUNT);
            }
            // Old numbers are none.
            motion.see(&report(position, 9_000.0, Status::Stale), &MOUNT);
        }
        (finger, motion)
    }

    #[test]
    fn a_reversed_motor_behind_gears_finds_the_height() {
        let (finger, motion) = closing(-6.0);
        let told = ObjectDesign::Circle { centre: [41.0, 52.0], radius: 40.0 };
        let found = motion.identify(&finger, &MOUNT, told, Unknown::Height, [30.0, 60.0]).expect("a height");
        assert!((found.identified.value - 45.0).abs() < 0.3, "{found:?}");
        assert!((found.free - 2.0 * 233.0).abs() < 5.0, "{found:?}");
        let ObjectDesign::Circle { centre, radius } = found.object else { panic!("{found:?}") };
        assert_eq!((centre, radius), ([41.0, found.identified.value], 40.0));
    }

    /// What is asked for before the motion is enough for it, and not much more.
    #[test]
    fn the_room_to_open_is_known_before_the_motion() {
        let (finger, _) = closing(0.5);
        let ask = |range| open_angle(&finger, &MOUNT, OBJECT, Unknown::Height, range).expect("a finger");
        let open = ask([30.0, 60.0]).expect("a contact").to_degrees();
        let find = |from_deg| {
            let motion = closing(from_deg).1;
            motion.identify(&finger, &MOUNT, OBJECT, Unknown::Height, [30.0, 60.0])
        };
        assert!(find(open).is_ok(), "{open}: {:?}", find(open));
        assert!(matches!(find(open + 1.8), Err(Error::NoFreeWay { .. })), "{open}: {:?}", find(open + 1.8));
        // A finger that does not come so far meets nothing.
        let short = Mount { range: [-0.2, -0.1], ..MOUNT };
        let open = open_angle(&finger, &short, OBJECT, Unknown::Height, [30.0, 60.0]).expect("a finger");
        assert_eq!(open, None);
    }

    #[test]
    fn without_a_free_way_or_a_contact_nothing_is_said() {
        let (finger, motion) = closing(0.5);
        let refused = motion.identify(&finger, &MOUNT, OBJECT, Unknown::Height, [30.0, 60.0]);
        assert!(matches!(refused, Err(Error::NoFreeWay { .. })), "{refused:?}");
        let refused = Motion::default().identify(&finger, &MOUNT, OBJECT, Unknown::Height, [30.0, 60.0]);
        assert!(matches!(refused, Err(Error::NothingMet)), "{refused:?}");
    }
}
