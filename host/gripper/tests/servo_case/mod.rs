//! Finger `ladder-80` on the Ø80 object in the physics `paper`, whose torques the figures of these tests are.

use std::sync::Arc;

use fre::case::preset;
use fre::study::model::Options;
use fre_gripper::servo::Load;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;

/// The object there, up to an angle. At mid height its centre is (41, 45) mm.
pub fn load(centre: [f64; 2], highest_deg: f64) -> Arc<Load> {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let object = ObjectDesign::Circle { centre, radius: 40.0 };
    let paper = Options { discretisation: Discretisation::full(Scheme::Paper, Physics::Paper), ..Load::REFERENCE };
    Arc::new(Load::of(&design, object, &Drive::Rotating, &paper, highest_deg).unwrap())
}
