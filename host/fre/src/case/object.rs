//! The object: the keys of `[object]` in the solver's units.

use model_core::object::{Corners, MAX_CORNERS, ObjectDesign, ObjectError};

use super::check;
use super::error::CaseError;
use super::keys::{self, ObjectTable};
use super::source::{Source, Table};

/// Reads an object and its coefficient of friction from a text that has the keys of `[object]` at its top; `name` stands for the text in
/// messages.
///
/// # Errors
/// The first thing in it that cannot be used.
pub fn read_object(name: &str, text: &str) -> Result<(ObjectDesign, f64), CaseError> {
    let source = Source { name: name.to_owned(), text: text.to_owned() };
    let tree = source.parse()?;
    let root = Table::root(&source, tree.get_ref());
    check::table(&root, keys::object_schema())?;
    let keys: ObjectTable = root.read()?;
    Ok((build(&keys, &root)?, keys.friction()))
}

impl ObjectTable {
    /// The keys that describe an object and its coefficient of friction, as [`read_object`] reads them.
    pub fn of(object: &ObjectDesign, friction: f64) -> Self {
        match *object {
            ObjectDesign::Circle { centre, radius } => Self::Circle { radius_mm: radius, centre_mm: centre, friction },
            ObjectDesign::Ellipse { centre, semi_axes, angle } => {
                Self::Ellipse { centre_mm: centre, semi_axes_mm: semi_axes, angle_deg: angle.to_degrees(), friction }
            }
            ObjectDesign::Polygon { corners, rounding } => {
                Self::Polygon { corners_mm: corners.to_vec(), rounding_mm: rounding, friction }
            }
            ObjectDesign::HalfPlane { point, normal } => Self::HalfPlane { point_mm: point, normal, friction },
            ObjectDesign::Bore { centre, radius } => Self::Bore { radius_mm: radius, centre_mm: centre, friction },
        }
    }
}

/// The object of a table that the schema's check has passed.
pub(super) fn build(keys: &ObjectTable, table: &Table<'_>) -> Result<ObjectDesign, CaseError> {
    let object = match keys {
        ObjectTable::Circle { radius_mm, centre_mm, .. } => {
            ObjectDesign::Circle { radius: *radius_mm, centre: *centre_mm }
        }
        ObjectTable::Ellipse { centre_mm, semi_axes_mm, angle_deg, .. } => {
            ObjectDesign::Ellipse { centre: *centre_mm, semi_axes: *semi_axes_mm, angle: angle_deg.to_radians() }
        }
        ObjectTable::Polygon { corners_mm, rounding_mm, .. } => {
            let full = || table.refuse("corners_mm", format!("at most {MAX_CORNERS} corners are allowed"));
            ObjectDesign::Polygon { corners: Corners::new(corners_mm).ok_or_else(full)?, rounding: *rounding_mm }
        }
        ObjectTable::HalfPlane { point_mm, normal, .. } => {
            ObjectDesign::HalfPlane { point: *point_mm, normal: *normal }
        }
        ObjectTable::Bore { radius_mm, centre_mm, .. } => ObjectDesign::Bore { radius: *radius_mm, centre: *centre_mm },
    };
    object.validate().map_err(|error| refusal(table, error))?;
    Ok(object)
}

/// The error at the place in the file that it is about.
fn refusal(table: &Table<'_>, error: ObjectError) -> CaseError {
    let corner = |index: usize, reason: &str| {
        let corners = table.find("corners_mm").and_then(|list| list.entries(String::new, MAX_CORNERS).ok());
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
