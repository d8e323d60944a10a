//! Material with memory by the force alone: the force of an elastic finger, faded.
//!
//! All stresses of a finger fade alike ([`crate::equilibrium::Follower::set_prony`]). As long as its shape only depends on where it is
//! pressed, so does its force, and one state per term and component is enough:
//!
//! > F = Fₑ − Σ gᵢ (Fₑ − hᵢ),  hᵢ ← aᵢ hᵢ + mᵢ (Fₑ − Fₑ₀),  aᵢ = e^(−Δt/τᵢ),  mᵢ = (1 − aᵢ) τᵢ/Δt,
//!
//! With friction it is the sum of the normal forces that is faded so, and all forces by the same part: forces along the object turn round with
//! the motion, and stay within their cones.
//!
//! Here Fₑ is the force of the elastic finger at the same place and Fₑ₀ that of the accepted state. An opening finger is still bent where the
//! elastic one has let go: there the form says too little of a small force, and near a snap it knows nothing. `tests` beside it have the limits.

#[cfg(test)]
mod tests;

use crate::bounds::OutOfBounds;
use crate::newton::memory::{MOST_TERMS, check_terms};
use crate::real::Real;

/// Force on the object, two components in N, and what contact demands of the motor, N·mm.
pub type Load<T> = [T; 3];

/// Up to which Δt/τ the decay is summed up as a series.
const SHORT: f64 = 1.0 / 16.0;

/// A term of the Prony series, and what it remembers.
#[derive(Clone, Copy, Debug)]
struct Term<T> {
    part: T,
    time: T,
    /// What is left of the load's past changes.
    left: Load<T>,
    /// What rounding has taken of that: a slow term changes by less than its last digit in a tick.
    rest: Load<T>,
    /// How wide the range is in which the remembered force may lie, N.
    doubt: T,
    /// Derivative of the two forces in `left` with `time`, N/s.
    drift: [T; 2],
}

/// Fades the load of an elastic finger. [`Self::ELASTIC`] is all zeros.
#[derive(Clone, Copy, Debug)]
pub struct Fading<T> {
    terms: [Term<T>; MOST_TERMS],
    count: u8,
    /// Load of the elastic finger at the accepted state.
    elastic: Load<T>,
    /// Time since then, s.
    wait: T,
}

impl<T: Real> Fading<T> {
    /// An elastic material: nothing fades.
    pub const ELASTIC: Self = {
        let none = [T::ZERO; 3];
        let term = Term { part: T::ZERO, time: T::ZERO, left: none, rest: none, doubt: T::ZERO, drift: [T::ZERO; 2] };
        Self { terms: [term; MOST_TERMS], count: 0, elastic: none, wait: T::ZERO }
    };

    /// Takes the terms [gᵢ, τᵢ in s], none for an elastic material; nothing has been strained yet.
    ///
    /// # Errors
    /// More than [`crate::equilibrium::PRONY_TERMS`], and values out of [`crate::equilibrium::PRONY_PARTS`] and
    /// [`crate::equilibrium::PRONY_TIMES`], which Σ gᵢ must not exceed either; the old ones then stay.
    pub fn set(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds> {
        check_terms(terms, MOST_TERMS)?;
        *self = Self::ELASTIC;
        self.count = terms.len() as u8;
        for (into, &[part, time]) in self.terms.iter_mut().zip(terms) {
            (into.part, into.time) = (T::of(part), T::of(time));
        }
        Ok(())
    }

    /// Whether anything fades.
    pub fn fades(&self) -> bool {
        self.count > 0
    }

    /// Whether these are its terms.
    pub fn has(&self, terms: &[[f64; 2]]) -> bool {
        let same = |(own, &[part, time]): (&Term<T>, &[f64; 2])| own.part == T::of(part) && own.time == T::of(time);
        terms.len() == usize::from(self.count) && self.terms.iter().zip(terms).all(same)
    }

    /// Nothing has been strained yet.
    pub fn begin(&mut self) {
        self.come(Self::ELASTIC.elastic, T::ZERO, T::ZERO);
    }

    /// The finger is found pressed, and nobody knows for how long: since just now, or since ever.
    pub fn find(&mut self, elastic: Load<T>) {
        self.come(elastic, T::of(0.5), size(elastic));
    }

    fn come(&mut self, elastic: Load<T>, part: T, doubt: T) {
        (self.elastic, self.wait) = (elastic, T::ZERO);
        for term in &mut self.terms {
            (term.left, term.rest, term.doubt) = (elastic.map(|x| part * x), [T::ZERO; 3], doubt);
            term.drift = [T::ZERO; 2];
        }
    }

    /// Time passes, s, until the load that is accepted next.
    pub fn pass(&mut self, seconds: f64) {
        if self.fades() {
            self.wait += T::of(seconds.max(0.0));
        }
    }

    /// Load of the elastic finger at the accepted state.
    pub fn accepted(&self) -> Load<T> {
        self.elastic
    }

    /// The faded load where the elastic finger's is this, the present time after the accepted state. Zero where it would pull: the finger is
    /// still bent and has let go.
    pub fn faded(&self, elastic: Load<T>) -> Load<T> {
        let change = minus(elastic, self.elastic);
        let mut load = elastic;
        for term in self.terms.iter().take(usize::from(self.count)) {
            let (left, step) = (term.left, term.step(change, decay(self.wait / term.time)));
            for i in 0..3 {
                load[i] -= term.part * (elastic[i] - (left[i] + step[i]));
            }
        }
        let pushes = load[0] * elastic[0] + load[1] * elastic[1] > T::ZERO;
        if self.fades() && !pushes { Self::ELASTIC.elastic } else { load }
    }

    /// Takes the load of the elastic finger as accepted; the faded one.
    pub fn accept(&mut self, elastic: Load<T>) -> Load<T> {
        let change = minus(elastic, self.elastic);
        let (count, wait) = (usize::from(self.count), self.wait);
        for term in self.terms.iter_mut().take(count) {
            let known = decay(wait / term.time);
            let step = term.step(change, known);
            term.doubt -= known[0] * term.doubt;
            term.drift = term.drifted(change, wait, known);
            for i in 0..3 {
                let add = step[i] + term.rest[i];
                let sum = term.left[i] + add;
                term.rest[i] = add - (sum - term.left[i]);
                term.left[i] = sum;
            }
        }
        (self.elastic, self.wait) = (elastic, T::ZERO);
        self.faded(elastic)
    }

    /// Derivatives of the faded force's magnitude where the elastic finger's load is this, the present time after the accepted state: of
    /// each term with its part gᵢ, N, and with its time τᵢ in the latter's own measure, τᵢ ∂F/∂τᵢ, N. Zero where it has let go, and for
    /// terms that are not there.
    pub fn slopes(&self, elastic: Load<T>) -> [[T; 2]; MOST_TERMS] {
        let mut slopes = [[T::ZERO; 2]; MOST_TERMS];
        let load = self.faded(elastic);
        let magnitude = size(load);
        if magnitude == T::ZERO {
            return slopes;
        }
        let along = [load[0] / magnitude, load[1] / magnitude];
        let change = minus(elastic, self.elastic);
        for (term, slope) in self.terms.iter().zip(&mut slopes).take(usize::from(self.count)) {
            let known = decay(self.wait / term.time);
            let (step, drift) = (term.step(change, known), term.drifted(change, self.wait, known));
            for i in 0..2 {
                slope[0] += along[i] * (term.left[i] + step[i] - elastic[i]);
                slope[1] += along[i] * term.part * term.time * drift[i];
            }
        }
        slopes
    }

    /// By how much the force may be larger or smaller, because its past is not known, N; zero where it is.
    pub fn doubt(&self) -> T {
        let mut sum = T::ZERO;
        for term in self.terms.iter().take(usize::from(self.count)) {
            sum += term.part * term.doubt;
        }
        T::of(0.5) * sum
    }
}

impl<T: Real> Term<T> {
    /// What is remembered changes by this as the elastic finger's load changes evenly within a time, whose [`decay`] is known.
    fn step(&self, change: Load<T>, [faded, gain]: [T; 2]) -> Load<T> {
        [0, 1, 2].map(|i| gain * change[i] - faded * self.left[i])
    }

    /// The derivative of what is remembered with the term's time, after such a change within a time. With x = Δt/τ it is that of
    /// a h + m ΔF: ∂a/∂τ = a x/τ and ∂m/∂τ = (m − a)/τ.
    fn drifted(&self, change: Load<T>, wait: T, [faded, gain]: [T; 2]) -> [T; 2] {
        let kept = T::one() - faded;
        let [aged, eased] = [kept * wait / self.time, gain - kept].map(|x| x / self.time);
        [0, 1].map(|i| kept * self.drift[i] + aged * self.left[i] + eased * change[i])
    }
}

/// 1 − a and m after the time `ratio` τ.
fn decay<T: Real>(ratio: T) -> [T; 2] {
    if ratio < T::of(SHORT) {
        let mut gain = T::one();
        for order in [6.0, 5.0, 4.0, 3.0, 2.0] {
            gain = T::one() - ratio * T::of(1.0 / order) * gain;
        }
        return [ratio * gain, gain];
    }
    let ratio = ratio.to_f64();
    let faded = -libm::expm1(-ratio);
    [T::of(faded), T::of(faded / ratio)]
}

fn minus<T: Real>(a: Load<T>, b: Load<T>) -> Load<T> {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// The force's magnitude.
fn size<T: Real>([x, y, _]: Load<T>) -> T {
    (x * x + y * y).sqrt()
}
