//! Small pictures of a case file's keys: what each length and angle is measured between.

use super::palette::Ink;
use super::path::{Path, Rect};
use super::scene::{Anchor, Scene, Stroke, Text, literal};

/// Names of the pictures.
pub const KEY_PICTURES: [&str; 8] = ["finger", "beam", "hinge", "circle", "ellipse", "polygon", "half-plane", "bore"];

/// Text size, px.
const SIZE: f64 = 12.0;

/// A picture of keys; none for another name.
pub fn key_picture(name: &str) -> Option<Scene> {
    Some(match name {
        "finger" => finger(),
        "beam" => beam(),
        "hinge" => hinge(),
        "circle" => circle(),
        "ellipse" => ellipse(),
        "polygon" => polygon(),
        "half-plane" => half_plane(),
        "bore" => bore(),
        _ => return None,
    })
}

/// A name with its line or point.
fn label(scene: &mut Scene, at: [f64; 2], anchor: Anchor, words: &str) {
    scene.text(Text::new(at, SIZE, literal(words)).anchor(anchor).halo());
}

/// A line with a head at each end.
fn dimension(scene: &mut Scene, a: [f64; 2], b: [f64; 2]) {
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    scene.arrow(middle, a, Ink::Force, 1.3);
    scene.arrow(middle, b, Ink::Force, 1.3);
}

/// A thin line from a part to its dimension.
fn guide(scene: &mut Scene, a: [f64; 2], b: [f64; 2]) {
    scene.line(Path::lines([a, b]), Stroke::new(Ink::Muted, 0.8).dashed(3.0, 3.0));
}

/// A point with its name.
fn point(scene: &mut Scene, at: [f64; 2], words: [f64; 2], anchor: Anchor, name: &str) {
    scene.fill(Path::circle(at, 3.5), Ink::Force, 1.0);
    label(scene, words, anchor, name);
}

/// A beam of a thickness along its centreline.
fn strip(scene: &mut Scene, centreline: &[[f64; 2]], thickness: f64, ink: Ink) {
    scene.line(Path::lines(centreline.iter().copied()), Stroke::new(ink, thickness));
    scene.line(Path::lines(centreline.iter().copied()), Stroke::new(Ink::Paper, 0.8).dashed(6.0, 4.0));
}

/// The axes of a frame.
fn axes(scene: &mut Scene, [x, y]: [f64; 2]) {
    scene.arrow([x, y], [x + 34.0, y], Ink::Muted, 1.2);
    scene.arrow([x, y], [x, y - 34.0], Ink::Muted, 1.2);
    scene.text(Text::new([x + 38.0, y + 4.0], SIZE, "*x*").ink(Ink::Muted));
    scene.text(Text::new([x - 3.0, y - 38.0], SIZE, "*y*").ink(Ink::Muted));
}

fn finger() -> Scene {
    let mut scene =
        Scene::new(560.0, 430.0, "Keys of the finger: base, tip, thickness, lamellae, tip wedge and motor axis");
    // Pixels per mm and the front base's place.
    let to = |[x, y]: [f64; 2]| [300.0 + 4.0 * x, 355.0 - 4.0 * y];
    let back_x = |y: f64| -28.0 * (1.0 - y / 80.0);
    for height in [10.0, 20.0, 30.0, 40.0, 50.0] {
        let ends = [[0.0, height], [back_x(height), height]].map(to);
        scene.line(Path::lines(ends), Stroke::new(Ink::Lamella, 9.0));
    }
    scene.fill(
        Path::polygon([[1.0, 70.0], [back_x(70.0) - 1.0, 70.0], [0.0, 81.0], [1.0, 81.0]].map(to)),
        Ink::Lamella,
        1.0,
    );
    strip(&mut scene, &[[-28.0, 0.0], [0.0, 80.0]].map(to), 8.0, Ink::Back);
    strip(&mut scene, &[[0.0, 0.0], [0.0, 80.0]].map(to), 8.0, Ink::Front);
    scene.line(Path::lines([[-34.0, 0.0], [6.0, 0.0]].map(to)), Stroke::new(Ink::Main, 2.5));
    point(&mut scene, to([0.0, 0.0]), [318.0, 374.0], Anchor::Start, "front.base_mm");
    point(&mut scene, to([-28.0, 0.0]), [172.0, 374.0], Anchor::End, "back.base_mm");
    point(&mut scene, to([0.0, 80.0]), [300.0, 22.0], Anchor::Middle, "front.tip_mm, back.tip_mm");
    point(&mut scene, to([-14.0, -14.0]), [256.0, 415.0], Anchor::Start, "motor.axis_mm");
    // The angle turns the finger clockwise about the axis.
    let [x, y] = to([-14.0, -14.0]);
    let arc = Path::arc([x, y], 26.0, -2.2, -0.9);
    scene.line(arc, Stroke::new(Ink::Force, 1.3));
    scene.arrow([x + 14.0, y - 22.0], [x + 20.0, y - 16.5], Ink::Force, 1.3);
    label(&mut scene, [x + 26.0, y - 14.0], Anchor::Start, "motor_angles_deg > 0");
    // Heights.
    let lamella = to([0.0, 40.0]);
    guide(&mut scene, lamella, [400.0, lamella[1]]);
    guide(&mut scene, to([0.0, 0.0]), [400.0, 355.0]);
    dimension(&mut scene, [390.0, 355.0], [390.0, lamella[1]]);
    label(&mut scene, [398.0, 280.0], Anchor::Start, "lamellae.heights_mm");
    let wedge = to([0.0, 70.0]);
    guide(&mut scene, wedge, [548.0, wedge[1]]);
    guide(&mut scene, [400.0, 355.0], [548.0, 355.0]);
    dimension(&mut scene, [540.0, 355.0], [540.0, wedge[1]]);
    label(&mut scene, [540.0, wedge[1] - 8.0], Anchor::End, "tip.rigid_above_mm");
    // Thickness.
    let [x, y] = to([0.0, 55.0]);
    scene.arrow([x + 40.0, y], [x + 4.0, y], Ink::Force, 1.3);
    // Between the beams, which are near to each other here.
    scene.arrow([x - 24.0, y], [x - 4.0, y], Ink::Force, 1.3);
    label(&mut scene, [x + 44.0, y + 4.0], Anchor::Start, "front.thickness_mm");
    axes(&mut scene, [30.0, 400.0]);
    scene
}

fn beam() -> Scene {
    let mut scene = Scene::new(560.0, 200.0, "Keys of a beam, laid on its side: sagitta, clamp and arc lengths");
    let bow = |part: f64| [60.0 + 440.0 * part, 130.0 - 4.0 * 46.0 * part * (1.0 - part)];
    let line: Vec<[f64; 2]> = (0..=40).map(|k| bow(f64::from(k) / 40.0)).collect();
    strip(&mut scene, &line, 10.0, Ink::Front);
    let held: Vec<[f64; 2]> = (0..=40).map(|k| bow(0.12 * f64::from(k) / 40.0)).collect();
    scene.line(Path::lines(held), Stroke::new(Ink::Main, 16.0));
    guide(&mut scene, bow(0.0), bow(1.0));
    dimension(&mut scene, [280.0, 130.0], [280.0, 84.0]);
    label(&mut scene, [288.0, 120.0], Anchor::Start, "sagitta_mm");
    label(&mut scene, [52.0, 82.0], Anchor::Start, "clamp_mm");
    // An arc length, along the beam.
    let beside: Vec<[f64; 2]> = (0..=40).map(|k| bow(0.72 * f64::from(k) / 40.0)).map(|[x, y]| [x, y - 26.0]).collect();
    scene.line(Path::lines(beside.iter().copied()), Stroke::new(Ink::Force, 1.3));
    if let [.., before, last] = beside[..] {
        scene.arrow(before, [last[0] + 1.0, last[1]], Ink::Force, 1.3);
    }
    guide(&mut scene, bow(0.72), [bow(0.72)[0], bow(0.72)[1] - 30.0]);
    label(&mut scene, [250.0, 44.0], Anchor::Middle, "lamellae.front_arc_mm, arc_mm of a taper");
    label(&mut scene, [60.0, 158.0], Anchor::Middle, "base_mm");
    label(&mut scene, [500.0, 158.0], Anchor::Middle, "tip_mm");
    scene
}

fn hinge() -> Scene {
    let mut scene = Scene::new(
        560.0,
        230.0,
        "Keys of lamellae and hinges: lengths from the centreline or from the face, thicknesses",
    );
    scene.fill(Path::polygon([[410.0, 20.0], [450.0, 20.0], [450.0, 150.0], [410.0, 150.0]]), Ink::Front, 1.0);
    guide(&mut scene, [430.0, 10.0], [430.0, 205.0]);
    guide(&mut scene, [410.0, 150.0], [410.0, 175.0]);
    scene.fill(Path::polygon([[330.0, 100.0], [410.0, 100.0], [410.0, 120.0], [330.0, 120.0]]), Ink::Lamella, 1.0);
    scene.fill(Path::polygon([[120.0, 80.0], [330.0, 80.0], [330.0, 140.0], [120.0, 140.0]]), Ink::Lamella, 1.0);
    dimension(&mut scene, [160.0, 80.0], [160.0, 140.0]);
    label(&mut scene, [168.0, 115.0], Anchor::Start, "lamellae.thickness_mm");
    scene.arrow([370.0, 76.0], [370.0, 100.0], Ink::Force, 1.3);
    scene.arrow([370.0, 144.0], [370.0, 120.0], Ink::Force, 1.3);
    label(&mut scene, [404.0, 68.0], Anchor::End, "hinge.thickness_mm");
    guide(&mut scene, [330.0, 140.0], [330.0, 205.0]);
    dimension(&mut scene, [330.0, 165.0], [410.0, 165.0]);
    label(&mut scene, [322.0, 169.0], Anchor::End, "hinge.length_mm, from = \"face\"");
    dimension(&mut scene, [330.0, 195.0], [430.0, 195.0]);
    label(&mut scene, [322.0, 199.0], Anchor::End, "hinge.length_mm, from = \"centreline\"");
    label(&mut scene, [458.0, 60.0], Anchor::Start, "front beam");
    scene
}

/// A picture of an object with the world's axes.
fn object(description: &str, contour: Path) -> Scene {
    let mut scene = Scene::new(300.0, 210.0, description);
    scene.area(contour, Ink::Object, 1.0, Stroke::new(Ink::ObjectEdge, 2.0));
    axes(&mut scene, [24.0, 190.0]);
    scene
}

fn circle() -> Scene {
    let centre = [160.0, 105.0];
    let mut scene = object("Keys of a circle", Path::circle(centre, 80.0));
    scene.arrow(centre, [centre[0] + 69.0, centre[1] - 40.0], Ink::Force, 1.3);
    label(&mut scene, [190.0, 62.0], Anchor::Middle, "radius_mm");
    point(&mut scene, centre, [160.0, 126.0], Anchor::Middle, "centre_mm");
    scene
}

fn ellipse() -> Scene {
    let (centre, [a, b], turn) = ([160.0, 110.0], [90.0, 50.0], 0.5_f64);
    let on = |angle: f64| {
        let (x, y) = (a * angle.cos(), b * angle.sin());
        [centre[0] + x * turn.cos() - y * turn.sin(), centre[1] - x * turn.sin() - y * turn.cos()]
    };
    let contour = Path::polygon((0..72).map(|k| on(f64::from(k) * std::f64::consts::TAU / 72.0)));
    let mut scene = object("Keys of an ellipse", contour);
    guide(&mut scene, centre, [centre[0] + 110.0, centre[1]]);
    scene.arrow(centre, on(0.0), Ink::Force, 1.3);
    scene.arrow(centre, on(std::f64::consts::FRAC_PI_2), Ink::Force, 1.3);
    label(&mut scene, [296.0, 38.0], Anchor::End, "semi_axes_mm[0]");
    label(&mut scene, [122.0, 60.0], Anchor::End, "semi_axes_mm[1]");
    scene.line(Path::arc(centre, 45.0, -turn, 0.0), Stroke::new(Ink::Force, 1.3));
    label(&mut scene, [238.0, 126.0], Anchor::Start, "angle_deg");
    point(&mut scene, centre, [152.0, 126.0], Anchor::End, "centre_mm");
    scene
}

fn polygon() -> Scene {
    let corners = [[90.0, 150.0], [210.0, 160.0], [230.0, 70.0], [110.0, 50.0]];
    let mut scene = object("Keys of a polygon", Path::default());
    // All points within the rounding: the polygon with a wide round rim.
    scene.line(Path::polygon(corners), Stroke::new(Ink::ObjectEdge, 54.0).round());
    scene.line(Path::polygon(corners), Stroke::new(Ink::Object, 50.0).round());
    scene.fill(Path::polygon(corners), Ink::Object, 1.0);
    scene.line(Path::polygon(corners), Stroke::new(Ink::Muted, 0.8).dashed(3.0, 3.0));
    for corner in corners {
        scene.fill(Path::circle(corner, 3.5), Ink::Force, 1.0);
    }
    label(&mut scene, [160.0, 110.0], Anchor::Middle, "corners_mm");
    let [x, y] = corners[2];
    scene.arrow([x, y], [x + 17.0, y - 17.0], Ink::Force, 1.3);
    label(&mut scene, [x + 20.0, y - 36.0], Anchor::Middle, "rounding_mm");
    scene
}

fn half_plane() -> Scene {
    let at = [170.0, 100.0];
    let along = [0.35_f64.sin(), -0.35_f64.cos()];
    let normal = [along[1], -along[0]];
    let on = |s: f64, d: f64| [at[0] + s * along[0] - d * normal[0], at[1] + s * along[1] - d * normal[1]];
    // It has a surface, but no other edge: it goes on beyond the picture.
    let far = 400.0;
    let mut scene = object("Keys of a half-plane", Path::default());
    scene.fill(Path::polygon([on(-far, 0.0), on(far, 0.0), on(far, far), on(-far, far)]), Ink::Object, 1.0);
    scene.line(Path::lines([on(-far, 0.0), on(far, 0.0)]), Stroke::new(Ink::ObjectEdge, 2.0));
    scene.arrow(at, [at[0] + 60.0 * normal[0], at[1] + 60.0 * normal[1]], Ink::Force, 1.6);
    label(&mut scene, [at[0] + 60.0 * normal[0], at[1] + 60.0 * normal[1] - 8.0], Anchor::Middle, "normal");
    point(&mut scene, at, [at[0] + 10.0, at[1] + 5.0], Anchor::Start, "point_mm");
    scene
}

fn bore() -> Scene {
    let centre = [160.0, 105.0];
    let mut scene = Scene::new(300.0, 210.0, "Keys of a bore");
    // The material goes on beyond the picture.
    scene.fill(Path::rectangle(Rect { left: 0.0, top: 0.0, right: 300.0, bottom: 210.0 }), Ink::Object, 1.0);
    scene.area(Path::circle(centre, 80.0), Ink::Paper, 1.0, Stroke::new(Ink::ObjectEdge, 2.0));
    axes(&mut scene, [24.0, 190.0]);
    scene.arrow(centre, [centre[0] + 69.0, centre[1] - 40.0], Ink::Force, 1.3);
    label(&mut scene, [190.0, 62.0], Anchor::Middle, "radius_mm");
    point(&mut scene, centre, [160.0, 126.0], Anchor::Middle, "centre_mm");
    scene
}
