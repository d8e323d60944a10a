//! The `[object]` table.

use model_core::object::{ObjectDesign, ObjectError};

use super::document::Table;
use super::error::CaseError;

/// Shapes of the file format.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    Circle,
    /// Known to the format, not yet to the solver.
    Later,
}

/// Reads and validates the object.
pub(super) fn read(root: &Table<'_>) -> Result<ObjectDesign, CaseError> {
    let table = root.need("object", "a table with shape, radius_mm and centre_mm")?.table()?;
    let word = table.need("shape", "\"circle\"")?;
    let shape = word.choice(&[
        ("circle", Shape::Circle),
        ("ellipse", Shape::Later),
        ("polygon", Shape::Later),
        ("half-plane", Shape::Later),
    ])?;
    if shape == Shape::Later {
        return Err(word.refuse("this shape is not available yet; allowed is \"circle\""));
    }
    let table = table.only(&["shape", "radius_mm", "centre_mm"])?;
    let object = ObjectDesign::Circle {
        radius: table.need("radius_mm", "a number of mm")?.number()?,
        centre: table.need("centre_mm", "[x, y] in mm, world frame")?.pair("[x, y] in mm")?,
    };
    object.validate().map_err(|ObjectError::OutOfRange { key, value, min, max }| {
        let reason = format!("allowed is {min} to {max} mm");
        match table.find(key) {
            Some(found) => found.entry_holding(value).refuse(reason),
            None => table.refuse(key, reason),
        }
    })?;
    Ok(object)
}
