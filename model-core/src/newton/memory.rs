//! Material with memory: generalised Maxwell on all strains alike (68)–(72).
//!
//! The stress is that of an elastic finger, S, faded: g∞ S + Σ gᵢ hᵢ with ḣᵢ = Ṡ − hᵢ/τᵢ. Over a step in which S changes evenly that is
//!
//! > k S + H, with k = g∞ + Σ gᵢ mᵢ, H = Σ gᵢ (aᵢ hᵢ − mᵢ S₀), aᵢ = e^(−Δt/τᵢ), mᵢ = (1 − aᵢ) τᵢ/Δt,
//!
//! so that a step is one of an elastic finger in a unit of force k times as large, under given initial stresses H/k. Nothing in the solver
//! but the elements' forces knows of it.

use crate::access::Access;
use crate::bounds::{OutOfBounds, check};
use crate::contact::{Row, own_rows};
use crate::element::{Link, MOST_LAYERS, Node, Past, Pull, Quadratic, Remembered, Strain};
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};
use crate::state::State;
use crate::topology::Kind;

/// The most terms that any size has.
pub const MOST_TERMS: usize = 4;
/// Least and greatest part gᵢ of the stress that a term takes, and time τᵢ in which it fades, s.
pub const PARTS: [f64; 2] = [0.0, 0.99];
/// See [`PARTS`].
pub const TIMES: [f64; 2] = [1e-4, 1e9];

/// Refuses more terms [gᵢ, τᵢ in s] than there is room for, and values out of their ranges.
pub(crate) fn check_terms(terms: &[[f64; 2]], room: usize) -> Result<(), OutOfBounds> {
    check("prony terms", terms.len() as f64, [0.0, room as f64])?;
    for &[part, time] in terms {
        check("prony g", part, PARTS)?;
        check("prony τ", time, TIMES)?;
    }
    check("sum of prony g", terms.iter().map(|[part, _]| part).sum(), PARTS)
}

/// A term of the Prony series.
#[derive(Clone, Copy)]
struct Term<T> {
    part: T,
    time: T,
    /// aᵢ and mᵢ of the present step.
    decay: T,
    gain: T,
}

impl<T: Real> Blank for Term<T> {
    const BLANK: Self = Self { part: T::ZERO, time: T::ZERO, decay: T::ZERO, gain: T::ZERO };
}

/// How many terms there are, whether anything has been strained yet, and the present step's time, s, and stiffness k.
#[derive(Clone, Copy)]
struct Course<T> {
    count: u8,
    is_strained: bool,
    /// Weights, decays and gains are those of the present step.
    is_aimed: bool,
    seconds: T,
    stiffness: T,
}

impl<T: Real> Blank for Course<T> {
    const BLANK: Self = Self { count: 0, is_strained: false, is_aimed: false, seconds: T::ZERO, stiffness: T::ZERO };
}

/// The material's terms, and the accepted state as they remember it.
pub(crate) struct Memory<T: Real, S: Size> {
    terms: S::Terms<Term<T>>,
    /// One, where there is room for terms at all.
    course: S::Terms<Course<T>>,
    /// Per node and layer: the elastic stresses S of the accepted state, and those hᵢ that each term has left of them.
    layers: S::Past<[T; 3]>,
    /// Weights of the layers in H/k.
    weights: S::Terms<T>,
}

impl<T: Real, S: Size> Memory<T, S> {
    // All zeros, as everything in a blank follower.
    pub const EMPTY: Self = Self {
        terms: <S::Terms<Term<T>> as Storage<Term<T>>>::EMPTY,
        course: <S::Terms<Course<T>> as Storage<Course<T>>>::EMPTY,
        layers: <S::Past<[T; 3]> as Storage<[T; 3]>>::EMPTY,
        weights: <S::Terms<T> as Storage<T>>::EMPTY,
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        !self.is_kept() || self.layers.fit(model.node_count * self.width())
    }

    /// Takes the terms [gᵢ, τᵢ in s]; none for an elastic material.
    pub fn set(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds> {
        check_terms(terms, S::TERMS.min(MOST_TERMS))?;
        let fits = terms.is_empty()
            || self.terms.fit(terms.len() + 1) && self.weights.fit(terms.len() + 1) && self.course.fit(1);
        for (into, &[part, time]) in self.terms.as_mut().iter_mut().zip(terms) {
            *into = Term { part: T::of(part), time: T::of(time), ..Term::BLANK };
        }
        let count = if fits { terms.len() as u8 } else { 0 };
        self.course.as_mut().fill(Course { count, ..Course::BLANK });
        Ok(())
    }

    /// Nodes that there is room for.
    pub fn most_nodes(&self) -> f64 {
        (self.layers.as_ref().len() / self.width()) as f64
    }

    /// The material remembers.
    #[inline(always)]
    pub fn is_kept(&self) -> bool {
        S::TERMS > 0 && self.count() > 0
    }

    /// It remembers, and something has been strained.
    #[inline(always)]
    pub fn is_strained(&self) -> bool {
        self.is_kept() && self.course.as_ref().at(0).is_strained
    }

    /// Layers per node.
    fn width(&self) -> usize {
        self.count() + 1
    }

    #[inline(always)]
    fn count(&self) -> usize {
        self.course.as_ref().first().map_or(0, |course| usize::from(course.count))
    }

    /// Stiffness k of the step, as a part of the sudden one.
    pub fn stiffness(&self) -> T {
        if self.is_kept() { self.course.as_ref().at(0).stiffness } else { T::one() }
    }

    /// Nothing has been strained yet.
    pub fn begin(&mut self) {
        self.strain(false);
        self.layers.as_mut().fill([T::ZERO; 3]);
        self.aim(T::ZERO);
    }

    fn strain(&mut self, is_strained: bool) {
        self.course.as_mut().iter_mut().take(1).for_each(|course| course.is_strained = is_strained);
    }

    /// The step that follows takes so long, s (69).
    pub fn aim(&mut self, seconds: T) {
        let Some(course) = self.course.as_mut().first_mut() else { return };
        // Ticks of a loop are equally long, and exponentials in double precision are dear on a microcontroller.
        if course.is_aimed && course.seconds == seconds {
            return;
        }
        (course.is_aimed, course.seconds) = (true, seconds);
        let (count, seconds) = (self.count(), seconds.to_f64());
        let mut stiffness = T::one();
        for term in self.terms.as_mut().iter_mut().take(count) {
            let ratio = seconds / term.time.to_f64();
            let faded = -libm::expm1(-ratio);
            let gain = T::of(if ratio > 0.0 { faded / ratio } else { 1.0 });
            (term.decay, term.gain) = (T::of(1.0 - faded), gain);
            stiffness -= term.part * (T::one() - gain);
        }
        let inverse = T::one() / stiffness;
        let Some((first, weights)) = self.weights.as_mut().split_first_mut() else { return };
        *first = T::ZERO;
        for (weight, term) in weights.iter_mut().zip(self.terms.as_ref()).take(count) {
            *weight = term.part * term.decay * inverse;
            *first -= term.part * term.gain * inverse;
        }
        self.course.as_mut().iter_mut().take(1).for_each(|course| course.stiffness = stiffness);
    }

    /// What is remembered does not count, until the next aim: the finger as if it had never been strained.
    pub fn mute(&mut self) {
        self.weights.as_mut().fill(T::ZERO);
        self.course.as_mut().iter_mut().take(1).for_each(|course| course.is_aimed = false);
    }

    /// What a run of nodes remembers.
    #[inline(always)]
    pub fn of(&self, nodes: core::ops::Range<usize>) -> Remembered<'_, T> {
        let width = self.width();
        let layers = self.layers.as_ref().get(nodes.start * width..nodes.end * width).unwrap_or(&[]);
        Remembered { layers, width, weights: self.weights() }
    }

    /// Weights of the layers in H/k, zeros beyond the last.
    #[inline(always)]
    fn weights(&self) -> [T; MOST_LAYERS] {
        let mut weights = [T::ZERO; MOST_LAYERS];
        for (into, &weight) in weights.iter_mut().zip(self.weights.as_ref()) {
            *into = weight;
        }
        weights
    }

    /// The state is accepted whose nodes, members and rows these are: its stresses become those of the past (70).
    pub fn accept(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        nodes: &[Node<T>],
        members: &[Strain<T>],
        rows: &[Row<T>],
    ) {
        self.strain(true);
        let (width, weights, fading, mut from) = (self.width(), self.weights(), self.fading(), 0);
        for (index, (member, out)) in model.members().iter().zip(members).enumerate() {
            let own = own_rows(rows, index, from);
            from = own.end;
            let run = member.nodes();
            let (Some(of), Some(angle), Some(on), Some(layers)) = (
                model.constants(member),
                state.angle.as_ref().get(run.clone()),
                nodes.get(run.clone()),
                self.layers.as_mut().get_mut(run.start * width..run.end * width),
            ) else {
                continue;
            };
            if member.compliance != [T::ZERO; 2] {
                // Stress along and across: what balances the force, the past taken off, in the step's unit.
                let mut pull = Pull::new(rows.run(own), out.force);
                let each = on.iter().zip(of.weight).zip(layers.chunks_exact_mut(width));
                for (local, ((node, &weight), layers)) in each.enumerate().rev() {
                    let force = pull.force(run.start + local, weight);
                    let [x, y] = node.e;
                    let [along, across] = Remembered { layers: &*layers, width, weights }.forces(0);
                    let stresses = [-(force[0] * x + force[1] * y + along), -(force[1] * x - force[0] * y + across)];
                    fading.advance(layers, 1, stresses);
                }
            }
            // Elements soften under compression by the force that their carriers have, which is the stress just found.
            match member.kind {
                Kind::Quadratic => {
                    let mut carry = T::ZERO;
                    let mut elements = layers.chunks_exact_mut(2 * width);
                    for (element, layers) in elements.by_ref().enumerate() {
                        let Some((start, middle)) = layers.split_at_mut_checked(width) else { break };
                        let pulled = middle.first().map_or(T::ZERO, |&[_, along, _]| -along);
                        let moments = Quadratic::moments(of, angle, 2 * element, pulled);
                        fading.advance(start, 0, [carry + moments[0]]);
                        fading.advance(middle, 0, [moments[1]]);
                        carry = moments[2];
                    }
                    fading.advance(elements.into_remainder(), 0, [carry]);
                }
                Kind::Link => {
                    for node in 0..angle.len().saturating_sub(1) {
                        let carrier = Link::carrier(of, node) * width;
                        let pulled = layers.get(carrier).map_or(T::ZERO, |&[_, along, _]| -along);
                        let moment = Link::moment(of, angle, node, pulled);
                        if let Some(layers) = layers.get_mut(node * width..(node + 1) * width) {
                            fading.advance(layers, 0, [moment]);
                        }
                    }
                }
            }
        }
    }

    /// How the terms fade in the present step.
    fn fading(&self) -> Fading<T> {
        let mut fading = Fading { width: self.width(), terms: [[T::ZERO; 2]; MOST_TERMS] };
        for (into, term) in fading.terms.iter_mut().zip(self.terms.as_ref()) {
            *into = [term.decay, term.gain];
        }
        fading
    }
}

/// Layers of a node, and aᵢ and mᵢ of each term.
#[derive(Clone, Copy)]
struct Fading<T> {
    width: usize,
    terms: [[T; 2]; MOST_TERMS],
}

impl<T: Real> Fading<T> {
    /// Moves stresses of a node, from the `first` of its three on, to new values: what each term has left of them (70). One and two terms
    /// go without a loop.
    #[inline(always)]
    fn advance<const N: usize>(&self, layers: &mut [[T; 3]], first: usize, stresses: [T; N]) {
        let [one, two, ..] = self.terms;
        let from = |now: &mut [T; 3]| {
            let mut changes = stresses;
            for (change, now) in changes.iter_mut().zip(now.iter_mut().skip(first)) {
                *change -= core::mem::replace(now, *change);
            }
            changes
        };
        let fade = |left: &mut [T; 3], [decay, gain]: [T; 2], changes: [T; N]| {
            for (left, change) in left.iter_mut().skip(first).zip(changes) {
                *left = decay * *left + gain * change;
            }
        };
        match (self.width, layers) {
            (2, [now, h]) => fade(h, one, from(now)),
            (3, [now, h, g]) => {
                let changes = from(now);
                fade(h, one, changes);
                fade(g, two, changes);
            }
            (_, [now, rest @ ..]) => {
                let changes = from(now);
                rest.iter_mut().zip(self.terms).for_each(|(h, term)| fade(h, term, changes));
            }
            _ => {}
        }
    }
}
