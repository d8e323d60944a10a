//! Pictures are well-formed, show what they should, and survive odd input.

use fre::case::preset;
use fre::draw::{self, Chart, FingerPicture, Ink, Mark, Panel, Scene, Series, Style, Theme};
use fre::shape::{Contact, Shape};
use kurbo::PathEl;
use model_core::design::{Attachments, Beam, Design, HingeKind};
use model_core::object::{Motion, ObjectDesign};

fn finger(title: &str, motion: Motion, coordinate: f64, force: f64) -> Scene {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let mut shape = Shape::undeformed(&design);
    if force > 0.0 {
        shape.contacts = vec![Contact {
            arc: 45.0,
            position: [1.0, 45.0],
            normal: [-1.0, 0.0],
            force,
            tangential: None,
            state: None,
        }];
    }
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    FingerPicture {
        title: title.into(),
        subtitle: "a test".into(),
        design: &design,
        motion,
        coordinate,
        object,
        shape: &shape,
        force: Some([force, 0.0]),
    }
    .scene()
}

const TURNING: Motion = Motion::Rotating { axis: [-14.0, -20.0] };

fn chart(points: Vec<[f64; 2]>) -> Scene {
    let mut chart = Chart::new("title", "subtitle", "x");
    for style in [Style::Line, Style::Dashed, Style::Dots, Style::LineAndDots, Style::Thick] {
        chart.panels.push(Panel {
            y_title: "*F*_{x} (N)".into(),
            series: vec![Series { name: format!("{style:?}"), colour: 9, style, points: points.clone() }],
            marks: vec![
                Mark::At { x: 1.0, words: "here".into() },
                Mark::Ring { at: [1.0, f64::NAN], words: "nowhere".into() },
                Mark::Band { low: 0.0, high: 1.0, words: "band".into() },
            ],
            ..Panel::default()
        });
    }
    chart.scene()
}

/// Parses the picture; every coordinate must be a finite number.
fn texts(scene: &Scene) -> Vec<String> {
    let svg = draw::svg(scene);
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    let tree = roxmltree::Document::parse(&svg).unwrap();
    let text = |node: roxmltree::Node| {
        node.descendants().filter(|n| n.is_text()).filter_map(|n| n.text().map(str::to_owned)).collect::<String>()
    };
    let nodes = tree.descendants().filter(|node| node.has_tag_name("text"));
    for node in nodes.clone() {
        let at = |key| node.attribute(key).unwrap().parse::<f64>().unwrap();
        assert!((0.0..=scene.width).contains(&at("x")) && (0.0..=scene.height).contains(&at("y")), "{node:?}");
        // In any font the words are as long as here, and within the picture.
        let length = if text(node).is_empty() { 0.0 } else { at("textLength") };
        let before = match node.attribute("text-anchor") {
            Some("end") => 1.0,
            Some("middle") => 0.5,
            _ => 0.0,
        };
        if node.attribute("transform").is_none() {
            let begin = at("x") - before * length;
            assert!(begin > -1.0 && begin + length < scene.width + 1.0, "{node:?} is from {begin}, {length} long");
        }
    }
    // What is not cut off at an area's edge lies in the picture as a whole.
    let mut clipped = false;
    for item in &scene.items {
        match item {
            draw::Item::Clip(_) => clipped = true,
            draw::Item::Unclip => clipped = false,
            _ if clipped => {}
            _ => {
                for p in item_points(item) {
                    assert!(
                        (0.0..=scene.width).contains(&p[0]) && (0.0..=scene.height).contains(&p[1]),
                        "{p:?}: {item:?}"
                    );
                }
            }
        }
    }
    // No letter begins beyond the picture's edge.
    for letter in tree.descendants().filter(|node| node.has_tag_name("use")) {
        if letter.parent().is_some_and(|text| text.attribute("transform").is_none()) {
            let place = letter.attribute("transform").unwrap().strip_prefix("translate(").unwrap();
            let x: f64 = place.split(' ').next().unwrap().parse().unwrap();
            assert!((0.0..scene.width).contains(&x), "{x} of {}", scene.width);
        }
    }
    nodes.map(text).collect()
}

/// Share of the picture's pixels that have exactly an ink's colour.
fn share(png: &[u8], ink: Ink) -> f64 {
    let map = tiny_skia::Pixmap::decode_png(png).unwrap();
    let [r, g, b] = ink.colours().0;
    let count = map.pixels().iter().filter(|p| [p.red(), p.green(), p.blue()] == [r, g, b]).count();
    count as f64 / map.pixels().len() as f64
}

#[test]
fn the_finger_shows_its_parts_and_its_force() {
    let scene = finger("A <finger> & \"more\"", TURNING, 0.1, 12.345);
    let words = texts(&scene);
    for expected in ["A <finger> & \"more\"", "front beam", "net force", "F = 12.35 N", "α = 5.73°", "20 mm", "5 N"] {
        assert!(words.iter().any(|word| word == expected), "{expected} is not among {words:?}");
    }
    let png = draw::png(&scene, 1.0, Theme::Light).unwrap();
    // Areas of beams and lamellae at this scale: about 80 × 2 mm each of some 130 × 110 mm.
    for (ink, least, most) in [
        (Ink::Front, 0.004, 0.03),
        (Ink::Back, 0.004, 0.03),
        (Ink::Lamella, 0.004, 0.05),
        (Ink::Force, 0.0004, 0.01),
        (Ink::Object, 0.1, 0.5),
        (Ink::Paper, 0.4, 0.9),
    ] {
        let share = share(&png, ink);
        assert!((least..most).contains(&share), "{ink:?} covers {share}");
    }
}

#[test]
fn a_picture_needs_no_font_of_the_system() {
    let scene = finger("title", TURNING, 0.0, 0.0);
    let mut blank = scene.clone();
    blank.items.clear();
    let dark = |scene: &Scene| share(&draw::png(scene, 1.0, Theme::Light).unwrap(), Ink::Main);
    assert_eq!(dark(&blank), 0.0);
    assert!(dark(&scene) > 0.001, "letters are missing");
}

#[test]
fn both_themes_are_in_the_svg_and_on_request_in_the_png() {
    let scene = finger("title", TURNING, 0.0, 1.0);
    let svg = draw::svg(&scene);
    assert!(svg.contains("prefers-color-scheme:dark") && svg.contains(".f-front{fill:#0072b2}"));
    let [light, dark] = [Theme::Light, Theme::Dark].map(|theme| draw::png(&scene, 1.0, theme).unwrap());
    assert!(share(&light, Ink::Paper) > 0.4 && share(&dark, Ink::Paper) < 0.01);
}

#[test]
fn a_translated_finger_and_a_free_one_are_drawn() {
    let sliding = texts(&finger("title", Motion::Translating { direction: [1.0, 0.0] }, 12.0, 3.0));
    assert!(sliding.iter().any(|word| word == "d = 12 mm"), "{sliding:?}");
    let free = texts(&finger("title", TURNING, -0.2, 0.0));
    assert!(free.iter().any(|word| word == "α = −11.46°"), "{free:?}");
    assert!(!free.iter().any(|word| word.starts_with("F =")), "{free:?}");
}

#[test]
fn charts_survive_odd_points() {
    let nan = f64::NAN;
    for points in [
        vec![],
        vec![[0.0, 0.0]],
        vec![[nan, 1.0], [1.0, nan]],
        vec![[0.0, 1e-30], [1.0, 2e-30]],
        vec![[0.0, -1e300], [1.0, 1e300]],
        vec![[0.0, 5.0], [1.0, nan], [2.0, 5.0], [3.0, f64::INFINITY]],
        (0..1000).map(|i| [f64::from(i), f64::from(i).sin()]).collect(),
    ] {
        let scene = chart(points.clone());
        let words = texts(&scene);
        assert!(words.iter().any(|word| word == "Fx (N)"), "{words:?}");
        draw::png(&scene, 1.0, Theme::Light).unwrap_or_else(|error| panic!("{points:?}: {error}"));
    }
}

#[test]
fn long_titles_are_broken_into_lines() {
    let title =
        "a finger with a name that is far longer than a picture of it is wide, and then some more of it to be sure";
    let words = texts(&finger(title, TURNING, 0.1, 1.0));
    assert!(words.iter().any(|word| word.starts_with("a finger with")) && !words.iter().any(|word| word == title));
    let mut chart = Chart::new(title, title, "x");
    chart.panels = vec![Panel::default()];
    assert!(texts(&chart.scene()).join(" ").contains(&format!("{title} {title}")));
}

#[test]
fn remarks_at_the_same_place_do_not_cover_each_other() {
    let mut chart = Chart::new("title", "", "x");
    let at = |x, words: &str| Mark::At { x, words: words.into() };
    chart.panels = vec![Panel {
        series: vec![Series { name: "s".into(), colour: 0, style: Style::Line, points: vec![[0.0, 0.0], [10.0, 1.0]] }],
        marks: vec![at(8.0, "the first long remark"), at(8.2, "the second long remark"), at(0.0, "elsewhere")],
        ..Panel::default()
    }];
    let svg = draw::svg(&chart.scene());
    let tree = roxmltree::Document::parse(&svg).unwrap();
    let height = |words: &str| {
        let node = tree.descendants().find(|node| node.has_tag_name("text") && node.text() == Some(words)).unwrap();
        node.attribute("y").unwrap().parse::<f64>().unwrap()
    };
    let [first, second, elsewhere] = ["the first long remark", "the second long remark", "elsewhere"].map(height);
    assert!(second > first + 10.0 && elsewhere == first, "{first} {second} {elsewhere}");
}

#[test]
fn an_object_s_name_is_in_the_picture_whatever_its_size() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let shape = Shape::undeformed(&design);
    for (centre, radius) in [([3.0, 40.0], 0.5), ([41.0, 45.0], 40.0), ([1001.0, 60.0], 1000.0), ([5.0, 130.0], 8.0)] {
        let object = ObjectDesign::Circle { centre, radius };
        let (title, subtitle) = (String::new(), String::new());
        let picture = FingerPicture {
            title,
            subtitle,
            design: &design,
            motion: TURNING,
            coordinate: 0.0,
            object,
            shape: &shape,
            force: None,
        };
        let scene = picture.scene();
        texts(&scene);
        let (at, _) = scene_text(&scene, &format!("object Ø{} mm", 2.0 * radius)).unwrap();
        assert!(
            (60.0..scene.width - 60.0).contains(&at[0]) && (30.0..scene.height - 30.0).contains(&at[1]),
            "{radius}: {at:?}"
        );
    }
}

#[test]
fn an_arrow_of_a_translated_base_does_not_cover_its_words() {
    for direction in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [0.8, -0.6], [-0.6, 0.8]] {
        let scene = finger("title", Motion::Translating { direction }, 12.0, 0.0);
        texts(&scene);
        let Some((at, anchor)) = scene_text(&scene, "*d* = 12 mm") else { panic!("no words: {direction:?}") };
        // The words lie on the tail's side.
        assert_eq!(anchor == "End", direction[0] > 0.0, "{direction:?}");
        assert!(at[0] > 0.0 && at[1] < scene.height);
    }
}

/// Where a text stands in a scene and how it is anchored.
fn scene_text(scene: &Scene, words: &str) -> Option<([f64; 2], String)> {
    scene.items.iter().find_map(|item| match item {
        draw::Item::Text(text) if text.words == words => Some((text.at, format!("{:?}", text.anchor))),
        _ => None,
    })
}

#[test]
fn a_gap_in_the_points_is_a_gap_in_the_line() {
    let line = |middle: f64| {
        let points = vec![[0.0, 1.0], [1.0, 1.0], [2.0, middle], [3.0, 1.0], [4.0, 1.0]];
        draw::svg(&chart(points)).matches(r#"<path class="s-series2" fill="none" stroke-width="2""#).count()
    };
    // The legend's sample, and one run of points or two.
    assert_eq!((line(1.0), line(f64::NAN)), (2, 3));
}

#[test]
fn a_picture_file_has_the_format_of_its_ending() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let scene = chart(vec![[0.0, 0.0], [1.0, 1.0]]);
    draw::write(&scene, &folder.join("a.svg")).unwrap();
    draw::write(&scene, &folder.join("a.PNG")).unwrap();
    assert!(std::fs::read(folder.join("a.svg")).unwrap().starts_with(b"<svg"));
    assert!(std::fs::read(folder.join("a.PNG")).unwrap().starts_with(b"\x89PNG"));
    for (file, words) in [("a.pdf", ".svg or .png"), ("a", ".svg or .png"), ("no/such/a.svg", "cannot be written")] {
        let message = draw::write(&scene, &folder.join(file)).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    assert!(draw::png(&scene, 1e6, Theme::Light).is_err() && draw::png(&scene, 0.0, Theme::Light).is_err());
}

/// The finger with every length multiplied.
fn scaled(design: &Design, factor: f64) -> Design {
    let mut out = design.clone();
    let beam = |beam: &mut Beam| {
        (beam.base, beam.tip) = (beam.base.map(|x| factor * x), beam.tip.map(|x| factor * x));
        beam.thickness.knots.iter_mut().flatten().for_each(|x| *x *= factor);
    };
    beam(&mut out.front);
    beam(&mut out.back);
    let Attachments::Heights(heights) = &mut out.lamellae.attachments else { panic!("the preset has heights") };
    heights.iter_mut().for_each(|x| *x *= factor);
    out.lamellae.thickness *= factor;
    out.hinge.length.iter_mut().for_each(|x| *x *= factor);
    out.hinge.thickness *= factor;
    out
}

#[test]
fn a_finger_of_any_size_has_the_same_picture() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let scene = |factor: f64, turning: bool| {
        let design = scaled(&design, factor);
        let shape = Shape::undeformed(&design);
        let picture = FingerPicture {
            title: "title".into(),
            subtitle: String::new(),
            design: &design,
            motion: if turning {
                Motion::Rotating { axis: [-14.0 * factor, -20.0 * factor] }
            } else {
                Motion::Translating { direction: [1.0, 0.0] }
            },
            coordinate: if turning { 0.1 } else { 0.0 },
            object: ObjectDesign::Circle { centre: [41.0 * factor, 45.0 * factor], radius: 40.0 * factor },
            shape: &shape,
            force: None,
        };
        picture.scene()
    };
    for turning in [true, false] {
        let usual = scene(1.0, turning);
        let points = |scene: &Scene| scene.items.iter().flat_map(item_points).collect::<Vec<_>>();
        // The scale below the picture is round, so it differs by the finger's size: the last line and its two ends.
        let drawn = |scene: &Scene| {
            let points = points(scene);
            points[..points.len() - 6].to_vec()
        };
        for factor in [0.05, 12.5] {
            let other = scene(factor, turning);
            texts(&other);
            assert_eq!(drawn(&other).len(), drawn(&usual).len());
            for (p, q) in drawn(&other).into_iter().zip(drawn(&usual)) {
                assert!((p[0] - q[0]).hypot(p[1] - q[1]) < 0.01, "{factor}: {p:?}, not {q:?}");
            }
        }
    }
}

/// The points of a path with their control points.
fn item_points(item: &draw::Item) -> Vec<[f64; 2]> {
    let draw::Item::Path(path, ..) = item else { return Vec::new() };
    path.0
        .iter()
        .flat_map(|element| match element {
            PathEl::MoveTo(p) | PathEl::LineTo(p) => vec![p],
            PathEl::QuadTo(a, p) => vec![a, p],
            PathEl::CurveTo(a, b, p) => vec![a, b, p],
            PathEl::ClosePath => Vec::new(),
        })
        .map(|point| [point.x, point.y])
        .collect()
}

/// What the words of a picture cover: left, top, right and bottom, px.
fn boxes(scene: &Scene) -> Vec<(String, [f64; 4])> {
    let svg = draw::svg(scene);
    let tree = roxmltree::Document::parse(&svg).unwrap();
    let nodes = tree.descendants().filter(|node| node.has_tag_name("text") && node.attribute("textLength").is_some());
    nodes
        .map(|node| {
            let [x, y, size, length] =
                ["x", "y", "font-size", "textLength"].map(|key| node.attribute(key).unwrap().parse::<f64>().unwrap());
            let before = match node.attribute("text-anchor") {
                Some("end") => 1.0,
                Some("middle") => 0.5,
                _ => 0.0,
            };
            let left = x - before * length;
            let words = node.descendants().filter(|n| n.is_text()).filter_map(|n| n.text()).collect::<String>();
            (words, [left, y - 0.75 * size, left + length, y + 0.2 * size])
        })
        .collect()
}

#[test]
fn forces_and_their_words_stay_in_the_picture_and_off_the_others() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let wall = |point: [f64; 2], normal: [f64; 2]| ObjectDesign::HalfPlane { point, normal };
    let circle = |centre: [f64; 2], radius: f64| ObjectDesign::Circle { centre, radius };
    let objects = [
        wall([0.0, 81.0], [0.0, -1.0]),
        wall([1.0, 0.0], [-1.0, 0.0]),
        wall([4.0, 70.0], [-1.0, -0.25]),
        circle([0.0, 82.0], 1.5),
        circle([2.5, 70.0], 1.5),
        circle([41.0, 45.0], 40.0),
        circle([12.0, 20.0], 11.0),
    ];
    let mut shape = Shape::undeformed(&design);
    let contact =
        |y: f64| Contact { arc: y, position: [1.0, y], normal: [-1.0, 0.0], force: 1.5, tangential: None, state: None };
    shape.contacts = vec![contact(45.0), contact(80.0)];
    for object in objects {
        for motion in [TURNING, Motion::Translating { direction: [0.0, 1.0] }] {
            for turn in 0..16 {
                let angle = f64::from(turn) * std::f64::consts::TAU / 16.0;
                let picture = FingerPicture {
                    title: "title".into(),
                    subtitle: "subtitle".into(),
                    design: &design,
                    motion,
                    coordinate: 0.0,
                    object,
                    shape: &shape,
                    force: Some([3.0 * angle.cos(), 3.0 * angle.sin()]),
                };
                let scene = picture.scene();
                let words = texts(&scene);
                assert!(words.iter().any(|word| word == "F = 3.00 N"), "{words:?}");
                let boxes = boxes(&scene);
                for (index, (words, a)) in boxes.iter().enumerate() {
                    assert!(a[1] > 0.0 && a[3] < scene.height, "{object:?}, {angle}: {words} at {a:?}");
                    for (others, b) in &boxes[..index] {
                        let apart = a[0] > b[2] || b[0] > a[2] || a[1] > b[3] || b[1] > a[3];
                        assert!(apart, "{object:?}, {motion:?}, {angle}: {words} covers {others}");
                    }
                }
                // Neither the cross at the object's centre nor the net force's shaft runs through words.
                let line = |ink: Ink, width: f64| {
                    let of = move |item: &&draw::Item| matches!(item, draw::Item::Path(_, None, Some(stroke)) if stroke.ink == ink && stroke.width == width);
                    scene.items.iter().filter(of).map(item_points).filter(|points| points.len() == 2)
                };
                for ends in line(Ink::ObjectEdge, 1.0).chain(line(Ink::Force, 2.6)) {
                    for part in 0..=40 {
                        let [x, y] = [0, 1].map(|i| ends[0][i] + (ends[1][i] - ends[0][i]) * f64::from(part) / 40.0);
                        for (words, b) in &boxes {
                            let through = (b[0]..b[2]).contains(&x) && (b[1]..b[3]).contains(&y);
                            assert!(!through, "{object:?}, {motion:?}, {angle}: a line through {words}");
                        }
                    }
                }
                // The net force's arrow, drawn twice, as a sample and at the finger: its head is below the legend.
                let legend = boxes.iter().find(|(words, _)| words == "net force").unwrap().1;
                let heads = scene
                    .items
                    .iter()
                    .filter(|item| matches!(item, draw::Item::Path(_, Some(fill), None) if fill.ink == Ink::Force));
                let heads: Vec<_> = heads.map(|item| item_points(item)[0]).collect();
                assert!(heads.len() == 3 && heads[1][1] > legend[3], "{object:?}, {angle}: {heads:?}");
            }
        }
    }
}

#[test]
fn a_chart_with_equal_scales_has_them_whatever_its_headings_are() {
    let title =
        "a name that goes on and on, over more than one line of the picture, and so takes up room above the axes";
    for (title, [wide, tall], scale) in
        [("short", [60.0, 90.0], 6.5), (title, [60.0, 90.0], 6.5), (title, [0.03, 4.0], 130.0), ("", [1e3, 1e3], 0.52)]
    {
        // A square with half the height's side: as wide as it is tall in the picture.
        let side = 0.5 * tall;
        let square = vec![[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]];
        let series = Series { name: "square".into(), colour: 6, style: Style::Dashed, points: square };
        let mut chart = Chart::new(title, title, "x");
        chart.x_range = Some([0.0, wide]);
        chart.panels = vec![Panel { y_range: Some([0.0, tall]), series: vec![series], ..Panel::default() }];
        let scene = chart.with_equal_scales(scale).scene();
        texts(&scene);
        let drawn = scene.items.iter().map(item_points).find(|points| points.len() == 4).unwrap();
        let [across, up] = [drawn[1][0] - drawn[0][0], drawn[1][1] - drawn[2][1]];
        assert!((across - scale * side).abs() < 1e-6 && (up - scale * side).abs() < 1e-6, "{across}, {up}: {title}");
    }
}

#[test]
fn a_ring_beyond_the_axes_is_not_drawn_and_asks_for_no_room() {
    let ink = |scene: &Scene| {
        let drawn =
            |item: &&draw::Item| matches!(item, draw::Item::Path(_, None, Some(stroke)) if stroke.ink == Ink::Force);
        scene.items.iter().filter(drawn).count()
    };
    let scene = |at: [f64; 2]| {
        let mut chart = Chart::new("title", "", "x");
        chart.panels = vec![Panel {
            series: vec![Series {
                name: "s".into(),
                colour: 0,
                style: Style::Line,
                points: vec![[5.0, 1.0], [10.0, 2.0]],
            }],
            marks: vec![Mark::Ring {
                at,
                words: "a ring with rather many words, too many for either side of it".into(),
            }],
            ..Panel::default()
        }];
        chart.scene()
    };
    let inside = scene([7.0, 20.0]);
    let words = texts(&inside);
    assert!(ink(&inside) == 1 && words.iter().any(|word| word == "20"), "{words:?}");
    for at in [[4.5, 20.0], [11.0, 20.0], [f64::NAN, 20.0]] {
        let scene = scene(at);
        let words = texts(&scene);
        assert!(ink(&scene) == 0 && !words.iter().any(|word| word == "20" || word.contains("ring")), "{words:?}");
    }
}

#[test]
fn a_snap_through_before_the_first_place_is_told() {
    let text = "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 75]\n\
                [motion]\nmotor_angles_deg = [7.5, 9]\n";
    let case = fre::case::Case::parse("case.toml", text).unwrap();
    let run = fre::study::run::solve(&case, &Default::default()).unwrap();
    assert_eq!(run.places[0].branch, Some(2), "the case begins beyond its snap-through");
    let scene = fre::study::pictures::overview(&case, &run).unwrap();
    let words = texts(&scene);
    assert!(
        words.iter().any(|word| word.starts_with("snap-through at") && word.contains("before the first")),
        "{words:?}"
    );
}

#[test]
fn a_level_s_words_do_not_cover_those_at_the_top() {
    let mut chart = Chart::new("title", "", "x");
    let series =
        |top: f64| Series { name: "s".into(), colour: 0, style: Style::Line, points: vec![[0.0, 0.0], [10.0, top]] };
    let mut covered = Vec::new();
    for level in [9.0, 9.5, 9.9, 10.0] {
        chart.panels = vec![Panel {
            y_range: Some([0.0, 10.0]),
            series: vec![series(10.0)],
            marks: vec![
                Mark::Level { y: level, words: "limit 7 %".into() },
                Mark::At { x: 9.5, words: "7".into() },
                Mark::At { x: 9.6, words: "8".into() },
            ],
            ..Panel::default()
        }];
        let boxes = boxes(&chart.scene());
        let one = |words: &str| boxes.iter().find(|(others, _)| others == words).unwrap().1;
        let limit = one("limit 7 %");
        for number in ["7", "8"].map(one) {
            covered.push(limit[0] < number[2] && number[0] < limit[2] && limit[1] < number[3] && number[1] < limit[3]);
        }
    }
    assert_eq!(covered, [false; 8]);
}

#[test]
fn names_are_shown_as_they_are() {
    for name in ["finger*2", "*bold* _{sub}", "a_{b", r"back\*slash\\", "} *", "***"] {
        let words = texts(&finger(name, TURNING, 0.1, 1.0));
        assert!(words.iter().any(|word| word == name), "{name}: {words:?}");
        let mut chart = Chart::new(name, format!("{} at *α*", draw::literal(name)), "x");
        chart.panels = vec![Panel::default()];
        let words = texts(&chart.scene());
        let subtitle = format!("{name} at α");
        assert!(words.iter().any(|word| word == name) && words.contains(&subtitle), "{name}: {words:?}");
    }
    let words = texts(&finger("two\nlines\tand a tab", TURNING, 0.1, 1.0));
    assert!(words.iter().any(|word| word == "two lines and a tab"), "{words:?}");
}

#[test]
fn pins_show_on_the_beams_and_only_where_there_are_pins() {
    for (kind, expected) in [(HingeKind::Pinned, true), (HingeKind::Welded, false), (HingeKind::Flexible, false)] {
        let mut design = preset("ladder-80").unwrap().unwrap().design;
        design.hinge.kind = kind;
        let shape = Shape::undeformed(&design);
        let picture = FingerPicture {
            title: String::new(),
            subtitle: String::new(),
            design: &design,
            // Without the motor, which is a circle too.
            motion: Motion::Translating { direction: [1.0, 0.0] },
            coordinate: 0.0,
            object: ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 },
            shape: &shape,
            force: None,
        };
        let items = picture.scene().items;
        let filled =
            |item: &draw::Item, ink: Ink| matches!(item, draw::Item::Path(_, Some(fill), _) if fill.ink == ink);
        let pins = items.iter().filter(|item| filled(item, Ink::Paper)).count();
        assert_eq!(pins, if expected { 2 * design.lamella_count() } else { 0 }, "{kind:?}");
        let last = |ink: Ink| items.iter().rposition(|item| filled(item, ink));
        assert!(!expected || items.iter().position(|item| filled(item, Ink::Paper)) > last(Ink::Front), "hidden");
    }
}

#[test]
fn any_letters_make_a_well_formed_picture() {
    let name: String =
        ('\0'..='\u{ff}').chain(['\u{d7ff}', '\u{e000}', '\u{fffd}', '\u{fffe}', '\u{ffff}', '\u{1f600}']).collect();
    let scene = finger(&name, TURNING, 0.1, 1.0);
    // Parses the picture.
    texts(&scene);
    let svg = draw::svg(&scene);
    assert!(!svg.contains('\u{fffe}') && !svg.contains('\u{ffff}') && svg.contains('\u{fffd}'));
}

#[test]
fn descriptions_are_words_without_marks() {
    let chart = |title: &str, subtitle: &str| Chart::new(title, subtitle, "x").scene();
    let both = chart("Strain of finger*2", "*α* = 8°: *F*_{x} = 6.03 N").above(&chart("Force", ""));
    assert_eq!(both.description, "Strain of finger*2. α = 8°: Fx = 6.03 N. Force");
    assert!(draw::svg(&both).contains("<title>Strain of finger*2. α = 8°: Fx = 6.03 N. Force</title>"));
}
