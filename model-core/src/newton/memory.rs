//! Material with memory: generalised Maxwell on all strains alike (68)–(72).
//!
//! The stress is that of an elastic finger, S, faded: g∞ S + Σ gᵢ hᵢ with ḣᵢ = Ṡ − hᵢ/τᵢ. Over a step in which S changes evenly that is
//!
//! > k S + H, with k = g∞ + Σ gᵢ mᵢ, H = Σ gᵢ (aᵢ hᵢ − mᵢ S₀), aᵢ = e^(−Δt/τᵢ), mᵢ = (1 − aᵢ) τᵢ/Δt,
//!
//! so that a step is one of an elastic finger in a unit of force k times as large, under given initial stresses H/k. Nothing in the solver
//! but the elements' forces knows of it.
//!
//! What is kept is not hᵢ but qᵢ = gᵢ (aᵢ hᵢ − mᵢ S₀)/k, so that a walk has a sum to take and nothing to multiply. It belongs to a step of
//! a certain length: one that is accepted leaves what another one as long will need, as ticks of a loop do (70).

use crate::access::Access;
use crate::bounds::{OutOfBounds, check};
use crate::contact::{Row, own_rows};
use crate::element::{Constants, Link, Node, Pull, Quadratic, Remembered, Strain, Trace};
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

/// A term of the Prony series, and 1 − aᵢ and mᵢ of the step that qᵢ belongs to.
#[derive(Clone, Copy)]
struct Term<T> {
    part: T,
    time: T,
    /// Precise where little fades in a tick.
    faded: T,
    gain: T,
}

impl<T: Real> Blank for Term<T> {
    const BLANK: Self = Self { part: T::ZERO, time: T::ZERO, faded: T::ZERO, gain: T::ZERO };
}

impl<T: Real> Term<T> {
    /// aᵢ.
    fn decay(&self) -> T {
        T::one() - self.faded
    }
}

/// Time, as a part of τᵢ, up to which the exponential is a series, and that series' last factor: they leave 1e-15.
const SHORT: f64 = 1.0 / 16.0;
const LAST: u8 = 9;

/// What of a term may fade over a step so that the next step is taken to be as long: what has faded cannot be found again.
const FADED: f64 = 0.5;

/// How many terms there are, whether anything has been strained yet, and the step that qᵢ belongs to: its time, s, and stiffness k.
#[derive(Clone, Copy)]
struct Course<T> {
    count: u8,
    is_strained: bool,
    /// The step is the one that is being made.
    is_aimed: bool,
    is_muted: bool,
    seconds: T,
    stiffness: T,
}

impl<T: Real> Blank for Course<T> {
    const BLANK: Self =
        Self { count: 0, is_strained: false, is_aimed: false, is_muted: false, seconds: T::ZERO, stiffness: T::ZERO };
}

/// Per term [f, c] of qᵢ ← f qᵢ + c S.
type Fading<T, S> = <S as Size>::Terms<[T; 2]>;

/// The material's terms, and the accepted state as they remember it.
pub(crate) struct Memory<T: Real, S: Size> {
    terms: S::Terms<Term<T>>,
    /// The first, where there is room for terms at all.
    course: S::Terms<Course<T>>,
    traces: S::Past<Trace<T, S>>,
}

impl<T: Real, S: Size> Memory<T, S> {
    // All zeros, as everything in a blank follower.
    pub const EMPTY: Self = Self {
        terms: <S::Terms<Term<T>> as Storage<Term<T>>>::EMPTY,
        course: <S::Terms<Course<T>> as Storage<Course<T>>>::EMPTY,
        traces: <S::Past<Trace<T, S>> as Storage<Trace<T, S>>>::EMPTY,
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        !self.is_kept() || self.traces.fit(model.node_count)
    }

    /// Takes the terms [gᵢ, τᵢ in s]; none for an elastic material.
    pub fn set(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds> {
        check_terms(terms, S::TERMS.min(MOST_TERMS))?;
        // What is beyond the last term keeps nothing.
        self.terms.as_mut().fill(Term::BLANK);
        for (into, &[part, time]) in self.terms.as_mut().iter_mut().zip(terms) {
            *into = Term { part: T::of(part), time: T::of(time), ..Term::BLANK };
        }
        let count = terms.len() as u8;
        self.course.as_mut().fill(Course { count, stiffness: T::one(), ..Course::BLANK });
        Ok(())
    }

    /// Nodes that there is room for.
    pub fn most_nodes(&self) -> f64 {
        self.traces.as_ref().len() as f64
    }

    #[inline(always)]
    fn course(&self) -> Course<T> {
        self.course.as_ref().first().copied().unwrap_or(Course::BLANK)
    }

    /// The material remembers.
    #[inline(always)]
    pub fn is_kept(&self) -> bool {
        S::TERMS > 0 && self.course().count > 0
    }

    /// It remembers, and something has been strained.
    #[inline(always)]
    pub fn is_strained(&self) -> bool {
        self.is_kept() && self.course().is_strained
    }

    /// What it remembers counts.
    #[inline(always)]
    pub fn is_heard(&self) -> bool {
        self.is_kept() && !self.course().is_muted
    }

    /// Stiffness k of the step, as a part of the sudden one.
    pub fn stiffness(&self) -> T {
        if self.is_kept() { self.course().stiffness } else { T::one() }
    }

    /// Nothing has been strained yet.
    pub fn begin(&mut self) {
        self.traces.as_mut().fill(Trace::BLANK);
        for course in self.course.as_mut() {
            *course = Course { count: course.count, is_aimed: true, stiffness: T::one(), ..Course::BLANK };
        }
        self.stand();
    }

    /// What is kept belongs to a sudden step.
    fn stand(&mut self) {
        for term in self.terms.as_mut() {
            (term.faded, term.gain) = (T::ZERO, T::one());
        }
    }

    /// The step that follows takes so long, s (69); `accepted` is the state that it begins at.
    pub fn aim(&mut self, model: &Model<T, S>, accepted: &State<T, S>, seconds: T) {
        let Some(course) = self.course.as_mut().first_mut() else { return };
        course.is_muted = false;
        if course.is_aimed && course.seconds == seconds {
            return;
        }
        let before = course.stiffness;
        let mut stiffness = T::one();
        let mut fading: Fading<T, S> = Blank::BLANK;
        for (term, fading) in self.terms.as_mut().iter_mut().zip(fading.as_mut()).take(usize::from(course.count)) {
            let then = *term;
            let [faded, gain] = faded_and_gain(seconds / term.time);
            // A step that fails is made in shorter ones: what it would forget is kept as well as it is worth.
            (term.faded, term.gain) = (faded.min(T::one() - T::EPSILON.sqrt()), gain);
            let longer = term.decay() / then.decay();
            *fading = [longer, term.part * (longer * then.gain - term.gain)];
            stiffness -= term.part * (T::one() - term.gain);
        }
        for fading in fading.as_mut() {
            *fading = [fading[0] * before / stiffness, fading[1] / stiffness];
        }
        let is_strained = course.is_strained;
        *course = Course { is_aimed: true, seconds, stiffness, ..*course };
        if is_strained {
            self.fade(model, accepted, &fading);
        }
    }

    /// What is remembered does not count, until the next aim: the finger as if it had never been strained.
    pub fn mute(&mut self) {
        self.course.as_mut().iter_mut().for_each(|course| course.is_muted = true);
    }

    /// What a run of nodes remembers.
    #[inline(always)]
    pub fn of(&self, nodes: core::ops::Range<usize>) -> Remembered<'_, T, S> {
        Remembered(self.traces.as_ref().get(nodes).unwrap_or(&[]))
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
        let fading = self.accepting();
        let (traces, mut from) = (self.traces.as_mut(), 0);
        for (index, (member, out)) in model.members().iter().zip(members).enumerate() {
            let run = member.nodes();
            let (Some(of), Some(angle), Some(on), Some(traces)) = (
                model.constants(member),
                state.angle.as_ref().get(run.clone()),
                nodes.get(run.clone()),
                traces.get_mut(run.clone()),
            ) else {
                continue;
            };
            if member.compliance != [T::ZERO; 2] {
                // Contacts are on the front spans.
                let own = if index < model.cells() { own_rows(rows, index, from) } else { 0..0 };
                if own.is_empty() {
                    for (node, trace) in on.iter().zip(&mut *traces) {
                        pass_forces(node, out.force, trace, &fading);
                    }
                } else {
                    from = own.end;
                    let mut pull = Pull::new(rows.run(own), out.force);
                    let each = on.iter().zip(of.weight).zip(&mut *traces).enumerate();
                    for (local, ((node, &weight), trace)) in each.rev() {
                        pass_forces(node, pull.force(run.start + local, weight), trace, &fading);
                    }
                }
            }
            // Elements soften under compression by the force that their carriers have, which is the stress just found.
            pass_moments(of, angle, traces, &fading);
        }
    }

    /// How what is kept changes when a step is accepted: into that of another one as long, or, if that step is long, of a sudden one.
    fn accepting(&mut self) -> Fading<T, S> {
        let Some(course) = self.course.as_mut().first_mut() else { return Blank::BLANK };
        course.is_strained = true;
        let count = usize::from(course.count);
        let is_long = self.terms.as_ref().iter().take(count).any(|term| term.faded > T::of(FADED));
        let inverse = T::one() / course.stiffness;
        let mut fading: Fading<T, S> = Blank::BLANK;
        for (into, term) in fading.as_mut().iter_mut().zip(self.terms.as_ref()) {
            let [factor, loss] =
                if is_long { [T::one(), T::one() - term.gain] } else { [term.decay(), term.gain * term.faded] };
            *into = [factor, -(term.part * loss * inverse)];
        }
        if is_long {
            course.is_aimed = false;
            self.stand();
        }
        fading
    }

    /// Makes what is kept that of another step, at the accepted state.
    fn fade(&mut self, model: &Model<T, S>, accepted: &State<T, S>, fading: &Fading<T, S>) {
        let traces = self.traces.as_mut();
        for member in model.members() {
            let run = member.nodes();
            let (Some(of), Some(angle), Some(traces)) =
                (model.constants(member), accepted.angle.as_ref().get(run.clone()), traces.get_mut(run))
            else {
                continue;
            };
            for trace in &mut *traces {
                pass::<T, S, 1>(trace, trace.stress[0], fading);
                pass::<T, S, 2>(trace, trace.stress[1], fading);
            }
            pass_moments(of, angle, traces, fading);
        }
    }
}

/// 1 − e^(−x) and (1 − e^(−x))/x. The library's exponential is one of double precision, which is expensive on a microcontroller; ticks are short.
fn faded_and_gain<T: Real>(x: T) -> [T; 2] {
    if x > T::of(SHORT) {
        let faded = T::of(-libm::expm1(-x.to_f64()));
        return [faded, faded / x];
    }
    // 1 − x/2 (1 − x/3 (1 − x/4 …)).
    let gain = (2..=LAST).rev().fold(T::one(), |rest, k| T::one() - x * T::of(1.0 / f64::from(k)) * rest);
    [x * gain, gain]
}

/// A node's stresses along and across become what balances the force through it, the past taken off, in the step's unit.
#[inline(always)]
fn pass_forces<T: Real, S: Size>(node: &Node<T>, force: [T; 2], trace: &mut Trace<T, S>, fading: &Fading<T, S>) {
    let ([x, y], [_, along, across]) = (node.e, trace.sum());
    trace.stress = [-(force[0] * x + force[1] * y + along), -(force[1] * x - force[0] * y + across)];
    pass::<T, S, 1>(trace, trace.stress[0], fading);
    pass::<T, S, 2>(trace, trace.stress[1], fading);
}

/// Changes what each term keeps of a node's stress, one of its three.
#[inline(always)]
fn pass<T: Real, S: Size, const PART: usize>(trace: &mut Trace<T, S>, stress: T, fading: &Fading<T, S>) {
    for (left, &[factor, loss]) in trace.left.as_mut().iter_mut().zip(fading.as_ref()) {
        left[PART] = factor * left[PART] + loss * stress;
    }
}

/// The same of all moments of a member, whose stresses along and across are known.
#[inline(always)]
fn pass_moments<T: Real, S: Size>(
    of: Constants<'_, T>,
    angle: &[T],
    traces: &mut [Trace<T, S>],
    fading: &Fading<T, S>,
) {
    match of.member.kind {
        Kind::Quadratic => {
            let (Some((&first, angles)), t) = (angle.split_first(), of.member.stiffening) else { return };
            let (elements, last) = traces.as_chunks_mut::<2>();
            let (mut a, mut carry) = (first, T::ZERO);
            let each = angles.as_chunks::<2>().0.iter().zip(of.coupling.as_chunks::<2>().0).zip(elements);
            for ((&[m, b], &[coupling, _]), [start, middle]) in each {
                let moments = Quadratic::moments([a, m, b], coupling, T::one() + t * middle.stress[0]);
                pass::<T, S, 0>(start, carry + moments[0], fading);
                pass::<T, S, 0>(middle, moments[1], fading);
                (a, carry) = (b, moments[2]);
            }
            if let [end] = last {
                pass::<T, S, 0>(end, carry, fading);
            }
        }
        Kind::Link => {
            for node in 0..angle.len().saturating_sub(1) {
                let along = traces.get(Link::carrier(of, node)).map_or(T::ZERO, |trace| trace.stress[0]);
                if let Some(trace) = traces.get_mut(node) {
                    pass::<T, S, 0>(trace, Link::moment(of, angle, node, -along), fading);
                }
            }
        }
        Kind::Gap => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The series and the library's exponential are one function.
    #[test]
    fn short_and_long_steps_fade_alike() {
        for x in [0.0, 1e-12, 1e-5, 0.01, SHORT, SHORT * 1.000001, 0.3, 7.0, 1e4] {
            let [faded, gain] = faded_and_gain::<f64>(x);
            let expected = -libm::expm1(-x);
            assert!((faded - expected).abs() <= 4e-16 * expected, "{x}: {faded:e} for {expected:e}");
            assert!(x == 0.0 && gain == 1.0 || (gain - expected / x).abs() < 1e-15, "{x}: {gain}");
            let [single, _] = faded_and_gain::<f32>(x as f32);
            assert!((f64::from(single) - expected).abs() <= 2e-7 * expected, "{x}: {single:e} for {expected:e}");
        }
    }
}
