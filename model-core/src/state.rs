//! The state of a discretised finger: what changes from solve to solve.

use crate::access::Access;
use crate::contact::ContactState;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};
use crate::topology::CLAMPED;

/// Angles, multipliers and the touching samples.
pub struct State<T: Real, S: Size> {
    /// Change of orientation θ at each node, rad; joint angles are repeated at every member that meets there.
    pub(crate) angle: S::Nodes<T>,
    /// Internal force λ_k of each closure, N.
    pub(crate) lambda: S::Cells<[T; 2]>,
    /// Dead load on the front beam, finger frame, N, and the cell at whose upper end it acts.
    pub(crate) load: [T; 2],
    pub(crate) load_cell: usize,
    /// Touching samples in order along the beam.
    pub(crate) touching: S::Contacts<u16>,
    /// Their multipliers μ, N.
    pub(crate) multiplier: S::Contacts<T>,
    /// Their normals when they were last evaluated: what strains the front beam before the gaps are known.
    pub(crate) normal: S::Contacts<[T; 2]>,
    /// With friction: their tangential forces τ towards the tip, N, and how they slip.
    pub(crate) tangential: S::SlipContacts<T>,
    pub(crate) slips: S::SlipContacts<ContactState>,
    pub(crate) touching_count: usize,
}

impl<T: Real, S: Size> State<T, S> {
    /// The undeformed, untouched finger.
    pub const EMPTY: Self = Self {
        angle: <S::Nodes<T> as Storage<T>>::EMPTY,
        lambda: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        load: [T::ZERO; 2],
        load_cell: 0,
        touching: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        multiplier: <S::Contacts<T> as Storage<T>>::EMPTY,
        normal: <S::Contacts<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        tangential: <S::SlipContacts<T> as Storage<T>>::EMPTY,
        slips: <S::SlipContacts<ContactState> as Storage<ContactState>>::EMPTY,
        touching_count: 0,
    };

    /// Makes room for a model; false if there is none.
    pub(crate) fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.angle.fit(model.node_count)
            && self.lambda.fit(model.cells())
            && self.touching.fit(S::CONTACTS)
            && self.multiplier.fit(S::CONTACTS)
            && self.normal.fit(S::CONTACTS)
            && (!S::RUBS || self.tangential.fit(S::CONTACTS) && self.slips.fit(S::CONTACTS))
    }

    /// Back to the undeformed, untouched finger.
    pub(crate) fn rest(&mut self) {
        self.angle.as_mut().fill(T::ZERO);
        self.lambda.as_mut().fill([T::ZERO; 2]);
        self.load = [T::ZERO; 2];
        self.touching_count = 0;
    }

    /// Σ μ n over the touching samples, N: the contact force with its sign changed, but for friction, whose part may turn round at once.
    pub(crate) fn force(&self) -> [T; 2] {
        let touching = self.multiplier.as_ref().iter().zip(self.normal.as_ref()).take(self.touching_count);
        touching.fold([T::ZERO; 2], |sum, (&force, normal)| [sum[0] + force * normal[0], sum[1] + force * normal[1]])
    }

    /// Expresses its forces in another unit, which the old one is `part` of.
    pub(crate) fn express(&mut self, part: T, model: &Model<T, S>) {
        let scale = |[x, y]: &mut [T; 2]| (*x, *y) = (part * *x, part * *y);
        self.lambda.as_mut().iter_mut().take(model.cells()).for_each(scale);
        scale(&mut self.load);
        for force in self.multiplier.as_mut().iter_mut().take(self.touching_count) {
            *force *= part;
        }
        for force in self.tangential.as_mut().iter_mut().take(self.touching_count) {
            *force *= part;
        }
    }

    /// Takes another state of the same model.
    pub(crate) fn copy(&mut self, from: &Self, model: &Model<T, S>) {
        fn copy<X: Blank>(into: &mut [X], from: &[X], count: usize) {
            for (into, &from) in into.iter_mut().zip(from).take(count) {
                *into = from;
            }
        }
        // By name, here and in [`Self::predict`]: a field that is added is a compiler's error until both know it.
        let Self { angle, lambda, load, load_cell, touching, multiplier, normal, tangential, slips, touching_count } =
            self;
        copy(angle.as_mut(), from.angle.as_ref(), model.node_count);
        copy(lambda.as_mut(), from.lambda.as_ref(), model.cells());
        let count = from.touching_count;
        copy(touching.as_mut(), from.touching.as_ref(), count);
        copy(multiplier.as_mut(), from.multiplier.as_ref(), count);
        copy(normal.as_mut(), from.normal.as_ref(), count);
        copy(tangential.as_mut(), from.tangential.as_ref(), count);
        copy(slips.as_mut(), from.slips.as_ref(), count);
        *touching_count = count;
        (*load, *load_cell) = (from.load, from.load_cell);
    }

    /// Goes on from another state to this one and `part` as far beyond. A contact that is new keeps its multiplier.
    pub(crate) fn predict(&mut self, from: &Self, part: T, model: &Model<T, S>) {
        // A load and where it acts are given, not found; what slips or sticks does so until the law says otherwise.
        let Self {
            angle,
            lambda,
            load: _,
            load_cell: _,
            touching,
            multiplier,
            normal,
            tangential,
            slips,
            touching_count,
        } = self;
        let beyond = |now: &mut T, then: T| *now += part * (*now - then);
        for (now, &then) in angle.as_mut().iter_mut().zip(from.angle.as_ref()).take(model.node_count) {
            beyond(now, then);
        }
        for (now, then) in lambda.as_mut().iter_mut().zip(from.lambda.as_ref()).take(model.cells()) {
            beyond(&mut now[0], then[0]);
            beyond(&mut now[1], then[1]);
        }
        let then = from.touching.as_ref().run(0..from.touching_count).iter().zip(from.multiplier.as_ref());
        let mut then = then.zip(from.normal.as_ref()).peekable();
        let count = *touching_count;
        let sum = |multipliers: &[T]| multipliers.iter().fold(T::ZERO, |sum, &multiplier| sum + multiplier);
        let mut whole = sum(multiplier.as_ref().run(0..count));
        beyond(&mut whole, sum(from.multiplier.as_ref().run(0..from.touching_count)));
        let now = multiplier.as_mut().iter_mut().zip(normal.as_mut());
        for (sample, (now, normal)) in touching.as_ref().run(0..count).iter().zip(now) {
            while then.next_if(|((other, _), _)| *other < sample).is_some() {}
            if let Some(((_, &before), &turned)) = then.next_if(|((other, _), _)| *other == sample) {
                beyond(&mut normal[0], turned[0]);
                beyond(&mut normal[1], turned[1]);
                // A contact may be about to open: the active set decides that, not this.
                let least = T::of(0.01) * *now;
                beyond(now, before);
                *now = now.max(least);
            }
        }
        if S::RUBS {
            // Of what sticks; the force of what slips follows from μ.
            let mut then =
                from.touching.as_ref().run(0..from.touching_count).iter().zip(from.tangential.as_ref()).peekable();
            let now = tangential.as_mut().iter_mut().zip(slips.as_ref());
            for (sample, (now, state)) in touching.as_ref().run(0..count).iter().zip(now) {
                while then.next_if(|(other, _)| *other < sample).is_some() {}
                if let Some((_, &before)) = then.next_if(|(other, _)| *other == sample)
                    && *state == ContactState::Stick
                {
                    beyond(now, before);
                }
            }
        }
        // The force goes on smoothly where the samples that carry it come and go.
        let multipliers = multiplier.as_mut().run_mut(0..count);
        let found = sum(multipliers);
        if whole > T::ZERO && found > T::ZERO {
            let scale = whole / found;
            multipliers.iter_mut().for_each(|multiplier| *multiplier *= scale);
        }
    }

    /// Goes on by `part` of a velocity: the changes of angles, multipliers and normals; the touching samples stay the same.
    pub(crate) fn go_on(&mut self, velocity: &Self, part: T, model: &Model<T, S>) {
        for (now, &change) in self.angle.as_mut().iter_mut().zip(velocity.angle.as_ref()).take(model.node_count) {
            *now += part * change;
        }
        for (now, change) in self.lambda.as_mut().iter_mut().zip(velocity.lambda.as_ref()).take(model.cells()) {
            *now = [now[0] + part * change[0], now[1] + part * change[1]];
        }
        let touching = self.multiplier.as_mut().iter_mut().zip(self.normal.as_mut()).take(self.touching_count);
        let changes = velocity.multiplier.as_ref().iter().zip(velocity.normal.as_ref());
        for ((multiplier, normal), (&change, turn)) in touching.zip(changes) {
            *multiplier += part * change;
            *normal = [normal[0] + part * turn[0], normal[1] + part * turn[1]];
        }
    }

    /// Largest difference of an angle to another state, rad.
    pub(crate) fn largest_move(&self, from: &Self, model: &Model<T, S>) -> T {
        let angles = self.angle.as_ref().iter().take(model.node_count).zip(from.angle.as_ref());
        angles.fold(T::ZERO, |most, (&now, &then)| most.max((now - then).abs()))
    }

    /// Makes the joint angles that members repeat agree again: that of the member which ends at the joint counts.
    pub(crate) fn share_joints(&mut self, model: &Model<T, S>) {
        let angle = self.angle.as_mut();
        for owner in model.members() {
            let (joint, value) = (owner.end, angle.at(owner.nodes().end - 1));
            for member in model.members() {
                if member.start == joint {
                    angle.put(usize::from(member.first), value);
                }
                if member.end == joint {
                    angle.put(member.nodes().end - 1, value);
                }
            }
        }
        for member in model.members().iter().filter(|member| member.start == CLAMPED) {
            angle.put(usize::from(member.first), T::ZERO);
        }
    }

    /// Elastic energy of bending, N·mm.
    pub(crate) fn bending_energy(&self, model: &Model<T, S>) -> T {
        let (angle, coupling) = (self.angle.as_ref(), model.coupling.as_ref());
        let mut twice = T::ZERO;
        for member in model.members() {
            let angle = angle.run(member.nodes());
            for (node, (&[next, after], &from)) in coupling.run(member.nodes()).iter().zip(angle).enumerate() {
                for (ahead, entry) in [(1, next), (2, after)] {
                    if let Some(&to) = angle.get(node + ahead) {
                        twice -= entry * (to - from) * (to - from);
                    }
                }
            }
        }
        T::of(0.5) * twice
    }
}
