//! Finger and object in one line.

use model_core::object::ObjectDesign;

use crate::case::Case;

/// The finger's name, and its object with its place: "ladder-80 on a cylinder Ø80 mm at (41, 60) mm".
pub fn headline(case: &Case) -> String {
    let at = |[x, y]: [f64; 2]| format!("at ({x}, {y}) mm");
    let object = match case.object {
        ObjectDesign::Circle { centre, radius } => format!("a cylinder Ø{} mm {}", 2.0 * radius, at(centre)),
        ObjectDesign::Ellipse { centre, semi_axes: [a, b], angle } => {
            let turned = if angle == 0.0 {
                String::new()
            } else {
                format!(" turned by {}°", (1e6 * angle.to_degrees()).round() / 1e6)
            };
            format!("an ellipse {} × {} mm {}{turned}", 2.0 * a, 2.0 * b, at(centre))
        }
        ObjectDesign::Polygon { corners, rounding } => {
            let corner = if corners.len() == 1 { "corner" } else { "corners" };
            format!("a polygon of {} {corner}, rounding {rounding} mm", corners.len())
        }
        ObjectDesign::HalfPlane { point, normal: [x, y] } => format!("a wall {}, normal ({x}, {y})", at(point)),
        ObjectDesign::Bore { centre, radius } => format!("a bore Ø{} mm {}", 2.0 * radius, at(centre)),
    };
    format!("{} on {object}", case.finger.name)
}
