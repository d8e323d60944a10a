//! A material that remembers by its force alone: the places of an elastic finger, with faded forces.

use model_core::fading::Fading;
use model_core::status::Status;

use super::place::{Place, State};
use crate::case::{Case, Memory};

/// Fades the forces of one place after the other.
pub(super) struct Fade {
    fading: Fading<f64>,
    /// Forces along the object stay within the cones of those that fade: the normal ones.
    rubs: bool,
}

impl Fade {
    /// Of a case whose material remembers so.
    pub fn of(case: &Case) -> Option<Self> {
        let mut fading = Fading::ELASTIC;
        let fades = case.finger.memory == Memory::Force && fading.set(&case.finger.prony).is_ok() && fading.fades();
        fades.then_some(Self { fading, rubs: case.friction > 0.0 })
    }

    /// What the elastic finger goes through on the way, within a time, s: force, sum of the normal forces and torque; nothing where that is not known.
    pub fn pass(&mut self, found: Option<([f64; 2], f64, f64)>, seconds: f64) {
        self.fading.pass(seconds);
        if let Some((force, normal, torque)) = found {
            let load = self.load(force, normal, torque);
            self.fading.accept(load);
        }
    }

    fn load(&self, [x, y]: [f64; 2], normal: f64, torque: f64) -> [f64; 3] {
        if self.rubs { [normal, 0.0, 0.0] } else { [x, y, torque] }
    }

    /// The place that is reached next, within a time, s.
    pub fn take(&mut self, place: &mut Place, seconds: f64) {
        self.fading.pass(seconds);
        let Some(state) = &mut place.state else { return };
        let ([x, y], torque) = (state.force_n, state.motor_torque_nmm);
        let normal = state.friction.as_ref().map_or(0.0, |friction| friction.normal_n);
        let elastic = self.load([x, y], normal, torque);
        let [u, v, faded] = self.fading.accept(elastic);
        let size = elastic[0].hypot(elastic[1]);
        if size == 0.0 {
            return;
        }
        let part = u.hypot(v) / size;
        if part == 0.0 {
            place.status = Status::NoContact;
        }
        if state.friction.is_some() {
            state.force_n = [part * x, part * y];
            state.motor_torque_nmm = part * torque;
            state.force_finger_frame_n = state.force_finger_frame_n.map(|force| part * force);
        } else {
            (state.force_n, state.motor_torque_nmm) = ([u, v], faded);
            // Turned as the force is.
            let [cos, sin] = [x * u + y * v, x * v - y * u].map(|product| product / (size * size));
            let [x, y] = state.force_finger_frame_n;
            state.force_finger_frame_n = [cos * x - sin * y, sin * x + cos * y];
        }
        scale(state, part);
    }
}

/// What is of the same contact fades as the force does.
fn scale(state: &mut State, part: f64) {
    for contact in &mut state.shape.contacts {
        contact.force *= part;
        contact.tangential = contact.tangential.map(|force| part * force);
    }
    for pressure in &mut state.contact_pressure {
        pressure.line_load_n_per_mm *= part;
        pressure.pressure_n_per_mm2 *= part;
    }
    if let Some(friction) = &mut state.friction {
        friction.normal_n *= part;
        friction.tangential_n *= part;
    }
    if let Some(interval) = &mut state.force_interval {
        for range in [&mut interval.normal, &mut interval.magnitude, &mut interval.torque_nmm] {
            *range = range.map(|end| part * end);
        }
    }
}
