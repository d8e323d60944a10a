//! The rows of `friction.csv`: the finger [`crate::fea_80`] rubbing on a circle that does not turn in the world, by finite elements.

use model_core::object::ObjectDesign;

/// A row; units in mm, N, N·mm, degrees.
#[derive(Clone, Copy, Debug)]
pub struct FrictionRow {
    /// Name of the pose.
    pub case: &'static str,
    /// Coefficient of friction.
    pub coefficient: f64,
    /// Radius of the circle, and height of its centre; it touches at 0.
    pub radius: f64,
    /// Height of its centre.
    pub height: f64,
    /// The motor opens; otherwise it closes.
    pub opens: bool,
    /// Motor angle, degrees.
    pub degrees: f64,
    /// Force on the object, world frame.
    pub force: [f64; 2],
    /// Its magnitude.
    pub magnitude: f64,
    /// Motor torque.
    pub torque: f64,
    /// Σ|τ|/(m Σμ).
    pub mobilised: f64,
    /// Part of the normal force that sticks.
    pub sticking: f64,
}

impl FrictionRow {
    /// The circle.
    pub fn object(&self) -> ObjectDesign {
        ObjectDesign::Circle { centre: [1.0 + self.radius, self.height], radius: self.radius }
    }
}

/// The rows of `friction.csv`, series by series, each closing and then opening.
///
/// # Panics
/// On a malformed file: the data are part of the tests.
pub fn friction_rows() -> impl Iterator<Item = FrictionRow> {
    let mut lines = include_str!("../friction.csv").lines();
    let header = lines.next().expect("friction.csv has a header");
    assert!(header.starts_with("code,case,mu,diameter_mm,contact_height_mm,mesh,step_deg,direction"), "{header}");
    lines.map(|line| {
        let field = |column: usize| line.split(',').nth(column).expect("a column");
        let number = |column: usize| -> f64 { field(column).parse().expect("a number") };
        FrictionRow {
            case: field(1),
            coefficient: number(2),
            radius: 0.5 * number(3),
            height: number(4),
            opens: field(7) == "opening",
            degrees: number(8),
            force: [number(9), number(10)],
            magnitude: number(13),
            torque: number(14),
            mobilised: if field(18).is_empty() { 0.0 } else { number(18) },
            sticking: if field(19).is_empty() { 0.0 } else { number(19) },
        }
    })
}
