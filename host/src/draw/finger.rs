//! The picture of a deformed finger on its object, in the world frame.

mod labels;

use model_core::design::{Design, HingeKind, Profile};
use model_core::object::{Motion, ObjectDesign};

use super::font::Fonts;
use super::heading::{self, MARGIN, Sample, TEXT};
use super::object;
use super::palette::Ink;
use super::scene::{Anchor, Item, Path, Rect, Scene, Step, Stroke, Text};
use crate::shape::Shape;
use labels::box_of;

/// What the picture shows.
#[derive(Clone, Debug)]
pub struct FingerPicture<'a> {
    /// Title; no letter of it is a mark.
    pub title: String,
    /// Conditions, in a line below the title.
    pub subtitle: String,
    /// The finger as it was designed.
    pub design: &'a Design,
    /// How its base moves.
    pub motion: Motion,
    /// Where along the motion it stands (rad or mm).
    pub coordinate: f64,
    /// The object.
    pub object: ObjectDesign,
    /// The deformed finger.
    pub shape: &'a Shape,
    /// Net force of the finger on the object, world frame, N; none if it is not known.
    pub force: Option<[f64; 2]>,
}

const WIDTH: f64 = 680.0;
const HIGHEST: f64 = 640.0;
/// Height of the row with the scales, px.
const FOOT: f64 = 44.0;
/// Length that the net force's arrow has at most, px.
const LONGEST_ARROW: f64 = 120.0;
/// Half the size of the cross at the object's centre, px.
const CROSS: f64 = 5.0;
/// Length of the arrow that shows where a base is translated to, px.
const MOTION_ARROW: f64 = 46.0;
/// Thickness of the base lamella in the picture, in parts of the finger's height.
const BASE: f64 = 4.0 / 80.0;
/// Width of the arm between motor and base lamella, in parts of the finger's height.
const ARM: f64 = 7.0 / 80.0;
/// Length of the lines between which the motor's angle is marked, in parts of the finger's height.
const ANGLE: f64 = 15.0 / 80.0;
/// Room around the finger's lines, in parts of its height.
const ROOM: f64 = 4.0 / 80.0;

impl FingerPicture<'_> {
    /// The picture.
    pub fn scene(&self) -> Scene {
        let fonts = Fonts::new();
        let mut scene = Scene::new(WIDTH, HIGHEST, heading::described(&self.title, &self.subtitle));
        let top = self.headings(&mut scene, &fonts);
        let ghost = Shape::undeformed(self.design);
        let net = self.net_force();
        let view = self.view(&ghost, top, &fonts, net);
        scene.height = view.area.bottom + FOOT + MARGIN;

        scene.items.push(Item::Clip(view.area));
        let labels = self.labels(&view, &fonts, &ghost, net);
        self.draw_object(&mut scene, &view, labels.object);
        self.draw_arm(&mut scene, &view);
        self.draw_ghost(&mut scene, &view, &ghost);
        self.draw_finger(&mut scene, &view);
        self.draw_base(&mut scene, &view);
        scene.items.push(Item::Unclip);
        self.draw_motion(&mut scene, &view);
        if let (Some(net), Some(at)) = (net, labels.force) {
            self.draw_forces(&mut scene, &view, net, at);
        }
        view.scale_bar(&mut scene);
        scene
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
            legend.push(("net force", Sample::Arrow(Ink::Force, 2.6)));
        }
        heading::draw(scene, fonts, [&self.title, &self.subtitle], &legend)
    }

    /// Position in the world of a point of the finger, mm.
    fn world(&self, p: [f64; 2]) -> [f64; 2] {
        match self.motion {
            Motion::Rotating { axis } => {
                let (sin, cos) = self.coordinate.sin_cos();
                let [x, y] = [p[0] - axis[0], p[1] - axis[1]];
                [axis[0] + cos * x + sin * y, axis[1] - sin * x + cos * y]
            }
            Motion::Translating { direction } => {
                [p[0] + direction[0] * self.coordinate, p[1] + direction[1] * self.coordinate]
            }
        }
    }

    /// The scale and place at which all that is drawn fits: each part is a point of the world with the room that it takes
    /// up around it, some of it in mm and some, as of words, in px.
    fn view(&self, ghost: &Shape, top: f64, fonts: &Fonts, net: Option<NetForce>) -> View {
        let height = self.height();
        let (base, room) = (BASE * height, ROOM * height);
        let mut parts = Vec::new();
        let mut include = |[x, y]: [f64; 2], reach: f64, rect: Rect| {
            if x.is_finite() && y.is_finite() {
                parts.push(([x - reach, y - reach], rect));
                parts.push(([x + reach, y + reach], rect));
            }
        };
        let bare = Rect { left: 0.0, top: 0.0, right: 0.0, bottom: 0.0 };
        for &p in ghost.front.iter().chain(&ghost.back).chain(&self.shape.front).chain(&self.shape.back) {
            include(self.world(p), room, bare);
        }
        include(self.world([self.design.front.base[0], self.design.front.base[1] - base]), room, bare);
        include(self.world([self.design.back.base[0], self.design.back.base[1] - base]), room, bare);
        match self.motion {
            Motion::Rotating { axis } => {
                include(axis, ARM * height, bare);
                include(axis, 0.0, box_of(fonts, &self.motion_text([0.0; 2])));
            }
            Motion::Translating { direction } => {
                include(self.below_base(), 2.25 * room, bare);
                let half = direction.map(|part| 0.5 * MOTION_ARROW * part.abs());
                let arrow = Rect { left: -half[0], top: -half[1], right: half[0], bottom: half[1] };
                include(self.below_base(), 0.0, arrow.with(box_of(fonts, &self.motion_text([0.0; 2]))));
            }
        }
        match object::bounds(&self.object) {
            Some((middle, radius)) if radius <= self.whole() => {
                include(middle, radius + 0.75 * room, bare);
                // Its name may stand below it.
                let [x, y] = object::lowest(&self.object);
                if !matches!(self.object, ObjectDesign::Circle { radius, .. } if radius > 3.0 * room) {
                    include([x, y - 2.0 * room], 0.0, bare);
                }
            }
            _ => {
                let foot = self.world(self.design.front.point(0.5 * height));
                let towards = object::towards(&self.object, foot);
                include([foot[0] + 0.5 * height * towards[0], foot[1] + 0.5 * height * towards[1]], 0.0, bare);
                // Room for its name behind its edge.
                let edge = object::onto(&self.object, foot);
                if (edge[0] - foot[0]).hypot(edge[1] - foot[1]) < height {
                    let [right, up] = towards.map(|part| 2.5 * TEXT * part);
                    let behind =
                        Rect { left: right.min(0.0), right: right.max(0.0), top: -up.max(0.0), bottom: -up.min(0.0) };
                    include(edge, 0.0, behind);
                }
            }
        }
        if let Some(net) = net {
            let room = Rect { left: -4.0, top: -4.0, right: 4.0, bottom: 4.0 };
            for (from, arrow) in self.arrows(net) {
                include(from, 0.0, room.moved(arrow));
            }
            let beside = self.force_places(fonts, net, net.arrow).swap_remove(0);
            include(net.from, 0.0, room.moved(net.arrow).with(box_of(fonts, &beside)));
        }
        // What the parts cover at a scale: from left, top to right, bottom, px from the world's origin.
        let covered = |scale: f64| {
            let none = Rect { left: f64::INFINITY, top: f64::INFINITY, right: -f64::INFINITY, bottom: -f64::INFINITY };
            parts.iter().fold(none, |all, ([x, y], rect)| all.with(rect.moved([scale * x, -scale * y])))
        };
        let (wide, tall) = (WIDTH - 2.0 * MARGIN, HIGHEST - top - FOOT - MARGIN);
        let fits = |scale: f64| {
            let all = covered(scale);
            all.right - all.left <= wide && all.bottom - all.top <= tall
        };
        // What is covered grows with the scale: halve towards the largest that fits.
        let points = covered(1.0);
        let (mut low, mut high) = (0.0, 2.0 * wide.max(tall) / height);
        if points.right.is_finite() {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if fits(middle) { low = middle } else { high = middle }
            }
        }
        let scale = low;
        let all = covered(scale);
        let left = 0.5 * (WIDTH - (all.right - all.left));
        let area = Rect { left: MARGIN, right: WIDTH - MARGIN, top, bottom: top + all.bottom - all.top };
        View { scale, origin: [left - all.left, top - all.top], area }
    }

    /// The net force with its arrow; none if it is not known or nothing.
    fn net_force(&self) -> Option<NetForce> {
        let force = self.force?;
        let magnitude = force[0].hypot(force[1]);
        let from = self.line_of_action(force);
        let scale = LONGEST_ARROW / magnitude;
        (magnitude > 0.0 && magnitude.is_finite() && from.iter().all(|x| x.is_finite())).then_some(NetForce {
            magnitude,
            from,
            scale,
            arrow: [scale * force[0], -scale * force[1]],
        })
    }

    /// The arrows of all forces, the net one last: where each begins (world, mm) and where it leads (px).
    fn arrows(&self, net: NetForce) -> Vec<([f64; 2], [f64; 2])> {
        let mut arrows = Vec::new();
        // A single contact force is the net force.
        if self.shape.contacts.len() > 1 {
            arrows.extend(self.shape.contacts.iter().map(|contact| {
                let n = self.world_direction(contact.normal);
                let length = net.scale * contact.force;
                (self.world(contact.position), [-length * n[0], length * n[1]])
            }));
        }
        arrows.push((net.from, net.arrow));
        arrows
    }

    fn draw_object(&self, scene: &mut Scene, view: &View, name: Option<Text>) {
        // Large enough to reach beyond the picture on all sides, for a half-plane.
        let reach = (view.area.right - view.area.left).hypot(view.area.bottom - view.area.top) / view.scale;
        let middle = view.world([0.5 * (view.area.left + view.area.right), 0.5 * (view.area.top + view.area.bottom)]);
        let outline = object::outline(&self.object, middle, reach).mapped(|p| view.at(p));
        scene.area(outline, Ink::Object, 1.0, Stroke::new(Ink::ObjectEdge, 1.4));
        let bounds = object::bounds(&self.object);
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

    /// The finger's height, mm: what has no size of its own is drawn in proportion to it.
    fn height(&self) -> f64 {
        self.design.front.length()
    }

    /// The largest radius of an object that is shown whole, mm: the finger is what the picture is about.
    fn whole(&self) -> f64 {
        0.6 * self.height()
    }

    /// Where the arrow of a translated base has its middle, world frame, mm.
    fn below_base(&self) -> [f64; 2] {
        let [front, back] = [self.design.front.base, self.design.back.base];
        self.world([0.5 * (front[0] + back[0]), front[1].min(back[1]) - 3.5 * BASE * self.height()])
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
        let flexible = design.hinge.kind == HingeKind::Flexible;
        for (lamella, bar) in self.shape.lamellae.iter().enumerate() {
            let arcs = design.attachment_arcs(lamella);
            let ends = [(&self.shape.front, &design.front, arcs[0]), (&self.shape.back, &design.back, arcs[1])];
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
                    let neck = Path(vec![
                        Step::Move(from),
                        Step::Cubic(
                            [from[0] + reach * leave[0], from[1] + reach * leave[1]],
                            [to[0] - reach * along[0], to[1] - reach * along[1]],
                            to,
                        ),
                    ]);
                    scene.line(neck, Stroke::new(Ink::Lamella, (view.scale * design.hinge.thickness).max(1.5)).round());
                }
            }
            let half = 0.5 * design.lamellae.thickness * view.scale;
            let corner = |[x, y]: [f64; 2], side: f64| [x - side * half * along[1], y + side * half * along[0]];
            let body = [corner(p, 1.0), corner(q, 1.0), corner(q, -1.0), corner(p, -1.0)];
            scene.area(Path::polygon(body), Ink::Lamella, 1.0, Stroke::new(Ink::Lamella, 1.0).round());
        }
        self.draw_beam(scene, view, &self.shape.back, &design.back.thickness, Ink::Back);
        self.draw_beam(scene, view, &self.shape.front, &design.front.thickness, Ink::Front);
        // Pins lie on the beams' centrelines and show on them; welded lamellae have none.
        if design.hinge.kind == HingeKind::Pinned {
            for end in self.shape.lamellae.iter().flatten() {
                let end = view.at(self.world(*end));
                scene.area(Path::circle(end, 3.0), Ink::Paper, 1.0, Stroke::new(Ink::Back, 1.4));
            }
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
        let mut outline = Path::lines([roots[0]]);
        outline.0.extend(sides[0].first().map(|&p| Step::Line(p)));
        outline.extend_smooth(&sides[0]);
        outline.0.extend(sides[1].first().map(|&p| Step::Line(p)));
        outline.extend_smooth(&sides[1]);
        outline.0.push(Step::Line(roots[1]));
        scene.area(outline.closed(), ink, 1.0, Stroke::new(ink, 0.6).round());
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

    /// The motor's angle beside it, or the distance beside its arrow's middle, px.
    fn motion_text(&self, [x, y]: [f64; 2]) -> Text {
        match self.motion {
            Motion::Rotating { .. } => {
                let words = format!("*α* = {}°", short(self.coordinate.to_degrees(), 2));
                Text::new([x + 12.0, y + 5.0], TEXT, words).halo()
            }
            Motion::Translating { direction } => {
                let from = [x - 0.5 * MOTION_ARROW * direction[0], y + 0.5 * MOTION_ARROW * direction[1]];
                // Behind the arrow's tail, where its head is not.
                let (aside, anchor) = if direction[0] > 0.0 { (-9.0, Anchor::End) } else { (9.0, Anchor::Start) };
                let words = format!("*d* = {} mm", short(self.coordinate, 2));
                Text::new([from[0] + aside, from[1] + 0.35 * TEXT], TEXT, words).halo().anchor(anchor)
            }
        }
    }

    fn draw_forces(&self, scene: &mut Scene, view: &View, net: NetForce, words: Text) {
        let arrows = self.arrows(net);
        for (index, &(from, [right, down])) in arrows.iter().enumerate() {
            let from = view.at(from);
            let (ink, width) = if index + 1 == arrows.len() { (Ink::Force, 2.6) } else { (Ink::Series(4), 1.3) };
            scene.arrow(from, [from[0] + right, from[1] + down], ink, width);
        }
        scene.text(words);

        let scale = net.scale;
        let round = round_below(80.0 / scale);
        let length = scale * round;
        let right = view.area.right - 20.0;
        let y = view.area.bottom + 0.5 * FOOT;
        scene.arrow([right - length, y], [right, y], Ink::Force, 2.6);
        let words = format!("{} N", round_words(round));
        scene.text(Text::new([right - 0.5 * length, y + 1.4 * TEXT], TEXT, words).anchor(Anchor::Middle));
    }

    /// Where the net force's arrow begins: on its line of action, beside the middle of the contact. World frame, mm.
    fn line_of_action(&self, force: [f64; 2]) -> [f64; 2] {
        let magnitude = force[0].hypot(force[1]);
        if let ObjectDesign::Circle { centre, radius } = self.object {
            // Without friction every part points at the circle's centre, and so does their sum.
            let reach = radius / magnitude;
            return [centre[0] - reach * force[0], centre[1] - reach * force[1]];
        }
        let (mut middle, mut total, mut moment) = ([0.0; 2], 0.0, 0.0);
        for contact in &self.shape.contacts {
            let (p, n) = (self.world(contact.position), self.world_direction(contact.normal));
            middle = [middle[0] + contact.force * p[0], middle[1] + contact.force * p[1]];
            total += contact.force;
            moment -= contact.force * (p[0] * n[1] - p[1] * n[0]);
        }
        if total <= 0.0 {
            return self.world(self.design.front.point(0.5 * self.design.front.length()));
        }
        let middle = [middle[0] / total, middle[1] / total];
        // Aside by what the moment about the middle asks for.
        let aside = (moment - (middle[0] * force[1] - middle[1] * force[0])) / (magnitude * magnitude);
        [middle[0] + aside * force[1], middle[1] - aside * force[0]]
    }

    fn world_direction(&self, v: [f64; 2]) -> [f64; 2] {
        let (origin, tip) = (self.world([0.0, 0.0]), self.world(v));
        [tip[0] - origin[0], tip[1] - origin[1]]
    }
}

/// The net force and its arrow.
#[derive(Clone, Copy, Debug)]
struct NetForce {
    /// N.
    magnitude: f64,
    /// Where the arrow begins, world frame, mm.
    from: [f64; 2],
    /// Length of forces' arrows, px per N.
    scale: f64,
    /// Where the arrow leads, px to the right and down.
    arrow: [f64; 2],
}

fn ghost_stroke() -> Stroke {
    Stroke::new(Ink::Ghost, 1.2).dashed(4.0, 3.0)
}

/// From mm in the world to the picture.
struct View {
    /// Pixels per mm.
    scale: f64,
    /// Where the world's origin lies.
    origin: [f64; 2],
    area: Rect,
}

impl View {
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + self.scale * x, self.origin[1] - self.scale * y]
    }

    fn world(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.origin[0]) / self.scale, (self.origin[1] - y) / self.scale]
    }

    fn scale_bar(&self, scene: &mut Scene) {
        let round = round_below(110.0 / self.scale);
        let (left, y) = (self.area.left + 20.0, self.area.bottom + 0.5 * FOOT);
        let right = left + self.scale * round;
        scene.line(Path::lines([[left, y], [right, y]]), Stroke::new(Ink::Main, 2.0));
        for x in [left, right] {
            scene.line(Path::lines([[x, y - 4.0], [x, y + 4.0]]), Stroke::new(Ink::Main, 2.0));
        }
        let words = format!("{} mm", round_words(round));
        scene.text(Text::new([0.5 * (left + right), y + 1.4 * TEXT], TEXT, words).anchor(Anchor::Middle));
    }
}

pub(super) fn unit([x, y]: [f64; 2]) -> [f64; 2] {
    let length = x.hypot(y);
    if length > 0.0 { [x / length, y / length] } else { [0.0, 0.0] }
}

/// Point and unit tangent of a polyline at an arc length.
fn along_line(line: &[[f64; 2]], arc: f64) -> Option<([f64; 2], [f64; 2])> {
    let mut passed = 0.0;
    for pair in line.windows(2) {
        let [a, b] = [pair[0], pair[1]];
        let step = [b[0] - a[0], b[1] - a[1]];
        let length = step[0].hypot(step[1]);
        if passed + length >= arc - 1e-9 && length > 0.0 {
            let part = ((arc - passed) / length).clamp(0.0, 1.0);
            return Some(([a[0] + part * step[0], a[1] + part * step[1]], unit(step)));
        }
        passed += length;
    }
    None
}

/// The largest of 1, 2, 5 times a power of ten that is not more.
fn round_below(most: f64) -> f64 {
    let power = 10_f64.powf(most.max(f64::MIN_POSITIVE).log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|factor| factor * power).find(|&value| value <= most).unwrap_or(power)
}

/// A value of [`round_below`] in words.
fn round_words(round: f64) -> String {
    // Beyond four decimals a power of ten reads better.
    if round >= 1e-4 { short(round, 4) } else { format!("{round:.0e}").replace('-', "−") }
}

/// So many decimals; of a small value as many as show three digits, below 1e−4 with a power of ten: what is not zero does
/// not read as zero.
pub(crate) fn significant(value: f64, decimals: usize) -> String {
    let size = value.abs();
    let text = if !(size > 0.0 && size.is_finite()) || size >= 10_f64.powi(1 - decimals as i32) {
        format!("{value:.decimals$}")
    } else if size >= 1e-4 {
        format!("{value:.*}", (2.0 - size.log10().floor()) as usize)
    } else {
        format!("{value:.2e}")
    };
    text.replace('-', "−")
}

/// At most so many decimals, without trailing zeros, with a true minus sign.
pub(crate) fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let text = if text == "-0" { "0" } else { text };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::{round_below, round_words, significant};

    #[test]
    fn small_values_keep_their_digits() {
        let words = [6.034, 0.5, 0.0, 0.015_23, 1.5e-5, -0.02, 123.456].map(|value| significant(value, 2));
        assert_eq!(words, ["6.03", "0.50", "0.00", "0.0152", "1.50e−5", "−0.0200", "123.46"]);
        assert_eq!([0.012_34, 0.001_234].map(|value| significant(value, 3)), ["0.012", "0.00123"]);
        let scales = [70.0, 3.0, 0.012, 4e-4, 1.1e-5, 6e-12].map(|most| round_words(round_below(most)));
        assert_eq!(scales, ["50", "2", "0.01", "0.0002", "1e−5", "5e−12"]);
    }
}
