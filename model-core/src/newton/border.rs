//! The border: contact rows g_j + ε_c μ_j = 0 against joints, λ and each other.

use super::Workspace;
use super::condense::solve_interior;
use super::condensed::Own;
use super::kinematics::{cell_of, sample_lever};
use crate::access::Access;
use crate::contact::Sample;
use crate::linear::banded;
use crate::linear::symmetric::product;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size};
use crate::topology::{CLAMPED, Kind};

#[inline]
fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// n·C·m of a node with direction e: how the row m gives way under the row n by stretch and shear.
#[inline]
fn compliance_along<T: Real>(e: [T; 2], compliance: [T; 2], n: [T; 2], m: [T; 2]) -> T {
    let cross = |v: [T; 2]| v[1] * e[0] - v[0] * e[1];
    compliance[0] * dot(e, n) * dot(e, m) + compliance[1] * cross(n) * cross(m)
}

/// Fills columns Q, the right-hand sides of the rows and −Z, all condensed.
pub(crate) fn assemble<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let mut span_start = 0;
    let mut cell = usize::MAX;
    for j in 0..work.contacts.row_count {
        let place = work.contacts.rows.as_ref().at(j).place;
        if cell != usize::from(place.cell) {
            (cell, span_start) = (usize::from(place.cell), j);
        }
        if let Some((ends, residual)) = own_span(model, work, j, span_start, &place) {
            spans_below(model, work, j, span_start, cell, ends, residual);
        }
    }
}

/// A row's own span, condensed: its entries with the start joint and the end joint, and what its residual gets.
fn own_span<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    j: usize,
    span_start: usize,
    sample: &Sample<T>,
) -> Option<([T; 2], T)> {
    let index = usize::from(sample.cell);
    let normal = work.contacts.rows.as_ref().at(j).normal;
    let (member, m) = (model.member(index)?, work.shape.members.as_ref().get(index)?);
    let nodes = member.nodes();
    let interior = usize::from(member.interior);
    let mut own = Own { lever: sample_lever(model, work, index, sample), ..Own::BLANK };
    // Raw entries on the span: −n·∂P with the angles, w C n with the force; nothing beyond the sample's element.
    let first = usize::from(sample.node).saturating_sub(nodes.start).min(nodes.len());
    let (start, end, before_end) = if work.factorisation.curved {
        let coupling = |node: usize| work.shape.nodes.as_ref().at(nodes.start + node).coupling;
        (coupling(0), coupling(interior), coupling(interior.saturating_sub(1)))
    } else {
        let coupling = |node: usize| model.coupling.as_ref().at(nodes.start + node);
        (coupling(0), coupling(interior), coupling(interior.saturating_sub(1)))
    };
    let list = work.shape.nodes.as_mut().get_mut(nodes.clone())?;
    let weight = model.weight.as_ref().get(nodes.clone())?;
    let mut tensor = [T::ZERO; 3];
    let mut weigh = |w: T, e: [T; 2]| {
        tensor = [tensor[0] + w * e[0] * e[0], tensor[1] + w * e[0] * e[1], tensor[2] + w];
    };
    let (below, beyond) = list.split_at_mut_checked(first)?;
    for (node, &w) in below.iter_mut().zip(weight) {
        node.delta = -dot(normal, node.lever);
        weigh(w, node.e);
    }
    for node in &mut *beyond {
        node.delta = T::ZERO;
    }
    for ((node, lever), &w) in beyond.iter_mut().zip(&own.lever).zip(&sample.weights) {
        node.delta = -dot(normal, *lever);
        weigh(w, node.e);
    }
    let ([stretch, shear], [xx, xy, all]) = (member.compliance, tensor);
    let (k, yy) = (stretch - shear, all - xx);
    own.strain = [
        k * (xx * normal[0] + xy * normal[1]) + shear * all * normal[0],
        k * (xy * normal[0] + yy * normal[1]) + shear * all * normal[1],
    ];
    own.x = own.strain;
    let turn = |r: [T; 2]| normal[1] * r[0] - normal[0] * r[1];
    let (Some(first_node), Some(last_node)) = (list.first(), list.last()) else { return None };
    let mut ends = [first_node.delta - turn(m.rigid_start), last_node.delta - sample.rigid * turn(m.rigid_end)];
    solve_interior(list, [T::ZERO; 2], T::ZERO, member.kind == Kind::Quadratic, |node| node.delta);
    // Eliminate the interior: entries with a, b, force, gradient.
    let [_, inner @ .., _] = &*list else { return None };
    if let ([first, ..], [.., last]) = (inner, inner) {
        ends = [ends[0] - start[0] * first.delta, ends[1] - end[0] * last.delta];
    }
    if let ([_, second, ..], [.., second_last, _]) = (inner, inner) {
        ends = [ends[0] - start[1] * second.delta, ends[1] - before_end[1] * second_last.delta];
    }
    let mut residual = T::ZERO;
    for node in inner {
        let z = node.delta;
        own.x = [own.x[0] - z * node.lever[0], own.x[1] - z * node.lever[1]];
        residual -= node.gradient * z;
    }
    *work.border.own.as_mut().get_mut(j)? = own;

    // Rows on the same span, this one included: −Z = −Σ n′·∂P′ z + Σ w w′/l n·C·n′.
    let mut swept = [T::ZERO; 2];
    let mut at = 0;
    let entries = work.border.flexibility.as_mut().get_mut(j * S::CONTACTS..)?.get_mut(span_start..=j)?;
    let rows =
        work.contacts.rows.as_ref().get(span_start..=j)?.iter().zip(work.border.own.as_ref().get(span_start..=j)?);
    for ((other, own), entry) in rows.zip(entries) {
        let lower = &other.place;
        let start = usize::from(lower.node).saturating_sub(nodes.start);
        while at + 1 < start
            && let Some(node) = inner.get(at)
        {
            swept = [swept[0] + node.lever[0] * node.delta, swept[1] + node.lever[1] * node.delta];
            at += 1;
        }
        let mut sum = dot(normal, own.strain) - dot(other.normal, swept);
        for (t, (&lever, &w)) in own.lever.iter().zip(&lower.weights).enumerate() {
            let node = start + t;
            // The joints at both ends come by their columns.
            if let Some(inner) = inner.get(node.wrapping_sub(1)) {
                sum -= dot(other.normal, lever) * inner.delta;
            }
            // A node that this row's sample has in part only.
            if w != T::ZERO
                && let (Some(part), Some(on), Some(&weight)) =
                    (node.checked_sub(first), list.get(node), weight.get(node))
            {
                let part = sample.weights.get(part).copied().unwrap_or(T::ZERO);
                sum += w * (part / weight - T::one()) * compliance_along(on.e, member.compliance, normal, other.normal);
            }
        }
        *entry = sum;
    }
    Some((ends, residual))
}

/// A row's column, its entries with the rows on lower spans, and its right-hand side.
fn spans_below<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    j: usize,
    span_start: usize,
    cell: usize,
    ends: [T; 2],
    mut residual: T,
) {
    let n = model.unknowns();
    let row = work.contacts.rows.as_ref().at(j);
    let normal = row.normal;
    let (Some(column), Some(entries)) = (
        work.border.columns.as_mut().get_mut(j * n..(j + 1) * n),
        work.border.flexibility.as_mut().get_mut(j * S::CONTACTS..(j + 1) * S::CONTACTS),
    ) else {
        return;
    };
    column.fill(T::ZERO);
    let (Some(fronts), Some(members)) =
        (work.factorisation.fronts.as_ref().get(..cell), model.topology.fronts().get(..cell))
    else {
        return;
    };
    let (Some(rows), Some(owns)) =
        (work.contacts.rows.as_ref().get(..span_start), work.border.own.as_ref().get(..span_start))
    else {
        return;
    };
    let mut next = 0;
    let mut below = [T::ZERO; 2];
    for (lower, (c, member)) in fronts.iter().zip(members).enumerate() {
        // They see this one through their own span's force, and by nᵀ XX n′ of every span below both.
        while let (Some(other), Some(own)) = (rows.get(next), owns.get(next))
            && cell_of(other) == lower
        {
            entries.put(next, dot(own.x, normal) - dot(below, other.normal));
            next += 1;
        }
        // Spans below: the row pulls at their force.
        let xn = [c.xx * normal[0] + c.xy * normal[1], c.xy * normal[0] + c.yy * normal[1]];
        below = [below[0] + xn[0], below[1] + xn[1]];
        if member.start != CLAMPED {
            column.add(usize::from(member.start), -dot(c.ax, normal));
        }
        column.add(usize::from(member.end), -dot(c.bx, normal));
        column.add(member.force_unknown(), -xn[0]);
        column.add(member.force_unknown() + 1, -xn[1]);
        residual -= dot(c.corrections.rx, normal);
    }
    if let Some(member) = model.member(cell) {
        let own = work.border.own.as_ref().at(j);
        if member.start != CLAMPED {
            column.add(usize::from(member.start), ends[0]);
        }
        column.add(usize::from(member.end), ends[1]);
        column.add(member.force_unknown(), own.x[0]);
        column.add(member.force_unknown() + 1, own.x[1]);
    }
    let rows = work.contacts.rows.as_ref().get(span_start..=j).unwrap_or(&[]);
    for (other, entry) in rows.iter().zip(entries.get_mut(span_start..).unwrap_or(&mut [])) {
        *entry -= dot(below, other.normal);
    }
    entries.add(j, row.softness);
    work.border.row_rhs.as_mut().put(j, -row.gap - row.softness * row.multiplier + residual);
}

/// Forward-substitutes the columns and completes D and the right-hand sides:
/// D = −Z + Qᵀ KKT⁻¹ Q, b = r_μ − Qᵀ KKT⁻¹ r with `rhs` = −r already forward-substituted.
pub(crate) fn complete<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let n = model.unknowns();
    if n == 0 {
        return;
    }
    let (Some(band), Some(rhs), Some(scaled)) = (
        work.factorisation.band.as_ref().get(..n),
        work.rhs.as_ref().get(..n),
        work.border.scaled.as_mut().get_mut(..n),
    ) else {
        return;
    };
    let flexibility = work.border.flexibility.as_mut();
    let right = work.border.row_rhs.as_mut().iter_mut().take(work.contacts.row_count);
    for (j, right) in right.enumerate() {
        let Some((below, column)) =
            work.border.columns.as_mut().get_mut(..(j + 1) * n).and_then(|all| all.split_at_mut_checked(j * n))
        else {
            return;
        };
        banded::forward(band, column);
        for ((scaled, &mut y), row) in scaled.iter_mut().zip(column.iter_mut()).zip(band) {
            *scaled = y * row[banded::BAND];
        }
        *right += product(scaled, rhs);
        for (k, other) in below.chunks_exact(n).chain([&*column]).enumerate() {
            let Some(entry) = flexibility.get_mut(j * S::CONTACTS + k) else { return };
            *entry += product(scaled, other);
            let value = *entry;
            if let Some(mirrored) = flexibility.get_mut(k * S::CONTACTS + j) {
                *mirrored = value;
            }
        }
    }
}

/// Completes the right-hand sides alone: the columns are those of the last factorisation.
pub(crate) fn complete_residuals<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let n = model.unknowns();
    let (band, rhs, scaled) = (
        work.factorisation.band.as_ref().run(0..n),
        work.rhs.as_ref().run(0..n),
        work.border.scaled.as_mut().run_mut(0..n),
    );
    for ((scaled, &y), row) in scaled.iter_mut().zip(rhs).zip(band) {
        *scaled = y * row[banded::BAND];
    }
    let columns = work.border.columns.as_ref().chunks_exact(n.max(1)).take(work.contacts.row_count);
    for (right, column) in work.border.row_rhs.as_mut().iter_mut().zip(columns) {
        *right += product(column, scaled);
    }
}
