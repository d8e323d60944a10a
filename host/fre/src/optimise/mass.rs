//! The mass of a finger.

use model_core::design::{Beam, Design};

/// Pieces into which a beam is cut: its width may be a taper against height, its thickness one against arc.
const PIECES: usize = 64;

/// Mass, g, for a density in kg/m³: both beams along their centrelines and the lamellae between them. Necks count as their lamella; the
/// roots and the solid tip, where parts overlap or are filled, are left aside.
pub fn mass(design: &Design, density: f64) -> f64 {
    let bars = (0..design.lamella_count()).map(|lamella| {
        let [arc, _] = design.attachment_arcs(lamella);
        let [_, height] = design.front.point(arc);
        let [front, back] = design.lamella_thickness(lamella);
        design.lamella_width(lamella) * 0.5 * (front + back) * design.width.at(height)
    });
    let volume = beam(design, &design.front) + beam(design, &design.back) + bars.sum::<f64>();
    // mm³ times kg/m³ is 1e-6 g.
    1e-6 * volume * density
}

/// Volume of a beam, mm³.
fn beam(design: &Design, beam: &Beam) -> f64 {
    let piece = beam.length() / PIECES as f64;
    let section = |arc: f64| beam.thickness.at(arc) * design.width.at(beam.point(arc)[1]);
    // Midpoints.
    (0..PIECES).map(|i| piece * section((i as f64 + 0.5) * piece)).sum()
}
