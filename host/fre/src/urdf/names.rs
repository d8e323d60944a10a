//! Names of a finger's links and its joint.

/// The link that stands still: the finger's world frame.
pub fn base(number: u8) -> String {
    format!("finger_{number}_base")
}

/// The link that the motor moves: it turns with the finger frame. Its origin is the motor's axis, or for a finger that is moved along a
/// line the origin of the finger frame.
pub fn finger(number: u8) -> String {
    format!("finger_{number}")
}

/// The joint between them.
pub fn joint(number: u8) -> String {
    format!("finger_{number}_joint")
}
