//! All that was seen of the demonstration.

use messages::{Counters, Version};
use model_core::design::Design;
use model_core::discretise::Physics;

use super::reference::Followed;
use super::sample::Sample;
use crate::source::Statistics;
use fre::metrics::along;
use fre::shape::{Contact, Shape};
use fre_qemu::Pace;

/// All that was seen.
pub struct Seen {
    /// The finger.
    pub design: Design,
    /// Physics of the target and both references.
    pub physics: Physics,
    /// The gripper.
    pub version: Version,
    /// How QEMU's time passed.
    pub pace: Pace,
    /// Every report, in order.
    pub samples: Vec<Sample>,
    /// The trustworthy shape with the greatest force.
    pub shape: Option<messages::Shape>,
    /// Shapes that came.
    pub shapes: u64,
    /// Time from the first report to the last, s, by this PC's clock.
    pub wall_s: f64,
    /// Whole closings and openings.
    pub cycles: u32,
    /// The gripper's counters at the beginning and at the end.
    pub counters: [Counters; 2],
    /// The link's.
    pub link: [Statistics; 2],
    /// Bytes lost on the bus.
    pub lost_on_bus: u64,
    /// What each reference leaves, in their order.
    pub followed: [Followed; 2],
    /// Samples that a reference had no room or no time for.
    pub left_out: [u64; 2],
}

impl Seen {
    /// The target's shape with the greatest force, the trapezoid reference's at the same angle, and that angle, rad.
    pub(super) fn shape_beside_reference(&self) -> Option<(Shape, &Shape, f64)> {
        let told = self.shape.as_ref()?;
        let report = self.samples.iter().find(|sample| sample.report.sequence == told.sequence)?.report;
        let reference = self.followed[0].shapes.get(&report.position)?;
        Some((shape_of(told), reference, f64::from(told.motor_angle)))
    }
}

/// A gripper's shape as pictures take it. It does not have arc lengths: those are taken along the polyline, to its nearest point.
fn shape_of(told: &messages::Shape) -> Shape {
    let double = |point: &[f32; 2]| point.map(f64::from);
    let front: Vec<[f64; 2]> = told.front.iter().map(double).collect();
    let contact = |contact: &messages::Contact| {
        let [x, y] = double(&contact.force);
        let force = x.hypot(y);
        let length = force.max(f64::MIN_POSITIVE);
        Contact {
            arc: along(double(&contact.position), &front).unwrap_or(0.0),
            position: double(&contact.position),
            normal: [-x / length, -y / length],
            force,
            tangential: None,
            state: None,
        }
    };
    let contacts = told.contacts.iter().map(contact).collect();
    let lamellae = told.lamella_front.iter().zip(&told.lamella_back).map(|(a, b)| [double(a), double(b)]).collect();
    Shape { back: told.back.iter().map(double).collect(), lamellae, contacts, front, ..Shape::default() }
}
