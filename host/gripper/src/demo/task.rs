//! What the demonstration does: which finger closes on which object, and what its files are called.

use model_core::object::ObjectDesign;

/// The finger.
pub(super) const PRESET: &str = "ladder-80";
/// Ø80 at Mid height, world frame, mm.
pub(super) const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: CENTRE, radius: RADIUS };
/// Its centre, mm.
pub(super) const CENTRE: [f64; 2] = [41.0, 45.0];
/// Its radius, mm.
pub(super) const RADIUS: f64 = 40.0;
/// Name of the firmware's log (defmt frames) in the report's folder.
pub const LOG: &str = "firmware.defmt";
