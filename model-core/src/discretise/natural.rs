//! The units that a finger is computed in, and the finger in them.

use crate::design::{Attachments, Beam, Design, LamellaKind, Profile, RibEnds};
use crate::units::Units;

/// Length, mm, and stiffness EI/L, N·mm, above which a finger's units are 2 mm and 2 N·mm; both are a little less than those of a
/// finger of 80 mm in a soft plastic, for which the units are 1.
const LENGTH: f64 = 64.0;
const STIFFNESS: f64 = 8.0;
/// Places along a beam at which its stiffness is looked at.
const PLACES: u32 = 32;

/// Largest power of two that is not above a positive, normal number: its exponent alone.
fn power_of_two(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & f64::INFINITY.to_bits())
}

/// Stiffness of a whole beam against bending, 1/∫ds/EI, N·mm: that of its thin parts counts most.
fn stiffness(design: &Design, beam: &Beam) -> f64 {
    let step = beam.length() / f64::from(PLACES);
    let mut compliance = 0.0;
    for place in 0..PLACES {
        let arc = (f64::from(place) + 0.5) * step;
        let (width, thickness) = (design.width.at(beam.point(arc)[1]), beam.thickness.at(arc));
        compliance += step / (width * thickness * thickness * thickness / 12.0);
    }
    design.material.youngs_modulus * beam.factors()[0] / compliance
}

/// The units of a valid finger: the unit length from its longer beam, the unit force from its stiffer one.
///
/// What a hinge or a thick part of a taper is stiffer than the beams does not go into the units but into the allowance for rounding of
/// the members concerned (`Model::complete_stiffness`): it raises the rounding of their own moments and nothing else.
pub(super) fn units(design: &Design) -> Units<f64> {
    let beams = [&design.front, &design.back];
    let length = beams.iter().fold(0.0_f64, |most, beam| most.max(beam.length()));
    let stiffness = beams.iter().fold(0.0_f64, |most, beam| most.max(stiffness(design, beam)));
    let length = power_of_two(length / LENGTH);
    Units { length, force: power_of_two(stiffness / STIFFNESS) / length }
}

// Double precision is software on the microcontroller: one copy for all the numbers of a finger.
#[inline(never)]
fn scale(value: &mut f64, by: f64) {
    *value *= by;
}

/// Expresses a finger in its units; every number keeps all its digits.
pub(super) fn express(design: &mut Design, units: &Units<f64>) {
    let inverse = 1.0 / units.length;
    let scale = |value: &mut f64| scale(value, inverse);
    let profile = |profile: &mut Profile| profile.knots.iter_mut().flatten().for_each(scale);
    profile(&mut design.width);
    for beam in [&mut design.front, &mut design.back] {
        beam.base.iter_mut().chain(&mut beam.tip).chain(beam.via.iter_mut().flatten()).for_each(scale);
        scale(&mut beam.sagitta);
        scale(&mut beam.clamp);
        profile(&mut beam.thickness);
    }
    match &mut design.lamellae.attachments {
        Attachments::Heights(heights) => heights.iter_mut().for_each(scale),
        Attachments::Arcs { front, back } => front.iter_mut().chain(back).for_each(scale),
    }
    design.lamellae.thickness.iter_mut().flatten().for_each(scale);
    if let LamellaKind::Rib(ribs) = &mut design.lamellae.kind {
        scale(&mut ribs.fillet);
        if let RibEnds::Gap(gap) = &mut ribs.ends {
            scale(gap);
        }
    }
    design.hinge.length.iter_mut().for_each(scale);
    scale(&mut design.hinge.thickness);
    design.rigid_above.iter_mut().for_each(scale);
    design.motor_axis.iter_mut().for_each(scale);
    design.material.youngs_modulus *= units.length * units.length / units.force;
}

#[cfg(test)]
mod tests {
    use super::power_of_two;

    #[test]
    fn a_power_of_two_is_the_largest_not_above() {
        for (value, power) in
            [(1.0, 1.0), (1.999, 1.0), (2.0, 2.0), (0.7, 0.5), (3e-5, 2.0_f64.powi(-16)), (5e6, 4_194_304.0)]
        {
            assert_eq!(power_of_two(value), power, "{value}");
        }
    }
}
