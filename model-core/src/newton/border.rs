//! The border: contact rows g_j + ε_c μ_j = 0 against joints, λ and each other.

use super::banded;
use super::condense::solve_interior;
use super::{Workspace, bend};
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
    /// Σ w C n: how the span's stretch and shear under the row move the sample, mm/N.
    pub strain: [T; 2],
}

impl<T: Real> Blank for Own<T> {
    const BLANK: Self = Self { x: [T::ZERO; 2], lever: [[T::ZERO; 2]; 3], strain: [T::ZERO; 2] };
}

#[inline]
fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
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
        let sample = samples[usize::from(row.sample)];
        let cell = usize::from(sample.cell);
        let normal = row.normal;
        if j > 0 && samples[usize::from(work.rows.as_ref()[j - 1].sample)].cell != sample.cell {
            span_start = j;
        }
        let index = 4 * cell;
        let member = ladder.members.as_ref()[index];
        let nodes = member.nodes();
        let interior = usize::from(member.interior);
        let mut own = Own { lever: bend::sample_lever(ladder, work, index, &sample), ..Own::BLANK };
        // Raw entries on the span: −n·∂P with the angles, w C n with the force; nothing beyond the sample's element.
        let first = usize::from(sample.node).saturating_sub(nodes.start).min(nodes.len());
        let z = &mut work.delta.as_mut()[nodes.clone()];
        let mut tensor = [T::ZERO; 3];
        let mut weigh = |w: T, e: [T; 2]| {
            tensor = [tensor[0] + w * e[0] * e[0], tensor[1] + w * e[0] * e[1], tensor[2] + w];
        };
        let (e, lever) = (&work.e.as_ref()[nodes.clone()], &work.lever.as_ref()[nodes.clone()]);
        let weight = &ladder.weight.as_ref()[nodes.clone()];
        for (((z, lever), &e), &w) in z[..first].iter_mut().zip(lever).zip(e).zip(weight) {
            *z = -dot(normal, *lever);
            weigh(w, e);
        }
        let (_, beyond) = z.split_at_mut(first);
        for z in beyond.iter_mut() {
            *z = T::ZERO;
        }
        for (((z, &e), lever), &w) in beyond.iter_mut().zip(&e[first..]).zip(&own.lever).zip(&sample.weights) {
            *z = -dot(normal, *lever);
            weigh(w, e);
        }
        let ([stretch, shear], [xx, xy, all]) = (member.compliance, tensor);
        let (k, yy) = (stretch - shear, all - xx);
        own.strain = [
            k * (xx * normal[0] + xy * normal[1]) + shear * all * normal[0],
            k * (xy * normal[0] + yy * normal[1]) + shear * all * normal[1],
        ];
        own.x = own.strain;
        let mut ends = [z[0], z[interior + 1]];
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
        let gradient = &work.gradient.as_ref()[nodes.clone()];
        let mut residual = T::ZERO;
        for i in 1..=interior {
            let [x, y] = lever[i];
            own.x[0] -= z[i] * x;
            own.x[1] -= z[i] * y;
            residual -= gradient[i] * z[i];
        }
        let force = own.x;
        work.own.as_mut()[j] = own;

        // Rows on the same span, this one included: −Z = −Σ n′·∂P′ z + Σ w w′/l n·C·n′.
        let mut swept = [T::ZERO; 2];
        let mut at = 1;
        for k in span_start..=j {
            let other = &work.rows.as_ref()[k];
            let (lower, own) = (&samples[usize::from(other.sample)], &work.own.as_ref()[k]);
            let start = usize::from(lower.node).saturating_sub(nodes.start);
            while at < start.min(interior + 1) {
                swept = [swept[0] + lever[at][0] * z[at], swept[1] + lever[at][1] * z[at]];
                at += 1;
            }
            let mut sum = dot(normal, own.strain) - dot(other.normal, swept);
            for (t, (&lever, &w)) in own.lever.iter().zip(&lower.weights).enumerate() {
                let node = start + t;
                if (1..=interior).contains(&node) {
                    sum -= dot(other.normal, lever) * z[node];
                }
                // A node that this row's sample has in part only.
                if node >= first && node < nodes.len() && w != T::ZERO {
                    let part = sample.weights.get(node - first).copied().unwrap_or(T::ZERO);
                    let missing = part / weight[node] - T::one();
                    sum += w * missing * give(e[node], member.compliance, normal, other.normal);
                }
            }
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
        let mut next = 0;
        let mut below = [T::ZERO; 2];
        for lower in 0..=cell {
            // Z: nᵀ XX n′ of every span below both rows, for those rows up to this one that lie on this span.
            while next <= j {
                let other = &work.rows.as_ref()[next];
                if usize::from(samples[usize::from(other.sample)].cell) != lower {
                    break;
                }
                work.flexibility.as_mut()[j * S::CONTACTS + next] -= dot(below, other.normal);
                next += 1;
            }
            if lower == cell {
                break;
            }
            let member = &ladder.members.as_ref()[4 * lower];
            let c = &work.fronts.as_ref()[lower];
            let xn = [c.xx * normal[0] + c.xy * normal[1], c.xy * normal[0] + c.yy * normal[1]];
            below = [below[0] + xn[0], below[1] + xn[1]];
            if member.start != CLAMPED {
                column[usize::from(member.start)] -= dot(c.ax, normal);
            }
            column[usize::from(member.end)] -= dot(c.bx, normal);
            column[PER_CELL * lower] -= xn[0];
            column[PER_CELL * lower + 1] -= xn[1];
            residual -= dot(c.rx, normal);
        }
        work.flexibility.as_mut()[j * S::CONTACTS + j] += row.softness;
        work.row_rhs.as_mut()[j] = -row.gap - row.softness * row.multiplier + residual;
    }
}

/// Forward-substitutes the columns and completes D and the right-hand sides:
/// D = −Z + Qᵀ KKT⁻¹ Q, b = r_μ − Qᵀ KKT⁻¹ r with `rhs` = −r already forward-substituted.
pub(crate) fn complete<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let n = ladder.unknowns();
    let (Some(band), Some(rhs), Some(scaled)) =
        (work.band.as_ref().get(..n), work.rhs.as_ref().get(..n), work.scaled.as_mut().get_mut(..n))
    else {
        return;
    };
    let flexibility = work.flexibility.as_mut();
    let right = work.row_rhs.as_mut().iter_mut().take(work.row_count);
    for (j, right) in right.enumerate() {
        let Some((below, column)) =
            work.columns.as_mut().get_mut(..(j + 1) * n).and_then(|all| all.split_at_mut_checked(j * n))
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

/// Σ aᵢ bᵢ, in order.
#[inline]
fn product<T: Real>(a: &[T], b: &[T]) -> T {
    let ((a, a_left), (b, b_left)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let four = |sum: T, (a, b): (&[T; 4], &[T; 4])| sum + a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    let sum = a.iter().zip(b).fold(T::ZERO, four);
    a_left.iter().zip(b_left).fold(sum, |sum, (&a, &b)| sum + a * b)
}
