//! Files of measurements: what is read, what is left out and how it is told, by the library and by `fre compare`.

mod said;

use std::path::PathBuf;
use std::process::Command;

use fre::case::{Case, Coordinate};
use fre::fit::measured::Measured;
use fre::study::model::Options;
use fre::study::run;

#[test]
fn forces_points_and_places_are_read_whatever_the_order_of_columns() {
    let text = "# by hand\nnote,force_n,motor_angle_deg,front_x_mm,front_y_mm\nfirst,1.5,6,0 -1 -2,0 40 80\n\nsecond,2.5,8,,\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    assert_eq!(measured.coordinate, Coordinate::Angle);
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
fn a_magnitude_that_contradicts_its_components_is_left_out() {
    let text = "motor_angle_deg,force_n,fx_n,fy_n\n1,5,3,4\n2,5.05,3,4\n3,6,3,4\n4,0,0,0.0009\n5,0,0,0.002\n6,5,,\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    let places: Vec<f64> = measured.measurements.iter().map(|m| m.place).collect();
    assert_eq!(places, [1.0, 2.0, 4.0, 6.0]);
    let said: Vec<String> = measured.problems.iter().map(ToString::to_string).collect();
    snapbox::assert_data_eq!(
        said.join("\n"),
        snapbox::str![[r#"
4: force_n = 6, but fx_n and fy_n make 5.0000; allowed is a difference of 1 % + 0.001 N
6: force_n = 0, but fx_n and fy_n make 0.0020; allowed is a difference of 1 % + 0.001 N
"#]]
    );
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
    let said: Vec<String> = measured.problems.iter().map(ToString::to_string).collect();
    snapbox::assert_data_eq!(
        said.join("\n"),
        snapbox::str![[r#"
3: motor_angle_deg is empty; needed is a number
4: force_n = "abc" is not a finite number (the unit belongs in the header)
5: force_n = "NaN" is not a finite number (the unit belongs in the header)
6: has neither a force, nor a torque, nor a point
7: front_x_mm has 2 numbers, front_y_mm 1; needed are as many
8: has 2 cells, the header 4 (decimals have a point)
9: force_n = -1; a magnitude is not negative (components are fx_n, fy_n)
11: motor_angle_deg = -300; allowed is -180 to 180
"#]]
    );
}

#[test]
fn a_header_that_lacks_something_says_what() {
    let mut said = String::new();
    for text in [
        "force_n\n1\n",
        "motor_angle_deg,distance_mm,force_n\n1,1,1\n",
        "motor_angle_deg,force_n,force_n\n1,1,1\n",
        // Other units: what the file has is repeated.
        "motor_angle_rad,force_n\n1,1\n",
        "motor_angle_deg,force_mN\n1,1\n",
        "2,1.3\n4,2.5\n",
        "motor_angle_deg,fx_n\n1,1\n",
        "motor_angle_deg\n1\n",
        "",
        "motor_angle_deg,force_n\n",
        "motor_angle_deg,force_n\n1,x\n",
        // A decimal comma among commas, with quotation marks and without.
        "motor_angle_deg,force_n\n1,2,5\n",
        "motor_angle_deg,force_n\n1,\"2,5\"\n",
        "motor_angle_deg,force_n\n1,1e300\n",
        "motor_angle_deg,force_n\n1,2.5 N\n",
        "motor_angle_deg,front_x_mm,front_y_mm\n6,1e300,40\n",
        "motor_angle_deg,front_x_mm,front_y_mm\n6,0 1,4 -10001\n",
        // A word that only begins as a separator's line does.
        "sep=what,force_n\n1,2\n",
    ] {
        said += &format!("{text:?}\n{}\n\n", Measured::parse("m.csv", text).unwrap_err());
    }
    snapbox::assert_data_eq!(said, snapbox::file!["words/measured.txt"].raw());
}

#[test]
fn what_spreadsheets_write_is_read() {
    let plain = Measured::parse("m.csv", "motor_angle_deg,force_n\n2,1.25\n4,2.5\n").unwrap();
    for text in [
        "\u{feff}motor_angle_deg,force_n\r\n2,1.25\r\n4,2.5\r\n",
        "motor_angle_deg,force_n\r2,1.25\r4,2.5\r",
        "motor_angle_deg;force_n\n2;1,25\n4,0;2.5\n",
        "motor_angle_deg\tforce_n\n2\t1,25\n4\t2,5\n",
        "\"Motor_Angle_deg\", \"FORCE_N\"\n\"2.0\",1.25\n 4 , \"2.5\" \n",
        // Columns without a name, and cells beyond the header's last.
        "motor_angle_deg,force_n,,\n2,1.25,,\n4,2.5,,,,\n",
    ] {
        let measured = Measured::parse("m.csv", text).unwrap();
        assert_eq!(measured, plain, "{text:?}");
    }
    // Quotation marks hold commas and marks; what is left aside is named.
    let text = "motor_angle_deg,note,force_n,arc_mm\n2,\"slipped, \"\"twice\"\"\",1.25,0\n4,,2.5,0\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    assert_eq!((measured.measurements, measured.aside), (plain.measurements.clone(), vec!["note".to_owned()]));
    // Thousands are no decimals.
    let measured = Measured::parse("m.csv", "motor_angle_deg;force_n\n2;1.234,5\n4;1,2,3\n6;1\n").unwrap();
    assert_eq!(measured.problems.iter().map(|problem| problem.line).collect::<Vec<_>>(), [2, 3]);
}

#[test]
fn headers_of_spreadsheets_tell_their_separator() {
    let plain = Measured::parse("m.csv", "motor_angle_deg,force_n\n2,1.25\n4,2.5\n").unwrap();
    for (text, aside) in [
        // A comma in a name, with quotation marks and without.
        ("motor_angle_deg;force_n;\"Bemerkung, frei\"\n2;1,25;\n4;2,5;gut\n", "Bemerkung, frei"),
        ("motor_angle_deg;force_n;Bemerkung, frei\n2;1,25;\n4;2,5;gut\n", "Bemerkung, frei"),
        ("motor_angle_deg,force_n,note; where\n2,1.25,\n4,2.5,here\n", "note; where"),
        // What a spreadsheet writes before the header.
        ("sep=;\r\nmotor_angle_deg;force_n;x\r\n2;1,25;\r\n4;2,5;\r\n", "x"),
        ("\"SEP=|\"\nmotor_angle_deg|force_n|x\n2|1.25|\n4|2.5|\n", "x"),
    ] {
        let measured = Measured::parse("m.csv", text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        let forces = |measured: &Measured| measured.measurements.iter().map(|m| (m.place, m.force)).collect::<Vec<_>>();
        assert_eq!(forces(&measured), forces(&plain), "{text:?}");
        assert_eq!((measured.aside, measured.problems.len()), (vec![aside.to_owned()], 0), "{text:?}");
    }
}

#[test]
fn a_line_break_in_quotation_marks_belongs_to_its_cell_and_lines_stay_right() {
    for end in ["\n", "\r\n", "\r"] {
        let text = [
            "motor_angle_deg,\"note,",
            "of two lines\",force_n",
            "2,\"slipped",
            "",
            "# twice\"\", he said\" ,1.25",
            "3,x,abc",
            "4,\"open,2.5",
            "5,,3",
            "6,4\" wide,4",
            "7,\"a \"\" b",
            "\"x,5",
            "8,,6",
        ]
        .join(end);
        let measured = Measured::parse("m.csv", &text).unwrap();
        let read: Vec<_> = measured.measurements.iter().map(|m| (m.line, m.place, m.force)).collect();
        // A mark that is not closed, or by a word, spoils its own line.
        assert_eq!(
            read,
            [(3, 2.0, Some(1.25)), (8, 5.0, Some(3.0)), (9, 6.0, Some(4.0)), (12, 8.0, Some(6.0))],
            "{end:?}"
        );
        assert_eq!(measured.problems.iter().map(|p| p.line).collect::<Vec<_>>(), [6, 7, 10, 11], "{end:?}");
        assert_eq!(measured.aside, ["note,\\nof two lines"]);
    }
}

#[test]
fn what_is_no_text_is_repeated_in_bounds_and_without_control_characters() {
    let binary: String =
        (0..60_000_u32).filter_map(|i| char::from_u32(i * 7919 % 300)).filter(|&c| c != '\n').collect();
    let long = format!("motor_angle_deg,force_n\n1,{}\n", "\u{1b}[2J".repeat(10_000));
    let many = format!("{}\n", "a\u{7},".repeat(50_000));
    for text in [&binary, &long, &many, "a\u{1b}[31m,b\n1,2\n"] {
        let error = Measured::parse("m.csv", text).unwrap_err().to_string();
        assert!(!error.chars().any(char::is_control), "{error:?}");
        assert!(error.len() < 3000, "{} bytes: {error:?}", error.len());
    }
    let aside = "motor_angle_deg,force_n,x\u{1b}[2J\n1,2,3\n";
    assert_eq!(Measured::parse("m.csv", aside).unwrap().aside, ["x\\u{1b}[2J"]);
}

#[test]
fn a_file_without_an_end_is_refused() {
    let error = Measured::read(std::path::Path::new("/dev/zero")).unwrap_err().to_string();
    assert_eq!(error, "/dev/zero: is larger than 64 MB; allowed are measurements up to that size");
}

#[test]
fn a_motion_with_a_way_back_is_told_and_can_be_followed() {
    let text = "motor_angle_deg,force_n,front_x_mm,front_y_mm\n2,1,0 1,0 5\n2,1.2,,\n6,4,,\n2,0.8,,\n";
    let measured = Measured::parse("m.csv", text).unwrap();
    assert_eq!(measured.turns_at(), Some(5));
    let closing: Vec<_> = measured.closing().into_iter().map(|m| (m.line, m.place, m.force)).collect();
    assert_eq!(closing, [(2, 2.0, Some(1.0)), (4, 6.0, Some(4.0))]);
    let visits = measured.visits();
    let told: Vec<_> = visits.iter().map(|m| (m.line, m.place, m.force)).collect();
    assert_eq!(told, [(2, 2.0, Some(1.1)), (4, 6.0, Some(4.0)), (5, 2.0, Some(0.8))]);
    assert_eq!((&visits[0].front[..], &visits[0].front_lines[..]), (&[[0.0, 0.0], [1.0, 5.0]][..], &[2, 2][..]));
    for text in ["motor_angle_deg,force_n\n2,1\n4,2\n", "motor_angle_deg,force_n\n4,2\n2,1\n"] {
        assert_eq!(Measured::parse("m.csv", text).unwrap().turns_at(), None, "{text}");
    }
}

const CASE: &str = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\n\
                    centre_mm = [41.0, 45.0]\n[motion]\nmotor_angles_deg = [2]\n";

/// `fre compare` on a file: standard output and standard error.
fn compare(name: &str, csv: &[u8], options: &[&str]) -> (String, String) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("measured-{name}"));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("case.toml"), CASE).unwrap();
    std::fs::write(folder.join("m.csv"), csv).unwrap();
    let words = ["compare", "case.toml", "--measured", "m.csv"].iter().chain(options);
    let output = Command::new(env!("CARGO_BIN_EXE_fre")).args(words).current_dir(&folder).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    assert_eq!(output.status.code(), Some(0), "{name}: {}", text(output.stderr));
    (text(output.stdout), text(output.stderr))
}

#[test]
fn outliers_are_named_by_their_own_line_and_small_differences_are_none() {
    // Residuals of about −0.1 N but for one of +0.07 N: less than a load cell tells apart.
    let good = "motor_angle_deg,force_n\n2,1.3\n4,2.5\n6,3.9\n8,6.1\n10,10.5\n";
    let (told, _) = compare("good", good.as_bytes(), &[]);
    assert!(told.lines().any(|line| line.starts_with("force error: mean 3.6")), "{told}");
    snapbox::assert_data_eq!(
        said::words(&told),
        snapbox::str![[r#"
at ° force N measured N diff. N error % shape mean mm shape max mm status
# # # # # – – converged
force error: mean # %, max # % (at #°)
force difference: mean # N, max # N (at #°): # and # % of the largest measured force
"#]]
    );
    // One of three readings of a place: not the place's first line.
    let bad = "motor_angle_deg,force_n\n2,1.3\n4,2.5\n6,3.9\n8,6.1\n8,6.2\n8,12.2\n10,10.5\n";
    let (told, _) = compare("bad", bad.as_bytes(), &[]);
    let ending = "converged, mean of 3 readings (6.1 to 12.2 N), outlier (line 7)";
    assert_eq!(told.lines().filter(|line| line.ends_with(ending)).count(), 1, "{told}");
    assert!(told.lines().any(|line| line.starts_with("without these (1 reading): force error: mean 3.")), "{told}");
    snapbox::assert_data_eq!(
        said::words(&told),
        snapbox::str![[r#"
at ° force N measured N diff. N error % shape mean mm shape max mm status
# # # # # – – converged
# # # # # – – converged, mean of # readings (# to # N), outlier (line #)
# # # # # – – converged
force error: mean # %, max # % (at #°)
force difference: mean # N, max # N (at #°): # and # % of the largest measured force
without these (# reading): force error: mean # %, max # %; force difference: mean # N, max # N
"#]]
    );
    let (json, _) = compare("json", bad.as_bytes(), &["--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let row = &json["rows"][3];
    assert_eq!((row["line"].as_u64(), row["outlier"].as_bool()), (Some(5), Some(true)), "{row}");
    let lines: Vec<_> =
        row["readings"].as_array().unwrap().iter().map(|r| (r["line"].as_u64(), r["outlier"].as_bool())).collect();
    assert_eq!(lines, [(Some(5), Some(false)), (Some(6), Some(false)), (Some(7), Some(true))]);
    // A point of an outline with a wrong digit.
    let mut outline = "motor_angle_deg,front_x_mm,front_y_mm\n".to_owned();
    for i in 0..16 {
        let (x, y) = (-0.05 * f64::from(i), 5.0 * f64::from(i));
        outline += &format!("8,{},{y}\n", if i == 9 { 3.0 } else { x });
    }
    let (told, _) = compare("outline", outline.as_bytes(), &[]);
    assert!(told.lines().any(|line| line.starts_with("outlier: the point (3, 45) mm of line 11, at 8°")), "{told}");
    snapbox::assert_data_eq!(
        said::words(&told),
        snapbox::str![[r#"
at ° force N measured N diff. N error % shape mean mm shape max mm status
# # – – – # # converged
shape deviation (nearest distance): mean # mm, max # mm (at #° near (#, #) mm, finger frame)
outlier: the point (#, #) mm of line #, at #°, is # mm from the model
without these (# point): shape deviation: mean # mm, max # mm
# of # places have no measured force
"#]]
    );
}

/// The model's front centreline at an angle, its first and its last point 1 mm off.
fn front_with_ends_off(angle: f64) -> Vec<[f64; 2]> {
    let text = CASE.replace("[2]", &format!("[{angle:?}]"));
    let mut front = run::solve(&Case::parse("case.toml", &text).unwrap(), &Options::default()).unwrap().places[0]
        .front_mm()
        .to_vec();
    let last = front.len() - 1;
    front[0][0] += 1.0;
    front[last][1] += 1.0;
    front
}

fn outline_rows(place: f64, points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{place},,{x},{y}\n")).collect()
}

const OUTLINE_HEADER: &str = "motor_angle_deg,force_n,front_x_mm,front_y_mm\n";

#[test]
fn several_outlines_of_a_place_count_like_one() {
    let block = outline_rows(6.0, &front_with_ends_off(6.0));
    let elsewhere = outline_rows(8.0, &front_with_ends_off(8.0));
    let shape = |name: &str, csv: String| {
        let (json, _) = compare(name, csv.as_bytes(), &["--format", "json"]);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let row = &json["rows"][0];
        assert_eq!(row["place"].as_f64(), Some(6.0));
        // The seams are no slips: the ends of an outline have too few beside them.
        assert!(row.get("outlying_points").is_none() && row.get("without_outliers").is_none(), "{name}: {row}");
        ["shape_mean_mm", "shape_max_mm"].map(|key| row[key].as_f64().unwrap())
    };
    let once = shape("once", format!("{OUTLINE_HEADER}{block}"));
    assert!(once[0] < 0.03 && (0.9..1.1).contains(&once[1]), "{once:?}");
    for (name, csv) in [
        ("twice", format!("{OUTLINE_HEADER}{block}{block}")),
        ("ten-times", format!("{OUTLINE_HEADER}{}", block.repeat(10))),
        // Closing and opening.
        ("way-back", format!("{OUTLINE_HEADER}{block}{elsewhere}{block}")),
    ] {
        let several = shape(name, csv);
        assert!(several.iter().zip(once).all(|(a, b)| (a - b).abs() < 1e-9), "{name}: {several:?} {once:?}");
    }
}

#[test]
fn an_outline_begins_where_the_points_leap_back_for_good() {
    let parts = |points: &[[f64; 2]]| {
        let text = format!("{OUTLINE_HEADER}{}", outline_rows(6.0, points));
        let outlines = Measured::parse("m.csv", &text).unwrap().measurements[0].outlines();
        outlines.into_iter().map(|part| (part.start, part.end)).collect::<Vec<_>>()
    };
    let line: Vec<[f64; 2]> = (0..=16).map(|i| [0.01 * f64::from(i), 5.0 * f64::from(i)]).collect();
    assert_eq!(parts(&line), [(0, 17)]);
    assert_eq!(parts(&line.repeat(3)), [(0, 17), (17, 34), (34, 51)]);
    // 45 mm read as 4.5, and one that covers less.
    let mut slip = line.clone();
    slip[9][1] = 4.5;
    slip.extend(&line[1..9]);
    assert_eq!(parts(&slip), [(0, 17), (17, 25)]);
    assert_eq!(parts(&line[..1]), [(0, 1)]);
}

/// Outliers count, as only who measured can tell a slip from a wrong model; what is left without them stands beside.
#[test]
fn outliers_count_and_the_figures_without_them_stand_beside() {
    let front = front_with_ends_off(8.0);
    let mut slip = front.clone();
    slip[30][0] += 4.0;
    let forces = "2,1.3,,\n4,2.5,,\n6,3.9,,\n8,6.1,,\n8,12.2,,\n10,10.5,,\n";
    let good = "2,1.3,,\n4,2.5,,\n6,3.9,,\n8,6.1,,\n10,10.5,,\n";
    let file = |forces: &str, front: &[[f64; 2]]| format!("{OUTLINE_HEADER}{forces}{}", outline_rows(8.0, front));
    let figures = |text: &str, begin: &str| {
        let line = text.lines().find(|line| line.starts_with(begin)).unwrap_or_else(|| panic!("{begin}: {text}"));
        let at = line.find("mean ").unwrap();
        line[at..].split(" (").next().unwrap().to_owned()
    };
    // The point left out, not moved: its neighbours take over what it weighs.
    let mut rest = front;
    rest.remove(30);
    let (plain, _) = compare("without-slips", file(good, &rest).as_bytes(), &[]);
    let (told, _) = compare("with-slips", file(forces, &slip).as_bytes(), &[]);
    let without = told.lines().find(|line| line.starts_with("without these (1 reading, 1 point): ")).unwrap();
    for begin in ["force error: ", "force difference: ", "shape deviation"] {
        assert_ne!(figures(&told, begin), figures(&plain, begin));
        let there = &without[without.find(begin.trim_end_matches([':', ' '])).unwrap()..];
        let there = &there[there.find("mean ").unwrap()..];
        assert!(there.starts_with(&figures(&plain, begin)), "{without} should have {}", figures(&plain, begin));
    }
    let (json, _) = compare("slips-json", file(forces, &slip).as_bytes(), &["--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let row = &json["rows"][3];
    assert_eq!(row["reference_force_n"].as_f64(), Some(0.5 * (6.1 + 12.2)));
    assert_eq!(row["without_outliers"]["reference_force_n"].as_f64(), Some(6.1));
    assert!(json["rows"][0].get("without_outliers").is_none());

    // CSV: the lines in columns, the words beside.
    let (csv, beside) = compare("slips-csv", file(forces, &slip).as_bytes(), &["--format", "csv"]);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][rows[0].len() - 2..], ["outlier_lines", "outlying_point_lines"]);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    assert_eq!(rows[4][rows[0].len() - 2..], ["6", "38"], "{csv}");
    assert_eq!(rows[1][rows[0].len() - 2..], ["", ""], "{csv}");
    let outlier =
        |line: &str| line.starts_with("fre: outlier: the point (") && line.split(" of line 38, at 8°").count() == 2;
    assert!(beside.lines().any(outlier), "{beside}");
    assert!(beside.lines().any(|line| line.strip_prefix("fre: ") == Some(without)), "{beside}");
    snapbox::assert_data_eq!(
        said::words(&beside),
        snapbox::str![[r#"
fre: note: the places go back at line #; every reading is compared with a closing motion (--order file follows the file)
fre: outlier: the point (-#, #) mm of line #, at #°, is # mm from the model
fre: without these (# reading, # point): force error: mean # %, max # %; force difference: mean # N, max # N; shape deviation: mean # mm, max # mm
"#]]
    );
}

#[test]
fn wrong_units_are_doubted() {
    let mut notes = String::new();
    for (name, csv) in [
        ("millinewtons", "motor_angle_deg,force_n\n2,1300\n4,2500\n6,3900\n"),
        ("radians", "motor_angle_deg,force_n\n0.035,1.3\n0.07,2.5\n0.105,3.9\n"),
        ("centimetres", "motor_angle_deg,front_x_mm,front_y_mm\n8,0 -0.1 -0.3,0 4 8\n"),
        ("right", "motor_angle_deg,force_n\n2,1.3\n4,2.5\n6,3.9\n"),
    ] {
        let (told, _) = compare(name, csv.as_bytes(), &[]);
        notes += &format!("{name}\n");
        notes.extend(told.lines().filter(|line| line.starts_with("note")).map(|line| format!("{line}\n")));
    }
    let lengths = "is 8.0 mm long, the front beam 80.0 mm: only that part is compared";
    assert!(notes.lines().any(|line| line.ends_with(lengths)), "{notes}");
    snapbox::assert_data_eq!(
        said::words(&notes),
        snapbox::str![[r#"
millinewtons
note: the measured forces are about # times the model's: check the units (N, and degrees or mm) and where the case has its object
radians
note: the measured forces are about # times the model's: check the units (N, and degrees or mm) and where the case has its object
centimetres
note: the outline of line # is # mm long, the front beam # mm: only that part is compared
right
"#]]
    );
}

#[test]
fn a_table_of_places_has_its_columns_and_notes_stand_beside_it() {
    // As a spreadsheet's "Unicode text" is: UTF-16 with a byte order mark.
    let text = "motor_angle_deg\tforce_n\tnote\n10\t10,5\tx\n6\t3,9\t\n8\tabc\t\n10\t10,4\t\n";
    let bytes: Vec<u8> = "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let (csv, beside) = compare("csv", &bytes, &["--format", "csv", "--order", "file"]);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..4], ["motor_angle_deg", "status", "force_n", "reference_force_n"], "{csv}");
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{csv}");
    let places: Vec<_> = rows[1..].iter().map(|row| (row[0], row[1], row[3])).collect();
    assert_eq!(places, [("10", "converged", "10.5"), ("6", "converged", "3.9"), ("10", "converged", "10.4")]);
    snapbox::assert_data_eq!(
        said::words(&beside),
        snapbox::str![[r#"
fre: note: columns left aside: note
fre: left out: m.csv:#: force_n = "abc" is not a finite number (the unit belongs in the header)
"#]]
    );
}

/// A gauge's noise before contact is a hundred percent of itself, and nothing against the forces.
#[test]
fn percent_of_next_to_nothing_are_not_counted() {
    let csv = b"motor_angle_deg,force_n\n-1.2,0.02\n0,0.05\n6,3.7\n10,10.2\n";
    let (table, _) = compare("small", csv, &[]);
    let line = table.lines().find(|line| line.starts_with("force error: ")).unwrap();
    assert!(line.ends_with("not counted: 2 places with less than 0.102 N, 1 % of the largest"), "{line}");
    let mean: f64 = line["force error: mean ".len()..].split(' ').next().unwrap().parse().unwrap();
    let percent = |row: &str| row.split_whitespace().nth(4).unwrap().parse::<f64>().unwrap().abs();
    let counted: Vec<f64> = table.lines().filter(|line| line.ends_with("  converged")).map(percent).collect();
    assert_eq!(counted.len(), 2);
    assert!((mean - (counted[0] + counted[1]) / 2.0).abs() < 0.011, "{table}");
    // In the table they are.
    assert_eq!(table.matches("-100.00").count(), 2, "{table}");
    let difference = table.lines().find(|line| line.starts_with("force difference: ")).unwrap();
    assert!(difference.ends_with(" % of the largest measured force"), "{difference}");
}
