//! Finger and object in one line.

use crate::case::{Case, ObjectWords};

/// The finger's name, and its object with its place: "ladder-80 on a cylinder Ø80 mm at (41, 60) mm".
pub fn headline(case: &Case) -> String {
    format!("{} on {}", case.finger.name, ObjectWords::of(&case.object).phrase())
}
