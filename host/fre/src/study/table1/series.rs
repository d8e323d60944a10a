//! The five series of grasps.

use model_core::object::ObjectDesign;

use crate::case::{Case, CaseError, MotionPath, Written, no_such_preset, preset};

/// The finger.
pub const PRESET: &str = "dhas-80";
/// Degrees from first contact to a series' first angle.
pub const APPROACH_DEG: f64 = 6.0;
/// Degrees before first contact at which the path begins.
const CLEARANCE_DEG: f64 = 1.0;
/// Cases of the table.
pub const CASES: usize = 20;

/// Grasps of one object at one height, at four motor angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// Name of the height in the paper.
    pub height: &'static str,
    /// First contact on the front beam, mm above its base (chosen here).
    pub height_mm: f64,
    /// The cylinder's diameter, mm.
    pub diameter_mm: f64,
    /// Motor angles, degrees (the paper's Table 1).
    pub angles_deg: [f64; 4],
}

const HIGH: (&str, f64) = ("High", 60.0);
const MID: (&str, f64) = ("Mid", 45.0);
const LOW: (&str, f64) = ("Low", 25.0);

const fn series(diameter_mm: f64, (height, height_mm): (&'static str, f64), angles_deg: [f64; 4]) -> Series {
    Series { height, height_mm, diameter_mm, angles_deg }
}

/// The five series.
pub const SERIES: [Series; 5] = [
    series(80.0, HIGH, [11.0, 13.0, 15.0, 17.0]),
    series(80.0, MID, [12.0, 15.0, 17.0, 19.0]),
    series(80.0, LOW, [13.0, 15.0, 17.0, 19.0]),
    series(60.0, HIGH, [18.0, 20.0, 22.0, 24.0]),
    series(60.0, LOW, [22.0, 24.0, 26.0, 28.0]),
];

impl Series {
    /// Name of a case of this series.
    pub fn name(&self, angle: usize) -> String {
        format!("Ø{} {} α{}", self.diameter_mm, self.height, angle + 1)
    }

    /// The case: the path begins 1° before first contact and leads through the four angles.
    ///
    /// # Errors
    /// None with the fingers that come with the program.
    pub fn case(&self) -> Result<Case, CaseError> {
        let missing = || CaseError::Unreadable {
            file: PRESET.to_owned(),
            kind: std::io::ErrorKind::NotFound,
            reason: no_such_preset(),
        };
        let finger = preset(PRESET).ok_or_else(missing)??;
        let touch_deg = self.angles_deg[0] - APPROACH_DEG;
        let (front, radius) = (&finger.design.front, self.diameter_mm / 2.0);
        let arc = front.arc_at_height(self.height_mm);
        // At first contact the undeformed front face, upright in the finger's frame, is tangent to the cylinder.
        let [x, y] = front.point(arc);
        let [ux, uy] = front.direction(arc);
        let away = radius + front.thickness.at(arc) / 2.0;
        let [mx, my] = finger.design.motor_axis;
        let (from_x, from_y) = (x + uy * away - mx, y - ux * away - my);
        let (sin, cos) = touch_deg.to_radians().sin_cos();
        let centre = [mx + cos * from_x + sin * from_y, my - sin * from_x + cos * from_y];
        let mut places = vec![touch_deg - CLEARANCE_DEG];
        places.extend(self.angles_deg);
        let path = MotionPath::rotating(&finger, places);
        Ok(Case {
            finger,
            object: ObjectDesign::Circle { centre, radius },
            friction: 0.0,
            path,
            written: Written::default(),
        })
    }
}
