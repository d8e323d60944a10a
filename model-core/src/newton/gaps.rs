//! Gaps of the contact samples, and the rows they make.

use super::Workspace;
use super::kinematics::place_front;
use super::workspace::{Contacts, Shape};
use crate::access::Access;
use crate::contact::{ContactState, Direction, Row, Sample, sample_gap};
use crate::element::Depth;
use crate::model::{Model, vec2_of};
use crate::object::{Gap, Object};
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size};
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

/// Makes rows of the places that touch, with the normals of the state: what strains the front beam, and so says where the gaps
/// are. That the normals there are the same is one more thing that must hold at an equilibrium.
pub(crate) fn recall<T: Real, S: Size>(model: &Model<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    work.contacts.row_count = state.touching_count;
    work.contacts.turning = None;
    let touching = state.touching.as_ref().iter().zip(state.multiplier.as_ref()).zip(state.normal.as_ref());
    let rows = work.contacts.rows.as_mut().iter_mut().zip(touching).take(state.touching_count);
    for (row, ((&sample, &multiplier), &normal)) in rows {
        *row =
            Row { sample, state: ContactState::Closed, place: model.place(sample), normal, multiplier, ..Row::BLANK };
    }
}

/// A sweep under way: the rows made so far, and what is known of the places still to come.
struct Gathering<'a, T: Real, S: Size> {
    state: &'a State<T, S>,
    rows: &'a mut [Row<T>],
    count: usize,
    softness: T,
    margin: T,
    /// How many of the places that touched before have been seen, and the next one.
    touched: usize,
    next: Option<usize>,
    /// Gap of the last row if that is the deepest so far of a run of new places.
    run: Option<T>,
    found: Sweep<T>,
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
        self.next = self.listed().get(self.touched).map(|&place| usize::from(place));
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
        if self.count + self.listed().len() - self.touched >= S::CONTACTS {
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
        let near = near_below || self.next.is_some_and(|above| above - index <= reach);
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

/// Finds the gaps of all samples, and near a sharp object of the places between them, and makes the contact rows: places that touched
/// before and those nearer than `margin`.
///
/// A place that is only near gives way when there is no room; one that touches or penetrates never does silently.
pub(crate) fn sweep<T: Real, S: Size, O: Object<T>>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
    margin: T,
) -> Sweep<T> {
    let samples = model.samples.as_ref().iter().take(model.sample_count);
    let Workspace { shape: Shape { nodes, start, members, .. }, contacts: Contacts { rows, .. }, .. } = work;
    let (nodes, weight) = (nodes.as_ref(), model.weight.as_ref());
    let far = T::of(1e9);
    let mut gathering = Gathering {
        state,
        rows: rows.as_mut(),
        count: 0,
        softness: model.contact_softness(),
        margin,
        touched: 0,
        next: state.touching.as_ref().run(0..state.touching_count).first().map(|&place| usize::from(place)),
        run: None,
        found: Sweep { nearest: far, normal: [T::ZERO; 2], nearest_free: far, overflow: false, near_overflow: false },
    };
    let is_fine = model.fineness > 1;
    let mut cell = usize::MAX;
    let mut node = 0;
    let mut prefix = Vec2::new(T::ZERO, T::ZERO);
    let mut rigid_end = prefix;
    // No beam is stretched by a quarter, so that a sample far off clears those that are nearer to it along the beam. Where there are
    // few samples to an element, a cheap test of each does as well.
    let (longest, mut seen) = (T::of(1.25), -far);
    for (at, sample) in samples.enumerate() {
        if cell != usize::from(sample.cell) {
            cell = usize::from(sample.cell);
            node = model.member(cell).map_or(0, |front| usize::from(front.first));
            prefix = vec2_of(start.as_ref().at(cell));
            rigid_end = members.as_ref().get(cell).map_or(rigid_end, |front| vec2_of(front.rigid_end));
        }
        let below = prefix;
        let mut position = prefix;
        if model.quadratic {
            while node < usize::from(sample.node)
                && let (Some(on), Some(&weight)) = (nodes.get(node), weight.get(node))
            {
                prefix += vec2_of(on.strained) * weight;
                node += 1;
            }
            position = prefix;
            // A node without a weight may be another member's, and not yet strained.
            let from = nodes.get(usize::from(sample.node)..).unwrap_or(&[]);
            for (on, &w) in from.iter().zip(&sample.weights) {
                if w != T::ZERO {
                    position += vec2_of(on.strained) * w;
                }
            }
            if sample.rigid != T::ZERO {
                position += rigid_end * sample.rigid;
            }
        } else if sample.weights[0] != T::ZERO
            && let Some(on) = nodes.get(usize::from(sample.node))
        {
            // A sample at each link's end.
            position += vec2_of(on.strained) * sample.weights[0];
            prefix = position;
        } else {
            position += rigid_end * sample.rigid;
        }
        if is_fine && model.is_fine(at) {
            let near = {
                let reach = sample.half_thickness + margin + longest * model.way_to(at);
                !object.clears(position, reach) && object.gap(position).distance <= reach
            };
            let index = model.index_of(at);
            let first = index + 1 - model.fineness;
            if near || gathering.next.is_some_and(|next| next < index) {
                for index in first..index {
                    let is_touching = gathering.next == Some(index);
                    if !near && !is_touching {
                        continue;
                    }
                    let place = model.place(index as u16);
                    // The nodes below the place's are in the prefix; of links, those below the link.
                    let from = if model.quadratic { prefix } else { below };
                    let skipped = usize::from(!model.quadratic);
                    let mut position = from + rigid_end * place.rigid;
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
        let index = if is_fine { model.index_of(at) } else { at };
        let touched = gathering.next == Some(index);
        // While something touches, where the others are does not matter.
        let matters = touched || state.touching_count == 0;
        if !matters && seen - longest * sample.arc > sample.half_thickness + margin {
            continue;
        }
        if !matters && model.quadratic && object.clears(position, sample.half_thickness + margin) {
            continue;
        }
        let gap = sample_gap(object, sample, position);
        if !model.quadratic {
            seen = gap.distance + sample.half_thickness + longest * sample.arc;
        }
        gathering.nearest(&gap);
        if touched {
            gathering.touching(index, sample, &gap);
        } else if is_fine && model.stride(at, &gap) < model.fineness {
            gathering.between(index, sample, &gap, usize::from(REACH) * model.stride(at, &gap));
        } else {
            gathering.run = None;
            gathering.free(index, sample, &gap);
        }
    }
    let Gathering { count, found, .. } = gathering;
    work.contacts.row_count = count;
    found
}

/// Strains the front beam anew with the normals that the sweep found where its samples touch, and measures those gaps again.
///
/// What the normals are then still behind is of second order in what they were behind before.
pub(crate) fn reposition<T: Real, S: Size, O: Object<T>, D: Depth>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
) {
    let count = work.contacts.row_count;
    for row in work.contacts.rows.as_mut().iter_mut().take(count).filter(|row| row.touches()) {
        row.normal = turned_by(row.normal, row.tilt);
    }
    place_front::<T, S, D>(model, state, work);
    for j in 0..count {
        let mut row = work.contacts.rows.as_ref().at(j);
        let gap = sample_gap(object, &row.place, sample_position(model, work, &row.place));
        row.gap = gap.distance;
        row.curvature = gap.curvature;
        if row.touches() {
            row.tilt = row.normal[0] * gap.normal.y - row.normal[1] * gap.normal.x;
        } else {
            row.normal = [gap.normal.x, gap.normal.y];
        }
        work.contacts.rows.as_mut().put(j, row);
    }
}

/// A unit vector turned by a small angle, rad; of length one up to third order whatever it was.
pub(crate) fn turned_by<T: Real>([x, y]: [T; 2], angle: T) -> [T; 2] {
    let length = T::of(1.5) - T::of(0.5) * (x * x + y * y + angle * angle);
    [length * (x - angle * y), length * (y + angle * x)]
}

/// Samples, or strides of places, beyond a touching one that stay among the rows when they are thinned.
const REACH: u16 = 2;

/// Thins the rows of samples that only penetrate if there are more than `many`: those near a touching sample stay, and of the
/// others those that penetrate deepest among their neighbours.
///
/// Where the motion has a kink, the extrapolated beam penetrates with many samples that will not touch, and a step costs the
/// square of its rows. What is left out and still penetrates after the step is a row of the next iteration.
pub(crate) fn thin<T: Real, S: Size>(work: &mut Workspace<T, S>, many: usize) {
    let rows = work.contacts.rows.as_mut().run_mut(0..work.contacts.row_count);
    let touches = |row: &Row<T>| row.touches();
    let new = rows.iter().filter(|row| !touches(row)).count();
    if new <= many || new == rows.len() {
        return;
    }
    let mut count = 0;
    let mut below: Option<Row<T>> = None;
    let mut touching_below: Option<u16> = None;
    for j in 0..rows.len() {
        let row = rows.at(j);
        let above = rows.get(j + 1..).unwrap_or(&[]);
        let keeps = touches(&row) || {
            let near_below = touching_below.is_some_and(|k| row.sample - k <= REACH);
            let near_above = above.iter().take_while(|r| r.sample - row.sample <= REACH).any(touches);
            let deeper = |other: &Row<T>| other.sample.abs_diff(row.sample) > 1 || row.gap < other.gap;
            near_below || near_above || (below.as_ref().is_none_or(deeper) && above.first().is_none_or(deeper))
        };
        if touches(&row) {
            touching_below = Some(row.sample);
        }
        below = Some(row);
        if keeps {
            rows.put(count, row);
            count += 1;
        }
    }
    work.contacts.row_count = count;
}

/// Position of a sample, finger frame, mm.
pub(crate) fn sample_position<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &Workspace<T, S>,
    sample: &Sample<T>,
) -> Vec2<T> {
    let cell = usize::from(sample.cell);
    let (nodes, weight) = (work.shape.nodes.as_ref(), model.weight.as_ref());
    let (first, node) = (model.member(cell).map_or(0, |front| usize::from(front.first)), usize::from(sample.node));
    let mut position = vec2_of(work.shape.start.as_ref().at(cell));
    for (on, &weight) in nodes.run(first..node).iter().zip(weight.run(first..node)) {
        position += vec2_of(on.strained) * weight;
    }
    for (k, &w) in sample.weights.iter().enumerate() {
        if w != T::ZERO {
            position += vec2_of(nodes.at(node + k).strained) * w;
        }
    }
    let rigid_end = work.shape.members.as_ref().get(cell).map_or([T::ZERO; 2], |front| front.rigid_end);
    position + vec2_of(rigid_end) * sample.rigid
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Paper;
    use std::boxed::Box;
    use std::vec::Vec;

    /// Samples that are left of rows with these gaps, from sample 10 on, of which some touch.
    fn thinned(gaps: &[f64], touching: &[u16], many: usize) -> Vec<u16> {
        let mut work: Box<Workspace<f64, Paper>> = Box::new(Workspace::EMPTY);
        for (j, &gap) in gaps.iter().enumerate() {
            let sample = 10 + j as u16;
            let touches = touching.contains(&sample);
            let (state, multiplier) = if touches { (ContactState::Closed, 1.0) } else { (ContactState::Open, 0.0) };
            work.contacts.rows[j] = Row { sample, state, gap, multiplier, ..Row::BLANK };
        }
        work.contacts.row_count = gaps.len();
        thin(&mut work, many);
        work.contacts.rows[..work.contacts.row_count].iter().map(|row| row.sample).collect()
    }

    const GAPS: [f64; 12] = [-0.1, 0.0, -0.1, -0.2, -0.3, -0.4, -0.3, -0.2, -0.3, -0.5, -0.6, -0.2];

    #[test]
    fn of_many_new_rows_the_deepest_and_those_beside_a_touching_one_stay() {
        // 11 touches: 10, 12 and 13 are near it; 15 and 20 are deeper than their neighbours.
        assert_eq!(thinned(&GAPS, &[11], 5), [10, 11, 12, 13, 15, 20]);
        // The last one touches as well.
        assert_eq!(thinned(&GAPS, &[11, 21], 5), [10, 11, 12, 13, 15, 19, 20, 21]);
    }

    #[test]
    fn few_new_rows_and_those_of_a_first_contact_all_stay() {
        let all: Vec<u16> = (10..22).collect();
        assert_eq!(thinned(&GAPS, &[11], 11), all);
        assert_eq!(thinned(&GAPS, &[], 5), all);
    }

    #[test]
    fn a_turned_normal_keeps_its_length_to_third_order() {
        let [x, y] = turned_by([-0.8, 0.6], 1e-3);
        assert!((libm::hypot(x, y) - 1.0).abs() < 1e-9);
        assert!((libm::atan2(y, x) - libm::atan2(0.6, -0.8) - 1e-3).abs() < 1e-9);
        let [x, y] = turned_by([-0.8 * 1.001, 0.6 * 1.001], 0.0);
        assert!((libm::hypot(x, y) - 1.0).abs() < 2e-6, "a length that was off is put right");
    }
}
