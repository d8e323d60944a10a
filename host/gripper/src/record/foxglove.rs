//! Foxglove's own message types, which its panels show without a plugin: `foxglove.Log` and `foxglove.SceneUpdate`
//! (<https://docs.foxglove.dev/docs/sdk/schemas>), in JSON.

use messages::{Derating, Event, Phase, Settings, Shape, Side};
use model_core::object::ObjectDesign;
use serde_json::{Value, json};

use crate::source::{Base, Setup};
use fre::draw::object_contour;

/// The frame of everything in the scene: the gripper's, in metres.
const FRAME: &str = "gripper";
/// Length of an arrow, metres per N.
const PER_NEWTON: f64 = 0.002;
/// Half of what is shown of a half-plane, mm.
const REACH: f64 = 150.0;

fn time(ns: u64) -> Value {
    json!({ "sec": ns / 1_000_000_000, "nsec": ns % 1_000_000_000 })
}

/// How grave, in `foxglove.Log`'s numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Level {
    Info = 2,
    Warning = 3,
    Error = 4,
}

/// How grave an event is.
pub(super) fn level(event: &Event) -> Level {
    match event {
        Event::ServoLost { .. } | Event::GoalRefused { .. } | Event::OtherMaster { .. } => Level::Error,
        Event::ServoAlert { hardware_error, .. } if *hardware_error != 0 => Level::Error,
        Event::Derated { derating: Derating::Stopped, .. } => Level::Error,
        Event::Derated { derating: Derating::Warned | Derating::Limited, .. } => Level::Warning,
        Event::Restored { damaged, .. } if *damaged > 0 => Level::Warning,
        Event::RateReached { hz, chosen_hz } if *hz < 0.95 * chosen_hz => Level::Warning,
        Event::PhaseChanged { phase: Phase::Waiting(_), .. } => Level::Warning,
        _ => Level::Info,
    }
}

/// A line of the log.
pub(super) fn log(ns: u64, level: Level, words: &str) -> Value {
    json!({ "timestamp": time(ns), "level": level as u8, "message": words, "name": "fre", "file": "", "line": 0 })
}

/// Micrometres are enough for the eye.
fn metres(mm: f64) -> f64 {
    (mm * 1e3).round() / 1e6
}

fn point([x, y]: [f64; 2]) -> Value {
    json!({ "x": metres(x), "y": metres(y), "z": 0 })
}

/// Points joined in their order, or in pairs.
fn line(kind: u8, points: Vec<Value>, thickness: f64, [r, g, b]: [f64; 3]) -> Value {
    let pose = json!({ "position": { "x": 0, "y": 0, "z": 0 }, "orientation": { "x": 0, "y": 0, "z": 0, "w": 1 } });
    json!({
        "type": kind, "pose": pose, "thickness": thickness, "scale_invariant": false, "points": points,
        "color": { "r": r, "g": g, "b": b, "a": 1 }, "colors": [], "indices": []
    })
}

const STRIP: u8 = 0;
const LOOP: u8 = 1;
const PAIRS: u8 = 2;
const STEEL: [f64; 3] = [0.35, 0.55, 0.8];
const GREY: [f64; 3] = [0.55, 0.55, 0.55];
const RED: [f64; 3] = [0.85, 0.2, 0.15];

fn update(ns: u64, id: &str, lines: &[Value]) -> Value {
    json!({ "deletions": [], "entities": [{
        "timestamp": time(ns), "frame_id": FRAME, "id": id, "lifetime": { "sec": 0, "nsec": 0 }, "frame_locked": true,
        "metadata": [], "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "lines": lines, "triangles": [],
        "texts": [], "models": []
    }] })
}

/// From a finger's world frame into the gripper's: a right finger is mirrored.
fn mirrored(settings: &Settings, finger: u8) -> f64 {
    match settings.finger(finger).map(|mount| mount.side) {
        Some(Side::Right) => -1.0,
        _ => 1.0,
    }
}

/// The deformed finger and the forces on the object; nothing without the finger's design.
pub(super) fn finger(ns: u64, shape: &Shape, setup: &Setup) -> Option<Value> {
    let design = &setup.models.get(usize::from(shape.finger))?.finger.as_ref()?.design;
    let base = Base::of(shape, design.motor_axis);
    let side = mirrored(&setup.settings, shape.finger);
    let world = |p: &[f32; 2]| {
        let [x, y] = base.point(*p);
        [side * x, y]
    };
    let beam = |points: &[[f32; 2]]| line(STRIP, points.iter().map(|p| point(world(p))).collect(), 0.002, STEEL);
    let ends = shape.lamella_front.iter().zip(&shape.lamella_back);
    let lamellae = ends.flat_map(|(front, back)| [point(world(front)), point(world(back))]).collect();
    let forces = shape.contacts.iter().flat_map(|contact| {
        let foot = world(&contact.position);
        let [fx, fy] = base.vector(contact.force);
        let scale = PER_NEWTON * 1e3;
        [point(foot), point([foot[0] + side * scale * fx, foot[1] + scale * fy])]
    });
    let mut lines = vec![beam(&shape.front), beam(&shape.back), line(PAIRS, lamellae, 0.0015, GREY)];
    if shape.status.is_trustworthy() && !shape.contacts.is_empty() {
        lines.push(line(PAIRS, forces.collect(), 0.001, RED));
    }
    Some(update(ns, &format!("finger {}", shape.finger), &lines))
}

/// A finger's object.
pub(super) fn object(ns: u64, finger: u8, object: &ObjectDesign, setup: &Setup) -> Value {
    let side = mirrored(&setup.settings, finger);
    let outline = object_contour(object, [0.0, 50.0], REACH);
    let points = outline.into_iter().map(|[x, y]| point([side * x, y])).collect();
    update(ns, &format!("object of finger {finger}"), &[line(LOOP, points, 0.001, GREY)])
}

/// JSON Schema of `foxglove.Log`.
pub(super) fn log_schema() -> Value {
    json!({ "title": "foxglove.Log", "type": "object", "properties": {
        "timestamp": time_schema(), "level": { "type": "integer" }, "message": { "type": "string" },
        "name": { "type": "string" }, "file": { "type": "string" }, "line": { "type": "integer" }
    } })
}

/// JSON Schema of `foxglove.SceneUpdate`, the primitives that are used.
pub(super) fn scene_schema() -> Value {
    let object = |properties: Value| json!({ "type": "object", "properties": properties });
    let list = |items: Value| json!({ "type": "array", "items": items });
    let number = || json!({ "type": "number" });
    let point = object(json!({ "x": number(), "y": number(), "z": number() }));
    let rotation = object(json!({ "x": number(), "y": number(), "z": number(), "w": number() }));
    let color = object(json!({ "r": number(), "g": number(), "b": number(), "a": number() }));
    let line = object(json!({
        "type": { "type": "integer" }, "pose": object(json!({ "position": point.clone(), "orientation": rotation })),
        "thickness": number(), "scale_invariant": { "type": "boolean" }, "points": list(point), "color": color.clone(),
        "colors": list(color), "indices": list(json!({ "type": "integer" }))
    }));
    let none = || list(object(json!({})));
    let pair = object(json!({ "key": { "type": "string" }, "value": { "type": "string" } }));
    let entity = object(json!({
        "timestamp": time_schema(), "frame_id": { "type": "string" }, "id": { "type": "string" },
        "lifetime": time_schema(), "frame_locked": { "type": "boolean" }, "metadata": list(pair), "arrows": none(),
        "cubes": none(), "spheres": none(), "cylinders": none(), "lines": list(line), "triangles": none(), "texts": none(),
        "models": none()
    }));
    let deletion = object(json!({
        "timestamp": time_schema(), "type": { "type": "integer" }, "id": { "type": "string" }
    }));
    json!({ "title": "foxglove.SceneUpdate", "type": "object", "properties": {
        "deletions": list(deletion), "entities": list(entity)
    } })
}

fn time_schema() -> Value {
    json!({ "type": "object", "title": "time", "properties": {
        "sec": { "type": "integer", "minimum": 0 }, "nsec": { "type": "integer", "minimum": 0, "maximum": 999_999_999 }
    } })
}
