//! Files of measurements: what is read, what is left out and how it is told.

use host::measured::{Coordinate, Measured};

#[test]
fn forces_points_and_places_are_read_whatever_the_order_of_columns() {
    let text = "# by hand\nnote,force_n,motor_angle_deg,front_x_mm,front_y_mm\nfirst,1.5,6,0 -1 -2,0 40 80\n\nsecond,2.5,8,,\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    assert_eq!(measured.coordinate, Coordinate::MotorAngle);
    assert!(measured.problems.is_empty());
    let [a, b] = &measured.measurements[..] else { panic!("two places: {measured:?}") };
    assert_eq!((a.line, a.place, a.force), (3, 6.0, Some(1.5)));
    assert_eq!(a.front, [[0.0, 0.0], [-1.0, 40.0], [-2.0, 80.0]]);
    assert_eq!((b.line, b.place, b.force, b.front.len()), (5, 8.0, Some(2.5), 0));
}

#[test]
fn rows_of_a_place_are_one_measurement_and_its_forces_a_mean() {
    let text = "distance_mm,fx_n,fy_n,front_x_mm,front_y_mm\n5,3,4,,\n5,0,7,,\n5,,,1,2\n5,,,3,4\n10,1,0,,\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    assert_eq!(measured.coordinate, Coordinate::Distance);
    assert_eq!(measured.measurements.len(), 2);
    assert_eq!(measured.measurements[0].force, Some(6.0));
    assert_eq!(measured.measurements[0].front, [[1.0, 2.0], [3.0, 4.0]]);
}

#[test]
fn bad_rows_and_gaps_are_told_with_their_line_and_do_not_spoil_the_rest() {
    let text = "motor_angle_deg,force_n,front_x_mm,front_y_mm\n\
        6,1.0,,\n,1.0,,\n7,abc,,\n8,NaN,,\n9,,,\n10,1,1 2,3\n11,1\n12,-1,,\n13,2.0,,\n-300,1,,\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    let places: Vec<f64> = measured.measurements.iter().map(|m| m.place).collect();
    assert_eq!(places, [6.0, 13.0]);
    let lines: Vec<usize> = measured.problems.iter().map(|p| p.line).collect();
    assert_eq!(lines, [3, 4, 5, 6, 7, 8, 9, 11]);
    let words = [
        "motor_angle_deg is empty",
        "\"abc\"",
        "NaN",
        "neither",
        "front_x_mm has 2",
        "2 cells",
        "negative",
        "-180 to 180",
    ];
    for (problem, word) in measured.problems.iter().zip(words) {
        assert!(problem.reason.contains(word), "{problem} should tell of {word}");
    }
}

#[test]
fn a_header_that_lacks_something_says_what() {
    for (text, word) in [
        ("force_n\n1\n", "motor_angle_deg or distance_mm"),
        ("motor_angle_deg,distance_mm,force_n\n1,1,1\n", "both"),
        ("motor_angle_deg,fx_n\n1,1\n", "the other of a pair"),
        ("motor_angle_deg\n1\n", "a force"),
        ("motor_angle_deg;force_n\n1;2,5\n", "separated by commas"),
        ("", "no row"),
        ("motor_angle_deg,force_n\n1,x\n", "line 2"),
    ] {
        let error = Measured::parse("m.csv", text).unwrap_err().to_string();
        assert!(error.contains(word) && error.starts_with("m.csv"), "{error:?} should tell of {word:?}");
    }
}
