//! The numbers of welds are those of finite elements of the junction.

use model_core::design::weld_numbers;
use reference_tests::junction::Junction;

/// The whole table, made again; and between its knots. Another Poisson's ratio changes it little.
#[test]
fn the_numbers_of_welds_are_those_of_finite_elements() {
    let made = |degrees: f64, rib: f64, fillet: f64, nu: f64| {
        let angle = degrees.to_radians();
        let junction = Junction { beam: 1.0, rib, angle, fillet: fillet * rib, nu, fineness: 8 };
        let numbers = junction.fit().numbers(&junction);
        println!("{degrees}°, {rib}, {fillet}: stiff, lean, root, coupling, turn, stretch, shear {numbers:.3?}");
        numbers
    };
    for fillet in [0.0, 0.5, 1.0, 2.0] {
        // A rib that is square to the beam leans nowhere: the limit.
        for (degrees, at) in [(90.0, 89.99), (75.0, 75.0), (60.0, 60.0), (45.0, 45.0), (30.0, 30.0)] {
            for rib in [0.2, 0.5, 1.0, 1.5, 2.0] {
                let (found, table) = (made(at, rib, fillet, 0.48), weld_numbers(rib, degrees, fillet));
                for (found, table) in found.iter().zip(table) {
                    assert!((found - table).abs() < 0.002, "{degrees}° {rib} {fillet}: {found} against {table}");
                }
            }
        }
    }
    let within = |degrees: f64, rib: f64, fillet: f64, nu: f64, tolerance: f64| {
        let (found, table) = (made(degrees, rib, fillet, nu), weld_numbers(rib, degrees, fillet));
        for (found, table) in found.iter().zip(table) {
            let off = (found - table).abs();
            assert!(off < tolerance * table.abs().max(1.0), "{degrees}° {rib} {fillet}: {found} against {table}");
        }
    };
    for (degrees, rib, nu) in
        [(82.0, 0.7, 0.48), (67.0, 0.35, 0.48), (52.0, 1.2, 0.48), (89.99, 0.5, 0.3), (60.0, 1.0, 0.3)]
    {
        within(degrees, rib, 0.0, nu, 0.04);
    }
    for (degrees, rib, fillet, nu) in [
        (82.0, 0.7, 0.25, 0.48),
        (67.0, 0.35, 0.3, 0.48),
        (52.0, 1.2, 0.75, 0.48),
        (37.0, 0.6, 0.5, 0.48),
        (89.99, 0.5, 0.75, 0.3),
        (70.0, 0.9, 1.5, 0.48),
    ] {
        within(degrees, rib, fillet, nu, 0.08);
    }
}
