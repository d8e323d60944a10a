//! The text of a description.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use model_core::object::Motion;

use super::names::{base, finger, joint};
use super::solid::Solid;

/// The link of a gripper with several fingers to which their frames are fixed.
pub const ROOT: &str = "gripper";
/// As many fingers as a gripper's firmware has room for.
pub const MOST_FINGERS: u8 = 4;
/// Greatest torque of the joint, N·m: the stall torque of an XM430-W350 at 12 V (ROBOTIS e-Manual).
pub const EFFORT: f64 = 4.1;
/// Greatest speed of the joint, rad/s: 46 rev/min of an XM430-W350 at 12 V without load.
pub const SPEED: f64 = 46.0 * TAU / 60.0;

/// Why there is no description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UrdfError {
    /// More fingers than a gripper has, or none.
    #[error("{0} fingers; allowed is 1 to {MOST_FINGERS}")]
    Fingers(u8),
    /// No room between the fingers.
    #[error("the distance between the fingers is {0} mm; allowed is above 0 to 10000")]
    Gap(f64),
    /// The joint has nowhere to go.
    #[error(
        "the joint's range is {0} to {1}; needed is a first number below the second, both within ±180° or ±1000 mm"
    )]
    Range(f64, f64),
    /// Not a density.
    #[error("the density is {0} kg/m³; allowed is above 0 to 30000")]
    Density(f64),
    /// A name that would need another spelling in XML and in a URI.
    #[error(
        "`{0}` cannot be part of a mesh's address; allowed is anything without blanks, quotation marks, <, > and &"
    )]
    Mesh(String),
}

/// A gripper of equal fingers around its axis, or one finger alone.
#[derive(Clone, Debug)]
pub struct Gripper {
    /// The robot's name; characters other than letters, digits, `_` and `-` become `_`.
    pub name: String,
    /// How many, 1 to [`MOST_FINGERS`]. One alone has no [`ROOT`].
    pub fingers: u8,
    /// Distance between the front beams' bases of opposite fingers where every joint is at 0, mm; of one alone without meaning.
    pub gap: f64,
    /// How the motor moves a finger.
    pub motion: Motion,
    /// Range of the joint: deg of a turned finger, mm of a moved one.
    pub range: [f64; 2],
    /// Whether the other joints follow that of finger 0 (mimic), or each has its own.
    pub follows: bool,
    /// Address of the finger's mesh, in mm, in the finger frame from z = 0 on.
    pub mesh: String,
    /// Width of the mesh, mm.
    pub width: f64,
    /// Mass and inertia of the mesh.
    pub solid: Solid,
}

impl Gripper {
    /// The description.
    ///
    /// # Errors
    /// A number that is out of its range, or a mesh's address that is not one.
    pub fn write(&self) -> Result<String, UrdfError> {
        self.check()?;
        let mut text = format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", word(&self.name));
        if self.fingers > 1 {
            put(&mut text, format_args!("  <link name=\"{ROOT}\"/>\n"));
        }
        for number in 0..self.fingers {
            self.finger(number, &mut text);
        }
        text += "</robot>\n";
        Ok(text)
    }

    fn check(&self) -> Result<(), UrdfError> {
        if !(1..=MOST_FINGERS).contains(&self.fingers) {
            return Err(UrdfError::Fingers(self.fingers));
        }
        if self.fingers > 1 && !(self.gap > 0.0 && self.gap <= 1e4) {
            return Err(UrdfError::Gap(self.gap));
        }
        let [low, high] = self.range;
        let most = if matches!(self.motion, Motion::Rotating { .. }) { 180.0 } else { 1000.0 };
        if !(low < high && -most <= low && high <= most) {
            return Err(UrdfError::Range(low, high));
        }
        let is_odd = |c: char| c.is_whitespace() || c.is_control() || "\"'<>&".contains(c);
        if self.mesh.is_empty() || self.mesh.contains(is_odd) {
            return Err(UrdfError::Mesh(self.mesh.clone()));
        }
        Ok(())
    }

    fn finger(&self, number: u8, text: &mut String) {
        let (base, finger, joint) = (base(number), finger(number), joint(number));
        put(text, format_args!("  <link name=\"{base}\"/>\n"));
        if self.fingers > 1 {
            // About the axis from the first finger on; then x to the object and y to the tips.
            let turn = TAU * f64::from(number) / f64::from(self.fingers);
            let out = 0.5e-3 * self.gap;
            let at = [0.0, out * turn.cos(), out * turn.sin()];
            put(text, format_args!("  <joint name=\"{base}_mount\" type=\"fixed\">\n"));
            put(text, format_args!("    <parent link=\"{ROOT}\"/>\n    <child link=\"{base}\"/>\n"));
            put(text, format_args!("    <origin xyz=\"{}\" rpy=\"{}\"/>\n", three(at), three([0.0, turn, -0.5 * PI])));
            *text += "  </joint>\n";
        }
        let (kind, axis, origin, [low, high], effort, speed) = self.joint();
        put(text, format_args!("  <joint name=\"{joint}\" type=\"{kind}\">\n"));
        put(text, format_args!("    <parent link=\"{base}\"/>\n    <child link=\"{finger}\"/>\n"));
        put(text, format_args!("    <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n", three(origin)));
        put(text, format_args!("    <axis xyz=\"{}\"/>\n", three(axis)));
        let limits = [low, high, effort, speed].map(digits);
        let [low, high, effort, speed] = limits;
        put(
            text,
            format_args!("    <limit lower=\"{low}\" upper=\"{high}\" effort=\"{effort}\" velocity=\"{speed}\"/>\n"),
        );
        if self.follows && number > 0 {
            put(text, format_args!("    <mimic joint=\"{}\"/>\n", super::joint(0)));
        }
        *text += "  </joint>\n";
        self.link(&finger, origin, text);
    }

    /// Type, axis, origin, range, greatest effort and speed of the motor's joint.
    fn joint(&self) -> (&'static str, [f64; 3], [f64; 3], [f64; 2], f64, f64) {
        match self.motion {
            // A positive angle turns clockwise as seen against z.
            Motion::Rotating { axis: [x, y] } => {
                let range = self.range.map(f64::to_radians);
                ("revolute", [0.0, 0.0, -1.0], [1e-3 * x, 1e-3 * y, 0.0], range, EFFORT, SPEED)
            }
            // What moves it is not known: a jaw's servo at a lever of 20 mm.
            Motion::Translating { direction: [x, y] } => {
                let lever = 0.02;
                let range = self.range.map(|mm| 1e-3 * mm);
                ("prismatic", [x, y, 0.0], [0.0; 3], range, EFFORT / lever, SPEED * lever)
            }
        }
    }

    /// The moving link; its origin is that of the joint.
    fn link(&self, name: &str, origin: [f64; 3], text: &mut String) {
        let Solid { mass, centre: [x, y], moments: [xx, yy, zz], product } = self.solid;
        put(text, format_args!("  <link name=\"{name}\">\n    <inertial>\n"));
        put(
            text,
            format_args!("      <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n", three([x - origin[0], y - origin[1], 0.0])),
        );
        put(text, format_args!("      <mass value=\"{}\"/>\n", digits(mass)));
        let [xx, yy, zz, xy] = [xx, yy, zz, product].map(digits);
        put(
            text,
            format_args!("      <inertia ixx=\"{xx}\" ixy=\"{xy}\" ixz=\"0\" iyy=\"{yy}\" iyz=\"0\" izz=\"{zz}\"/>\n"),
        );
        *text += "    </inertial>\n";
        let at = three([-origin[0], -origin[1], -0.5e-3 * self.width]);
        for part in ["visual", "collision"] {
            put(text, format_args!("    <{part}>\n      <origin xyz=\"{at}\" rpy=\"0 0 0\"/>\n"));
            let mesh = &self.mesh;
            put(
                text,
                format_args!("      <geometry><mesh filename=\"{mesh}\" scale=\"0.001 0.001 0.001\"/></geometry>\n"),
            );
            put(text, format_args!("    </{part}>\n"));
        }
        *text += "  </link>\n";
    }
}

/// Writing to a text cannot fail.
fn put(text: &mut String, words: std::fmt::Arguments<'_>) {
    let _ = text.write_fmt(words);
}

fn three(numbers: [f64; 3]) -> String {
    numbers.map(digits).join(" ")
}

/// Twelve digits after the first one; 0 for what rounding has left of it.
fn digits(number: f64) -> String {
    if number.abs() < 1e-15 {
        return "0".to_owned();
    }
    let rounded: f64 = format!("{number:.12e}").parse().unwrap_or(number);
    format!("{rounded}")
}

fn word(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
    let word: String = name.chars().map(plain).collect();
    if word.is_empty() { ROOT.to_owned() } else { word }
}
