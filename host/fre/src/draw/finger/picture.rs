//! A deformed finger on its object in the world: points, forces and their arrows.

use model_core::design::Design;
use model_core::object::{Motion, ObjectDesign};

use crate::draw::path::Rect;
use crate::draw::scene::unit;
use crate::shape::{Contact, Shape};

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
    /// Where along the motion it is (rad or mm).
    pub coordinate: f64,
    /// The object.
    pub object: ObjectDesign,
    /// Coefficient of friction; with some, contact forces are drawn with their cones.
    pub friction: f64,
    /// The deformed finger.
    pub shape: &'a Shape,
    /// Net force of the finger on the object, world frame, N; none if it is not known.
    pub force: Option<[f64; 2]>,
}

/// Length that the net force's arrow has at most, px.
pub(super) const LONGEST_ARROW: f64 = 120.0;
/// Thickness of the base lamella in the picture, in parts of the finger's height.
pub(super) const BASE: f64 = 4.0 / 80.0;
/// Width of the arm between motor and base lamella, in parts of the finger's height.
pub(super) const ARM: f64 = 7.0 / 80.0;

impl FingerPicture<'_> {
    /// Position in the world of a point of the finger, mm.
    pub(super) fn world(&self, p: [f64; 2]) -> [f64; 2] {
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

    /// Magnitude of the net force, N; 0 if it is not known.
    pub(super) fn magnitude(&self) -> f64 {
        self.force.map_or(0.0, |[x, y]| x.hypot(y))
    }

    /// The net force with its arrow, where the longest arrow is that of a force `largest` (N); none if it is not known or nothing.
    pub(super) fn net_force(&self, largest: f64) -> Option<NetForce> {
        let force = self.force?;
        let magnitude = self.magnitude();
        let from = self.line_of_action(force);
        let scale = LONGEST_ARROW / largest.max(magnitude);
        (magnitude > 0.0 && magnitude.is_finite() && from.iter().all(|x| x.is_finite())).then_some(NetForce {
            magnitude,
            from,
            scale,
            arrow: [scale * force[0], -scale * force[1]],
        })
    }

    /// The arrows of all forces, the net one last: where each begins (world, mm) and where it leads (px).
    pub(super) fn arrows(&self, net: NetForce) -> Vec<([f64; 2], [f64; 2])> {
        let mut arrows = Vec::new();
        // A single contact force is the net force.
        if self.shape.contacts.len() > 1 {
            arrows.extend(self.shape.contacts.iter().map(|contact| {
                let [x, y] = self.push(contact, contact.tangential.unwrap_or(0.0));
                (self.world(contact.position), [net.scale * x, -net.scale * y])
            }));
        }
        arrows.push((net.from, net.arrow));
        arrows
    }

    /// Force of the finger on the object at a contact with this tangential part (N, towards the finger's tip on the finger), world frame, N.
    fn push(&self, contact: &Contact, tangential: f64) -> [f64; 2] {
        let [x, y] = self.world_direction(contact.normal);
        [-(contact.force * x + tangential * y), -(contact.force * y - tangential * x)]
    }

    /// The cones within which contact forces lie: a triangle each, whose sides are forces that slip one way and the other. World, mm, and
    /// from there px.
    pub(super) fn cones(&self, net: NetForce) -> Vec<([f64; 2], [[f64; 2]; 2])> {
        let cone = |contact: &Contact| {
            let most = self.friction * contact.force;
            let sides = [most, -most].map(|tangential| {
                let [x, y] = self.push(contact, tangential);
                [net.scale * x, -net.scale * y]
            });
            (self.world(contact.position), sides)
        };
        if self.friction > 0.0 { self.shape.contacts.iter().map(cone).collect() } else { Vec::new() }
    }

    /// The finger's height, mm: what has no size of its own is drawn in proportion to it.
    pub(super) fn height(&self) -> f64 {
        self.design.front.length()
    }

    /// The largest radius of an object that is shown whole, mm: the finger is what the picture is about.
    pub(super) fn whole(&self) -> f64 {
        0.6 * self.height()
    }

    /// Where the arrow of a translated base has its middle, world frame, mm.
    pub(super) fn below_base(&self) -> [f64; 2] {
        let [front, back] = [self.design.front.base, self.design.back.base];
        self.world([0.5 * (front[0] + back[0]), front[1].min(back[1]) - 3.5 * BASE * self.height()])
    }

    /// Where the net force's arrow begins: on its line of action, beside the middle of the contact. World frame, mm.
    pub(super) fn line_of_action(&self, force: [f64; 2]) -> [f64; 2] {
        let magnitude = force[0].hypot(force[1]);
        if let (ObjectDesign::Circle { centre, radius }, true) = (self.object, self.friction == 0.0) {
            // Without friction every part points at the circle's centre, and so does their sum.
            let reach = radius / magnitude;
            return [centre[0] - reach * force[0], centre[1] - reach * force[1]];
        }
        let (mut middle, mut total, mut moment) = ([0.0; 2], 0.0, 0.0);
        for contact in &self.shape.contacts {
            let (p, f) = (self.world(contact.position), self.push(contact, contact.tangential.unwrap_or(0.0)));
            middle = [middle[0] + contact.force * p[0], middle[1] + contact.force * p[1]];
            total += contact.force;
            moment += p[0] * f[1] - p[1] * f[0];
        }
        if total <= 0.0 {
            return self.world(self.design.front.point(0.5 * self.design.front.length()));
        }
        let middle = [middle[0] / total, middle[1] / total];
        // Aside by what the moment about the middle asks for.
        let aside = (moment - (middle[0] * force[1] - middle[1] * force[0])) / (magnitude * magnitude);
        [middle[0] + aside * force[1], middle[1] - aside * force[0]]
    }

    pub(super) fn world_direction(&self, v: [f64; 2]) -> [f64; 2] {
        let (origin, tip) = (self.world([0.0, 0.0]), self.world(v));
        [tip[0] - origin[0], tip[1] - origin[1]]
    }
}

/// The net force and its arrow.
#[derive(Clone, Copy, Debug)]
pub(super) struct NetForce {
    /// N.
    pub(super) magnitude: f64,
    /// Where the arrow begins, world frame, mm.
    pub(super) from: [f64; 2],
    /// Length of forces' arrows, px per N.
    pub(super) scale: f64,
    /// Where the arrow leads, px to the right and down.
    pub(super) arrow: [f64; 2],
}

/// From mm in the world to the picture.
pub(super) struct View {
    /// Pixels per mm.
    pub(super) scale: f64,
    /// Where the world's origin lies.
    pub(super) origin: [f64; 2],
    pub(super) area: Rect,
}

impl View {
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + self.scale * x, self.origin[1] - self.scale * y]
    }

    pub(super) fn world(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [(x - self.origin[0]) / self.scale, (self.origin[1] - y) / self.scale]
    }
}

/// Point and unit tangent of a polyline at an arc length.
pub(super) fn along_line(line: &[[f64; 2]], arc: f64) -> Option<([f64; 2], [f64; 2])> {
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
