//! Refusals have the unit in which a person gave the number.

use messages::{Mount, Settings, SettingsField};

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
