//! The border of a derivative: two rows per touching sample, as long as there is room.
//!
//! A sample's gap row is the Newton step's, n·dP + ε_c dμ = n·v + …, with v the velocity of the object's point there. A
//! derivative must not leave out the contact curvature −μκ ttᵀ (t the tangent, κ the curvature of the object's level line):
//! the force turns with the normal by ν = μκ t·(dP − v). As a row, scaled by s = √(μ|κ|) so that flat faces need no case of
//! their own: s t·dP ∓ y = s t·v with ν = s y, the upper sign for κ > 0.
//!
//! Where there is no room for two rows each, runs of neighbours share a turning row, with the sum of their μκ: they move alike
//! along the object, as in the Newton step (`newton::turning`).

use core::ops::Range;

use super::quarter;
use crate::access::Access;
use crate::contact::{Direction, Row};
use crate::equilibrium::Parts;
use crate::linear::symmetric;
use crate::model::Model;
use crate::newton::condense::Diagonal;
use crate::newton::end_gaps;
use crate::newton::{Evaluated, Hessian, Workspace};
use crate::real::Real;
use crate::size::Size;
use crate::state::State;

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

/// Turning rows where there is no room for one per sample: more make it more expensive than a Newton step and no more exact.
pub(super) const FEW: usize = 4;

/// Where the rows are: those of the gaps, base to tip, and behind the middle one of each run of neighbours the run's turning row.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    /// Touching samples, and runs of them: one per sample, or a few.
    pub touching: usize,
    runs: usize,
}

impl Layout {
    /// `None` if there is no room for a single turning row.
    fn new(touching: usize, capacity: usize, most: usize) -> Option<Self> {
        let room = capacity.checked_sub(touching)?;
        let runs = if room >= touching { touching.min(most) } else { room.min(FEW) };
        (runs > 0).then_some(Self { touching, runs })
    }

    pub(super) fn rows(self) -> usize {
        self.touching + self.runs
    }

    /// How far the rows of a factor are apart.
    fn stride<S: Size>(self) -> usize {
        S::stride(self.rows())
    }

    /// The samples of a run.
    fn run(self, run: usize) -> Range<usize> {
        let first = |run: usize| (run * self.touching).checked_div(self.runs).unwrap_or(0);
        first(run)..first(run + 1)
    }

    /// The sample of a run that its turning row belongs to.
    fn leader(self, run: usize) -> usize {
        let Range { start, end } = self.run(run);
        (start + end.max(1) - 1) / 2
    }

    fn turning(self, run: usize) -> usize {
        self.leader(run) + run + 1
    }

    /// The gap rows of a run.
    fn gaps(self, run: usize) -> impl DoubleEndedIterator<Item = usize> + ExactSizeIterator {
        let leader = self.leader(run);
        self.run(run).map(move |sample| sample + run + usize::from(sample > leader))
    }

    /// Every sample has a turning row of its own.
    pub(super) fn is_whole(self) -> bool {
        self.runs == self.touching
    }

    /// All gap rows.
    pub(super) fn all_gaps(self) -> impl Iterator<Item = usize> {
        (0..self.runs).flat_map(move |run| self.gaps(run))
    }

    /// Room is left for the samples' positions.
    fn notes_positions<S: Size>(self) -> bool {
        2 * self.touching <= S::CONTACTS
    }
}

/// Gives the touching samples their turning rows, at most so many, and notes where the samples are; `None` if there is no room. [`narrow`] undoes
/// it.
pub(super) fn widen<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>, most: usize) -> Option<Layout> {
    let touching = work.contacts.rows().iter().filter(|row| row.touches()).count();
    let layout = Layout::new(touching, S::CONTACTS, most)?;
    let mut kept = 0;
    for j in 0..work.contacts.count {
        let row = work.contacts.rows.as_ref().at(j);
        if row.touches() {
            work.contacts.rows.as_mut().put(kept, row);
            kept += 1;
        }
    }
    if layout.notes_positions::<S>() {
        for j in 0..touching {
            let position = position(model, work, &work.contacts.rows.as_ref().at(j));
            work.solution.scratch.as_mut().put(2 * j, position[0]);
            work.solution.scratch.as_mut().put(2 * j + 1, position[1]);
        }
    }
    for run in (0..layout.runs).rev() {
        let (samples, leader) = (layout.run(run), layout.leader(run));
        let (mut whole, mut bent) = (T::ZERO, T::ZERO);
        for row in work.contacts.rows.as_ref().run(samples.clone()) {
            whole += row.multiplier;
            bent += row.multiplier * row.curvature;
        }
        // From the last one, so that no row is overwritten before it has moved.
        for (sample, place) in samples.zip(layout.gaps(run)).rev() {
            let row = work.contacts.rows.as_ref().at(sample);
            work.contacts.rows.as_mut().put(place, row);
            if sample == leader {
                work.contacts.rows.as_mut().put(place + 1, turning(row, whole, bent / whole));
            }
        }
    }
    work.contacts.count = layout.rows();
    Some(layout)
}

/// The turning row behind a gap row, for a run's force and mean curvature.
fn turning<T: Real>(leader: Row<T>, force: T, curvature: T) -> Row<T> {
    // A face whose radius is beyond this is flat for all the precision there is.
    let flat = T::EPSILON.sqrt();
    let hollow = curvature < T::ZERO;
    let size = curvature.abs().max(flat);
    let scale = (force * size).sqrt();
    Row {
        direction: Direction::Turning,
        normal: quarter(leader.normal).map(|x| scale * x),
        softness: if hollow { T::one() } else { -T::one() },
        curvature: if hollow { -size } else { size },
        gap: T::ZERO,
        multiplier: T::ZERO,
        ..leader
    }
}

/// Where a row's sample is, finger frame, mm.
fn position<T: Real, S: Size>(model: &Model<T, S>, work: &Workspace<T, S>, row: &Row<T>) -> [T; 2] {
    let position = work.kinematics.position(model, &row.place);
    [position.x, position.y]
}

/// The gap rows alone.
pub(super) fn narrow<T: Real, S: Size>(work: &mut Workspace<T, S>, layout: Layout) {
    for (j, place) in layout.all_gaps().enumerate() {
        let row = work.contacts.rows.as_ref().at(place);
        work.contacts.rows.as_mut().put(j, row);
    }
    work.contacts.count = layout.touching;
}

/// Factorises the KKT at the equilibrium and the dense border on all rows.
pub(super) fn factorise<T: Real, S: Size>(parts: &mut Parts<'_, T, S>, layout: Layout) {
    end_gaps::soften_all(parts.model, &mut parts.work.kinematics);
    parts.work.factorise(parts.model, parts.factored, Diagonal::of(Hessian::Newton, T::ZERO));
    settle(parts, layout);
}

/// As [`factorise`] with the factorised KKT of the last step.
pub(super) fn keep<T: Real, S: Size>(parts: &mut Parts<'_, T, S>, layout: Layout) {
    parts.work.border(parts.model, parts.factored);
    settle(parts, layout);
}

/// Factorises the dense border.
fn settle<T: Real, S: Size>(Parts { work, factored, .. }: &mut Parts<'_, T, S>, layout: Layout) {
    // The turning rows first: their block is the identity's with a sign and a little more, and what they leave of the gap rows'
    // is no worse than it was. The other way round the gap rows of neighbouring samples, which are almost the same, would spoil
    // the turning ones.
    let turnings = (0..layout.runs).map(|run| layout.turning(run));
    for (place, row) in work.solution.listed.as_mut().iter_mut().zip(turnings.chain(layout.all_gaps())) {
        *place = row as u16;
    }
    let stride = layout.stride::<S>();
    // A heap has the room.
    let _ = work.solution.fit_rows(stride);
    let (from, rows, listed) =
        (factored.border.flexibility.as_ref(), work.contacts.count, work.solution.listed.as_ref());
    let place = |i: usize| usize::from(listed.at(i));
    symmetric::factorise_from(from, work.solution.factored.as_mut(), rows, stride, work.solution.order.as_mut(), place);
}

/// Solves for the change of the state, per unit of a parameter, where the residuals in the workspace are their own derivatives: into
/// `velocity`. Every sample must have its own turning row.
pub(super) fn velocity<T: Real, S: Size>(
    Parts { model, work, factored }: &mut Parts<'_, T, S>,
    layout: Layout,
    velocity: &mut State<T, S>,
) {
    let Workspace { kinematics, contacts, right, solution, increment, .. } = &mut **work;
    for (into, &row) in solution.delta.as_mut().iter_mut().zip(right.rows.as_ref()).take(layout.rows()) {
        *into = row;
    }
    let (x, y) = (solution.delta.as_mut(), solution.spare.as_mut());
    symmetric::solve(solution.factored.as_ref(), layout.rows(), layout.stride::<S>(), solution.order.as_ref(), x, y);
    let delta = solution.delta.as_ref();
    increment.find(Evaluated { model, kinematics, contacts }, &factored.kkt, &factored.border, right, delta);
    for (into, &angle) in velocity.angle.as_mut().iter_mut().zip(increment.angle.as_ref()).take(model.node_count) {
        *into = angle;
    }
    for (into, closure) in velocity.lambda.as_mut().iter_mut().zip(model.topology.closures()) {
        let (x, joints) = (usize::from(closure.unknown), increment.joints.as_ref());
        *into = [joints.at(x), joints.at(x + 1)];
    }
    for (sample, gap) in layout.all_gaps().enumerate() {
        let (row, turning) = (contacts.rows.as_ref().at(gap), contacts.rows.as_ref().at(gap + 1));
        let t = quarter(row.normal);
        let tilt = dot(turning.normal, t) * delta.at(gap + 1) / row.multiplier;
        velocity.multiplier.as_mut().put(sample, delta.at(gap));
        velocity.normal.as_mut().put(sample, t.map(|x| tilt * x));
    }
}

/// Solves for the contacts' answer; `axis` is what the moment is taken about, `thickening` how much a sample's distance from the
/// beam's surface grows (in units of length, unlike `cause` and `axis`).
pub(super) fn respond<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    layout: Layout,
    cause: &Cause<T>,
    thickening: impl Fn(u16) -> T,
    axis: [T; 2],
) -> Response<T> {
    let units = model.units;
    let inverse = T::one() / units.length;
    let scaled = |v: [T; 2]| v.map(|x| x * inverse);
    let cause = Cause {
        shift: scaled(cause.shift),
        pivot: scaled(cause.pivot),
        growth: cause.growth * inverse,
        softening: cause.softening * units.force * inverse,
        ..*cause
    };
    let response = respond_scaled(model, work, layout, &cause, thickening, scaled(axis));
    Response {
        turn: response.turn,
        force_change: units.newtons(response.force_change),
        moment_change: response.moment_change * units.moment(),
        centre: units.millimetres(response.centre),
        centre_change: units.millimetres(response.centre_change),
    }
}

/// As [`respond`], all in the finger's units.
#[inline(never)]
fn respond_scaled<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    layout: Layout,
    cause: &Cause<T>,
    thickening: impl Fn(u16) -> T,
    axis: [T; 2],
) -> Response<T> {
    let noted = layout.notes_positions::<S>();
    let place = |work: &Workspace<T, S>, sample: usize, row: &Row<T>| {
        let noted = noted.then(|| {
            [work.solution.scratch.as_ref().at(2 * sample), work.solution.scratch.as_ref().at(2 * sample + 1)]
        });
        noted.unwrap_or_else(|| position(model, work, row))
    };
    let grown = |row: &Row<T>| cause.growth + thickening(row.sample) - cause.softening * row.multiplier;
    for run in 0..layout.runs {
        let at = layout.turning(run);
        let (leader, turning) = (layout.leader(run), work.contacts.rows.as_ref().at(at));
        for (sample, j) in layout.run(run).zip(layout.gaps(run)) {
            let row = work.contacts.rows.as_ref().at(j);
            let v = cause.velocity(place(work, sample, &row));
            let own = |j: usize| if cause.residuals { work.right.rows.as_ref().at(j) } else { T::ZERO };
            let (own, own_turning) = (own(j), own(at));
            work.solution.delta.as_mut().put(j, own + dot(row.normal, v) + grown(&row));
            if sample == leader {
                let scale = dot(turning.normal, quarter(row.normal));
                // The normals turn with the object: v at the centre of curvature.
                let turned = own_turning + dot(turning.normal, v) - scale * cause.turn / turning.curvature;
                work.solution.delta.as_mut().put(at, turned);
            }
        }
    }
    let (x, y) = (work.solution.delta.as_mut(), work.solution.spare.as_mut());
    symmetric::solve(
        work.solution.factored.as_ref(),
        layout.rows(),
        layout.stride::<S>(),
        work.solution.order.as_ref(),
        x,
        y,
    );

    let zero = [T::ZERO; 2];
    let mut response =
        Response { turn: cause.turn, force_change: zero, moment_change: T::ZERO, centre: zero, centre_change: zero };
    let (mut total, mut total_change) = (T::ZERO, T::ZERO);
    for run in 0..layout.runs {
        let at = layout.turning(run);
        let turning = work.contacts.rows.as_ref().at(at);
        let whole = layout.gaps(run).fold(T::ZERO, |sum, j| sum + work.contacts.rows.as_ref().at(j).multiplier);
        // Of the normals, per unit; the force across them changes by μ times that.
        let tilt = dot(turning.normal, quarter(work.contacts.rows.as_ref().at(at - 1).normal))
            * work.solution.delta.as_ref().at(at)
            / whole;
        for (sample, j) in layout.run(run).zip(layout.gaps(run)) {
            let row = work.contacts.rows.as_ref().at(j);
            let half = row.place.half_thickness;
            let p = place(work, sample, &row);
            let (n, t) = (row.normal, quarter(row.normal));
            let change = work.solution.delta.as_ref().at(j);
            let v = cause.velocity(p);
            let along = (tilt - cause.turn) / turning.curvature + dot(t, v);
            let out = dot(n, v) + grown(&row) - model.contact_softness() * change;
            let across = row.multiplier * tilt;
            let push = [change * n[0] + across * t[0], change * n[1] + across * t[1]];
            let moved = [out * n[0] + along * t[0], out * n[1] + along * t[1]];
            let arm = [p[0] - axis[0], p[1] - axis[1]];
            response.moment_change += row.multiplier * cross(moved, n) + cross(arm, push);
            for i in 0..2 {
                response.force_change[i] -= push[i];
                let surface = p[i] - half * n[i];
                let slid = moved[i] - thickening(row.sample) * n[i] - half * tilt * t[i];
                response.centre[i] += row.multiplier * surface;
                response.centre_change[i] += change * surface + row.multiplier * slid;
            }
            total += row.multiplier;
            total_change += change;
        }
    }
    let inverse = T::one() / total;
    for i in 0..2 {
        response.centre[i] *= inverse;
        response.centre_change[i] = inverse * (response.centre_change[i] - response.centre[i] * total_change);
    }
    response
}
