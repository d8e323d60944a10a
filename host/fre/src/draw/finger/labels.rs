//! Where the words of a finger's picture are.

use model_core::object::{Motion, ObjectDesign};

use super::picture::{FingerPicture, NetForce, View};
use crate::case::ObjectWords;
use crate::draw::font::Fonts;
use crate::draw::heading::TEXT;
use crate::draw::number::{short, significant};
use crate::draw::object;
use crate::draw::palette::Ink;
use crate::draw::path::Rect;
use crate::draw::scene::{Anchor, Text};
use crate::shape::Shape;

/// Half the size of the cross at the object's centre, px.
pub(super) const CROSS: f64 = 5.0;
/// Length of the arrow that shows where a base is translated to, px.
pub(super) const MOTION_ARROW: f64 = 46.0;

/// Words whose places depend on what else is drawn.
pub(super) struct Labels {
    pub(super) object: Option<Text>,
    pub(super) force: Option<Text>,
}

impl FingerPicture<'_> {
    /// The motor's angle beside it, or the distance beside its arrow's middle, px.
    pub(super) fn motion_text(&self, [x, y]: [f64; 2]) -> Text {
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

    /// Where the net force's words may be, the best place first; the arrow's head is at a point, px.
    pub(super) fn force_places(&self, fonts: &Fonts, net: NetForce, head: [f64; 2]) -> Vec<Text> {
        let text = net_text(net.magnitude);
        let width = fonts.width(&text);
        let [x, y] = head;
        let (right, left) = (x + 8.0, x - 8.0 - width);
        let sides = if net.arrow[0] >= 0.0 { [right, left] } else { [left, right] };
        let beyond = if net.arrow[1] < 0.0 { -0.5 * text.size } else { 1.3 * text.size };
        let size = text.size;
        let aside = [0.35, -0.45, 1.15].into_iter().flat_map(|down| sides.map(|x| [x, y + down * size]));
        aside.chain([[x - 0.5 * width, y + beyond]]).map(|at| Text { at, ..text.clone() }).collect()
    }

    /// Where the words of the object and of the net force are: off each other, and off all lines where there is room.
    pub(super) fn labels(&self, view: &View, fonts: &Fonts, ghost: &Shape, net: Option<NetForce>) -> Labels {
        let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
        if let Some((centre, _)) = self.object.bounds() {
            let [x, y] = view.at(centre);
            lines.extend([vec![[x - CROSS, y], [x + CROSS, y]], vec![[x, y - CROSS], [x, y + CROSS]]]);
        }
        for beam in [&self.shape.front, &self.shape.back, &ghost.front, &ghost.back] {
            lines.push(beam.iter().map(|&p| view.at(self.world(p))).collect());
        }
        for (from, [right, down]) in net.map(|net| self.arrows(net)).unwrap_or_default() {
            let from = view.at(from);
            lines.push(vec![from, [from[0] + right, from[1] + down]]);
        }
        let crossed = |rect: Rect, lines: &[Vec<[f64; 2]>]| {
            lines.iter().flat_map(|line| line.windows(2)).filter(|ends| rect.meets([ends[0], ends[1]])).count()
        };
        let least = |places: Vec<Text>, lines: &[Vec<[f64; 2]>]| {
            let cost = |text: &Text| {
                let rect = box_of(fonts, text);
                crossed(rect, lines) + if rect.within(view.area) { 0 } else { 1000 }
            };
            // Of equals the first: the best one.
            places.into_iter().min_by_key(cost)
        };
        let force = net.and_then(|net| {
            let head = view.at(net.from);
            least(self.force_places(fonts, net, [head[0] + net.arrow[0], head[1] + net.arrow[1]]), &lines)
        });
        if let Some(text) = &force {
            lines.push(box_of(fonts, text).corners());
        }
        let object = self.object_places(view, fonts);
        Labels { object: least(object, &lines), force }
    }

    /// Where the object's name may be, the best place first: in a circle with room for it, else below the contour and away
    /// from the finger; for an object that is cut off, where the picture reaches deepest into it.
    fn object_places(&self, view: &View, fonts: &Fonts) -> Vec<Text> {
        let text =
            Text::new([0.0; 2], TEXT, ObjectWords::of(&self.object).name()).ink(Ink::Muted).anchor(Anchor::Middle);
        let half = 0.5 * fonts.width(&text);
        let area = view.area;
        let [left, right] = [area.left + half, area.right - half];
        let mut places = Vec::new();
        if let ObjectDesign::Circle { centre, radius } = self.object {
            let [x, y] = view.at(centre);
            let down = (0.62 * view.scale * radius).min(90.0);
            if half < 0.7 * view.scale * radius && (left..right).contains(&x) {
                let inside = |y: &f64| (area.top + TEXT..area.bottom).contains(y);
                places.extend([y + down, y - down + 0.7 * TEXT].into_iter().filter(inside).map(|y| [x, y]));
            }
        }
        if let Some((middle, radius)) = self.object.bounds().filter(|(_, radius)| *radius <= self.whole()) {
            let [x, y] = view.at(self.object.lowest());
            let within =
                |[x, y]: [f64; 2]| [x.min(right).max(left), y.min(area.bottom - 0.5 * TEXT).max(area.top + 1.5 * TEXT)];
            let ([mx, my], reach) = (view.at(middle), view.scale * radius + 10.0);
            places.extend([
                within([x + 70.0, y + 1.5 * TEXT]),
                within([mx + reach + half, my + 0.35 * TEXT]),
                within([mx + 70.0, my - reach]),
                within([mx - reach - half, my + 0.35 * TEXT]),
            ]);
        }
        if places.is_empty() {
            let aside = [area.left + 60.0, 0.5 * (area.left + area.right), area.right - 60.0];
            let mut rows = aside
                .into_iter()
                .flat_map(|x| [[x, area.bottom - TEXT], [x, area.top + 1.5 * TEXT]])
                .collect::<Vec<_>>();
            // How far out of the object the box of the words reaches.
            let out = |&at: &[f64; 2]| {
                let corners = box_of(fonts, &Text { at, ..text.clone() }).corners();
                corners
                    .into_iter()
                    .map(|p| object::distance(&self.object, view.world(p)))
                    .fold(f64::NEG_INFINITY, f64::max)
            };
            rows.sort_by(|a, b| out(a).total_cmp(&out(b)));
            // Places outside are none, unless there is no other.
            let inside = rows.iter().filter(|at| out(at) < 0.0).count().max(1);
            places.extend(rows.into_iter().take(inside));
        }
        places.into_iter().map(|at| Text { at, ..text.clone() }).collect()
    }
}

/// The net force in words, yet without a place.
pub(super) fn net_text(magnitude: f64) -> Text {
    Text::new([0.0; 2], 15.0, format!("*F* = {} N", significant(magnitude, 2))).ink(Ink::Force).halo()
}

/// What a text covers, px.
pub(super) fn box_of(fonts: &Fonts, text: &Text) -> Rect {
    let (width, [x, y]) = (fonts.width(text), text.at);
    let left = match text.anchor {
        Anchor::Start => x,
        Anchor::Middle => x - 0.5 * width,
        Anchor::End => x - width,
    };
    Rect { left, top: y - 0.8 * text.size, right: left + width, bottom: y + 0.25 * text.size }
}
