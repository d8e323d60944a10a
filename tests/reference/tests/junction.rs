//! The numbers of welds are those of finite elements of the junction.

use model_core::design::weld_numbers;
use reference_tests::junction::Junction;

/// The whole table, made again; and between its knots. Another Poisson's ratio changes it little.
#[test]
fn the_numbers_of_welds_are_those_of_finite_elements() {
    let made = |degrees: f64, rib: f64, nu: f64| {
        let junction = Junction { beam: 1.0, rib, angle: degrees.to_radians(), nu, fineness: 8 };
        let numbers = junction.fit().numbers(&junction);
        println!("{degrees}°, {rib}: stiff, lean, root, coupling, turn, stretch, shear {numbers:.3?}");
        numbers
    };
    // A rib that is square to the beam leans nowhere: the limit.
    for (degrees, at) in [(90.0, 89.0), (75.0, 75.0), (60.0, 60.0), (45.0, 45.0), (30.0, 30.0)] {
        for rib in [0.2, 0.5, 1.0, 1.5, 2.0] {
            let (found, table) = (made(at, rib, 0.48), weld_numbers(rib, degrees));
            for (found, table) in found.iter().zip(table) {
                assert!((found - table).abs() < 0.002, "{degrees}° {rib}: {found} against {table}");
            }
        }
    }
    for (degrees, rib, nu) in
        [(82.0, 0.7, 0.48), (67.0, 0.35, 0.48), (52.0, 1.2, 0.48), (89.0, 0.5, 0.3), (60.0, 1.0, 0.3)]
    {
        let (found, table) = (made(degrees, rib, nu), weld_numbers(rib, degrees));
        for (found, table) in found.iter().zip(table) {
            assert!((found - table).abs() < 0.04, "{degrees}° {rib}: {found} against {table}");
        }
    }
}
