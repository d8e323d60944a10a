//! The numbers of welds are those of finite elements of the junction.

use model_core::design::weld_numbers;
use reference_tests::junction::Junction;

/// The whole table, made again; and between its knots. Another Poisson's ratio changes it little.
#[test]
fn the_numbers_of_welds_are_those_of_finite_elements() {
    let made = |degrees: f64, rib: f64, nu: f64| {
        let junction = Junction { beam: 1.0, rib, angle: degrees.to_radians(), nu, fineness: 6 };
        let fit = junction.fit();
        let (numbers, off) = fit.numbers(&junction);
        println!(
            "{degrees}°, {rib}: stiff {:.3}, root {:.3}, coupling {:.3}; root's middle off by {off:.3}, left {:.2}/E",
            numbers[0], numbers[1], numbers[2], fit.left
        );
        assert!(off.abs() < 0.08, "the stiff length lies about the root's middle: {off}");
        numbers
    };
    for degrees in [90.0, 75.0, 60.0, 45.0, 30.0] {
        for rib in [0.2, 0.5, 1.0, 1.5, 2.0] {
            let (found, table) = (made(degrees, rib, 0.48), weld_numbers(rib, degrees));
            for (found, table) in found.iter().zip(table) {
                assert!((found - table).abs() < 0.02, "{degrees}° {rib}: {found} against {table}");
            }
        }
    }
    for (degrees, rib, nu) in
        [(82.0, 0.7, 0.48), (67.0, 0.35, 0.48), (52.0, 1.2, 0.48), (90.0, 0.5, 0.3), (60.0, 1.0, 0.3)]
    {
        let (found, table) = (made(degrees, rib, nu), weld_numbers(rib, degrees));
        for (found, table) in found.iter().zip(table) {
            assert!((found - table).abs() < 0.06, "{degrees}° {rib}: {found} against {table}");
        }
    }
}
