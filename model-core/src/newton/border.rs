//! The border: contact rows g_j + ε_c μ_j = 0 against joints, λ and each other.

use super::banded::{self, force_terms};
use super::condense::solve_interior;
use super::{Workspace, bend};
use crate::contact::Sample;
use crate::ladder::{CLAMPED, Ladder, PER_CELL};
use crate::real::Real;
use crate::size::{Blank, Size};

/// A row's entries with its own span, after condensation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Own<T> {
    /// With the span's force.
    pub x: [T; 2],
    /// Derivatives of the sample's position with respect to the angles of the three nodes of its element, mm.
    pub lever: [[T; 2]; 3],
}

impl<T: Real> Blank for Own<T> {
    const BLANK: Self = Self { x: [T::ZERO; 2], lever: [[T::ZERO; 2]; 3] };
}

#[inline]
fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// Weight of a node of its span in a sample's position, mm.
#[inline]
fn weight_at<T: Real, S: Size>(ladder: &Ladder<T, S>, sample: usize, node: usize) -> T {
    let sample = &ladder.samples.as_ref()[sample];
    let first = usize::from(sample.node);
    if node < first {
        ladder.weight.as_ref()[node]
    } else {
        sample.weights.get(node - first).copied().unwrap_or(T::ZERO)
    }
}

/// Derivative of a sample's position with respect to the angle of a node at or below its element, mm.
#[inline]
fn position_lever<T: Real>(lever: &[[T; 2]], sample: &Sample<T>, own: &Own<T>, node: usize) -> [T; 2] {
    let first = usize::from(sample.node);
    if node < first { lever[node] } else { own.lever.get(node - first).copied().unwrap_or([T::ZERO; 2]) }
}

/// n·C·m of a node with direction e: how the row m gives way under the row n by stretch and shear.
#[inline]
fn give<T: Real>(e: [T; 2], compliance: [T; 2], n: [T; 2], m: [T; 2]) -> T {
    let cross = |v: [T; 2]| v[1] * e[0] - v[0] * e[1];
    compliance[0] * dot(e, n) * dot(e, m) + compliance[1] * cross(n) * cross(m)
}

/// Fills columns Q, the right-hand sides of the rows and −Z, all condensed.
pub(crate) fn assemble<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let n = ladder.unknowns();
    let count = work.row_count;
    let samples = ladder.samples.as_ref();
    let mut span_start = 0;
    for j in 0..count {
        let row = work.rows.as_ref()[j];
        let sample_index = usize::from(row.sample);
        let sample = samples[sample_index];
        let cell = usize::from(sample.cell);
        let normal = row.normal;
        if j > 0 && samples[usize::from(work.rows.as_ref()[j - 1].sample)].cell != sample.cell {
            span_start = j;
        }
        let index = 4 * cell;
        let member = ladder.members.as_ref()[index];
        let nodes = member.nodes();
        let interior = usize::from(member.interior);
        let mut own = Own { x: [T::ZERO; 2], lever: bend::sample_lever(ladder, work, index, &sample) };
        let (e, lever) = (work.e.as_ref(), work.lever.as_ref());
        let strains = member.compliance[0] != T::ZERO;
        // Raw entries on the span: −w n·d′ with the angles, w C n with the force.
        let z = &mut work.delta.as_mut()[nodes.clone()];
        let reach = usize::from(sample.node) + 2;
        let mut ends = [T::ZERO; 2];
        for node in nodes.clone() {
            let w = if node <= reach { weight_at(ladder, sample_index, node) } else { T::ZERO };
            let local = node - nodes.start;
            let raw = if node <= reach { -dot(normal, position_lever(lever, &sample, &own, node)) } else { T::ZERO };
            if local == 0 {
                ends[0] = raw;
            } else if local == interior + 1 {
                ends[1] = raw;
            } else {
                z[local] = raw;
            }
            if strains && w != T::ZERO {
                let along = w * member.compliance[0] * dot(e[node], normal);
                let across = w * member.compliance[1] * (normal[1] * e[node][0] - normal[0] * e[node][1]);
                own.x[0] += along * e[node][0] - across * e[node][1];
                own.x[1] += along * e[node][1] + across * e[node][0];
            }
        }
        let m = &work.members.as_ref()[index];
        let turn = |r: [T; 2]| normal[1] * r[0] - normal[0] * r[1];
        ends[0] -= turn(m.rigid_start);
        ends[1] -= sample.rigid * turn(m.rigid_end);
        solve_interior(&work.factor.as_ref()[nodes.clone()], z, interior, T::ZERO);
        // Eliminate the interior: entries with a, b, force, gradient.
        let coupling = super::coupling(ladder, work.coupling.as_ref(), work.curved, index);
        let (mut a, mut b) = (ends[0], ends[1]);
        if interior >= 1 {
            a -= coupling[0][0] * z[1];
            b -= coupling[interior][0] * z[interior];
        }
        if interior >= 2 {
            a -= coupling[0][1] * z[2];
            b -= coupling[interior - 1][1] * z[interior - 1];
        }
        let weight = &ladder.weight.as_ref()[nodes.clone()];
        let gradient = &work.gradient.as_ref()[nodes.clone()];
        let mut residual = T::ZERO;
        for i in 1..=interior {
            let [x, y] = lever[nodes.start + i];
            own.x[0] -= z[i] * x;
            own.x[1] -= z[i] * y;
            residual -= gradient[i] * z[i];
        }
        let force = own.x;
        work.own.as_mut()[j] = own;

        // Rows on the same span, this one included.
        for k in span_start..=j {
            let other = work.rows.as_ref()[k];
            let other_sample = usize::from(other.sample);
            let mut sum = T::ZERO;
            let reach = usize::from(samples[other_sample].node) + 2;
            for i in 0..nodes.len() {
                let node = nodes.start + i;
                if node > reach {
                    break;
                }
                let w = weight_at(ladder, other_sample, node);
                if i >= 1 && i <= interior {
                    let (sample, own) = (&samples[other_sample], &work.own.as_ref()[k]);
                    sum -= dot(other.normal, position_lever(lever, sample, own, node)) * z[i];
                }
                if strains && weight[i] != T::ZERO {
                    let share = weight_at(ladder, sample_index, node) / weight[i];
                    sum += w * share * give(e[node], member.compliance, normal, other.normal);
                }
            }
            // −Z = c′ᵀ z + Σ w w′/l n·C·n′ with c′ = −w n·d′.
            work.flexibility.as_mut()[j * S::CONTACTS + k] = sum;
        }
        // Rows on lower spans see this one through their own span's force.
        for k in 0..span_start {
            work.flexibility.as_mut()[j * S::CONTACTS + k] = dot(work.own.as_ref()[k].x, normal);
        }
        let start = j * n;
        let column = &mut work.columns.as_mut()[start..start + n];
        column.fill(T::ZERO);
        if member.start != CLAMPED {
            column[usize::from(member.start)] += a;
        }
        column[usize::from(member.end)] += b;
        column[PER_CELL * cell] += force[0];
        column[PER_CELL * cell + 1] += force[1];
        // Spans below: the row pulls at their force.
        for lower in 0..cell {
            let member = &ladder.members.as_ref()[4 * lower];
            let c = &work.fronts.as_ref()[lower];
            let (terms, _) = force_terms::<T>(4 * lower);
            let u = terms[0].0;
            let xn = [c.xx * normal[0] + c.xy * normal[1], c.xy * normal[0] + c.yy * normal[1]];
            if member.start != CLAMPED {
                column[usize::from(member.start)] -= dot(c.ax, normal);
            }
            column[usize::from(member.end)] -= dot(c.bx, normal);
            column[u] -= xn[0];
            column[u + 1] -= xn[1];
            residual -= dot(c.rx, normal);
            // Z: nᵀ XX n′ for every row at or below this one that lies above span `lower`.
            for k in 0..=j {
                let other = work.rows.as_ref()[k];
                if usize::from(samples[usize::from(other.sample)].cell) > lower {
                    work.flexibility.as_mut()[j * S::CONTACTS + k] -= dot(xn, other.normal);
                }
            }
        }
        work.flexibility.as_mut()[j * S::CONTACTS + j] += row.softness;
        work.row_rhs.as_mut()[j] = -row.gap - row.softness * row.multiplier + residual;
    }
}

/// Forward-substitutes the columns and completes D and the right-hand sides:
/// D = −Z + Qᵀ KKT⁻¹ Q, b = r_μ − Qᵀ KKT⁻¹ r with `rhs` = −r already forward-substituted.
pub(crate) fn complete<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let n = ladder.unknowns();
    let band = &work.band.as_ref()[..n];
    let columns = work.columns.as_mut();
    for j in 0..work.row_count {
        banded::forward(band, &mut columns[j * n..(j + 1) * n]);
    }
    let scaled = &mut work.scaled.as_mut()[..n];
    for j in 0..work.row_count {
        for ((scaled, &y), row) in scaled.iter_mut().zip(&columns[j * n..(j + 1) * n]).zip(band) {
            *scaled = y * row[banded::BAND];
        }
        let dot = |other: &[T]| scaled.iter().zip(other).fold(T::ZERO, |sum, (&a, &b)| sum + a * b);
        work.row_rhs.as_mut()[j] += dot(&work.rhs.as_ref()[..n]);
        for k in 0..=j {
            let entry = work.flexibility.as_ref()[j * S::CONTACTS + k] + dot(&columns[k * n..(k + 1) * n]);
            work.flexibility.as_mut()[j * S::CONTACTS + k] = entry;
            work.flexibility.as_mut()[k * S::CONTACTS + j] = entry;
        }
    }
}
