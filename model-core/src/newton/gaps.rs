//! Gaps of the contact samples, and the rows they make.

use super::kinematics::Kinematics;
use super::turning::Patches;
use crate::access::Access;
use crate::contact::{ContactState, Direction, Row, Sample, sample_gap};
use crate::model::{Model, vec2_of};
use crate::object::{Gap, Object};
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size, Storage};
use crate::state::State;

/// What a sweep over the samples found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sweep<T> {
    /// Smallest gap of all samples, mm; while some touch, of those and the ones near them.
    pub nearest: T,
    /// Normal there, out of the object.
    pub normal: [T; 2],
    /// Smallest gap of the samples that did not touch before, mm, if it is below the margin.
    pub nearest_free: T,
    /// Some sample that penetrates found no room among the rows.
    pub overflow: bool,
    /// Some sample that is only near found no room.
    pub near_overflow: bool,
}

impl<T: Real> Sweep<T> {
    /// Before any: all zeros.
    pub const NONE: Self =
        Self { nearest: T::ZERO, normal: [T::ZERO; 2], nearest_free: T::ZERO, overflow: false, near_overflow: false };
}

/// Contact rows: touching samples and those near the object, in order along the beam.
pub(crate) struct Contacts<T: Real, S: Size> {
    pub rows: S::Contacts<Row<T>>,
    pub count: usize,
    /// Which of them are not gaps but the turning of the contact force (see [`super::turning`]).
    pub patches: Patches,
}

/// A sweep under way: the rows made so far, and what is known of the places still to come.
struct Gathering<'a, T: Real, S: Size> {
    state: &'a State<T, S>,
    rows: &'a mut [Row<T>],
    count: usize,
    softness: T,
    /// Places that find room among the rows.
    room: usize,
    margin: T,
    /// How many of the places that touched before have been seen, and the next one: beyond all where there is none.
    touched: usize,
    next: usize,
    /// Gap of the last row if that is the deepest so far of a run of new places.
    run: Option<T>,
    found: Sweep<T>,
}

/// A place of those listed, beyond all places where there is none.
#[inline(always)]
fn place_at(listed: &[u16], at: usize) -> usize {
    listed.get(at).map_or(usize::MAX, |&place| usize::from(place))
}

impl<T: Real, S: Size> Gathering<'_, T, S> {
    fn listed(&self) -> &[u16] {
        self.state.touching.as_ref().run(0..self.state.touching_count)
    }

    #[inline(always)]
    fn nearest(&mut self, gap: &Gap<T>) {
        if gap.distance < self.found.nearest {
            self.found.nearest = gap.distance;
            self.found.normal = [gap.normal.x, gap.normal.y];
        }
    }

    /// A place that touched before: its row, with the normal that the beam is strained with.
    #[inline(always)]
    fn touching(&mut self, index: usize, place: &Sample<T>, gap: &Gap<T>) {
        let (multiplier, normal) =
            (self.state.multiplier.as_ref().at(self.touched), self.state.normal.as_ref().at(self.touched));
        self.touched += 1;
        self.next = place_at(self.listed(), self.touched);
        let tilt = normal[0] * gap.normal.y - normal[1] * gap.normal.x;
        self.run = None;
        self.push(index, place, gap, ContactState::Closed, [normal, [tilt, multiplier]]);
    }

    /// Another place: a row if it is near and there is room.
    #[inline(always)]
    fn free(&mut self, index: usize, place: &Sample<T>, gap: &Gap<T>) {
        self.found.nearest_free = self.found.nearest_free.min(gap.distance);
        if gap.distance > self.margin {
            return;
        }
        // Room is kept for the places that touch further up the beam.
        if self.count + self.listed().len() - self.touched >= self.room {
            self.found.overflow |= gap.distance < T::ZERO;
            self.found.near_overflow = true;
            return;
        }
        self.push(index, place, gap, ContactState::Open, [[gap.normal.x, gap.normal.y], [T::ZERO; 2]]);
    }

    /// Another place of those between the samples: of a run of them only the deepest becomes a row, and those within `reach` of one
    /// that touches. What is left out and still penetrates after the step is near one that touches then.
    fn between(&mut self, index: usize, place: &Sample<T>, gap: &Gap<T>, reach: usize) {
        let touching_below = self.touched.checked_sub(1).and_then(|last| self.listed().get(last));
        let near_below = touching_below.is_some_and(|&below| index - usize::from(below) <= reach);
        let near = near_below || self.next - index <= reach;
        if near || gap.distance > self.margin {
            self.run = None;
            self.free(index, place, gap);
            return;
        }
        match self.run {
            Some(deepest) if gap.distance >= deepest => return,
            Some(_) => self.count -= 1,
            None => {}
        }
        let rows = self.count;
        self.free(index, place, gap);
        self.run = (self.count > rows).then_some(gap.distance);
    }

    #[inline(always)]
    fn push(
        &mut self,
        index: usize,
        place: &Sample<T>,
        gap: &Gap<T>,
        state: ContactState,
        [normal, [tilt, multiplier]]: [[T; 2]; 2],
    ) {
        if let Some(row) = self.rows.get_mut(self.count) {
            *row = Row {
                sample: index as u16,
                direction: Direction::Normal,
                state,
                place: *place,
                gap: gap.distance,
                normal,
                tilt,
                curvature: gap.curvature,
                softness: self.softness,
                multiplier,
            };
            self.count += 1;
        }
    }
}

impl<T: Real, S: Size> Contacts<T, S> {
    pub const EMPTY: Self =
        Self { rows: <S::Contacts<Row<T>> as Storage<Row<T>>>::EMPTY, count: 0, patches: Patches::NONE };

    /// Makes room; false if there is none.
    pub fn fit(&mut self) -> bool {
        self.rows.fit(S::CONTACTS)
    }

    /// The rows.
    #[inline(always)]
    pub fn rows(&self) -> &[Row<T>] {
        self.rows.as_ref().run(0..self.count)
    }

    #[inline(always)]
    pub fn rows_mut(&mut self) -> &mut [Row<T>] {
        self.rows.as_mut().run_mut(0..self.count)
    }

    /// Makes rows of the places that touch, with the normals of the state: what strains the front beam, and so says where the gaps
    /// are. That the normals there are the same is one more thing that must hold at an equilibrium.
    pub fn recall(&mut self, model: &Model<T, S>, state: &State<T, S>) {
        (self.count, self.patches) = (state.touching_count, Patches::NONE);
        let touching = state.touching.as_ref().iter().zip(state.multiplier.as_ref()).zip(state.normal.as_ref());
        for (row, ((&sample, &multiplier), &normal)) in self.rows.as_mut().iter_mut().zip(touching).take(self.count) {
            let place = model.place(sample);
            *row = Row { sample, state: ContactState::Closed, place, normal, multiplier, ..Row::BLANK };
        }
    }

    /// Finds the gaps of all samples, and near a sharp object of the places between them, and makes the contact rows: places that touched
    /// before and those nearer than `margin`, `room` of them.
    ///
    /// A place that is only near gives way when there is no room; one that touches or penetrates never does silently.
    pub fn sweep<O: Object<T>>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        object: &O,
        margin: T,
        room: usize,
    ) -> Sweep<T> {
        if model.fineness > 1 || model.every > 1 {
            self.sweep_places(model, state, kinematics, object, (margin, room))
        } else {
            self.sweep_samples(model, state, kinematics, object, (margin, room))
        }
    }

    /// As [`Self::sweep`], without places between the samples, which all count.
    #[inline(never)]
    fn sweep_samples<O: Object<T>>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        object: &O,
        within: (T, usize),
    ) -> Sweep<T> {
        self.sweep_all::<O, false>(model, state, kinematics, object, within)
    }

    /// As [`Self::sweep`], with places between the samples, or where not all of these count.
    #[inline(never)]
    fn sweep_places<O: Object<T>>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        object: &O,
        within: (T, usize),
    ) -> Sweep<T> {
        self.sweep_all::<O, true>(model, state, kinematics, object, within)
    }

    /// As [`Self::sweep`], with places between the samples, or where not all of these count (`FINE`), or without.
    #[inline(always)]
    fn sweep_all<O: Object<T>, const FINE: bool>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        object: &O,
        (margin, room): (T, usize),
    ) -> Sweep<T> {
        let samples = model.samples.as_ref().iter().take(model.sample_count);
        let Kinematics { nodes, start, members, .. } = kinematics;
        let (nodes, weight) = (nodes.as_ref(), model.weight.as_ref());
        let far = T::of(1e9);
        let mut gathering = Gathering {
            state,
            rows: self.rows.as_mut(),
            count: 0,
            softness: model.contact_softness(),
            room,
            margin,
            touched: 0,
            next: place_at(state.touching.as_ref().run(0..state.touching_count), 0),
            run: None,
            found: Sweep {
                nearest: far,
                normal: [T::ZERO; 2],
                nearest_free: far,
                overflow: false,
                near_overflow: false,
            },
        };
        let touches = state.touching_count > 0;
        let mut cell = usize::MAX;
        let mut node = 0;
        let mut prefix = Vec2::new(T::ZERO, T::ZERO);
        let mut rigid_end = prefix;
        // No beam is stretched by a quarter, so that a sample far off clears those that are nearer to it along the beam.
        let (longest, mut seen) = (T::of(1.25), -far);
        // Samples until the next one that counts; the last one does.
        let every = usize::from(model.every.max(1));
        let mut until = model.sample_count.saturating_sub(1) % every;
        for (at, sample) in samples.enumerate() {
            if cell != usize::from(sample.cell) {
                cell = usize::from(sample.cell);
                node = model.member(cell).map_or(0, |front| usize::from(front.first));
                prefix = vec2_of(start.as_ref().at(cell));
                rigid_end = members.as_ref().get(cell).map_or(rigid_end, |front| vec2_of(front.rigid_end));
            }
            // The nodes below the sample's own.
            while node < usize::from(sample.node)
                && let (Some(on), Some(&weight)) = (nodes.get(node), weight.get(node))
            {
                prefix += vec2_of(on.strained) * weight;
                node += 1;
            }
            let index = if FINE { model.index_of(at) } else { at };
            let counts = !FINE || until == 0;
            if FINE {
                until = if counts { every - 1 } else { until - 1 };
            }
            // Neither near nor the nearest. While something touches, where the others are does not matter.
            let is_far = |gathering: &Gathering<'_, T, S>| {
                let matters = if touches { margin } else { margin.max(gathering.found.nearest) };
                gathering.next != index && seen - longest * sample.arc > sample.half_thickness + matters
            };
            if !FINE && is_far(&gathering) {
                continue;
            }
            let below = prefix;
            let mut position = prefix;
            let from = nodes.get(usize::from(sample.node)..).unwrap_or(&[]);
            match (sample.weights, from) {
                // At the end of its node's length, which is the next one's start.
                ([w, next, _], [on, ..]) if w != T::ZERO && next == T::ZERO => {
                    position += vec2_of(on.strained) * w;
                    (prefix, node) = (position, node + 1);
                }
                // A node without a weight may be another member's, and not yet strained.
                (weights, _) => {
                    for (on, w) in from.iter().zip(weights).take_while(|(_, w)| *w != T::ZERO) {
                        position += vec2_of(on.strained) * w;
                    }
                }
            }
            if sample.rigid != T::ZERO {
                position += rigid_end * sample.rigid;
            }
            if FINE && model.is_fine(at) {
                let near = {
                    let reach = sample.half_thickness + margin + longest * model.way_to(at);
                    !object.clears(position, reach) && object.gap(position).distance <= reach
                };
                let first = index + 1 - model.fineness;
                if near || gathering.next < index {
                    for index in first..index {
                        let is_touching = gathering.next == index;
                        if !near && !is_touching {
                            continue;
                        }
                        let place = model.place(index as u16);
                        // Nodes of the place that are below the sample's are summed up already.
                        let skipped = usize::from(sample.node.saturating_sub(place.node));
                        let mut position = below + rigid_end * place.rigid;
                        let on = nodes.get(usize::from(place.node)..).unwrap_or(&[]).iter().zip(&place.weights);
                        for (on, &w) in on.skip(skipped).filter(|(_, w)| **w != T::ZERO) {
                            position += vec2_of(on.strained) * w;
                        }
                        let gap = sample_gap(object, &place, position);
                        if is_touching {
                            gathering.nearest(&gap);
                            gathering.touching(index, &place, &gap);
                            continue;
                        }
                        let stride = model.stride(at, &gap);
                        if (index + 1 - first).is_multiple_of(stride) {
                            gathering.nearest(&gap);
                            gathering.between(index, &place, &gap, usize::from(REACH) * stride);
                        }
                    }
                }
            }
            if FINE && is_far(&gathering) {
                continue;
            }
            let gap = sample_gap(object, sample, position);
            seen = gap.distance + sample.half_thickness + longest * sample.arc;
            gathering.nearest(&gap);
            if gathering.next == index {
                gathering.touching(index, sample, &gap);
            } else if FINE && model.stride(at, &gap) < model.fineness {
                gathering.between(index, sample, &gap, usize::from(REACH) * model.stride(at, &gap));
            } else if counts {
                gathering.run = None;
                gathering.free(index, sample, &gap);
            }
        }
        let Gathering { count, found, .. } = gathering;
        self.count = count;
        found
    }

    /// Gives the rows that touch the object's normals as the last sweep has found them: what strains the front beam from here on.
    ///
    /// What they are then still behind, once the gaps are measured again, is of second order in what they were behind before.
    pub fn redirect(&mut self) {
        for row in self.rows_mut().iter_mut().filter(|row| row.touches()) {
            row.normal = turned_by(row.normal, row.tilt);
        }
    }

    /// Measures the gaps of the rows again.
    pub fn measure<O: Object<T>>(&mut self, model: &Model<T, S>, kinematics: &Kinematics<T, S>, object: &O) {
        for row in self.rows_mut().iter_mut().filter(|row| row.only_pushes()) {
            let gap = sample_gap(object, &row.place, kinematics.position(model, &row.place));
            (row.gap, row.curvature) = (gap.distance, gap.curvature);
            if row.touches() {
                row.tilt = row.normal[0] * gap.normal.y - row.normal[1] * gap.normal.x;
            } else {
                row.normal = [gap.normal.x, gap.normal.y];
            }
        }
    }

    /// By how much the gradient is off for normals that are not the object's where the samples are, N·mm. A node's gradient takes the
    /// forces above it times its weight, so what counts is the largest sum of misdirected force from the tip down: opposite tilts further
    /// apart do not make up for each other. NaN stays NaN.
    pub fn misdirected(&self, model: &Model<T, S>) -> T {
        let (mut most, mut arm, mut above) = (T::ZERO, T::ZERO, [T::ZERO; 2]);
        for row in self.rows().iter().rev() {
            if row.touches() {
                arm = model.weight.as_ref().get(usize::from(row.place.node) + 1).map_or(arm, |&weight| arm.max(weight));
                let across = row.multiplier * row.tilt;
                above = [above[0] - across * row.normal[1], above[1] + across * row.normal[0]];
                let size = above[0] * above[0] + above[1] * above[1];
                most = if size <= most { most } else { size };
            }
        }
        most.sqrt() * arm
    }

    /// Gives the rows the multipliers and normals that the last whole step has given the state, so that the contacts can be read
    /// without another evaluation.
    pub fn settle(&mut self, state: &State<T, S>) {
        let touching = state.touching.as_ref().iter().take(state.touching_count);
        let forces = state.multiplier.as_ref().iter().zip(state.normal.as_ref());
        let mut settled = touching.zip(forces).peekable();
        for row in self.rows_mut().iter_mut().filter(|row| row.only_pushes()) {
            (row.multiplier, row.state) = (T::ZERO, ContactState::Open);
            if let Some((_, (&multiplier, &normal))) = settled.next_if(|(sample, _)| **sample == row.sample) {
                (row.multiplier, row.normal, row.state) = (multiplier, normal, ContactState::Closed);
            }
        }
    }
}

/// A unit vector turned by a small angle, rad; of length one up to third order whatever it was.
pub(crate) fn turned_by<T: Real>([x, y]: [T; 2], angle: T) -> [T; 2] {
    let length = T::of(1.5) - T::of(0.5) * (x * x + y * y + angle * angle);
    [length * (x - angle * y), length * (y + angle * x)]
}

/// Samples, or strides of places, beyond a touching one that stay among the rows when they are thinned.
pub(super) const REACH: u16 = 2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_normal_keeps_its_length_to_third_order() {
        let [x, y] = turned_by([-0.8, 0.6], 1e-3);
        assert!((libm::hypot(x, y) - 1.0).abs() < 1e-9);
        assert!((libm::atan2(y, x) - libm::atan2(0.6, -0.8) - 1e-3).abs() < 1e-9);
        let [x, y] = turned_by([-0.8 * 1.001, 0.6 * 1.001], 0.0);
        assert!((libm::hypot(x, y) - 1.0).abs() < 2e-6, "a length that was off is put right");
    }
}
