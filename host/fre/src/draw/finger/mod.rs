//! The picture of a deformed finger on its object, in the world frame.

mod labels;
mod picture;
mod scales;
mod view;

use model_core::design::{Beam, HingeKind, Profile};
use model_core::object::Motion;

use super::font::Fonts;
use super::heading::{self, MARGIN, Sample};
use super::object;
use super::palette::Ink;
use super::path::Path;
use super::scene::{Item, Scene, Stroke, Text, unit};
use crate::shape::Shape;
use labels::{CROSS, MOTION_ARROW};
use picture::{ARM, BASE, NetForce, View, along_line};
use view::{FOOT, HIGHEST, WIDTH};

pub use picture::FingerPicture;

/// Length of the lines between which the motor's angle is marked, in parts of the finger's height.
const ANGLE: f64 = 15.0 / 80.0;

/// Pictures of one finger along its motion, all of one size and with one scale of lengths and of forces: the frames of a moving picture.
pub fn frames(pictures: &[FingerPicture]) -> Vec<Scene> {
    let fonts = Fonts::new();
    let largest = pictures.iter().map(FingerPicture::magnitude).fold(0.0, f64::max);
    let (mut begun, mut parts, mut top) = (Vec::new(), Vec::new(), 0.0_f64);
    for picture in pictures {
        let mut scene = Scene::new(WIDTH, HIGHEST, heading::described(&picture.title, &picture.subtitle));
        top = top.max(picture.headings(&mut scene, &fonts));
        let ghost = Shape::undeformed(picture.design);
        let net = picture.net_force(largest);
        parts.extend(picture.parts(&ghost, &fonts, net));
        begun.push((picture, scene, ghost, net));
    }
    let height = pictures.iter().map(FingerPicture::height).fold(0.0, f64::max);
    let view = View::of(&parts, height, top);
    begun
        .into_iter()
        .map(|(picture, mut scene, ghost, net)| {
            picture.draw(&mut scene, &view, &fonts, &ghost, net);
            scene
        })
        .collect()
}

impl FingerPicture<'_> {
    /// The picture.
    pub fn scene(&self) -> Scene {
        frames(std::slice::from_ref(self)).swap_remove(0)
    }

    /// Draws all below the headings.
    fn draw(&self, scene: &mut Scene, view: &View, fonts: &Fonts, ghost: &Shape, net: Option<NetForce>) {
        scene.height = view.area.bottom + FOOT + MARGIN;

        scene.items.push(Item::Clip(view.area));
        let labels = self.labels(view, fonts, ghost, net);
        self.draw_object(scene, view, labels.object);
        self.draw_arm(scene, view);
        self.draw_ghost(scene, view, ghost);
        self.draw_finger(scene, view);
        self.draw_base(scene, view);
        scene.items.push(Item::Unclip);
        self.draw_motion(scene, view);
        if let (Some(net), Some(at)) = (net, labels.force) {
            self.draw_forces(scene, view, net, at);
        }
        view.scale_bar(scene);
    }

    fn headings(&self, scene: &mut Scene, fonts: &Fonts) -> f64 {
        let mut legend = vec![
            ("front beam", Sample::Line(Stroke::new(Ink::Front, 7.0))),
            ("back beam", Sample::Line(Stroke::new(Ink::Back, 7.0))),
            ("undeformed", Sample::Line(ghost_stroke())),
        ];
        if !self.shape.lamellae.is_empty() {
            legend.insert(2, ("lamellae", Sample::Line(Stroke::new(Ink::Lamella, 7.0))));
        }
        if self.force.is_some() && !self.shape.contacts.is_empty() {
            // A single one is the net force.
            if self.shape.contacts.len() > 1 {
                legend.push(("contact forces", Sample::Arrow(Ink::Series(4), 1.3)));
            }
            if self.friction > 0.0 {
                legend.push(("friction cones", Sample::Area(Ink::Series(4))));
            }
            legend.push(("net force", Sample::Arrow(Ink::Force, 2.6)));
        }
        heading::draw(scene, fonts, [&self.title, &self.subtitle], &legend)
    }

    fn draw_object(&self, scene: &mut Scene, view: &View, name: Option<Text>) {
        // Large enough to reach beyond the picture on all sides, for a half-plane.
        let reach = (view.area.right - view.area.left).hypot(view.area.bottom - view.area.top) / view.scale;
        let middle = view.world([0.5 * (view.area.left + view.area.right), 0.5 * (view.area.top + view.area.bottom)]);
        let contour = object::contour(&self.object, middle, reach).mapped(|p| view.at(p));
        scene.area(contour, Ink::Object, 1.0, Stroke::new(Ink::ObjectEdge, 1.4));
        let bounds = self.object.bounds();
        if let Some((centre, _)) = bounds {
            let [x, y] = view.at(centre);
            for [dx, dy] in [[CROSS, 0.0], [0.0, CROSS]] {
                let line = Path::lines([[x - dx, y - dy], [x + dx, y + dy]]);
                scene.line(line, Stroke::new(Ink::ObjectEdge, 1.0));
            }
        }
        if let Some(name) = name {
            let outside = object::distance(&self.object, view.world(name.at)) > 0.0;
            scene.text(if outside { name.halo() } else { name });
        }
    }

    /// The arm from the motor to the base lamella.
    fn draw_arm(&self, scene: &mut Scene, view: &View) {
        let Motion::Rotating { axis } = self.motion else { return };
        let [front, back] = [self.design.front.base, self.design.back.base];
        let middle = [0.5 * (front[0] + back[0]), 0.5 * (front[1] + back[1]) - 0.5 * BASE * self.height()];
        let arm = Path::lines([view.at(axis), view.at(self.world(middle))]);
        scene.line(arm, Stroke::new(Ink::Faint, ARM * self.height() * view.scale).round());
    }

    /// The base lamella, over the beams' ends.
    fn draw_base(&self, scene: &mut Scene, view: &View) {
        let [front, back] = [self.design.front.base, self.design.back.base];
        let base = BASE * self.height();
        let side = 0.5 * base;
        let corners = [
            [back[0] - side, back[1]],
            [front[0] + side, front[1]],
            [front[0] + side, front[1] - base],
            [back[0] - side, back[1] - base],
        ];
        let block = Path::polygon(corners.map(|p| view.at(self.world(p))));
        scene.area(block, Ink::Ghost, 1.0, Stroke::new(Ink::Ghost, 1.0).round());
    }

    fn draw_ghost(&self, scene: &mut Scene, view: &View, ghost: &Shape) {
        let stroke = ghost_stroke();
        for line in [&ghost.front, &ghost.back] {
            scene.line(Path::lines(line.iter().map(|&p| view.at(self.world(p)))), stroke);
        }
        for bar in &ghost.lamellae {
            scene.line(Path::lines(bar.map(|p| view.at(self.world(p)))), Stroke::new(Ink::Ghost, 0.8).dashed(2.0, 3.0));
        }
    }

    fn draw_finger(&self, scene: &mut Scene, view: &View) {
        let design = self.design;
        for (lamella, rib) in self.shape.ribs.iter().enumerate() {
            self.draw_rib(scene, view, lamella, rib);
        }
        let [front, back] = [(&design.front, &self.shape.front), (&design.back, &self.shape.back)]
            .map(|(beam, line)| whole(beam, line));
        let flexible = design.joint() == HingeKind::Flexible;
        let bars = if self.shape.ribs.is_empty() { &self.shape.lamellae[..] } else { &[] };
        for (lamella, bar) in bars.iter().enumerate() {
            let arcs = design.attachment_arcs(lamella);
            let ends = [(&front, &design.front, arcs[0]), (&back, &design.back, arcs[1])];
            let [p, q] = bar.map(|p| view.at(self.world(p)));
            let along = unit([q[0] - p[0], q[1] - p[1]]);
            if flexible {
                for (side, (line, beam, arc)) in ends.into_iter().enumerate() {
                    let Some((point, tangent)) = along_line(line, arc) else { continue };
                    // The hinge leaves the beam in the direction it had, turned with the beam.
                    let turn = tangent[1].atan2(tangent[0]) - {
                        let rest = beam.direction(arc);
                        rest[1].atan2(rest[0])
                    };
                    let rest = self.rest_direction(lamella);
                    let (sin, cos) = turn.sin_cos();
                    let turned = [cos * rest[0] - sin * rest[1], sin * rest[0] + cos * rest[1]];
                    let sign = if side == 0 { 1.0 } else { -1.0 };
                    let from = view.at(self.world(point));
                    let tip = self.world([point[0] + turned[0], point[1] + turned[1]]);
                    let leave = unit([view.at(tip)[0] - from[0], view.at(tip)[1] - from[1]]);
                    let to = if side == 0 { p } else { q };
                    let reach = sign * (to[0] - from[0]).hypot(to[1] - from[1]) / 3.0;
                    let neck = Path::curve(
                        from,
                        [from[0] + reach * leave[0], from[1] + reach * leave[1]],
                        [to[0] - reach * along[0], to[1] - reach * along[1]],
                        to,
                    );
                    scene.line(neck, Stroke::new(Ink::Lamella, (view.scale * design.hinge.thickness).max(1.5)).round());
                }
            }
            let halves = design.lamella_thickness(lamella).map(|thickness| 0.5 * thickness * view.scale);
            let corner = |end: usize, side: f64| {
                let ([x, y], half) = ([p, q][end], side * halves[end]);
                [x - half * along[1], y + half * along[0]]
            };
            let body = [corner(0, 1.0), corner(1, 1.0), corner(1, -1.0), corner(0, -1.0)];
            scene.area(Path::polygon(body), Ink::Lamella, 1.0, Stroke::new(Ink::Lamella, 1.0).round());
        }
        self.draw_beam(scene, view, &back, &design.back.thickness, Ink::Back);
        self.draw_beam(scene, view, &front, &design.front.thickness, Ink::Front);
        // Pins lie on the beams' centrelines and show on them; welded lamellae have none.
        if design.joint() == HingeKind::Pinned {
            for end in self.shape.lamellae.iter().flatten() {
                let end = view.at(self.world(*end));
                scene.area(Path::circle(end, 3.0), Ink::Paper, 1.0, Stroke::new(Ink::Back, 1.4));
            }
        }
    }

    /// A rib along its bent centreline, with its taper, and necks at their ends where it has some.
    fn draw_rib(&self, scene: &mut Scene, view: &View, lamella: usize, rib: &[[f64; 2]]) {
        let design = self.design;
        let [front, back] = design.lamella_thickness(lamella);
        let length = rib.windows(2).map(|pair| distance(pair[0], pair[1])).sum::<f64>();
        let neck = match design.joint() {
            HingeKind::Flexible => design.hinge.length_of(lamella) / length.max(f64::MIN_POSITIVE),
            HingeKind::Pinned | HingeKind::Welded => 0.0,
        };
        let thickness = |part: f64| {
            if part < neck || part > 1.0 - neck { design.hinge.thickness } else { front + part * (back - front) }
        };
        let mut at = 0.0;
        for pair in rib.windows(2) {
            let piece = distance(pair[0], pair[1]);
            let width = view.scale * thickness((at + 0.5 * piece) / length.max(f64::MIN_POSITIVE));
            at += piece;
            let line = Path::lines([pair[0], pair[1]].map(|p| view.at(self.world(p))));
            scene.line(line, Stroke::new(Ink::Lamella, width.max(1.5)).round());
        }
    }

    fn rest_direction(&self, lamella: usize) -> [f64; 2] {
        let arcs = self.design.attachment_arcs(lamella);
        let (p, q) = (self.design.front.point(arcs[0]), self.design.back.point(arcs[1]));
        unit([q[0] - p[0], q[1] - p[1]])
    }

    fn draw_beam(&self, scene: &mut Scene, view: &View, line: &[[f64; 2]], thickness: &Profile, ink: Ink) {
        if line.len() < 2 {
            return;
        }
        let mut arc = 0.0;
        let mut sides = [Vec::with_capacity(line.len()), Vec::with_capacity(line.len())];
        for (i, &p) in line.iter().enumerate() {
            let (before, after) = (line[i.saturating_sub(1)], line[(i + 1).min(line.len() - 1)]);
            if i > 0 {
                arc += (p[0] - before[0]).hypot(p[1] - before[1]);
            }
            let e = unit([after[0] - before[0], after[1] - before[1]]);
            let half = 0.5 * thickness.at(arc);
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                sides[side].push(view.at(self.world([p[0] - sign * half * e[1], p[1] + sign * half * e[0]])));
            }
        }
        // The beam reaches into the base, which is drawn over it, and ends round: both beams' ends make one tip.
        let foot = unit([line[1][0] - line[0][0], line[1][1] - line[0][1]]);
        let deep = 0.5 * BASE * self.height();
        let root = |side: f64| {
            let half = 0.5 * side * thickness.at(0.0);
            [line[0][0] - deep * foot[0] - half * foot[1], line[0][1] - deep * foot[1] + half * foot[0]]
        };
        let roots = [1.0, -1.0].map(|side| view.at(self.world(root(side))));
        if let Some(&tip) = line.last() {
            scene.fill(Path::circle(view.at(self.world(tip)), 0.5 * view.scale * thickness.at(arc)), ink, 1.0);
        }
        sides[1].reverse();
        let mut edge = Path::lines([roots[0]]);
        sides[0].first().into_iter().for_each(|&p| edge.line_to(p));
        edge.extend_smooth(&sides[0]);
        sides[1].first().into_iter().for_each(|&p| edge.line_to(p));
        edge.extend_smooth(&sides[1]);
        edge.line_to(roots[1]);
        scene.area(edge.closed(), ink, 1.0, Stroke::new(ink, 0.6).round());
    }

    /// The motor with its angle, or the distance travelled.
    fn draw_motion(&self, scene: &mut Scene, view: &View) {
        match self.motion {
            Motion::Rotating { axis } => {
                let m = view.at(axis);
                let reach = ANGLE * self.height() * view.scale;
                let angle = self.coordinate;
                let up = [m[0], m[1] - reach];
                let turned = [m[0] + reach * angle.sin(), m[1] - reach * angle.cos()];
                scene.line(Path::lines([m, up]), Stroke::new(Ink::Muted, 1.0).dashed(3.0, 3.0));
                scene.line(Path::lines([m, turned]), Stroke::new(Ink::Muted, 1.0));
                let quarter = std::f64::consts::FRAC_PI_2;
                let arc = Path::arc(m, 0.8 * reach, -quarter, angle - quarter);
                scene.line(arc, Stroke::new(Ink::Muted, 1.2));
                scene.area(Path::circle(m, 5.0), Ink::Paper, 1.0, Stroke::new(Ink::Main, 1.6));
                scene.fill(Path::circle(m, 1.6), Ink::Main, 1.0);
                scene.text(self.motion_text(m));
            }
            Motion::Translating { direction } => {
                let middle = view.at(self.below_base());
                let half = [0.5 * MOTION_ARROW * direction[0], -0.5 * MOTION_ARROW * direction[1]];
                let from = [middle[0] - half[0], middle[1] - half[1]];
                scene.arrow(from, [middle[0] + half[0], middle[1] + half[1]], Ink::Main, 1.4);
                scene.text(self.motion_text(middle));
            }
        }
    }

    fn draw_forces(&self, scene: &mut Scene, view: &View, net: NetForce, words: Text) {
        for (from, sides) in self.cones(net) {
            let [x, y] = view.at(from);
            let [a, b] = sides.map(|[right, down]| [x + right, y + down]);
            scene.area(Path::polygon([[x, y], a, b]), Ink::Series(4), 0.25, Stroke::new(Ink::Series(4), 0.5));
        }
        let arrows = self.arrows(net);
        for (index, &(from, [right, down])) in arrows.iter().enumerate() {
            let from = view.at(from);
            let (ink, width) = if index + 1 == arrows.len() { (Ink::Force, 2.6) } else { (Ink::Series(4), 1.3) };
            scene.arrow(from, [from[0] + right, from[1] + down], ink, width);
        }
        scene.text(words);
        view.force_scale(scene, net);
    }
}

fn ghost_stroke() -> Stroke {
    Stroke::new(Ink::Ghost, 1.2).dashed(4.0, 3.0)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// A beam's deformed centreline with the part that is held, base to tip.
fn whole(beam: &Beam, bends: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const HELD: u32 = 24;
    let pieces = if beam.clamp > 0.0 { HELD } else { 0 };
    let held = (0..pieces).map(|i| beam.point(beam.clamp * f64::from(i) / f64::from(HELD)));
    held.chain(bends.iter().copied()).collect()
}
