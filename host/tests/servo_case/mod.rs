//! The load of the demonstration: finger `ladder-80`, the Ø80 object.

use std::sync::Arc;

use host::case::preset;
use host::servo::Load;
use model_core::object::ObjectDesign;

/// The object there, up to an angle. At mid height its centre is (41, 45) mm.
pub fn load(centre: [f64; 2], highest_deg: f64) -> Arc<Load> {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let object = ObjectDesign::Circle { centre, radius: 40.0 };
    Arc::new(Load::of(&design, object, &Load::REFERENCE, highest_deg).unwrap())
}
