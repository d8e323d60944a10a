//! The border: contact rows g_j + ε_c μ_j = 0 against joints, λ and each other.

use super::assembly::add_corrections;
use super::condense::solve_interior;
use super::condensed::{Corrections, Own};
use super::evaluated::Evaluated;
use super::factorisation::{Factorisation, begin_right};
use super::residual::Residual;
use super::slip;
use super::through::{Through, shared};
use crate::access::Access;
use crate::contact::{Direction, Row, cell_of, own_rows};
use crate::element::Node;
use crate::linear::banded;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};
use crate::topology::{CLAMPED, Kind};

#[inline]
fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// C·n of a node with direction e: how stretch and shear under a force n move it.
#[inline]
fn yielding<T: Real>([x, y]: [T; 2], [stretch, shear]: [T; 2], n: [T; 2]) -> [T; 2] {
    let (along, across) = (stretch * (x * n[0] + y * n[1]), shear * (x * n[1] - y * n[0]));
    [along * x - across * y, along * y + across * x]
}

/// The contact rows against joints, λ and each other: what a factorisation makes of them, and is kept with it.
pub(crate) struct Border<T: Real, S: Size> {
    /// Columns Q of the contact rows, then L⁻¹Q; one run of unknowns per row.
    columns: S::Rows<T>,
    /// What they share; then room for D⁻¹L⁻¹ of two columns.
    through: Through<T, S>,
    /// Own-span entries of each row.
    pub own: S::Contacts<Own<T>>,
    /// D = −Z + Qᵀ KKT⁻¹ Q, mm/N, row by row; symmetric.
    pub flexibility: S::Pairs<T>,
    /// How many rows it was made for.
    rows: usize,
}

/// The condensed residual with its sign changed: what the increments are to take away.
pub(crate) struct Right<T: Real, S: Size> {
    /// Of joints and closures, forward-substituted.
    pub joints: S::Unknowns<T>,
    /// Of the rows once joints and closures are eliminated: b, mm.
    pub rows: S::Contacts<T>,
}

impl<T: Real, S: Size> Right<T, S> {
    pub const EMPTY: Self =
        Self { joints: <S::Unknowns<T> as Storage<T>>::EMPTY, rows: <S::Contacts<T> as Storage<T>>::EMPTY };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.joints.fit(model.unknowns()) && self.rows.fit(S::CONTACTS)
    }
}

impl<T: Real, S: Size> Border<T, S> {
    pub const EMPTY: Self = Self {
        columns: <S::Rows<T> as Storage<T>>::EMPTY,
        through: Through::EMPTY,
        own: <S::Contacts<Own<T>> as Storage<Own<T>>>::EMPTY,
        flexibility: <S::Pairs<T> as Storage<T>>::EMPTY,
        rows: 0,
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.fit_rows(model, 0) && self.through.fit(model) && self.own.fit(S::CONTACTS)
    }

    /// Makes room for so many rows; an array has it since it was fitted to the model.
    fn fit_rows(&mut self, model: &Model<T, S>, rows: usize) -> bool {
        let stride = S::stride(rows);
        self.columns.fit(stride * model.unknowns()) && self.flexibility.fit(stride * stride)
    }

    /// How far the rows of D are apart.
    pub fn stride(&self) -> usize {
        S::stride(self.rows)
    }

    /// Borders a factorisation by the contact rows (31): columns, D and the rows' right-hand sides b. `room` is for a solution on the
    /// interiors.
    pub fn make(
        &mut self,
        at: Evaluated<'_, T, S>,
        kkt: &Factorisation<T, S>,
        right: &mut Right<T, S>,
        room: &mut [T],
    ) {
        self.rows = at.contacts.count;
        if !self.fit_rows(at.model, self.rows) {
            return;
        }
        self.through.begin(at.model);
        let (mut span_start, mut cell) = (0, usize::MAX);
        // The rows of a sample come one after the other.
        let (mut sample, mut lever) = (None, [[T::ZERO; 2]; 3]);
        for (j, row) in at.contacts.rows().iter().enumerate() {
            if cell != cell_of(row) {
                (cell, span_start) = (cell_of(row), j);
                self.through.pass_to(at.model, kkt, right.joints.as_ref(), cell);
            }
            if sample.replace(row.sample) != Some(row.sample) {
                lever = at.kinematics.lever(at.model, cell, &row.place);
            }
            if let Some((ends, residual)) = self.own_span(at, kkt, (room, lever), j, span_start) {
                self.spans_below(at, right, j, span_start, (ends, residual));
            }
        }
        self.complete(at, kkt, right);
    }

    /// The columns' forward-substituted entries, row by row.
    pub fn columns(&self, unknowns: usize) -> impl Iterator<Item = &[T]> {
        self.columns.as_ref().chunks_exact(unknowns.max(1))
    }

    /// A row's own span, condensed: its entries with the start joint and the end joint, and what its residual gets. `lever` is its sample's
    /// ([`Kinematics::lever`](super::kinematics::Kinematics::lever)).
    fn own_span(
        &mut self,
        at: Evaluated<'_, T, S>,
        kkt: &Factorisation<T, S>,
        (room, mut lever): (&mut [T], [[T; 2]; 3]),
        j: usize,
        span_start: usize,
    ) -> Option<([T; 2], T)> {
        let Evaluated { model, kinematics, contacts } = at;
        let row = contacts.rows.as_ref().get(j)?;
        let (sample, normal, index) = (&row.place, row.normal, cell_of(row));
        let (member, m) = (model.member(index)?, kinematics.members.as_ref().get(index)?);
        let nodes = member.nodes();
        let interior = usize::from(member.interior);
        if S::RUBS && row.direction == Direction::Tangent {
            slip::lengthen(model, row, &mut lever);
        }
        let mut own = Own { entries: lever.map(|lever| -dot(normal, lever)), ..Own::BLANK };
        // Raw entries on the span: −n·∂P with the angles, w C n with the force; nothing beyond the sample's element.
        let first = usize::from(sample.node).saturating_sub(nodes.start).min(nodes.len());
        let (start, end, before_end) = if kkt.curved {
            let coupling = |node: usize| kinematics.nodes.as_ref().at(nodes.start + node).coupling();
            (coupling(0), coupling(interior), coupling(interior.saturating_sub(1)))
        } else {
            let coupling = |node: usize| model.coupling.as_ref().at(nodes.start + node);
            (coupling(0), coupling(interior), coupling(interior.saturating_sub(1)))
        };
        let list = kinematics.nodes.as_ref().get(nodes.clone())?;
        let column = room.get_mut(nodes.clone())?;
        let weight = model.weight.as_ref().get(nodes.clone())?;
        // A member without stretch and shear moves no sample by them.
        let is_strained = member.compliance != [T::ZERO; 2];
        let tensor = if is_strained {
            raw_entries::<T, true>(column, list, weight, first, &own.entries, row)?
        } else {
            raw_entries::<T, false>(column, list, weight, first, &own.entries, row)?
        };
        if S::RUBS
            && row.direction == Direction::Tangent
            && usize::from(sample.node) >= nodes.end
            && let Some(joint) = column.last_mut()
        {
            // On the wedge: with the joint at the tip alone.
            *joint -= sample.half_thickness;
        }
        if is_strained {
            let ([stretch, shear], [xx, xy, all]) = (member.compliance, tensor);
            let (k, yy) = (stretch - shear, all - xx);
            own.strain = [
                k * (xx * normal[0] + xy * normal[1]) + shear * all * normal[0],
                k * (xy * normal[0] + yy * normal[1]) + shear * all * normal[1],
            ];
            own.x = own.strain;
        }
        let turn = |r: [T; 2]| normal[1] * r[0] - normal[0] * r[1];
        let &[first_entry, .., last_entry] = &*column else { return None };
        let mut ends = [first_entry - turn(m.rigid_start), last_entry - sample.rigid * turn(m.rigid_end)];
        let factors = kkt.interiors.as_ref().get(nodes.clone())?;
        let wide = member.kind == Kind::Quadratic;
        solve_interior((list, factors, column), [T::ZERO; 2], T::ZERO, wide, |_, entry| entry);
        // The joints at both ends come by their columns.
        if let [first, .., last] = column {
            (*first, *last) = (T::ZERO, T::ZERO);
        }
        // Eliminate the interior: entries with a, b, force, gradient.
        let ([_, inner @ .., _], [_, solved @ .., _]) = (list, &*column) else { return None };
        if let ([first, ..], [.., last]) = (solved, solved) {
            ends = [ends[0] - start[0] * *first, ends[1] - end[0] * *last];
        }
        if let ([_, second, ..], [.., second_last, _]) = (solved, solved) {
            ends = [ends[0] - start[1] * *second, ends[1] - before_end[1] * *second_last];
        }
        let mut residual = T::ZERO;
        for (node, &z) in inner.iter().zip(solved) {
            own.x = [own.x[0] - z * node.lever[0], own.x[1] - z * node.lever[1]];
            residual -= node.gradient * z;
        }
        *self.own.as_mut().get_mut(j)? = own;

        // Rows on the same span, this one included: −Z = −Σ n′·∂P′ z + Σ w w′/l n·C·n′; `strain` has the last sum without what a node has
        // beyond this row's sample.
        let mut beyond = [[T::ZERO; 2]; 3];
        if is_strained {
            let on = list.get(first..)?.iter().zip(weight.get(first..)?).zip(&sample.weights);
            for (beyond, ((node, &weight), &part)) in beyond.iter_mut().zip(on) {
                if weight != T::ZERO {
                    *beyond = yielding(node.e, member.compliance, normal).map(|c| (part / weight - T::one()) * c);
                }
            }
        }
        let mut swept = [T::ZERO; 2];
        let mut passed = 0;
        let stride = self.stride();
        let entries = self.flexibility.as_mut().get_mut(j * stride..)?.get_mut(span_start..=j)?;
        let rows = contacts.rows.as_ref().get(span_start..=j)?.iter().zip(self.own.as_ref().get(span_start..=j)?);
        for ((other, own), entry) in rows.zip(entries) {
            let lower = &other.place;
            let start = usize::from(lower.node).saturating_sub(nodes.start);
            while passed + 1 < start
                && let (Some(node), Some(&z)) = (inner.get(passed), solved.get(passed))
            {
                swept = [swept[0] + node.lever[0] * z, swept[1] + node.lever[1] * z];
                passed += 1;
            }
            let mut sum = dot(normal, own.strain) - dot(other.normal, swept);
            sum += match column.get(start..) {
                Some([first, middle, last, ..]) => {
                    own.entries[0] * *first + own.entries[1] * *middle + own.entries[2] * *last
                }
                at => own.entries.iter().zip(at.unwrap_or(&[])).fold(T::ZERO, |sum, (&entry, &z)| sum + entry * z),
            };
            if is_strained && let Some(weights) = first.checked_sub(start).and_then(|apart| lower.weights.get(apart..))
            {
                sum += match (weights, &beyond) {
                    (&[a, b, c], [x, y, z]) => dot([0, 1].map(|i| a * x[i] + b * y[i] + c * z[i]), other.normal),
                    _ => weights
                        .iter()
                        .zip(&beyond)
                        .fold(T::ZERO, |sum, (&w, &beyond)| sum + w * dot(beyond, other.normal)),
                };
            }
            *entry = sum;
        }
        Some((ends, residual))
    }

    /// A row's column, its entries with the rows on lower spans, and its right-hand side.
    fn spans_below(
        &mut self,
        at: Evaluated<'_, T, S>,
        right: &mut Right<T, S>,
        j: usize,
        span_start: usize,
        (ends, residual): ([T; 2], T),
    ) {
        let Evaluated { model, contacts, .. } = at;
        let (n, stride) = (model.unknowns(), self.stride());
        let (Some(row), Some(own)) = (contacts.rows.as_ref().get(j), self.own.as_mut().get_mut(j)) else { return };
        let (Some(column), Some(entries), Some(member)) = (
            self.columns.as_mut().get_mut(j * n..(j + 1) * n),
            self.flexibility.as_mut().get_mut(j * stride..(j + 1) * stride),
            model.member(cell_of(row)),
        ) else {
            return;
        };
        self.through.fill(column, row.normal);
        if member.start != CLAMPED {
            column.add(usize::from(member.start), ends[0]);
        }
        column.add(usize::from(member.end), ends[1]);
        column.add(member.force_unknown(), own.x[0]);
        column.add(member.force_unknown() + 1, own.x[1]);
        // What lies below both moves by the force of either.
        let moved = self.through.moves(row.normal);
        own.x = [own.x[0] - moved[0], own.x[1] - moved[1]];
        let Some((lower, same)) = entries.split_at_mut_checked(span_start) else { return };
        for (entry, own) in lower.iter_mut().zip(self.own.as_ref()) {
            *entry = dot(own.x, row.normal);
        }
        for (entry, other) in same.iter_mut().zip(contacts.rows.as_ref().run(span_start..j + 1)) {
            *entry -= dot(moved, other.normal);
        }
        entries.add(j, row.softness);
        let residual = residual - dot(self.through.found(), row.normal);
        right.rows.as_mut().put(j, -row.gap - row.softness * row.multiplier + residual);
    }

    /// Forward-substitutes the columns and completes D and the right-hand sides:
    /// D = −Z + Qᵀ KKT⁻¹ Q, b = r_μ − Qᵀ KKT⁻¹ r.
    fn complete(&mut self, at: Evaluated<'_, T, S>, kkt: &Factorisation<T, S>, right: &mut Right<T, S>) {
        let Evaluated { model, contacts, .. } = at;
        let (n, stride, rows) = (model.unknowns(), self.stride(), contacts.rows());
        if n == 0 {
            return;
        }
        let [scaled, next_scaled] = self.through.room(n);
        let (Some(band), Some(joints), Some(columns)) = (
            kkt.band.as_ref().get(..n),
            right.joints.as_ref().get(..n),
            self.columns.as_mut().get_mut(..rows.len() * n),
        ) else {
            return;
        };
        let flexibility = self.flexibility.as_mut();
        // From the tip, two of a span at once: what is loaded for one serves the other.
        let mut end = rows.len();
        while let Some((row, below)) = rows.get(..end).and_then(<[Row<T>]>::split_last) {
            let span = cell_of(row);
            let count = if below.last().is_some_and(|row| cell_of(row) == span) { 2 } else { 1 };
            let (j, start) = (end - count, shared(model, span));
            let (Some((columns, above)), Some((entries, entries_above)), Some(rights)) = (
                columns.get_mut(j * n..).and_then(|columns| columns.split_at_mut_checked(count * n)),
                flexibility.get_mut(j * stride..).and_then(|rows| rows.split_at_mut_checked(count * stride)),
                right.rows.as_mut().get_mut(j..end),
            ) else {
                return;
            };
            let Some((column, next)) = columns.split_at_mut_checked(n) else { return };
            if count == 2 {
                banded::forward_both(band, column, next, start);
            } else {
                banded::forward(band, column, start);
            }
            let next = if count == 2 { &*next } else { &*column };
            let (Some(column), Some(next), Some(joints), Some(band)) =
                (column.get(start..), next.get(start..), joints.get(start..), band.get(start..))
            else {
                return;
            };
            for ((scaled, next_scaled), ((&x, &y), row)) in
                scaled.iter_mut().zip(&mut *next_scaled).zip(column.iter().zip(next).zip(band))
            {
                (*scaled, *next_scaled) = (x * row[banded::BAND], y * row[banded::BAND]);
            }
            let pair = [scaled.run(0..n - start), next_scaled.run(0..n - start)];
            for (right, [taken, _]) in rights.iter_mut().zip(products(pair, joints, joints)) {
                *right += taken;
            }
            let [[own, across], [_, next_own]] = products(pair, column, next);
            entries.add(j, own);
            if count == 2 {
                entries.add(stride + j, across);
                entries.put(j + 1, entries.at(stride + j));
                entries.add(stride + j + 1, next_own);
            }
            let pairs_above = above.chunks((2 * n).max(1)).zip(entries_above.chunks_mut(2 * stride));
            for (k, (columns, entries_above)) in (end..).step_by(2).zip(pairs_above) {
                let (first, second) = columns.split_at_checked(n).unwrap_or_default();
                let second = if second.is_empty() { first } else { second };
                let (Some(first), Some(second)) = (first.get(start..), second.get(start..)) else { return };
                let products = products(pair, first, second);
                for (i, products) in products.iter().enumerate().take(count) {
                    for (l, &product) in products.iter().enumerate().take(if columns.len() > n { 2 } else { 1 }) {
                        entries_above.add(l * stride + j + i, product);
                        entries.put(i * stride + k + l, entries_above.at(l * stride + j + i));
                    }
                }
            }
            end = j;
        }
    }

    /// The condensed residual of another state than the one the factorisation was made at: columns and D stay. The rows are those that it
    /// takes ([`Factorisation::takes`]).
    pub fn load(
        &mut self,
        at: Evaluated<'_, T, S>,
        residual: &Residual<T, S>,
        kkt: &Factorisation<T, S>,
        right: &mut Right<T, S>,
        room: &mut [T],
    ) {
        let Evaluated { model, contacts, .. } = at;
        begin_right(model, residual, right.joints.as_mut());
        let (mut below, mut from) = ([T::ZERO; 2], 0);
        for (index, member) in model.members().iter().enumerate() {
            let Some(corrections) = condense(at, kkt, room, index) else { continue };
            add_corrections(right.joints.as_mut(), member, &corrections);
            if index < model.cells() {
                from = self.load_rows(at, right, room, (index, from), below);
                below = [below[0] + corrections.rx[0], below[1] + corrections.rx[1]];
            }
        }
        kkt.substitute(model, right.joints.as_mut());
        let n = model.unknowns();
        let [scaled, _] = self.through.room(n);
        let band = kkt.band.as_ref().run(0..n);
        for ((scaled, &y), row) in scaled.iter_mut().zip(right.joints.as_ref()).zip(band) {
            *scaled = y * row[banded::BAND];
        }
        let columns = self.columns.as_ref().chunks_exact(n.max(1)).take(contacts.count);
        for (right, column) in right.rows.as_mut().iter_mut().zip(columns) {
            *right += column.iter().zip(&*scaled).fold(T::ZERO, |sum, (&entry, &scaled)| sum + entry * scaled);
        }
    }

    /// Right-hand sides of the rows on a front span, but for what the joints and closures take; returns the first row beyond it.
    /// `below` is the sum of what the spans below have found for their forces.
    fn load_rows(
        &self,
        at: Evaluated<'_, T, S>,
        right: &mut Right<T, S>,
        solved: &[T],
        (index, from): (usize, usize),
        below: [T; 2],
    ) -> usize {
        let Evaluated { model, kinematics, contacts } = at;
        let own = own_rows(contacts.rows(), index, from);
        let Some(nodes) = model.member(index).map(|member| member.nodes()) else { return own.end };
        let (Some([_, inner @ .., _]), Some([_, solved @ .., _])) =
            (kinematics.nodes.as_ref().get(nodes.clone()), solved.get(nodes.clone()))
        else {
            return own.end;
        };
        let (mut passed, mut swept) = (0, [T::ZERO; 2]);
        let rows = contacts.rows().run(own.clone()).iter().zip(self.own.as_ref().run(own.clone()));
        for ((row, own), right) in rows.zip(right.rows.as_mut().run_mut(own.clone())) {
            let first = usize::from(row.place.node).saturating_sub(nodes.start);
            // The interior nodes below the sample's element, whose levers are whole.
            while passed + 1 < first
                && let (Some(node), Some(&z)) = (inner.get(passed), solved.get(passed))
            {
                swept = [swept[0] + node.lever[0] * z, swept[1] + node.lever[1] * z];
                passed += 1;
            }
            let mut moved = dot(row.normal, [swept[0] - below[0], swept[1] - below[1]]);
            let (joints, from) = if first == 0 { (1, 0) } else { (0, first - 1) };
            for (&entry, &z) in own.entries.iter().skip(joints).zip(solved.get(from..).unwrap_or(&[])) {
                moved -= entry * z;
            }
            *right = moved - row.gap - row.softness * row.multiplier;
        }
        own.end
    }
}

/// Products of two columns with two others.
// Called four times: copies would cost flash and spare little.
#[inline(never)]
fn products<T: Real>([x, y]: [&[T]; 2], first: &[T], second: &[T]) -> [[T; 2]; 2] {
    let mut sums = [[T::ZERO; 2]; 2];
    let mut add = |(x, y): (T, T), (a, b): (T, T)| {
        sums = [[sums[0][0] + x * a, sums[0][1] + x * b], [sums[1][0] + y * a, sums[1][1] + y * b]];
    };
    let count = x.len().min(y.len()).min(first.len()).min(second.len());
    let [(x, x_left), (y, y_left), (first, first_left), (second, second_left)] =
        [x, y, first, second].map(|column| column.run(0..count).as_chunks::<4>());
    for ((x, y), (a, b)) in x.iter().zip(y).zip(first.iter().zip(second)) {
        for i in 0..4 {
            add((x[i], y[i]), (a[i], b[i]));
        }
    }
    for ((&x, &y), (&a, &b)) in x_left.iter().zip(y_left).zip(first_left.iter().zip(second_left)) {
        add((x, y), (a, b));
    }
    sums
}

/// Entries of a row with the angles of its own span, from its node `first` on those given, before condensation; with them Σ w of
/// eₓ², eₓ e_y and 1, if the span is `STRAINED`.
#[inline(always)]
fn raw_entries<T: Real, const STRAINED: bool>(
    column: &mut [T],
    list: &[Node<T>],
    weight: &[T],
    first: usize,
    entries: &[T; 3],
    row: &Row<T>,
) -> Option<[T; 3]> {
    let mut tensor = [T::ZERO; 3];
    let mut weigh = |w: T, [x, y]: [T; 2]| {
        if STRAINED {
            tensor = [tensor[0] + w * x * x, tensor[1] + w * x * y, tensor[2] + w];
        }
    };
    let (below, beyond) = column.split_at_mut_checked(first)?;
    for ((value, node), &w) in below.iter_mut().zip(list).zip(weight) {
        *value = -dot(row.normal, node.lever);
        weigh(w, node.e);
    }
    beyond.fill(T::ZERO);
    let element = list.get(first..)?.iter().zip(entries).zip(&row.place.weights);
    for (value, ((node, &entry), &w)) in beyond.iter_mut().zip(element) {
        *value = entry;
        weigh(w, node.e);
    }
    Some(tensor)
}

/// Condenses a member's gradient alone; its solution on the interior stays in `room`.
fn condense<T: Real, S: Size>(
    at: Evaluated<'_, T, S>,
    kkt: &Factorisation<T, S>,
    room: &mut [T],
    index: usize,
) -> Option<Corrections<T>> {
    let Evaluated { model, kinematics, .. } = at;
    let member = model.member(index)?;
    let nodes = member.nodes();
    let constant = model.coupling.as_ref().get(nodes.clone())?;
    let (list, factors) = (kinematics.nodes.as_ref().get(nodes.clone())?, kkt.interiors.as_ref().get(nodes.clone())?);
    let solved = room.get_mut(nodes)?;
    let wide = member.kind == Kind::Quadratic;
    solve_interior((list, factors, solved), [T::ZERO; 2], T::ZERO, wide, |node, _| node.gradient);
    let coupling = |at: usize| match (kkt.curved, list.get(at)) {
        (true, Some(node)) => node.coupling(),
        _ => constant.at(at),
    };
    let ([_, inner @ .., _], [_, solved @ .., _]) = (list, &*solved) else { return None };
    let count = inner.len();
    let mut rx = [T::ZERO; 2];
    for (node, &z) in inner.iter().zip(solved) {
        rx = [rx[0] - node.lever[0] * z, rx[1] - node.lever[1] * z];
    }
    let (mut ra, mut rb) = (T::ZERO, T::ZERO);
    if let ([first, ..], [.., last]) = (solved, solved) {
        (ra, rb) = (ra - coupling(0)[0] * *first, rb - coupling(count)[0] * *last);
    }
    if let ([_, second, ..], [.., second_last, _]) = (solved, solved) {
        (ra, rb) = (ra - coupling(0)[1] * *second, rb - coupling(count - 1)[1] * *second_last);
    }
    Some(Corrections { ra, rb, rx })
}
