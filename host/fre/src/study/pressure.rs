//! Contact pressure: each touching sample's force spread over the length of the front beam that it stands for.

use model_core::design::Design;
use serde::{Deserialize, Serialize};

use crate::shape::Contact;

/// The pressure at a touching sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressure {
    /// Arc length along the front beam, mm.
    pub arc_mm: f64,
    /// Where the length that the sample stands for begins and ends: halfway to its neighbours, mm.
    pub between_mm: [f64; 2],
    /// Force per length of the beam, N/mm.
    pub line_load_n_per_mm: f64,
    /// The same over the finger's width there, N/mm².
    pub pressure_n_per_mm2: f64,
}

/// Pressures of the touching samples; `arcs` are those of all samples, ascending, mm.
pub fn pressures(design: &Design, arcs: &[f64], contacts: &[Contact]) -> Vec<Pressure> {
    let of = |contact: &Contact| {
        let index = arcs.partition_point(|&arc| arc < contact.arc - 1e-6);
        // The base before the first sample is clamped and no sample; it gets half a distance as the tip does.
        let next = arcs.get(index + 1).map_or(contact.arc, |&next| 0.5 * (contact.arc + next));
        let before = match index.checked_sub(1).and_then(|before| arcs.get(before)) {
            Some(&before) => 0.5 * (before + contact.arc),
            None => (contact.arc - (next - contact.arc)).max(0.0),
        };
        let line_load = contact.force / (next - before).max(1e-9);
        let width = design.width.at(design.front.point(contact.arc)[1]);
        Pressure {
            arc_mm: contact.arc,
            between_mm: [before, next],
            line_load_n_per_mm: line_load,
            pressure_n_per_mm2: line_load / width,
        }
    };
    contacts.iter().map(of).collect()
}
