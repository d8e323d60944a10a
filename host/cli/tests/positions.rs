//! `fre replay` on a plain table of times and motor positions, whatever has recorded it.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

const CASE: &str = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n\
    [motion]\nmotor_angles_deg = [1, 3.5, 6, 8.25, 11]\n";
/// The motor angles of the case, deg.
const ANGLES: [f64; 5] = [1.0, 3.5, 6.0, 8.25, 11.0];
const AGAIN: &str = "--again --case case.toml --csv forces.csv";

/// A folder with the case, in which commands run.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("case.toml", CASE);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn fre(&self, words: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.args(words.split_whitespace()).current_dir(self.0.path()).output().unwrap()
    }

    /// The table with its forces, as columns and rows; what the command printed.
    fn label(&self, table: &str, options: &str) -> (Vec<String>, Vec<Vec<String>>, String) {
        self.write("positions.csv", table);
        let output = self.fre(&format!("replay positions.csv {AGAIN} --force {options}"));
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        // 2 where some row has no force.
        let (all, whole) = printed.split_once(" positions, ").unwrap_or_default();
        let whole = all.rsplit(' ').next() == whole.split(' ').next();
        let expected = Some(if whole { 0 } else { 2 });
        assert_eq!(output.status.code(), expected, "{options}: {}", String::from_utf8_lossy(&output.stderr));
        let mut reader = csv::Reader::from_path(self.path("forces.csv")).unwrap();
        let head = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let rows = reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect();
        (head, rows, printed)
    }

    /// The forces of a table, N.
    fn forces(&self, table: &str, options: &str) -> Vec<f64> {
        let (head, rows, _) = self.label(table, options);
        let column = head.iter().position(|name| name == "force_n").unwrap();
        rows.iter().map(|row| row[column].parse().unwrap()).collect()
    }

    /// Why a table gets no forces; no file is made.
    fn refusal(&self, table: &str, options: &str) -> String {
        self.write("positions.csv", table);
        let output = self.fre(&format!("replay positions.csv {options}"));
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{options}: {words}");
        assert!(!self.path("forces.csv").exists(), "{words}");
        words
    }
}

/// What `fre solve` finds at the same angles: magnitude, N, and torque, N·mm.
fn solved(folder: &Folder) -> Vec<[f64; 2]> {
    let output = folder.fre("solve case.toml --format json");
    assert!(output.status.success());
    let rows: Vec<Value> = serde_json::from_slice(&output.stdout).unwrap();
    rows.iter().map(|row| ["force_magnitude_n", "motor_torque_nmm"].map(|key| row[key].as_f64().unwrap())).collect()
}

fn table(column: &str, of: impl Fn(f64) -> f64) -> String {
    let rows = ANGLES.iter().enumerate().map(|(row, angle)| format!("{},{}\n", 0.1 * row as f64, of(*angle)));
    format!("time_s,{column}\n{}", rows.collect::<String>())
}

#[test]
fn positions_get_the_forces_that_solve_finds_there() {
    let folder = Folder::new();
    let wanted = solved(&folder);
    assert!(wanted[4][0] > 5.0, "a finger that presses: {wanted:?}");
    let rows = ANGLES.iter().enumerate().map(|(row, angle)| format!("7,\"a, b\",{},{angle},x\n", 0.1 * row as f64));
    let text = format!("episode,note,time_s,angle_deg,last\n{}", rows.collect::<String>());
    let (head, rows, printed) = folder.label(&text, "");
    let added = ["force_x_n", "force_y_n", "force_n", "standard_deviation_n", "torque_nmm", "status"];
    assert_eq!(head, [&["episode", "note", "time_s", "angle_deg", "last"][..], &added].concat());
    assert_eq!(printed, "positions.csv: 5 positions, 5 with a trustworthy force\n");
    assert_eq!(rows.len(), ANGLES.len());
    for (row, [force, torque]) in rows.iter().zip(&wanted) {
        assert_eq!([&row[0], &row[1], &row[4]], ["7", "a, b", "x"]);
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        // An estimate is single precision, whatever it was computed in.
        assert!((number(7) - force).abs() < 1e-5 * force.max(1.0), "{row:?}: {force}");
        assert!((number(5).hypot(number(6)) - force).abs() < 1e-5 * force.max(1.0), "{row:?}: {force}");
        assert!((number(9) - torque).abs() < 1e-5 * torque.abs().max(100.0), "{row:?}: {torque}");
        assert!(["converged", "no-contact"].contains(&row[10].as_str()), "{row:?}");
    }
    // Where the finger presses, an unknown zero makes the force uncertain.
    assert!(rows[4][8].parse::<f64>().unwrap() > 0.01, "{:?}", rows[4]);
}

#[test]
fn radians_and_counts_are_the_same_positions() {
    let folder = Folder::new();
    let degrees = folder.forces(&table("angle_deg", |angle| angle), "");
    let radians = folder.forces(&table("angle_rad", f64::to_radians), "");
    for (of_radians, of_degrees) in radians.iter().zip(&degrees) {
        assert!((of_radians - of_degrees).abs() < 1e-5, "{of_radians} {of_degrees}");
    }
    // 4096 counts are a turn; the servo's zero is at 2000 of them, and it turns the other way.
    let counts = |angle: f64| (2000.0 - angle / 360.0 * 4096.0).round();
    let settings = "--set finger.0.zero_counts=2000 --set finger.0.reversed=true";
    let of_counts = folder.forces(&table("position_counts", counts), settings);
    let rounded = |angle: f64| (2000.0 - counts(angle)) * 360.0 / 4096.0;
    let wanted = folder.forces(&table("angle_deg", rounded), "");
    assert!(wanted[4] > 5.0);
    for (of_counts, wanted) in of_counts.iter().zip(&wanted) {
        assert!((of_counts - wanted).abs() < 1e-4, "{of_counts} {wanted}");
    }
}

/// As spreadsheets save a table: semicolons and decimal commas, a byte order mark, capitals, an empty column; or tabs. The copy is like it.
#[test]
fn a_spreadsheet_s_table_gets_its_forces_in_its_own_way() {
    let folder = Folder::new();
    let plain = folder.forces(&table("angle_deg", |angle| angle), "");
    let rows = |separator: &str, decimal: &str| {
        let comma = |number: f64| number.to_string().replace('.', decimal);
        let row = |(row, angle): (usize, &f64)| {
            ["1,5 mm".to_owned(), comma(0.1 * row as f64), comma(*angle), String::new()].join(separator) + "\r\n"
        };
        let head = ["note", "Time_s", "Angle_deg", ""].join(separator) + "\r\n";
        head + &ANGLES.iter().enumerate().map(row).collect::<String>()
    };
    for (text, separator, decimal) in [
        ("\u{feff}".to_owned() + &rows(";", ","), b';', ","),
        (rows("\t", "."), b'\t', "."),
        (rows("\t", ","), b'\t', ","),
    ] {
        folder.write("positions.csv", &text);
        let output = folder.fre(&format!("replay positions.csv {AGAIN} --force"));
        assert_eq!(output.status.code(), Some(0), "{text}: {}", String::from_utf8_lossy(&output.stderr));
        let mut reader = csv::ReaderBuilder::new().delimiter(separator).from_path(folder.path("forces.csv")).unwrap();
        assert_eq!(
            reader.headers().unwrap().iter().take(5).collect::<Vec<_>>(),
            ["note", "Time_s", "Angle_deg", "", "force_x_n"]
        );
        for (row, (plain, angle)) in reader.records().zip(plain.iter().zip(ANGLES)) {
            let row = row.unwrap();
            let number = |column: usize| {
                assert!(decimal == "." || !row[column].contains('.'), "{row:?}");
                row[column].replace(decimal, ".").parse::<f64>().unwrap()
            };
            assert_eq!((&row[0], number(2), number(6)), ("1,5 mm", angle, *plain));
        }
        assert!(String::from_utf8_lossy(&output.stdout).contains("5 positions, 5 with a trustworthy force"));
    }
}

#[test]
fn a_table_goes_from_standard_input_to_standard_output() {
    let folder = Folder::new();
    let text = table("angle_deg", |angle| angle);
    folder.label(&text, "");
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args("replay - --again --case case.toml --csv -".split(' ')).current_dir(folder.0.path());
    let table = fs::File::open(folder.path("positions.csv")).unwrap();
    let output = command.stdin(table).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        (output.status.code(), said.as_str()),
        (Some(0), "fre: standard input: 5 positions, 5 with a trustworthy force\n")
    );
    assert_eq!(output.stdout, fs::read(folder.path("forces.csv")).unwrap());
}

/// A wrong cell at the end, after more rows than a buffer holds: a program that reads the copy gets no half of it.
#[test]
fn nothing_is_printed_of_a_table_with_a_wrong_cell() {
    let folder = Folder::new();
    let rows: String = (0..500).map(|row| format!("{row},0,{}\n", "x".repeat(40))).collect();
    folder.write("positions.csv", &format!("time_s,angle_deg,note\n{rows}500,wide,\n"));
    let output = folder.fre("replay positions.csv --again --case case.toml --csv -");
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stdout).as_ref()), (Some(1), ""));
    assert!(String::from_utf8_lossy(&output.stderr).starts_with("fre: positions.csv:502: "));
}

#[test]
fn a_leap_is_followed_and_what_is_beyond_the_finger_has_no_force() {
    let folder = Folder::new();
    let text = "time_s,angle_deg\n0,0\n1,11\n2,120\n3,11\n";
    let (_, rows, printed) = folder.label(text, "");
    assert_eq!(printed, "positions.csv: 4 positions, 3 with a trustworthy force\n");
    let wanted = solved(&folder)[4][0];
    for row in [&rows[1], &rows[3]] {
        assert!((row[4].parse::<f64>().unwrap() - wanted).abs() < 1e-4 * wanted, "{row:?}: {wanted}");
    }
    assert_eq!(rows[2][2..7], [""; 5]);
    assert_eq!([&rows[2][7], &rows[3][7]], ["out-of-range", "converged"]);
}

#[test]
fn a_table_that_gets_no_forces_says_why() {
    let folder = Folder::new();
    let good = table("angle_deg", |angle| angle);
    let tables = [
        "t,angle_deg\n0,1\n",
        "time_s,angle\n0,1\n",
        "time_s,angle_deg,angle_rad\n0,1,1\n",
        "time_s,angle_deg,force_n\n0,1,1\n",
        "time_s,angle_deg\n0,1\n0.1,wide\n",
        "time_s,angle_deg\n0,1\n0.1,nan\n",
        "time_s,angle_deg\n1,1\n1,2\n",
        // As spreadsheets and Python end their lines.
        "time_s,angle_deg\r\n1,1\r\n1,2\r\n",
        // A row without its position.
        "time_s,angle_deg\n0,1\n0.1\n",
        "time_s,position_counts\n0,2048.5\n",
    ];
    let options = [
        "",
        "--again --case case.toml",
        "--again --csv forces.csv",
        &format!("{AGAIN} --set finger.0.colour=red"),
        &format!("{AGAIN} --youngs-modulus-pa 5e7"),
        "--again --case nowhere.toml --csv forces.csv",
        "--again --case case.toml --csv positions.csv --force",
    ];
    let of_tables = tables.iter().map(|table| format!("{table:?}\n{}", folder.refusal(table, AGAIN)));
    let of_options = options.iter().map(|options| format!("\"{options}\"\n{}", folder.refusal(&good, options)));
    let said: Vec<String> = of_tables.chain(of_options).collect();
    snapbox::assert_data_eq!(said.join("\n"), snapbox::file!["words/positions.txt"].raw());
    assert_eq!(fs::read_to_string(folder.path("positions.csv")).unwrap(), good);
}

/// With friction the force depends on the way that the table describes, and lies in an interval where the motion has just turned round.
#[test]
fn with_friction_the_way_matters() {
    let folder = Folder::new();
    let rough = CASE.replace("radius_mm", "friction = 0.6\nradius_mm");
    folder.write("case.toml", &rough.replace("[1, 3.5, 6, 8.25, 11]", "[0, 2, 4, 6, 8, 7.9, 6, 4]"));
    let table = "time_s,angle_deg\n0,-1\n1,2\n2,6\n3,8\n4,7.8\n5,6\n6,4\n";
    let (head, rows, words) = folder.label(table, "");
    snapbox::assert_data_eq!(
        words,
        snapbox::str![[r#"
positions.csv: 7 positions, 7 with a trustworthy force

"#]]
    );
    let column = |name: &str| head.iter().position(|column| column == name).unwrap();
    let number = |row: usize, name: &str| rows[row][column(name)].parse::<f64>().unwrap();
    let solved = solved(&folder);
    // Closing at 2, 6 and 8°, opening at 6 and 4°.
    for (row, solved) in [(1, solved[1]), (2, solved[3]), (3, solved[4]), (5, solved[6]), (6, solved[7])] {
        let (force, torque) = (number(row, "force_n"), number(row, "torque_nmm"));
        assert!((force / solved[0] - 1.0).abs() < 0.02, "row {row}: {force} {solved:?}");
        assert!((torque / solved[1] - 1.0).abs() < 0.02, "row {row}: {torque} {solved:?}");
        let (low, high) = (number(row, "force_interval_low_n"), number(row, "force_interval_high_n"));
        assert!(
            low <= force * 1.0001 && force * 0.9999 <= high && high - low < 0.05 * force,
            "row {row}: {low} {high}"
        );
        assert!(number(row, "standard_deviation_n") > 0.0);
    }
    assert!(number(2, "force_n") > 1.1 * number(5, "force_n"), "closing and opening");
    // A reversal of 0.2° may not have reached the finger.
    assert!(number(4, "force_interval_high_n") - number(4, "force_interval_low_n") > 0.05 * number(4, "force_n"));
    // Without friction there are no such columns.
    folder.write("case.toml", CASE);
    let (head, ..) = folder.label(table, "");
    assert!(!head.iter().any(|name| name.contains("interval")));
}

/// A jaw's case for a motor that turns its finger: no silent rotation.
#[test]
fn a_table_without_a_row_or_with_bytes_that_are_no_text_is_refused() {
    let folder = Folder::new();
    assert_eq!(
        folder.refusal("time_s,angle_deg\n", AGAIN),
        "fre: positions.csv: has no row below its header; needed is at least one\n"
    );
    fs::write(folder.path("latin.csv"), b"time_s,angle_deg,note\n0,1,a\n1,2,H\xf6he\n").unwrap();
    let output = folder.fre("replay latin.csv --again --case case.toml --csv -");
    assert_eq!(
        (output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()),
        (Some(1), "fre: latin.csv:3: is not text; allowed is a table in UTF-8 or UTF-16\n")
    );
    assert!(output.stdout.is_empty());
    assert_eq!(
        folder.refusal("time_s,angle_deg\n0,1\n", &format!("{AGAIN} --case case.toml")),
        "fre: --case is given 2 times; a table of positions has one finger\n"
    );
}

#[test]
fn a_case_along_a_line_needs_a_drive_along_it() {
    let folder = Folder::new();
    folder.write(
        "case.toml",
        &CASE.replace("motor_angles_deg = [1, 3.5, 6, 8.25, 11]", "direction = [1, 0]\ndistances_mm = [2]"),
    );
    let table = "time_s,angle_rad\n0,0.1\n";
    snapbox::assert_data_eq!(
        folder.refusal(table, AGAIN),
        snapbox::str![[r#"
fre: case.toml: [motion] moves the base along a line, and finger.0.drive is rotating; needed is finger.0.drive="linear X,Y MM_PER_RAD" or "table X,Y DEG:MM DEG:MM …"

"#]]
    );
    let output = |drive: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.args(["replay", "positions.csv"]).args(AGAIN.split(' ')).args(["--set", drive]);
        command.current_dir(folder.0.path()).output().unwrap()
    };
    let refused = output("finger.0.drive=linear 0,1 20");
    snapbox::assert_data_eq!(
        refused.stderr,
        snapbox::str![[r#"
fre: case.toml: motion.direction is 90.0° from the direction of finger.0.drive; allowed is 0.1°

"#]]
    );
    assert!(!folder.path("forces.csv").exists());
    // 0.1 rad are 2 mm.
    let jaw = output("finger.0.drive=linear 1,0 20");
    assert_eq!(jaw.status.code(), Some(0), "{}", String::from_utf8_lossy(&jaw.stderr));
    let mut reader = csv::Reader::from_path(folder.path("forces.csv")).unwrap();
    let force: f64 = reader.records().next().unwrap().unwrap()[4].parse().unwrap();
    let wanted = solved(&folder)[0][0];
    assert!((force - wanted).abs() < 1e-5 && wanted > 0.1, "{force} N for {wanted} N");
}
