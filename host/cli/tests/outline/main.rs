//! `fre outline` on photographs whose truth is known: accuracy with perspective, lens, noise and blur.

#[path = "../said/mod.rs"]
mod said;

mod refused;
mod scene;

use crate::scene::{
    ANGLE, Folder, LENS, MARKS, STRAIGHT, arc_error, boards, command, deviation, exact_marks, mark, sheet, solved,
    solved_at, words,
};
use test_photograph::{BRIGHT_FINGER, DARK_FINGER, Eye, Lights, save};

#[test]
fn perspective_noise_and_blur_leave_a_tenth_of_a_millimetre() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [14.0, -17.0, 6.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.3, 3.0, 1), &folder.path("photo.png"));
    // Marks are clicked, a few pixels off; their dots are found.
    let clicks = [[7.0, -5.0], [-6.0, 4.0], [3.0, 9.0], [-8.0, -3.0]];
    let clicked: Vec<String> = MARKS
        .iter()
        .zip(clicks)
        .map(|(&mm, [dx, dy])| {
            let [x, y] = eye.pixel(mm);
            mark([x + dx, y + dy], mm)
        })
        .collect();
    let (points, arcs) = folder.outline_and_arcs(ANGLE, &clicked, &["--dot-mm", "4", "--plot", "overlay.png"]);
    let off = arc_error(&points, &arcs, solution.front_mm());
    println!("arc lengths within {off:.3} mm");
    assert!(off < 0.3, "arc length off by {off}");
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("perspective, clicked dots: mean {mean:.4} mm, max {max:.4} mm of {} points", points.len());
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");
    // From base to tip, without holes.
    assert!(points[0][1] < 3.0 && points[points.len() - 1][1] > 75.0, "{points:?}");
    assert!(points.windows(2).all(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]) < 2.5));
    let overlay = image::open(folder.path("overlay.png")).unwrap().to_rgb8();
    let red = overlay.pixels().filter(|p| p.0[0] > 180 && p.0[1] < 90 && p.0[2] < 90).count();
    assert!(red > 800, "{red} red pixels of the outline");

    // A similarity instead of a perspective through the same marks is far off: the perspective is really needed.
    let similar: Vec<[f64; 2]> = MARKS.iter().map(|&mm| eye.pixel(mm)).collect();
    let flat: Vec<String> = similarity(&MARKS, &similar).iter().zip(MARKS).map(|(&p, mm)| mark(p, mm)).collect();
    let [mean, _] = deviation(&folder.outline(&flat, &[]), solution.front_mm());
    println!("without perspective: mean {mean:.3} mm");
    assert!(mean > 0.5, "mean {mean}");
}

/// Least-squares similarity (mirrored: y is up in mm, down in pixels) of places, applied to them.
fn similarity(mm: &[[f64; 2]], pixels: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = mm.len() as f64;
    let centre = |points: &[[f64; 2]]| [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
    let (from, to) = (centre(mm), centre(pixels));
    let (mut a, mut b, mut size) = (0.0, 0.0, 0.0);
    for (p, q) in mm.iter().zip(pixels) {
        let (x, y) = (p[0] - from[0], from[1] - p[1]);
        let (u, v) = (q[0] - to[0], q[1] - to[1]);
        a += x * u + y * v;
        b += x * v - y * u;
        size += x * x + y * y;
    }
    let (a, b) = (a / size, b / size);
    let map = |p: &[f64; 2]| {
        let (x, y) = (p[0] - from[0], from[1] - p[1]);
        [to[0] + a * x - b * y, to[1] + b * x + a * y]
    };
    mm.iter().map(map).collect()
}

#[test]
fn a_checkerboard_removes_the_lens() {
    let folder = Folder::new();
    let lens = Eye { lens: LENS, centre: [507.0, 640.0], focal: [1705.0, 1698.0], ..STRAIGHT };
    let eye = lens.looking_at([-8.0, 40.0], 170.0, [-10.0, 12.0, -4.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.1, 2.5, 2), &folder.path("photo.png"));
    let boards = boards(&lens, folder.0.path());
    let marks = exact_marks(&eye);
    let mut options = vec!["--squares", "10x7", "--square-mm", "12", "--save-camera", "camera.toml", "--checkerboard"];
    options.extend(boards.iter().map(String::as_str));
    let points = folder.outline(&marks, &options);
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("lens and perspective: mean {mean:.4} mm, max {max:.4} mm");
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");

    // The camera kept in a file gives the same.
    let again = folder.outline(&marks, &["--camera", "camera.toml"]);
    assert_eq!(points, again);

    // Without it the lens is really in the way.
    let [ignored, max] = deviation(&folder.outline(&marks, &[]), solution.front_mm());
    println!("lens ignored: mean {ignored:.4} mm, max {max:.4} mm");
    assert!(ignored > 4.0 * mean && max > 0.15, "mean {ignored}, max {max}");
}

#[test]
fn marks_that_stand_still_and_a_bright_finger_seen_from_behind() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([0.0, 38.0], 170.0, [-9.0, 8.0, -5.0], true);
    let solution = solved();
    // Everything is drawn where it stands in the world; the outline must come back in the finger frame.
    let sheet = sheet(BRIGHT_FINGER, &solution, &MARKS, true);
    save(&eye.photograph(sheet.light(), 1.2, 2.5, 3), &folder.path("photo.png"));
    let marks = exact_marks(&eye);
    let points = folder.outline(&marks, &["--frame", "world"]);
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("world frame, mirrored, bright: mean {mean:.4} mm, max {max:.4} mm of {} points", points.len());
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");

    // Taken for the finger frame, the same marks have the finger turned by the motor's angle.
    let [mean, _] = deviation(&folder.outline(&marks, &[]), solution.front_mm());
    println!("world taken for finger: mean {mean:.3} mm");
    assert!(mean > 2.0, "mean {mean}");
}

#[test]
fn any_load_and_light_will_do() {
    let folder = Folder::new();
    let solutions = solved_at(&[0.0, 4.0, 11.0]);
    // Free, touching, and bent as far as it goes without a snap.
    assert!(solutions[0].force_magnitude_n() == Some(0.0) && solutions[2].force_magnitude_n() > Some(10.0));
    let lights = [
        Lights { ground: 250, finger: 60, object: 140, dots: 10 },
        Lights { ground: 90, finger: 30, object: 160, dots: 220 },
        Lights { ground: 60, finger: 110, object: 10, dots: 240 },
    ];
    for (i, (solution, lights)) in solutions.iter().zip(lights).chain(solutions.iter().rev().zip(lights)).enumerate() {
        let tilt = [10.0 - 4.0 * i as f64, 3.0 * i as f64 - 8.0, 2.0];
        let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, tilt, false);
        let sheet = sheet(lights, solution, &MARKS, false);
        save(
            &eye.photograph(sheet.light(), 1.0 + 0.2 * i as f64, 1.0 + 0.5 * i as f64, 20 + i as u64),
            &folder.path("photo.png"),
        );
        let plot = format!("overlay-{i}.png");
        let (points, arcs) = folder.outline_and_arcs(solution.at.value(), &exact_marks(&eye), &["--plot", &plot]);
        let [mean, max] = deviation(&points, solution.front_mm());
        let off = arc_error(&points, &arcs, solution.front_mm());
        println!(
            "{} degrees: mean {mean:.4} mm, max {max:.4} mm of {} points, arc length {off:.3} mm",
            solution.at.value(),
            points.len()
        );
        assert!(
            mean < 0.05 && max < 0.2 && off < 0.3,
            "{} degrees: mean {mean}, max {max}, arc length {off}",
            solution.at.value()
        );
        assert!(points.len() > 60, "{} points", points.len());
    }
}

#[test]
fn a_finger_as_bright_as_what_is_behind_it_is_known_by_its_colour() {
    let folder = Folder::new();
    let solution = solved();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [7.0, -6.0, 2.0], false);
    // Orange on green: red, green and blue light of ground, finger, object and dots. Both have 20 % of white's light.
    let lights = [[26, 153, 90, 4], [64, 27, 90, 4], [13, 8, 90, 4]];
    let channels = [0, 1, 2].map(|i| {
        let [ground, finger, object, dots] = lights[i];
        let sheet = sheet(Lights { ground, finger, object, dots }, &solution, &MARKS, false);
        eye.photograph(sheet.light(), 1.2, 2.0, 40 + i as u64)
    });
    let [red, green, blue] = &channels;
    let picture = image::RgbImage::from_fn(red.width(), red.height(), |x, y| {
        image::Rgb([red, green, blue].map(|channel| channel.get_pixel(x, y).0[0]))
    });
    picture.save(folder.path("photo.png")).unwrap();
    let output = folder.fre(&command(&exact_marks(&eye), &[]));
    snapbox::assert_data_eq!(
        said::words(&words(&output.stderr)),
        snapbox::str![[r#"
marks #, no residual: four marks fit any perspective, a fifth or a camera would check them
outline # points, arc length # to # mm, # mm per pixel
edges contrast # % of white's red, blur # px, scatter # mm before smoothing
thickness # % of the design's
"#]]
    );
    let [mean, max] = deviation(&folder.outline(&exact_marks(&eye), &["--plot", "overlay.png"]), solution.front_mm());
    println!("orange on green: mean {mean:.4} mm, max {max:.4} mm");
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");
}

#[test]
fn compare_reads_a_series_and_finds_the_model_again() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [8.0, 10.0, 0.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    save(&eye.photograph(sheet.light(), 1.3, 3.0, 4), &folder.path("photo.png"));
    let marks = exact_marks(&eye);
    let force = format!("{}", solution.force_magnitude_n().unwrap());
    let file = ["--output", "measured.csv", "--force-n", &force];
    assert_eq!(folder.fre(&command(&marks, &file)).status.code(), Some(0));
    // The same photograph as if at another angle: another place in the same file.
    let mut other = command(&marks, &["--output", "measured.csv", "--append"]);
    other[5] = "9";
    assert_eq!(folder.fre(&other).status.code(), Some(0));
    let output = folder.fre(&["compare", "case.toml", "--measured", "measured.csv", "--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let compared: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = compared["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    let number = |row: usize, key: &str| rows[row][key].as_f64().unwrap();
    assert!(number(0, "shape_mean_mm") < 0.05, "{compared}");
    assert!(number(0, "difference_n").abs() < 1e-6, "{compared}");
    assert!(number(1, "shape_mean_mm") > 2.0 * number(0, "shape_mean_mm"), "{compared}");

    std::fs::write(folder.path("measured.csv"), "something,else\n").unwrap();
    let refused = folder.fre(&command(&marks, &["--output", "measured.csv", "--append"]));
    snapbox::assert_data_eq!(
        words(&refused.stderr),
        snapbox::str![[r#"
fre: measured.csv:1: --append needs the header motor_angle_deg,force_n,front_x_mm,front_y_mm,arc_mm,deviation_mm

"#]]
    );
}

/// A kill, or a disk that fills up, while a photograph is added to a series: here a limit of the file's size.

#[test]
fn an_object_brighter_than_the_background_ends_the_outline_where_it_hides_the_tip() {
    let folder = Folder::new();
    let solution = solved();
    let lights = Lights { ground: 190, finger: 30, object: 255, dots: 100 };
    let sheet = sheet(lights, &solution, &MARKS, false);
    for (seed, tilt) in [[12.0, -6.0, 3.0], [-9.0, 8.0, 0.0], [0.0; 3]].into_iter().enumerate() {
        let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, tilt, false);
        save(&eye.photograph(sheet.light(), 1.1, 2.5, 60 + seed as u64), &folder.path("photo.png"));
        let points = folder.outline(&exact_marks(&eye), &[]);
        let [mean, max] = deviation(&points, solution.front_mm());
        println!("bright object: mean {mean:.4} mm, max {max:.4} mm of {} points", points.len());
        assert!(mean < 0.03 && max < 0.2 && points.len() > 60, "mean {mean}, max {max}, {} points", points.len());
    }
}

#[test]
fn a_camera_held_upright_is_turned_as_its_file_says() {
    let folder = Folder::new();
    let eye = STRAIGHT.looking_at([-8.0, 40.0], 170.0, [6.0, -5.0, 2.0], false);
    let solution = solved();
    let sheet = sheet(DARK_FINGER, &solution, &MARKS, false);
    let upright = eye.photograph(sheet.light(), 1.2, 2.0, 8);
    // Stored lying; orientation 6: turn clockwise to see it upright.
    let mut jpeg = Vec::new();
    let stored = image::imageops::rotate270(&upright);
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95).encode_image(&stored).unwrap();
    let tiff = [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"[..]].concat();
    let mut file = vec![0xFF, 0xD8, 0xFF, 0xE1];
    file.extend(((2 + 6 + tiff.len()) as u16).to_be_bytes());
    file.extend(b"Exif\0\0");
    file.extend(tiff);
    file.extend(&jpeg[2..]);
    // The content counts, not the ending.
    std::fs::write(folder.path("photo.png"), file).unwrap();
    let points = folder.outline(&exact_marks(&eye), &[]);
    let [mean, max] = deviation(&points, solution.front_mm());
    println!("JPEG with orientation: mean {mean:.4} mm, max {max:.4} mm");
    assert!(mean < 0.03 && max < 0.1, "mean {mean}, max {max}");
}
