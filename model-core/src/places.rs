//! Places on the front beam at which a gap can be checked: the samples, and for sharp objects others between them.
//!
//! A pin lies between two samples, or slips through. An object of small radius is therefore looked for at more places: every way from
//! one sample to the next is divided evenly, and of those places so many count that the normals of neighbours differ by no more than
//! [`FINEST`]: on a flat side none but the samples, at a sharp corner beside it all of them ([`Model::stride`]). The places are fixed
//! on the beam whatever its state, as a closest point that moves finds no rest where the beam conforms, and their rows are those of
//! samples.
//!
//! A blunt object touches over a long way, with more samples than a small model has room for. Then fewer of them count ([`Model::spare`]).

use crate::access::Access;
use crate::contact::Sample;
use crate::model::Model;
use crate::object::Gap;
use crate::real::Real;
use crate::size::Size;

/// Angle between the normals at neighbouring places, rad: a beam bent around the object by 1.3 rad finds room in the smallest model.
const FINEST: f64 = 0.06;
/// Radius of the line that a centreline touches, in half thicknesses, above which the beam conforms (its fibres are then strained by less
/// than 6 %) and samples do.
const BLUNT: f64 = 17.0;

/// Of the samples every how many one counts at most.
const FEWEST: u16 = 4;

impl<T: Real, S: Size> Model<T, S> {
    /// The place of an index: `fineness` times its sample's, the sample itself being the last of them.
    #[inline]
    pub(crate) fn place(&self, index: u16) -> Sample<T> {
        if self.fineness <= 1 {
            self.samples.as_ref().at(usize::from(index))
        } else {
            self.fine_place(usize::from(index))
        }
    }

    fn fine_place(&self, index: usize) -> Sample<T> {
        let fineness = self.fineness.max(1);
        let (at, step) = (index / fineness, index % fineness + 1);
        let samples = self.samples.as_ref();
        let sample = samples.at(at);
        if step == fineness {
            return sample;
        }
        let part = T::of(step as f64 / fineness as f64);
        let below = at.checked_sub(1).map(|below| samples.at(below));
        let between = |from: T, to: T| from + part * (to - from);
        let place = Sample {
            arc: between(below.map_or(self.clamps[0], |below| below.arc), sample.arc),
            half_thickness: between(
                below.map_or(sample.half_thickness, |below| below.half_thickness),
                sample.half_thickness,
            ),
            ..sample
        };
        if sample.rigid != T::ZERO {
            let rigid = below.map_or(T::ZERO, |below| below.rigid);
            return Sample { rigid: between(rigid, sample.rigid), ..place };
        }
        let Some(front) = self.member(usize::from(sample.cell)) else { return place };
        let xi = self.within_element(at, usize::from(sample.cell), part);
        let (node, weights) = front.kind.between(self.weight.as_ref(), front.first, &sample, xi);
        Sample { node, weights, ..place }
    }

    /// Position ξ within its element or link of a place on the way to a sample of a span, `part` of that way on: 0 … 1.
    pub(crate) fn within_element(&self, sample: usize, cell: usize, part: T) -> T {
        let per_element = self.per_element.max(1);
        let first = usize::from(self.first_samples.as_ref().at(cell));
        (T::of((sample.saturating_sub(first) % per_element) as f64) + part) / T::of(per_element as f64)
    }

    /// Contact softness ε_c in use: between the samples of a sharp object's contact no less than the beam's own, and with friction that where
    /// there would be none. Without any, the force would hop from place to place.
    #[inline]
    pub(crate) fn contact_softness(&self) -> T {
        let [asked, own] = self.softness;
        if self.fineness > 1 || self.rubs && asked == T::ZERO { asked.max(own) } else { asked }
    }

    /// The softness in use is the beam's own, which goes with Young's modulus.
    pub(crate) fn softness_follows(&self) -> bool {
        let [asked, own] = self.softness;
        self.softness_is_own || own > asked && self.contact_softness() == own
    }

    /// Number of places.
    pub(crate) fn place_count(&self) -> usize {
        self.sample_count * self.fineness.max(1)
    }

    /// Index of a sample among the places.
    #[inline]
    pub(crate) fn index_of(&self, sample: usize) -> usize {
        sample * self.fineness + self.fineness - 1
    }

    /// Divides the ways between the samples if an object of a smallest radius of curvature asks for it: as finely as one
    /// without any radius would, so that a place has the same index on all of them.
    pub(crate) fn refine(&mut self, radius: T) {
        self.every = 1;
        let samples = self.samples.as_ref().run(0..self.sample_count);
        let mut below = self.clamps[0];
        let (mut longest, mut thinnest) = (T::ZERO, T::of(1e9));
        for sample in samples {
            longest = longest.max(sample.arc - below);
            thinnest = thinnest.min(sample.half_thickness);
            below = sample.arc;
        }
        self.sharpest = radius + thinnest;
        self.bluntest = T::of(BLUNT) * thinnest;
        if self.sharpest > self.bluntest || longest <= T::of(FINEST) * self.sharpest {
            self.fineness = 1;
            return;
        }
        let most = usize::from(u16::MAX) / self.sample_count.max(1);
        self.fineness = (libm::ceil(longest.to_f64() / (FINEST * thinnest.to_f64())) as usize).clamp(1, most.max(1));
    }

    /// Of the samples that count on a blunt side every second one counts from here on; false if there are as few as may be.
    pub(crate) fn spare(&mut self) -> bool {
        let every = 2 * self.every.max(1);
        let fits = every <= FEWEST;
        if fits {
            self.every = every;
        }
        fits
    }

    /// Every how many places on the way to a sample count where the object's surface has a curvature, given by the gap at one of them.
    pub(crate) fn stride(&self, sample: usize, gap: &Gap<T>) -> usize {
        if gap.curvature <= T::ZERO {
            return self.fineness;
        }
        // Radius of the level line that the centreline touches.
        self.stride_on(sample, T::one() / gap.curvature - gap.distance)
    }

    /// Some places on the way to a sample may count.
    pub(crate) fn is_fine(&self, sample: usize) -> bool {
        self.fineness > 1 && self.stride_on(sample, self.sharpest) < self.fineness
    }

    fn stride_on(&self, sample: usize, radius: T) -> usize {
        if radius > self.bluntest {
            return self.fineness;
        }
        let part = T::of(FINEST) * radius / self.way_to(sample);
        ((part.to_f64() * self.fineness as f64) as usize).max(1).min(self.fineness)
    }

    /// Arc length from the sample before to a sample.
    pub(crate) fn way_to(&self, sample: usize) -> T {
        let samples = self.samples.as_ref();
        let below = sample.checked_sub(1).map_or(self.clamps[0], |below| samples.at(below).arc);
        samples.at(sample).arc - below
    }
}
