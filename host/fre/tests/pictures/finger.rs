//! Pictures of fingers.

use fre::case::preset;
use fre::draw::{self, FingerPicture, Ink, Scene, Theme};
use fre::shape::{Contact, Shape};
use model_core::design::{Attachments, Beam, Design, HingeKind};
use model_core::object::{Motion, ObjectDesign};

use crate::reading::{TURNING, boxes, finger, item_points, scene_text, share, texts};

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
fn a_translated_finger_and_a_free_one_are_drawn() {
    let sliding = texts(&finger("title", Motion::Translating { direction: [1.0, 0.0] }, 12.0, 3.0));
    assert!(sliding.iter().any(|word| word == "d = 12 mm"), "{sliding:?}");
    let free = texts(&finger("title", TURNING, -0.2, 0.0));
    assert!(free.iter().any(|word| word == "α = −11.46°"), "{free:?}");
    assert!(!free.iter().any(|word| word.starts_with("F =")), "{free:?}");
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
            friction: 0.0,
            shape: &shape,
            force: None,
        };
        let scene = picture.scene();
        texts(&scene);
        let (at, _) = scene_text(&scene, &format!("cylinder Ø{} mm", 2.0 * radius)).unwrap();
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
    out.lamellae.thickness.iter_mut().flatten().for_each(|thickness| *thickness *= factor);
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
            friction: 0.0,
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
                    friction: 0.0,
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
            friction: 0.0,
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
