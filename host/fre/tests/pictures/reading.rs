//! Pictures to look at, and what can be read off them: words, boxes, points, pixels.

use fre::case::preset;
use fre::draw::{self, Chart, FingerPicture, Ink, Mark, Panel, Scene, Series, Style};
use fre::shape::{Contact, Shape};
use kurbo::PathEl;
use model_core::object::{Motion, ObjectDesign};

pub fn finger(title: &str, motion: Motion, coordinate: f64, force: f64) -> Scene {
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
        friction: 0.0,
        shape: &shape,
        force: Some([force, 0.0]),
    }
    .scene()
}

pub const TURNING: Motion = Motion::Rotating { axis: [-14.0, -20.0] };

pub fn chart(points: Vec<[f64; 2]>) -> Scene {
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
pub fn texts(scene: &Scene) -> Vec<String> {
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
pub fn share(png: &[u8], ink: Ink) -> f64 {
    let map = tiny_skia::Pixmap::decode_png(png).unwrap();
    let [r, g, b] = ink.colours().0;
    let count = map.pixels().iter().filter(|p| [p.red(), p.green(), p.blue()] == [r, g, b]).count();
    count as f64 / map.pixels().len() as f64
}

/// Where a text stands in a scene and how it is anchored.
pub fn scene_text(scene: &Scene, words: &str) -> Option<([f64; 2], String)> {
    scene.items.iter().find_map(|item| match item {
        draw::Item::Text(text) if text.words == words => Some((text.at, format!("{:?}", text.anchor))),
        _ => None,
    })
}

/// The points of a path with their control points.
pub fn item_points(item: &draw::Item) -> Vec<[f64; 2]> {
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
pub fn boxes(scene: &Scene) -> Vec<(String, [f64; 4])> {
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
