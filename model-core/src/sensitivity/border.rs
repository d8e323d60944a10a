//! The border of a derivative: two rows per touching sample.
//!
//! A sample's gap row is the Newton step's, n·dP + ε_c dμ = n·v + …, with v the velocity of the object's point there. A
//! derivative must not leave out the contact curvature −μκ ttᵀ (t the tangent, κ the curvature of the object's level line):
//! the force turns with the normal by ν = μκ t·(dP − v). As a row, scaled by s = √(μ|κ|) so that flat faces need no case of
//! their own: s t·dP ∓ y = s t·v with ν = s y, the upper sign for κ > 0.

use super::quarter;
use crate::access::Access;
use crate::contact::Row;
use crate::ladder::Ladder;
use crate::newton::condense::Diagonal;
use crate::newton::{Workspace, active_set, gaps, step};
use crate::real::Real;
use crate::size::Size;

/// What changes, per unit of a parameter, finger frame.
#[derive(Clone, Copy)]
pub(super) struct Cause<T> {
    /// The object moves, mm.
    pub shift: [T; 2],
    /// It turns, rad, about a pivot.
    pub turn: T,
    pub pivot: [T; 2],
    /// Its surface grows outwards, mm.
    pub growth: T,
    /// The contact softness ε_c grows, mm/N.
    pub softening: T,
    /// Half the front beam's thickness grows, mm.
    pub thickening: T,
    /// The residuals shift as well: the rows' right-hand sides are those that the border was made with.
    pub residuals: bool,
}

impl<T: Real> Cause<T> {
    pub(super) const NONE: Self = Self {
        shift: [T::ZERO; 2],
        turn: T::ZERO,
        pivot: [T::ZERO; 2],
        growth: T::ZERO,
        softening: T::ZERO,
        thickening: T::ZERO,
        residuals: false,
    };

    /// Velocity of the object's point at p.
    fn velocity(&self, p: [T; 2]) -> [T; 2] {
        let arm = quarter([p[0] - self.pivot[0], p[1] - self.pivot[1]]);
        [self.shift[0] + self.turn * arm[0], self.shift[1] + self.turn * arm[1]]
    }
}

/// How the contacts answer, finger frame.
#[derive(Clone, Copy)]
pub(super) struct Response<T> {
    /// The object's turn that caused it.
    pub turn: T,
    /// Change of the force on the object, N.
    pub force_change: [T; 2],
    /// Change of the contacts' moment about the motor axis, N·mm.
    pub moment_change: T,
    /// Contact centre and its change, mm.
    pub centre: [T; 2],
    pub centre_change: [T; 2],
}

fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

fn cross<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

/// Makes two rows of each touching sample and notes where the samples are; returns how many touch, `None` if there is no
/// room. [`narrow`] is the way back.
pub(super) fn widen<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) -> Option<usize> {
    let touching = work.rows.as_ref().iter().take(work.row_count).filter(|row| row.multiplier > T::ZERO).count();
    if 2 * touching > S::CONTACTS {
        return None;
    }
    let mut kept = 0;
    for j in 0..work.row_count {
        let row = work.rows.as_ref().at(j);
        if row.multiplier > T::ZERO {
            work.rows.as_mut().put(kept, row);
            kept += 1;
        }
    }
    // A face whose radius is beyond this is flat for all the precision there is.
    let flat = T::EPSILON.sqrt();
    for j in (0..touching).rev() {
        let row = work.rows.as_ref().at(j);
        let position = gaps::sample_position(ladder, work, &ladder.samples.as_ref().at(usize::from(row.sample)));
        work.scratch.as_mut().put(2 * j, position.x);
        work.scratch.as_mut().put(2 * j + 1, position.y);
        let hollow = row.curvature < T::ZERO;
        let size = row.curvature.abs().max(flat);
        let scale = (row.multiplier * size).sqrt();
        let tangent = quarter(row.normal);
        work.rows.as_mut().put(2 * j, row);
        let turning = Row {
            normal: tangent.map(|x| scale * x),
            softness: if hollow { T::one() } else { -T::one() },
            curvature: if hollow { -size } else { size },
            gap: T::ZERO,
            multiplier: T::ZERO,
            ..row
        };
        work.rows.as_mut().put(2 * j + 1, turning);
    }
    work.row_count = 2 * touching;
    Some(touching)
}

/// The gap rows alone.
pub(super) fn narrow<T: Real, S: Size>(work: &mut Workspace<T, S>, touching: usize) {
    for j in 0..touching {
        let row = work.rows.as_ref().at(2 * j);
        work.rows.as_mut().put(j, row);
    }
    work.row_count = touching;
}

/// Factorises the KKT at the equilibrium and the dense border on all rows.
pub(super) fn factorise<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    step::factorise(ladder, work, Diagonal { curvature: T::one(), shift: T::ZERO });
    let (from, rows) = (work.flexibility.as_ref(), work.row_count);
    // The turning rows first: their block is the identity's with a sign and a little more, and what they leave of the gap rows'
    // is no worse than it was. The other way round the gap rows of neighbouring samples, which are almost the same, would spoil
    // the turning ones.
    let touching = rows / 2;
    let place = |i: usize| if i < touching { 2 * i + 1 } else { 2 * (i - touching) };
    active_set::factorise_from(from, work.factored.as_mut(), rows, S::CONTACTS, work.order.as_mut(), place);
}

/// Solves for the contacts' answer; `axis` is what the moment is taken about.
pub(super) fn respond<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    cause: &Cause<T>,
    axis: [T; 2],
) -> Response<T> {
    let count = work.row_count;
    for j in (0..count).step_by(2) {
        let (row, turning) = (work.rows.as_ref().at(j), work.rows.as_ref().at(j + 1));
        let v = cause.velocity([work.scratch.as_ref().at(j), work.scratch.as_ref().at(j + 1)]);
        let scale = dot(turning.normal, quarter(row.normal));
        let own =
            if cause.residuals { [work.row_rhs.as_ref().at(j), work.row_rhs.as_ref().at(j + 1)] } else { [T::ZERO; 2] };
        let grown = cause.growth + cause.thickening - cause.softening * row.multiplier;
        let delta = work.row_delta.as_mut();
        delta.put(j, own[0] + dot(row.normal, v) + grown);
        // The normals turn with the object: v at the centre of curvature.
        delta.put(j + 1, own[1] + dot(turning.normal, v) - scale * cause.turn / turning.curvature);
    }
    let (x, y) = (work.row_delta.as_mut(), work.spare.as_mut());
    active_set::solve(work.factored.as_ref(), count, S::CONTACTS, work.order.as_ref(), x, y);

    let zero = [T::ZERO; 2];
    let mut response =
        Response { turn: cause.turn, force_change: zero, moment_change: T::ZERO, centre: zero, centre_change: zero };
    let (mut total, mut total_change) = (T::ZERO, T::ZERO);
    for j in (0..count).step_by(2) {
        let (row, turning) = (work.rows.as_ref().at(j), work.rows.as_ref().at(j + 1));
        let half = ladder.samples.as_ref().at(usize::from(row.sample)).half_thickness;
        let p = [work.scratch.as_ref().at(j), work.scratch.as_ref().at(j + 1)];
        let (n, t) = (row.normal, quarter(row.normal));
        let change = work.row_delta.as_ref().at(j);
        // Of the normal, per unit; the force across it changes by μ times that.
        let tilt = dot(turning.normal, t) * work.row_delta.as_ref().at(j + 1) / row.multiplier;
        let v = cause.velocity(p);
        let along = (tilt - cause.turn) / turning.curvature + dot(t, v);
        let out =
            dot(n, v) + cause.growth + cause.thickening - cause.softening * row.multiplier - ladder.softness * change;
        let across = row.multiplier * tilt;
        let push = [change * n[0] + across * t[0], change * n[1] + across * t[1]];
        let moved = [out * n[0] + along * t[0], out * n[1] + along * t[1]];
        let arm = [p[0] - axis[0], p[1] - axis[1]];
        response.moment_change += row.multiplier * cross(moved, n) + cross(arm, push);
        for i in 0..2 {
            response.force_change[i] -= push[i];
            let surface = p[i] - half * n[i];
            let slid = moved[i] - cause.thickening * n[i] - half * tilt * t[i];
            response.centre[i] += row.multiplier * surface;
            response.centre_change[i] += change * surface + row.multiplier * slid;
        }
        total += row.multiplier;
        total_change += change;
    }
    let inverse = T::one() / total;
    for i in 0..2 {
        response.centre[i] *= inverse;
        response.centre_change[i] = inverse * (response.centre_change[i] - response.centre[i] * total_change);
    }
    response
}
