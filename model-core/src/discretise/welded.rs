//! A rod between two welds: what they add to its compliances and take from them.

use crate::design::weld::Arm;

/// Largest part of what gives way to a shear force that the turn of the ribs takes from it. Between ribs on a thick wall the law asks for
/// more than all: a span shorter than its thickness is hardly a rod. Chosen among a few parts in a linear frame of the preset `umi`.
const MOST_TAKEN: f64 = 0.5;
/// Largest part by which a rod's bending compliance rises or falls towards an end.
const MOST_TILT: f64 = 0.9;

/// A rod with its welds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Welded {
    /// 1/EA and 1/κGA over the length that bends, 1/N.
    pub compliance: [f64; 2],
    tilt: f64,
}

impl Welded {
    /// From the section's compliances, 1/N, the welds at start and end, the length that bends, mm, and its bending stiffness, N·mm².
    #[inline(never)]
    pub fn new([stretch, shear]: [f64; 2], welds: [Arm; 2], length: f64, bending: f64) -> Self {
        let [start, end] = welds;
        let longer = |kind: usize| (1.0 + (start.extra_length[kind] + end.extra_length[kind]) / length).max(0.0);
        let sheared = shear * longer(1);
        // What gives way by bending to a shear force whose moment vanishes in the middle.
        let bent = length * length / (12.0 * bending);
        let turns = shear * (start.turn + end.turn);
        let most = MOST_TAKEN * (sheared + bent);
        let part = if turns > most { most / turns } else { 1.0 };
        let tilt = 0.5 * part * shear * (start.turn - end.turn) / bent;
        Self { compliance: [stretch * longer(0), sheared - part * turns], tilt: tilt.clamp(-MOST_TILT, MOST_TILT) }
    }

    /// Factor on the bending stiffness at a position along the rod, 0 … 1: where the two welds turn the rib unlike, the moment in the
    /// rod's middle does so as well.
    pub fn bending(&self, at: f64) -> f64 {
        1.0 / (1.0 + self.tilt * (2.0 * at - 1.0))
    }
}
