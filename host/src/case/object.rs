//! The `[object]` table.

use model_core::object::{Corners, MAX_CORNERS, ObjectDesign, ObjectError};

use super::document::Table;
use super::error::CaseError;

/// Shapes of the file format.
#[derive(Clone, Copy)]
enum Shape {
    Circle,
    Ellipse,
    Polygon,
    HalfPlane,
}

/// Reads and validates the object.
pub(super) fn read(root: &Table<'_>) -> Result<ObjectDesign, CaseError> {
    let table = root.need("object", "a table with shape and the shape's keys")?.table()?;
    let shape = table.need("shape", "\"circle\", \"ellipse\", \"polygon\" or \"half-plane\"")?.choice(&[
        ("circle", Shape::Circle),
        ("ellipse", Shape::Ellipse),
        ("polygon", Shape::Polygon),
        ("half-plane", Shape::HalfPlane),
    ])?;
    let table = table.only(match shape {
        Shape::Circle => &["shape", "radius_mm", "centre_mm"],
        Shape::Ellipse => &["shape", "centre_mm", "semi_axes_mm", "angle_deg"],
        Shape::Polygon => &["shape", "corners_mm", "rounding_mm"],
        Shape::HalfPlane => &["shape", "point_mm", "normal"],
    })?;
    let number = |key| table.need(key, "a number of mm")?.number();
    let point = |key| table.need(key, "[x, y] in mm, world frame")?.pair("[x, y] in mm");
    let object = match shape {
        Shape::Circle => ObjectDesign::Circle { radius: number("radius_mm")?, centre: point("centre_mm")? },
        Shape::Ellipse => ObjectDesign::Ellipse {
            centre: point("centre_mm")?,
            semi_axes: table.need("semi_axes_mm", "[a, b] in mm")?.pair("[a, b] in mm")?,
            angle: table.get("angle_deg").map_or(Ok(0.0), |angle| angle.number())?.to_radians(),
        },
        Shape::Polygon => ObjectDesign::Polygon { corners: corners(&table)?, rounding: number("rounding_mm")? },
        Shape::HalfPlane => ObjectDesign::HalfPlane {
            point: point("point_mm")?,
            normal: table.need("normal", "[x, y], out of the object")?.pair("[x, y], out of the object")?,
        },
    };
    object.validate().map_err(|error| refusal(&table, error))?;
    Ok(object)
}

fn corners(table: &Table<'_>) -> Result<Corners, CaseError> {
    let expected = "an array of [x, y] in mm, world frame, in order around the object";
    let list = table.need("corners_mm", expected)?;
    let points = list.entries(expected, MAX_CORNERS)?;
    let points = points.iter().map(|corner| corner.pair("[x, y] in mm")).collect::<Result<Vec<_>, _>>()?;
    Corners::new(&points).ok_or_else(|| list.refuse(format!("at most {MAX_CORNERS} corners are allowed")))
}

/// The error at the place in the file that it is about.
fn refusal(table: &Table<'_>, error: ObjectError) -> CaseError {
    let corner = |index: usize, reason: &str| {
        let corners = table.find("corners_mm").and_then(|list| list.entries("", MAX_CORNERS).ok());
        match corners.as_ref().and_then(|corners| corners.get(index)) {
            Some(corner) => corner.refuse(reason),
            None => table.refuse("corners_mm", reason),
        }
    };
    match error {
        ObjectError::OutOfRange { key, value, min, max } => {
            let unit = if key.ends_with("_deg") { "degrees" } else { "mm" };
            let reason = format!("allowed is {min} to {max} {unit}");
            match table.find(key) {
                Some(found) => found.entry_holding(value).refuse(reason),
                None => table.refuse(key, reason),
            }
        }
        ObjectError::TooSharp { radius, min } => table.refuse(
            "semi_axes_mm",
            format!("the ends' radius of curvature b²/a is {radius:.3} mm; allowed is {min} mm or more"),
        ),
        ObjectError::NoCorner => {
            table.refuse("corners_mm", format!("is empty; allowed are 1 to {MAX_CORNERS} corners"))
        }
        ObjectError::RepeatedCorner { index } => {
            corner(index, "is the same as another corner; each corner is named once, the first is not repeated")
        }
        ObjectError::NotConvex { index } => corner(
            index,
            "makes the polygon not convex; allowed are corners that all turn the same way, in order around the object",
        ),
        ObjectError::NoDirection { key } => {
            table.refuse(key, "has no length to speak of; allowed is a length of 1e-6 to 1e6 (it is scaled to 1)")
        }
    }
}
