//! What the whole grip bears before the object slips, from the contact forces of all fingers.

use std::f64::consts::TAU;

use messages::{FINGERS, FreeObject, Shape, Side};
use model_core::grasp::{Margin, Pull, Touch, margin};
use model_core::object::{self, Object as _, ObjectDesign};
use model_core::real::Vec2;

use super::base::Base;
use super::setup::Setup;
use super::told::Told;

/// Directions in which the weakest one is looked for: every 15°.
const DIRECTIONS: u32 = 24;

/// What a grip bears: the largest load at the object's reference point (centre; of a polygon, the mean of its corners) for which there are
/// forces within the friction cones, none pressing harder than now.
#[derive(Clone, Debug, PartialEq)]
pub struct GripMargin {
    /// In the plane, N: in directions every 15° from x of the gripper frame, counter-clockwise.
    pub along: Vec<Margin>,
    /// Across the plane, N.
    pub across: Margin,
    /// A couple about the reference point, N·mm: the weaker one of both ways.
    pub couple: Margin,
}

impl GripMargin {
    /// Of places of contact around a reference point; `reach`: how far the object reaches from there, mm.
    fn of(touches: &[Touch], reach: f64) -> Self {
        let bears = |pull: &Pull| margin(touches.iter().copied(), [0.0; 2], reach, pull);
        let along = (0..DIRECTIONS).map(|at| {
            let (sin, cos) = (TAU * f64::from(at) / f64::from(DIRECTIONS)).sin_cos();
            bears(&Pull { force: [cos, sin], ..Pull::default() })
        });
        let turned = [1.0, -1.0].map(|couple| bears(&Pull { couple, ..Pull::default() }));
        let [one, other] = turned;
        Self {
            along: along.collect(),
            across: bears(&Pull { across: 1.0, ..Pull::default() }),
            couple: if one.bears < other.bears { one } else { other },
        }
    }

    /// As it is reported with the grasp, so many ticks later.
    pub fn of_age(&self, ticks: u64) -> messages::GripMargin {
        let numbered = self.along.iter().enumerate();
        let least =
            numbered.min_by(|(_, a), (_, b)| a.bears.total_cmp(&b.bears)).map_or((0, 0.0), |(at, m)| (at, m.bears));
        messages::GripMargin {
            least: least.1 as f32,
            direction: (TAU * least.0 as f64 / f64::from(DIRECTIONS)) as f32,
            across: self.across.bears as f32,
            couple: self.couple.bears as f32,
            slips: self.weakest().slips.map(|finger| finger as u8),
            carried: None,
            age: ticks.min(u64::from(u16::MAX)) as u16,
        }
    }

    /// Of the direction in which it bears least, in the plane or across it, N.
    pub fn weakest(&self) -> Margin {
        self.along.iter().fold(self.across, |least, one| if one.bears < least.bears { *one } else { least })
    }
}

/// A finger's part.
#[derive(Clone, Debug)]
struct Held {
    axis: [f64; 2],
    object: ObjectDesign,
    friction: f64,
    is_mirrored: bool,
    shape: Option<Shape>,
    /// The last report's number and force, N: with friction the shape's contacts are those of an angle that lags by a play.
    force: Option<(u32, f64)>,
}

/// Collects the shapes of one tick.
#[derive(Clone, Debug, Default)]
pub struct Margins {
    /// One per finger; none where there is nothing to hold with.
    fingers: Vec<Option<Held>>,
    free: Option<FreeObject>,
}

impl Margins {
    /// Of a source with this set-up.
    pub fn new(setup: &Setup) -> Self {
        let held = |number: usize| {
            let mount = setup.settings.finger(number as u8)?;
            let model = setup.models.get(number)?;
            Some(Held {
                axis: model.finger.as_ref()?.design.motor_axis,
                object: model.object?,
                friction: model.friction,
                is_mirrored: mount.side == Side::Right,
                shape: None,
                force: None,
            })
        };
        let count = (0..FINGERS).rfind(|&number| setup.settings.finger(number as u8).is_some());
        Self { fingers: (0..count.map_or(0, |last| last + 1)).map(held).collect(), free: None }
    }

    /// Takes what was reported. The margin, once the shapes of all fingers of one tick are there and can be trusted; one finger grips
    /// nothing.
    pub fn take(&mut self, told: &Told) -> Option<GripMargin> {
        let shape = match told {
            Told::Grasp(grasp) => {
                self.free = grasp.free;
                return None;
            }
            Told::Setup(setup) => {
                *self = Self::new(setup);
                return None;
            }
            Told::Shape(shape) => shape,
            Told::Report(report) => {
                let held = self.fingers.get_mut(usize::from(report.finger))?.as_mut()?;
                held.force = Some((report.sequence, f64::from(report.estimate.force_magnitude())));
                return None;
            }
            Told::Event(_) => return None,
        };
        let held = self.fingers.get_mut(usize::from(shape.finger))?.as_mut()?;
        held.shape = Some(Shape::clone(shape));
        let mut touches = Vec::new();
        let mut reach = 0.0_f64;
        let mut count = 0;
        for (number, held) in self.fingers.iter().enumerate() {
            let Some(held) = held else { continue };
            let of = held.shape.as_ref()?;
            // Sequences count every finger's reports.
            if shape.sequence.wrapping_sub(of.sequence) >= FINGERS as u32 || !of.status.is_trustworthy() {
                return None;
            }
            count += 1;
            reach = reach.max(held.touches(number, self.free.as_ref(), &mut touches)?);
        }
        (count >= 2).then(|| GripMargin::of(&touches, reach))
    }
}

impl Held {
    /// Adds its places of contact, around the object's reference point in the gripper's axes; how far the object reaches.
    fn touches(&self, finger: usize, free: Option<&FreeObject>, touches: &mut Vec<Touch>) -> Option<f64> {
        let shape = self.shape.as_ref()?;
        let placed = super::setup::placed(&self.object, free, self.is_mirrored);
        let (middle, reach) = placed.reference()?;
        let outline: object::Shape<f64> = placed.into();
        let base = Base::of(shape, self.axis);
        let seen = |[x, y]: [f64; 2]| if self.is_mirrored { [-x, y] } else { [x, y] };
        let whole = shape.contacts.iter().fold([0.0; 2], |[x, y], contact| {
            let [u, v] = contact.force.map(f64::from);
            [x + u, y + v]
        });
        let whole = whole[0].hypot(whole[1]);
        let reported = self.force.filter(|(sequence, _)| *sequence == shape.sequence && whole > 0.0);
        let scale = reported.map_or(1.0, |(_, force)| force / whole);
        for contact in &shape.contacts {
            let point = base.point(contact.position);
            let push = base.vector(contact.force);
            let out = outline.gap(Vec2::new(point[0], point[1])).normal;
            let normal = [-out.x, -out.y];
            touches.push(Touch {
                finger,
                point: seen([point[0] - middle[0], point[1] - middle[1]]),
                normal: seen(normal),
                force: scale * (push[0] * normal[0] + push[1] * normal[1]).max(0.0),
                friction: self.friction,
            });
        }
        Some(reach)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use messages::{Contact, Mount, Settings};
    use model_core::discretise::{Discretisation, Physics};
    use model_core::status::Status;

    use super::*;
    use crate::source::{Modelled, Origin};

    const RADIUS: f64 = 20.0;

    /// A gripper with one or two fingers, mirror images, on a cylinder.
    pub(crate) fn gripper(friction: f64, fingers: usize) -> Setup {
        let design = fre::case::preset("ladder-80").unwrap().unwrap().design;
        let how = Discretisation::estimator(Physics::Extended);
        let model = Modelled {
            finger: Some(messages::Finger::elastic(design, how)),
            object: Some(ObjectDesign::Circle { centre: [22.0, 45.0], radius: RADIUS }),
            friction,
            uncertainty: None,
        };
        let mut settings = Settings::of(Mount::DEFAULT);
        settings.fingers[1] = (fingers > 1).then_some(Mount { servo_id: 2, side: Side::Right, ..Mount::DEFAULT });
        Setup {
            origin: Origin::Gripper,
            place: "a test".to_owned(),
            board: "bench".to_owned(),
            firmware: "1.2.3".to_owned(),
            protocol: messages::PROTOCOL_VERSION,
            cost_hz: 1,
            settings,
            models: vec![model; fingers],
        }
    }

    /// A finger that touches the cylinder at its own side's middle with a force along the normal and one that rubs.
    pub(crate) fn touching(finger: u8, sequence: u32, status: Status) -> Told {
        let contact = Contact { position: [2.0, 45.0], force: [4.0, 1.0] };
        let bare = Shape {
            sequence,
            finger,
            status,
            motor_angle: 0.0,
            shift: [0.0; 2],
            front: Default::default(),
            back: Default::default(),
            lamella_front: Default::default(),
            lamella_back: Default::default(),
            contacts: [contact].into_iter().collect(),
        };
        Told::Shape(bare.into())
    }

    #[test]
    fn two_mirrored_fingers_bear_by_friction_and_by_their_squeeze() {
        let mut margins = Margins::new(&gripper(0.5, 2));
        assert_eq!(margins.take(&touching(0, 10, Status::Converged)), None, "half of a tick");
        let margin = margins.take(&touching(1, 11, Status::Converged)).expect("both are there");
        let near =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-3 * expected, "{found} {expected}");
        // 4 N from either side: up, down, across and a couple are borne by friction, along x one finger comes off.
        near(margin.along[6].bears, 4.0);
        near(margin.along[18].bears, 4.0);
        near(margin.along[0].bears, 4.0);
        near(margin.across.bears, 4.0);
        near(margin.couple.bears, 4.0 * RADIUS);
        near(margin.weakest().bears, margin.along.iter().map(|one| one.bears).fold(4.0, f64::min));
        // 45°: half of what each bears by friction is across its normal.
        assert!(margin.along[3].bears < 4.0 && margin.along[3].bears > 2.0, "{margin:?}");
    }

    #[test]
    fn there_is_none_of_one_finger_of_different_ticks_and_of_what_cannot_be_trusted() {
        let mut one = Margins::new(&gripper(0.5, 1));
        assert_eq!(one.take(&touching(0, 10, Status::Converged)), None);
        let mut margins = Margins::new(&gripper(0.5, 2));
        margins.take(&touching(0, 10, Status::Converged));
        assert_eq!(margins.take(&touching(1, 31, Status::Converged)), None, "another tick");
        assert_eq!(margins.take(&touching(0, 32, Status::Stale)), None, "no estimate");
        // Friction is needed in the weakest direction.
        let mut smooth = Margins::new(&gripper(0.0, 2));
        smooth.take(&touching(0, 10, Status::Converged));
        let found = smooth.take(&touching(1, 11, Status::Converged)).expect("a grip without friction");
        assert!(found.weakest().bears < 1e-3, "{found:?}");
    }
}
