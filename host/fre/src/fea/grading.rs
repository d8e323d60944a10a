//! Where elements end along a line: sizes graded towards corners, and layers through a thickness.

/// The core's share of a thickness in layers. The core yields most to shear, and thin skins leave it nearly as stiff as it was.
pub(super) const CORE: f64 = 0.75;
/// Growth of element sizes away from a corner, mm per mm.
const GROWTH: f64 = 0.4;

/// Arcs of a beam at half steps, from where it is held to where the beams merge, past joints (lower and upper edge, and between which arcs
/// they and their fillets lie).
pub(super) fn stations(clamp: f64, joints: &[[[f64; 2]; 2]], merge: f64, sizes: &Sizes, neck: &[f64]) -> Vec<f64> {
    let mut arcs = vec![clamp];
    let mut from = clamp;
    let mut extend = |from: f64, to: f64, fractions: &mut dyn Iterator<Item = f64>| {
        arcs.extend(fractions.skip(1).map(|t| lerp([from, to], t)));
    };
    for &[[low, high], [start, end]] in joints {
        extend(from, start, &mut sizes.fractions(start - from, [true, true]).into_iter());
        if start < low {
            extend(start, low, &mut sizes.fractions(low - start, [true, true]).into_iter());
        }
        extend(low, high, &mut neck.iter().copied());
        if high < end {
            extend(high, end, &mut sizes.fractions(end - high, [true, true]).into_iter());
        }
        from = end;
    }
    extend(from, merge, &mut sizes.fractions(merge - from, [true, true]).into_iter());
    arcs
}

/// Element sizes along a line.
pub(super) struct Sizes {
    /// At a corner, mm.
    pub fine: f64,
    /// Far from corners, mm.
    pub largest: f64,
    pub refinement: usize,
}

impl Sizes {
    /// Fractions of a length at half steps, graded towards the ends that are marked.
    pub fn fractions(&self, length: f64, graded: [bool; 2]) -> Vec<f64> {
        const SAMPLES: usize = 400;
        let density = |t: f64| {
            let from_start = if graded[0] { t * length } else { f64::INFINITY };
            let from_end = if graded[1] { (1.0 - t) * length } else { f64::INFINITY };
            length / (self.fine + GROWTH * from_start.min(from_end)).min(self.largest)
        };
        let mut sums = vec![0.0];
        for i in 0..SAMPLES {
            let t = (i as f64 + 0.5) / SAMPLES as f64;
            sums.push(sums[i] + density(t) / SAMPLES as f64);
        }
        let total = sums[SAMPLES];
        let half_steps = 2 * (total.ceil().max(1.0) as usize) * self.refinement;
        let mut fractions = Vec::with_capacity(half_steps + 1);
        let mut i = 0;
        for k in 0..=half_steps {
            let wanted = total * k as f64 / half_steps as f64;
            while i + 1 < SAMPLES && sums[i + 1] < wanted {
                i += 1;
            }
            let part = (wanted - sums[i]) / (sums[i + 1] - sums[i]);
            fractions.push(((i as f64 + part) / SAMPLES as f64).clamp(0.0, 1.0));
        }
        // Exactly the ends, so that neighbouring patches meet.
        fractions[0] = 0.0;
        fractions[half_steps] = 1.0;
        // Middles of sides in the middle.
        for k in (1..half_steps).step_by(2) {
            fractions[k] = 0.5 * (fractions[k - 1] + fractions[k + 1]);
        }
        fractions
    }
}

/// Fractions of a thickness at half steps: even, or a core of even elements between two skins of one each.
pub(super) fn through_thickness(elements: usize, layered: bool, refinement: usize) -> Vec<f64> {
    let skin = 0.5 * (1.0 - CORE);
    let knot = |i: usize| match i {
        0 => 0.0,
        _ if i == elements => 1.0,
        _ if layered => skin + CORE * (i - 1) as f64 / (elements - 2) as f64,
        _ => i as f64 / elements as f64,
    };
    let within = |i: usize| even(2 * refinement).skip(1).map(move |t| lerp([knot(i), knot(i + 1)], t));
    std::iter::once(0.0).chain((0..elements).flat_map(within)).collect()
}

/// Even fractions 0, 1/n, …, 1.
fn even(steps: usize) -> impl Iterator<Item = f64> {
    (0..=steps).map(move |i| i as f64 / steps as f64)
}

pub(super) fn lerp([a, b]: [f64; 2], t: f64) -> f64 {
    a + t * (b - a)
}
