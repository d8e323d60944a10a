//! Files of measurements: any bytes give measurements that can be used, or an error that names the file, in words that can be shown.

use std::ops::ControlFlow;
use std::path::Path;

use fre::fit::measured::{Measured, outliers};

use crate::{Target, is_shown};

pub(crate) const TARGET: Target = Target { name: "measured", run, seeds, words };

const NAME: &str = "fuzz.csv";

fn run(bytes: &[u8]) {
    match Measured::read_from(NAME, bytes, |_| ControlFlow::Continue(())) {
        Ok(measured) => accepted(&measured),
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with(NAME) && is_shown(&message), "{message:?}");
        }
    }
}

/// What was accepted must be something that a comparison or a calibration can use.
fn accepted(measured: &Measured) {
    let Measured { measurements, problems, aside, .. } = measured;
    assert!(!measurements.is_empty() && aside.iter().all(|name| is_shown(name)), "{aside:?}");
    assert!(problems.windows(2).all(|pair| pair[0].line < pair[1].line), "{problems:?}");
    assert!(problems.iter().all(|problem| problem.line > 0 && is_shown(&problem.to_string())), "{problems:?}");
    for measurement in measurements {
        assert!(measurement.place.is_finite() && measurement.force.is_none_or(f64::is_finite), "{measurement:?}");
        assert!(measurement.front.iter().flatten().all(|number| number.is_finite()), "{measurement:?}");
        assert_eq!(measurement.front.len(), measurement.front_lines.len());
        // One outline after the other, and every point in one.
        let mut end = 0;
        for outline in measurement.outlines() {
            assert!(outline.start == end && outline.end > end, "{outline:?} after {end}");
            end = outline.end;
        }
        assert_eq!(end, measurement.front.len());
        let forces: Vec<f64> = measurement.forces.iter().map(|(_, force)| *force).collect();
        let out = outliers(&forces, 0.02);
        assert_eq!(measurement.without(&out, &[]).forces.len(), forces.len() - out.len());
    }
    let closing = measured.closing();
    assert!(closing.windows(2).all(|pair| pair[0].place < pair[1].place), "{closing:?}");
    let visits = measured.visits();
    assert!(visits.windows(2).all(|pair| pair[0].place != pair[1].place), "{visits:?}");
    if let Some(line) = measured.turns_at() {
        assert!(visits.iter().any(|visit| visit.line == line), "line {line}: {visits:?}");
    }
}

/// The example, and tables with what it leaves out.
fn seeds() -> Vec<Vec<u8>> {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/measured.csv");
    let example = std::fs::read(&example).unwrap_or_else(|error| panic!("{}: {error}", example.display()));
    let wide =
        |order: fn(u16) -> [u8; 2]| [0xFEFF].into_iter().chain(TEXTS[0].encode_utf16()).flat_map(order).collect();
    [example, wide(u16::to_le_bytes), wide(u16::to_be_bytes)]
        .into_iter()
        .chain(TEXTS.iter().map(|text| text.as_bytes().to_vec()))
        .collect()
}

const TEXTS: &[&str] = &[
    "# by hand\nnote,force_n,motor_angle_deg,front_x_mm,front_y_mm\nfirst,1.5,6,0 -1 -2,0 40 80\n\n\"two\nlines\",2.5,8,,\n",
    "distance_mm,fx_n,fy_n,front_x_mm,front_y_mm\n5,3,4,,\n5,0,7,,\n5,,,1,2\n5,,,3,4\n5,,,1.1,2\n5,,,3,4.5\n10,1,0,,\n",
    "sep=;\r\nMotor_Angle_Deg;Force_N;\"my \"\"own\"\" column\"\r\n6,5;1,25;a\r\n8;2,5;b\r\n6,5;1,5;\r\n",
    "time_s\tmotor_angle_deg\tmotor_torque_nmm\tforce_n\r0\t0\t\t0\r1\t4\t120.5\t0.9\r2\t6\t-3\t1.8\r3\t4\t80\t0.7\r",
    "\u{feff}motor_angle_deg,force_n\n6,1\n6,1.01\n6,0.99\n6,1.02\n6,9\n6,1\n",
    "motor_angle_deg,force_n,front_x_mm,front_y_mm\n6,1.0,,\n,1,,\n7,abc,,\n8,NaN,,\n10,1,1 2,3\n11,1\n12,-1,,\n-300,1,,\n5,1e6,,\n",
];

/// Columns, marks and numbers at the edge of what is believed.
fn words() -> Vec<String> {
    let words = [
        "motor_angle_deg",
        "distance_mm",
        "force_n",
        "fx_n",
        "fy_n",
        "front_x_mm",
        "front_y_mm",
        "time_s",
        "motor_torque_nmm",
        "arc_mm",
        "sep=;",
        "#",
        "\"",
        "\"\"",
        "\n",
        "\r\n",
        "\r",
        "\t",
        ";",
        ",",
        "1e5",
        "-180",
        "1e308",
        "-0",
        "1e-320",
        "inf",
        "nan",
    ];
    words.map(str::to_owned).into()
}
