//! Refusals have the unit in which a person gave the number.

use messages::{Direction, Mount, Settings, SettingsField};

#[test]
fn angles_and_speeds_are_refused_in_degrees() {
    let mount = Mount { speed: 1200.0_f32.to_radians(), ..Mount::DEFAULT };
    let words = Settings::of(mount).validate(1).unwrap_err().to_string();
    assert_eq!(words, "speed in degrees per second is 1200.000; allowed is 0.057 to 1145.916");
    let words = SettingsField::Angle.check(2.0, -0.5, 1.0).unwrap_err().to_string();
    assert_eq!(words, "angle in degrees is 114.592; allowed is -28.648 to 57.296");
    let words = SettingsField::Force.check(16.0, 0.01, 15.0).unwrap_err().to_string();
    assert_eq!(words, "force in N is 16; allowed is 0.01 to 15");
}

/// With a fence the range lies within the servo's revolution: what is beyond is named, in the finger's degrees.
#[test]
fn a_fence_allows_a_range_within_one_revolution() {
    let mount = |current_fence, gear_ratio, direction, range| {
        let mount = Mount { current_fence, gear_ratio, direction, range, ..Mount::DEFAULT };
        Settings::of(mount).validate(1).map_err(|refusal| refusal.to_string())
    };
    let (same, reversed) = (Direction::Same, Direction::Reversed);
    let [wide, narrow] = [[-1.0, 1.0], [-0.7, 0.7]];
    assert_eq!(mount(false, 4.0, same, wide), Ok(()));
    for direction in [same, reversed] {
        assert_eq!(mount(true, 1.0, direction, wide), Ok(()));
        assert_eq!(mount(true, 4.0, direction, narrow), Ok(()));
    }
    // Counts 0 and 4095 about 2048, through a gear of 4.
    let least = "least angle in degrees is -57.296; allowed is -45.000 to 44.978";
    assert_eq!(mount(true, 4.0, same, wide), Err(least.to_owned()));
    let greatest = "greatest angle in degrees is 57.296; allowed is -44.978 to 45.000";
    assert_eq!(mount(true, 4.0, reversed, [-0.7, 1.0]), Err(greatest.to_owned()));
}
