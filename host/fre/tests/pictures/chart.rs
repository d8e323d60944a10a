//! Charts.

use fre::draw::{self, Chart, Ink, Mark, Panel, Scene, Series, Style, Theme};

use crate::reading::{boxes, chart, item_points, texts};

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
fn a_gap_in_the_points_is_a_gap_in_the_line() {
    let line = |middle: f64| {
        let points = vec![[0.0, 1.0], [1.0, 1.0], [2.0, middle], [3.0, 1.0], [4.0, 1.0]];
        draw::svg(&chart(points)).matches(r#"<path class="s-series2" fill="none" stroke-width="2""#).count()
    };
    // The legend's sample, and one run of points or two.
    assert_eq!((line(1.0), line(f64::NAN)), (2, 3));
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
