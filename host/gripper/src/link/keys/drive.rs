//! How a motor moves its finger, in one value: `rotating`, `linear X,Y MM_PER_RAD`, or `table X,Y DEG:MM DEG:MM …`.

use model_core::drive::{Drive, Knots, Travel};

/// What a value may be.
pub(super) const ALLOWED: &str =
    "rotating, linear X,Y MM_PER_RAD, or table X,Y DEG:MM DEG:MM … with 2 to 6 knots (X,Y: the direction of closing)";

/// A drive as a value.
pub(super) fn words(drive: &Drive) -> String {
    match drive {
        Drive::Rotating => "rotating".to_owned(),
        Drive::Translating { direction: [x, y], travel: Travel::Linear { mm_per_rad } } => {
            format!("linear {x},{y} {mm_per_rad}")
        }
        Drive::Translating { direction: [x, y], travel: Travel::Table(knots) } => {
            let knots = knots.iter().map(|[angle, distance]| format!(" {}:{distance}", super::shown(*angle)));
            format!("table {x},{y}{}", knots.collect::<String>())
        }
    }
}

/// The drive that a value says, if it says one. (What is out of range the gripper refuses.)
pub(super) fn read(words: &str) -> Option<Drive> {
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
    fn what_is_no_drive_is_none() {
        for value in
            ["", "turning", "rotating 1", "linear 1,0", "linear 1 10", "linear 1,0 10 11", "table 1,0 3", "table"]
        {
            assert_eq!(read(value), None, "{value}");
        }
        assert_eq!(read("table 1,0 0:0 1:1 2:2 3:3 4:4 5:5 6:6"), None, "too many knots");
    }
}
