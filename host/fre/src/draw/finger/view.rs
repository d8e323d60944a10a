//! The parts of a finger's picture, and the scale and place at which they fit.

use model_core::object::{Motion, ObjectDesign};

use super::labels::{MOTION_ARROW, box_of};
use super::picture::{ARM, BASE, FingerPicture, NetForce, View};
use crate::draw::font::Fonts;
use crate::draw::heading::{MARGIN, TEXT};
use crate::draw::object;
use crate::draw::path::Rect;
use crate::shape::Shape;

pub(super) const WIDTH: f64 = 680.0;
pub(super) const HIGHEST: f64 = 640.0;
/// Height of the row with the scales, px.
pub(super) const FOOT: f64 = 44.0;
/// Room around the finger's lines, in parts of its height.
pub(super) const ROOM: f64 = 4.0 / 80.0;

/// A point of the world, mm, and the room that is needed around it, px from it to the right and down.
pub(super) type Part = ([f64; 2], Rect);

impl FingerPicture<'_> {
    /// All that is drawn: points of the world with the room that they take up around them, some of it in mm and some, as of words,
    /// in px.
    pub(super) fn parts(&self, ghost: &Shape, fonts: &Fonts, net: Option<NetForce>) -> Vec<Part> {
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
        match self.object.bounds() {
            Some((middle, radius)) if radius <= self.whole() => {
                include(middle, radius + 0.75 * room, bare);
                // Its name may stand below it.
                let [x, y] = self.object.lowest();
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
        parts
    }
}

impl View {
    /// The scale and place at which all parts fit below the headings, which end at `top` (px), for a finger of a height (mm).
    pub(super) fn of(parts: &[Part], height: f64, top: f64) -> Self {
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
        Self { scale, origin: [left - all.left, top - all.top], area }
    }
}
