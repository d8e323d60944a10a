//! How a motor moves its finger: in one value, `rotating`, `linear X,Y MM_PER_RAD`, or `table X,Y DEG:MM DEG:MM …`.

use model_core::drive::{Drive, Knots, Travel};
use model_core::object::Motion;

/// What a value may be.
pub const ALLOWED: &str =
    "rotating, linear X,Y MM_PER_RAD, or table X,Y DEG:MM DEG:MM … with 2 to 6 knots (X,Y: the direction of closing)";

/// A drive as a value.
pub fn words(drive: &Drive) -> String {
    match drive {
        Drive::Rotating => "rotating".to_owned(),
        Drive::Translating { direction: [x, y], travel: Travel::Linear { mm_per_rad } } => {
            format!("linear {x},{y} {mm_per_rad}")
        }
        Drive::Translating { direction: [x, y], travel: Travel::Table(knots) } => {
            let knots = knots.iter().map(|[angle, distance]| format!(" {}:{distance}", degrees(*angle)));
            format!("table {x},{y}{}", knots.collect::<String>())
        }
    }
}

/// An angle in degrees, without the digits that a single-precision radian has not.
pub fn degrees(angle: f32) -> String {
    let degrees = f64::from(angle).to_degrees();
    ((degrees * 1e5).round() / 1e5 + 0.0).to_string()
}

/// The drive that a value says, if it says one. ([`Drive::validate`] finds what is out of range.)
pub fn read(words: &str) -> Option<Drive> {
    let pair = |word: &str, between: char| {
        let (first, second) = word.split_once(between)?;
        Some([first.parse::<f32>().ok()?, second.parse::<f32>().ok()?])
    };
    let mut words = words.split_whitespace();
    let kind = words.next()?;
    if kind == "rotating" {
        return words.next().is_none().then_some(Drive::Rotating);
    }
    let direction = pair(words.next()?, ',')?;
    let travel = match kind {
        "linear" => {
            let mm_per_rad = words.next()?.parse().ok()?;
            words.next().is_none().then_some(Travel::Linear { mm_per_rad })?
        }
        "table" => {
            let knots = words.map(|word| pair(word, ':').map(|[angle, distance]| [angle.to_radians(), distance]));
            Travel::Table(Knots::new(&knots.collect::<Option<Vec<_>>>()?)?)
        }
        _ => return None,
    };
    Some(Drive::Translating { direction, travel })
}

/// Why a case's motion is not that of a drive.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OtherMotion {
    /// The case moves its base along a line, the motor turns it.
    #[error("[motion] moves the base along a line; --drive is needed to say how far a turn of the motor moves it")]
    NoDrive,
    /// The case turns its base, the drive moves it along a line.
    #[error("[motion] turns the base, and --drive moves it along a line: give direction and distances_mm")]
    Turned,
    /// Both move it along a line, in different directions.
    #[error("motion.direction is {off_deg:.1}° from the direction of --drive; allowed is {ALIGNED_DEG}°")]
    Direction {
        /// Angle between both.
        off_deg: f64,
    },
}

/// Directions of case and drive that differ by more are two, degrees.
const ALIGNED_DEG: f64 = 0.1;

/// Whether a case's base moves as a drive moves it.
///
/// # Errors
/// How they differ.
pub fn agrees(motion: &Motion, drive: &Drive) -> Result<(), OtherMotion> {
    match (motion, drive.motion([0.0; 2])) {
        (Motion::Rotating { .. }, Motion::Rotating { .. }) => Ok(()),
        (Motion::Translating { .. }, Motion::Rotating { .. }) => Err(OtherMotion::NoDrive),
        (Motion::Rotating { .. }, Motion::Translating { .. }) => Err(OtherMotion::Turned),
        (Motion::Translating { direction: [x, y] }, Motion::Translating { direction: [u, v] }) => {
            let off_deg = (x * v - y * u).atan2(x * u + y * v).to_degrees().abs();
            if off_deg <= ALIGNED_DEG { Ok(()) } else { Err(OtherMotion::Direction { off_deg }) }
        }
    }
}

/// Whether the base of a case that is given to a gripper's finger moves as the finger's setting `drive` says. A case that turns its base may
/// be given to a jaw: where the finger moves is then the drive's alone.
///
/// # Errors
/// The case moves it along a line, and the drive does not, or along another one: for people, by the setting's key.
pub fn fits_finger(motion: &Motion, drive: &Drive, finger: usize) -> Result<(), String> {
    match agrees(motion, drive) {
        Ok(()) | Err(OtherMotion::Turned) => Ok(()),
        Err(OtherMotion::NoDrive) => Err(format!(
            "[motion] moves the base along a line, and finger.{finger}.drive is rotating; needed is finger.{finger}.drive=\"linear X,Y \
             MM_PER_RAD\" or \"table X,Y DEG:MM DEG:MM …\""
        )),
        Err(OtherMotion::Direction { off_deg }) => Err(format!(
            "motion.direction is {off_deg:.1}° from the direction of finger.{finger}.drive; allowed is {ALIGNED_DEG}°"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_comes_back_from_its_words() {
        for value in ["rotating", "linear 1,0 10.5", "linear -0.6,0.8 0.25", "table 1,0 -60:-17.3 0:0 30:10 60:17.25"] {
            let drive = read(value).unwrap_or_else(|| panic!("{value}"));
            assert_eq!(words(&drive), value);
        }
        let crank = read("table 1,0 -90:-20 90:20").unwrap();
        assert!((crank.range()[1] - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    }

    #[test]
    fn a_case_has_to_move_as_the_drive_does() {
        let turned = Motion::Rotating { axis: [0.0; 2] };
        let along = |direction| Motion::Translating { direction };
        let drive = read("linear 3,4 10").unwrap();
        assert_eq!(agrees(&turned, &Drive::Rotating), Ok(()));
        assert_eq!(agrees(&along([0.6, 0.8]), &drive), Ok(()));
        assert_eq!(agrees(&along([1.0, 0.0]), &Drive::Rotating), Err(OtherMotion::NoDrive));
        assert_eq!(agrees(&turned, &drive), Err(OtherMotion::Turned));
        for (direction, expected) in [([-0.6, -0.8], 180.0), ([0.8, 0.6], 16.26)] {
            match agrees(&along(direction), &drive) {
                Err(OtherMotion::Direction { off_deg }) => assert!((off_deg - expected).abs() < 0.01, "{off_deg}"),
                other => panic!("{other:?}"),
            }
        }
    }

    #[test]
    fn what_is_no_drive_is_none() {
        for value in
            ["", "turning", "rotating 1", "linear 1,0", "linear 1 10", "linear 1,0 10 11", "table 1,0 3", "table"]
        {
            assert_eq!(read(value), None, "{value}");
        }
        assert_eq!(read("table 1,0 0:0 1:1 2:2 3:3 4:4 5:5 6:6"), None, "too many knots");
    }
}
