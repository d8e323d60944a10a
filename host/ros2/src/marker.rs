//! The deformed finger as `visualization_msgs/MarkerArray`, in the frame of its forces.

use fre_gripper::source::Base;
use messages::Shape;

use crate::message::{self, Action, ColorRgba, Duration, Header, Marker, MarkerArray, Point, Vector3};

/// Length of a force's line, m per N.
const PER_NEWTON: f64 = 0.002;
/// A finger that is not shown anew disappears after this: a picture must not outlive its source.
const LIFETIME: Duration = Duration { sec: 0, nanosec: 500_000_000 };
const STEEL: ColorRgba = ColorRgba { r: 0.35, g: 0.55, b: 0.8, a: 1.0 };
const GREY: ColorRgba = ColorRgba { r: 0.55, g: 0.55, b: 0.55, a: 1.0 };
const RED: ColorRgba = ColorRgba { r: 0.85, g: 0.2, b: 0.15, a: 1.0 };

/// Front beam, back beam, lamellae and forces: markers 0 to 3 of the group `finger_N`. An untrustworthy shape is grey and has no forces.
pub fn markers(shape: &Shape, axis: [f64; 2], header: &Header) -> MarkerArray {
    let base = Base::of(shape, axis);
    let trusted = shape.status.is_trustworthy();
    let at = |point: &[f32; 2]| metres(base.point(*point));
    let pairs = |front: &[[f32; 2]], back: &[[f32; 2]]| -> Vec<Point> {
        front.iter().zip(back).flat_map(|(front, back)| [at(front), at(back)]).collect()
    };
    let forces = shape.contacts.iter().flat_map(|contact| {
        let foot = base.point(contact.position);
        let [fx, fy] = base.vector(contact.force).map(|force| 1e3 * PER_NEWTON * force);
        [metres(foot), metres([foot[0] + fx, foot[1] + fy])]
    });
    let colour = |own| if trusted { own } else { GREY };
    let strip = message::Shape::LineStrip;
    let list = message::Shape::LineList;
    let lines = [
        (strip, shape.front.iter().map(at).collect(), 0.002, colour(STEEL)),
        (strip, shape.back.iter().map(at).collect(), 0.002, colour(STEEL)),
        (list, pairs(&shape.lamella_front, &shape.lamella_back), 0.0015, GREY),
        (list, if trusted { forces.collect() } else { Vec::new() }, 0.001, RED),
    ];
    let marker = |(id, (kind, points, thickness, color)): (i32, (message::Shape, Vec<Point>, f64, ColorRgba))| Marker {
        header: header.clone(),
        ns: format!("finger_{}", shape.finger),
        id,
        r#type: kind as i32,
        // A line without points is an error on every screen.
        action: if points.len() < 2 { Action::Delete } else { Action::Add } as i32,
        scale: Vector3 { x: thickness, ..Vector3::default() },
        color,
        lifetime: LIFETIME,
        frame_locked: true,
        points,
        ..Marker::default()
    };
    MarkerArray { markers: (0..).zip(lines).map(marker).collect() }
}

fn metres([x, y]: [f64; 2]) -> Point {
    Point { x: 1e-3 * x, y: 1e-3 * y, z: 0.0 }
}
