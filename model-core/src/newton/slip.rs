//! Slip of the samples that touch: what friction remembers, and the tangent rows that it adds to the border.
//!
//! Samples are material points of the beam, so that no anchor is carried along: each keeps its tangential force τ⁰ at the last accepted
//! state, and the beam's accepted pose says where it was. Since then the beam's surface has slipped over the object by
//!
//! > d = t·[P − Φ(P⁰)] + ½h (Δθ − Δα),
//!
//! with t the tangent towards the tip, Φ the object's motion in the finger's frame, Δα its turn, and θ the orientation of the section.
//! A tangent row is d + ε_t (τ − τ⁰) for a sample that sticks. Its force acts on the beam's surface, ½h beside the centreline: the
//! beam is pulled by τ t and turned by ½h τ.

use super::gaps::Contacts;
use super::kinematics::{Kinematics, position};
use crate::access::Access;
use crate::contact::coulomb::Law;
use crate::contact::{ContactState, Direction, Row, Sample, own_rows};
use crate::model::{Model, vec2_of};
use crate::object::Displacement;
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size, Storage};
use crate::state::State;
use crate::topology::Kind;

/// The coefficient of friction, and the accepted state as friction remembers it.
pub(crate) struct Slip<T: Real, S: Size> {
    /// Coefficient of friction m; 0 for none.
    pub coefficient: T,
    /// It is left out for now, on the way to a place whose past is unknown.
    pub is_idle: bool,
    /// How everything that touches slips, whatever the past; [`ContactState::Open`] if the past decides.
    pub forced: ContactState,
    /// Angles, strained directions, starts and rigid ends of the front spans.
    angle: S::SlipNodes<T>,
    strained: S::SlipNodes<[T; 2]>,
    start: S::SlipCells<[T; 2]>,
    rigid_end: S::SlipCells<[T; 2]>,
    /// What touched, and its tangential force τ⁰.
    touching: S::SlipContacts<u16>,
    tangential: S::SlipContacts<T>,
    count: u16,
    /// The object's motion since, in the finger's frame: 1 − cosine and sine of its turn, shift, and the turn itself, rad.
    rotation: [T; 2],
    shift: [T; 2],
    turned: T,
    /// Energy that friction has dissipated since the path began.
    pub dissipated: T,
}

/// What [`Slip::mark`] leaves with its caller.
pub(crate) struct Rubbed<T> {
    count: u16,
    dissipated: T,
}

impl<T: Real, S: Size> Slip<T, S> {
    pub(crate) const EMPTY: Self = Self {
        coefficient: T::ZERO,
        is_idle: false,
        forced: ContactState::Open,
        angle: <S::SlipNodes<T> as Storage<T>>::EMPTY,
        strained: <S::SlipNodes<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        start: <S::SlipCells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        rigid_end: <S::SlipCells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        touching: <S::SlipContacts<u16> as Storage<u16>>::EMPTY,
        tangential: <S::SlipContacts<T> as Storage<T>>::EMPTY,
        count: 0,
        rotation: [T::ZERO; 2],
        shift: [T::ZERO; 2],
        turned: T::ZERO,
        dissipated: T::ZERO,
    };

    /// Makes room for a model; false if there is none. Where no friction has room nothing is needed.
    pub(crate) fn fit(&mut self, model: &Model<T, S>) -> bool {
        !S::RUBS
            || self.angle.fit(model.node_count)
                && self.strained.fit(model.node_count)
                && self.start.fit(model.cells())
                && self.rigid_end.fit(model.cells())
                && self.touching.fit(S::CONTACTS)
                && self.tangential.fit(S::CONTACTS)
    }

    /// What the contacts obey.
    pub(crate) fn law(&self) -> Law<T> {
        Law { coefficient: self.coefficient, forced: self.forced, is_bounded: false }
    }

    /// Everything that touches slips one way.
    pub(crate) fn is_forced(&self) -> bool {
        self.forced != ContactState::Open
    }

    /// There is friction between finger and object, whether it is left out for now or not.
    #[inline(always)]
    pub(crate) fn is_given(&self) -> bool {
        S::RUBS && self.coefficient > T::ZERO
    }

    /// Friction acts.
    #[inline(always)]
    pub(crate) fn rubs(&self) -> bool {
        self.is_given() && !self.is_idle
    }

    /// Samples that find room among the rows.
    #[inline(always)]
    pub(crate) fn room(&self) -> usize {
        if self.is_given() { (S::CONTACTS - 1) / 2 } else { S::CONTACTS }
    }

    /// The object has moved in the finger's frame since the last accepted state: a displacement in mm that turns it by an angle, rad.
    pub(crate) fn aim(&mut self, by: &Displacement<T>, turned: T, length: T) {
        self.rotation = [by.back(), by.rotation.y];
        self.shift = [by.translation.x / length, by.translation.y / length];
        self.turned = turned;
    }

    /// Expresses its forces in another unit, which the old one is `part` of.
    pub(crate) fn express(&mut self, part: T) {
        self.tangential.as_mut().iter_mut().take(usize::from(self.count)).for_each(|force| *force *= part);
        self.dissipated *= part;
    }

    /// By how much a sample at a position has left where it would be, had it stuck to the object since the accepted state. Of the object's
    /// motion only what it moves by is subtracted: places would leave their rounding in every step.
    fn left(&self, model: &Model<T, S>, sample: &Sample<T>, now: Vec2<T>) -> Vec2<T> {
        let cell = usize::from(sample.cell);
        let ends = [self.start.as_ref().at(cell), self.rigid_end.as_ref().at(cell)];
        let then = position(model, sample, ends, self.strained.as_ref(), |&strained| strained);
        let [back, s] = self.rotation;
        let carried = Vec2::new(-(back * then.x + s * then.y), s * then.x - back * then.y) + vec2_of(self.shift);
        (now - then) - carried
    }

    /// Tangential force τ⁰ of a place in the accepted state; zero if it did not touch.
    fn before(&self, sample: u16) -> T {
        let mut touching = self.touching.as_ref().iter().zip(self.tangential.as_ref()).take(usize::from(self.count));
        touching.find(|(place, _)| **place == sample).map_or(T::ZERO, |(_, &tangential)| tangential)
    }

    /// Σ|τ| of what did not touch in the accepted state, as a part of Σμ: its slip counts from there, with the way before it touched.
    #[inline(never)]
    pub(crate) fn doubtful(&self, rows: &[Row<T>]) -> T {
        let touched = self.touching.as_ref().get(..usize::from(self.count)).unwrap_or(&[]);
        let (mut new, mut all) = (T::ZERO, T::ZERO);
        for [tangent, normal] in rows.as_chunks::<2>().0 {
            all += normal.multiplier;
            if !touched.contains(&tangent.sample) {
                new += tangent.multiplier.abs();
            }
        }
        if all > T::ZERO { new / all } else { T::ZERO }
    }
}

/// Tangent towards the tip of a normal out of the object.
#[inline(always)]
pub(crate) fn towards_tip<T: Real>([x, y]: [T; 2]) -> [T; 2] {
    [y, -x]
}

/// Derivatives of the slip with respect to the angles of the section where a place is: three nodes, from the one returned on, mm.
pub(crate) fn arms<T: Real, S: Size>(model: &Model<T, S>, row: &Row<T>) -> (usize, [T; 3]) {
    let (index, node, half) = (usize::from(row.sample), usize::from(row.place.node), row.place.half_thickness);
    let fineness = model.fineness.max(1);
    let (at, step) = (index / fineness, index % fineness + 1);
    if row.place.rigid != T::ZERO {
        // On a rigid part, which turns with the joint at its span's end.
        return (node.saturating_sub(1), [half, T::ZERO, T::ZERO]);
    }
    let xi = model.within_element(at, usize::from(row.place.cell), T::of(step as f64) / T::of(fineness as f64));
    let kind = model.member(usize::from(row.place.cell)).map_or(Kind::Link, |front| front.kind);
    let (from, shares) = kind.turns(&row.place, xi);
    (node + from, shares.map(|share| half * share))
}

/// Adds to a tangent row's levers what its place turns by: along the tangent, as it slips by ½h Δθ. On the wedge, which has none, nothing.
pub(crate) fn lengthen<T: Real, S: Size>(model: &Model<T, S>, row: &Row<T>, levers: &mut [[T; 2]; 3]) {
    let (node, arms) = arms(model, row);
    let Some(from) = node.checked_sub(usize::from(row.place.node)) else { return };
    for (lever, arm) in levers.iter_mut().skip(from).zip(arms) {
        *lever = [lever[0] + arm * row.normal[0], lever[1] + arm * row.normal[1]];
    }
}

/// Softness ε_t = h/(E w ℓ) of a sample along the object: a layer of the beam one thickness deep, as long as the way between samples.
///
/// It lets what sticks reach its cone gradually, and decides where a reversal begins to slip: with less, Σ|τ| changes too early within a
/// reversal; with more, the force lags (`friction.csv`, finite elements).
fn softness<T: Real, S: Size>(model: &Model<T, S>, row: &Row<T>) -> T {
    let way = model.way_to(usize::from(row.sample) / model.fineness.max(1)) * T::of(f64::from(model.every.max(1)));
    let half = row.place.half_thickness;
    if way > T::ZERO { model.softness[1] * (half + half) / way } else { model.softness[1] }
}

impl<T: Real, S: Size> Slip<T, S> {
    /// Gives every row its tangent, which comes before it: those that touch with the state's tangential forces.
    pub(crate) fn pair(&self, model: &Model<T, S>, state: &State<T, S>, contacts: &mut Contacts<T, S>) {
        let count = contacts.count;
        let mut touching = contacts.rows().iter().filter(|row| row.touches()).count();
        let rows = contacts.rows.as_mut();
        // From the last one, so that no row is overwritten before it has moved.
        for j in (0..count).rev() {
            let row = rows.at(j);
            let (mut slips, mut multiplier) = (ContactState::Open, T::ZERO);
            if row.touches() {
                touching -= 1;
                slips = if self.is_forced() { self.forced } else { state.slips.as_ref().at(touching) };
                multiplier = match slips {
                    ContactState::SlipUp => self.coefficient * row.multiplier,
                    ContactState::SlipDown => -(self.coefficient * row.multiplier),
                    _ => state.tangential.as_ref().at(touching),
                };
            }
            let tangent = Row {
                direction: Direction::Tangent,
                state: slips,
                normal: towards_tip(row.normal),
                gap: T::ZERO,
                tilt: T::ZERO,
                curvature: T::ZERO,
                softness: softness(model, &row),
                multiplier,
                ..row
            };
            rows.put(2 * j + 1, row);
            rows.put(2 * j, tangent);
        }
        contacts.count = 2 * count;
    }

    /// Measures how far the samples have slipped, along the present normals' tangents: a tangent row's gap is d − ε_t τ⁰.
    pub(crate) fn measure(
        &self,
        model: &Model<T, S>,
        state: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        contacts: &mut Contacts<T, S>,
    ) {
        redirect(contacts.rows_mut());
        for row in contacts.rows_mut().iter_mut().filter(|row| row.direction == Direction::Tangent) {
            row.gap = self.slipped(model, state, kinematics, row);
        }
    }

    /// d − ε_t τ⁰ of a tangent row.
    #[inline(never)]
    fn slipped(&self, model: &Model<T, S>, state: &State<T, S>, kinematics: &Kinematics<T, S>, row: &Row<T>) -> T {
        let moved = self.left(model, &row.place, kinematics.position(model, &row.place));
        let (node, arms) = arms(model, row);
        let mut turned = -(row.place.half_thickness * self.turned);
        let angles = state.angle.as_ref().get(node..).unwrap_or(&[]).iter();
        let before = self.angle.as_ref().get(node..).unwrap_or(&[]);
        for ((&now, &before), &arm) in angles.zip(before).zip(&arms) {
            turned += arm * (now - before);
        }
        let slip = row.normal[0] * moved.x + row.normal[1] * moved.y + turned;
        slip - row.softness * self.before(row.sample)
    }

    /// What friction dissipates at a tangent row since the accepted state (64).
    fn lost(&self, row: &Row<T>) -> T {
        T::of(-0.5) * (row.multiplier + self.before(row.sample)) * (row.gap + row.softness * row.multiplier)
    }

    /// By how much the tangents miss their law, as a length: the slip of what sticks, slip the wrong way, a force beyond the cone.
    pub(crate) fn missed(&self, model: &Model<T, S>, rows: &[Row<T>]) -> T {
        let pairs = rows.as_chunks::<2>().0.iter();
        pairs.fold(T::ZERO, |most, [tangent, normal]| {
            let slip = tangent.gap + tangent.softness * tangent.multiplier;
            most.max(match tangent.state {
                ContactState::SlipUp | ContactState::SlipDown if self.is_forced() => T::ZERO,
                ContactState::SlipUp => slip,
                ContactState::SlipDown => -slip,
                ContactState::Stick => {
                    let beyond = tangent.multiplier.abs() - self.coefficient * normal.multiplier;
                    slip.abs().max(model.softness[1] * beyond)
                }
                ContactState::Open | ContactState::Closed => T::ZERO,
            })
        })
    }

    /// The hand is open: nothing has touched yet, and nothing is dissipated.
    pub(crate) fn begin(&mut self, model: &Model<T, S>, state: &State<T, S>, kinematics: &Kinematics<T, S>) {
        (self.count, self.dissipated) = (0, T::ZERO);
        self.remember(model, state, kinematics);
    }

    /// The state is accepted, after `before`: what friction dissipated on the way to it (64), and its forces and pose as those of the past.
    pub(crate) fn accept(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        before: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        rows: &[Row<T>],
    ) {
        let tangents = || rows.iter().filter(|row| row.direction == Direction::Tangent);
        let mut near = tangents().peekable();
        let mut lost = T::ZERO;
        // What let go has rubbed as well, with or without a row near the object.
        let touched = before.touching.as_ref().iter().zip(before.normal.as_ref()).take(before.touching_count);
        for (&sample, &normal) in touched {
            while near.next_if(|row| row.sample < sample).is_some() {}
            if near.next_if(|row| row.sample == sample).is_none() {
                let place = model.place(sample);
                let mut row = Row { sample, place, normal: towards_tip(normal), ..Row::BLANK };
                row.softness = softness(model, &row);
                row.gap = self.slipped(model, state, kinematics, &row);
                lost += self.lost(&row);
            }
        }
        self.dissipated += tangents().fold(lost, |lost, row| lost + self.lost(row));
        self.count = 0;
        for row in tangents().filter(|row| row.state != ContactState::Open) {
            self.touching.as_mut().put(usize::from(self.count), row.sample);
            // What sticks may have crept by the tolerance: the next step takes that back.
            let sticks = row.state == ContactState::Stick && row.softness > T::ZERO;
            let crept = if sticks { row.gap / row.softness + row.multiplier } else { T::ZERO };
            self.tangential.as_mut().put(usize::from(self.count), row.multiplier - crept);
            self.count += 1;
        }
        self.remember(model, state, kinematics);
    }

    /// Keeps what it remembers but for the pose, for [`Self::go_back`].
    pub(crate) fn mark(&mut self) -> Rubbed<T> {
        let room = self.room();
        keep(self.touching.as_mut(), room, |now, kept| *kept = *now);
        keep(self.tangential.as_mut(), room, |now, kept| *kept = *now);
        Rubbed { count: self.count, dissipated: self.dissipated }
    }

    /// Its past is that of the mark again, whose pose is the present one.
    pub(crate) fn go_back(
        &mut self,
        mark: &Rubbed<T>,
        model: &Model<T, S>,
        state: &State<T, S>,
        kinematics: &Kinematics<T, S>,
    ) {
        if self.rubs() {
            let room = self.room();
            keep(self.touching.as_mut(), room, |now, kept| *now = *kept);
            keep(self.tangential.as_mut(), room, |now, kept| *now = *kept);
            (self.count, self.dissipated) = (mark.count, mark.dissipated);
            self.remember(model, state, kinematics);
        }
    }

    /// Takes the present pose for the accepted one.
    fn remember(&mut self, model: &Model<T, S>, state: &State<T, S>, kinematics: &Kinematics<T, S>) {
        let (nodes, cells) = (model.node_count, model.cells());
        for (past, &now) in self.angle.as_mut().iter_mut().zip(state.angle.as_ref()).take(nodes) {
            *past = now;
        }
        for (past, now) in self.strained.as_mut().iter_mut().zip(kinematics.nodes.as_ref()).take(nodes) {
            *past = now.strained;
        }
        for (past, &now) in self.start.as_mut().iter_mut().zip(kinematics.start.as_ref()).take(cells) {
            *past = now;
        }
        for (past, now) in self.rigid_end.as_mut().iter_mut().zip(kinematics.members.as_ref()).take(cells) {
            *past = now.rigid_end;
        }
        (self.rotation, self.shift, self.turned) = ([T::ZERO; 2], [T::ZERO; 2], T::ZERO);
    }
}

/// Goes through a list and the half of it that no sample fills, as one takes two rows: that keeps what a mark remembers.
fn keep<X>(list: &mut [X], room: usize, each: impl Fn(&mut X, &mut X)) {
    if let Some((now, kept)) = list.split_at_mut_checked(room) {
        now.iter_mut().zip(kept).for_each(|(now, kept)| each(now, kept));
    }
}

/// Turns the tangents with their normals.
pub(crate) fn redirect<T: Real>(rows: &mut [Row<T>]) {
    for [tangent, normal] in rows.as_chunks_mut::<2>().0 {
        tangent.normal = towards_tip(normal.normal);
    }
}

/// Adds the moments of the tangential forces to the gradient of the front spans, before their bending moments are.
pub(crate) fn turn<T: Real, S: Size>(model: &Model<T, S>, kinematics: &mut Kinematics<T, S>, rows: &[Row<T>]) {
    let mut from = 0;
    for (index, member) in model.topology.fronts().iter().enumerate() {
        let own = own_rows(rows, index, from);
        from = own.end;
        for row in rows.run(own).iter().filter(|row| row.direction == Direction::Tangent && row.multiplier != T::ZERO) {
            let (node, arms) = arms(model, row);
            let nodes = kinematics.nodes.as_mut().get_mut(node..member.nodes().end).unwrap_or(&mut []);
            for (node, arm) in nodes.iter_mut().zip(arms) {
                node.gradient -= row.multiplier * arm;
            }
        }
        if member.kind == Kind::Link
            && let (Some([_, interior @ .., _]), Some(out)) =
                (kinematics.nodes.as_ref().get(member.nodes()), kinematics.members.as_mut().get_mut(index))
        {
            // Of quadratic elements it is found with the bending moments, which come later.
            out.steepest = interior.iter().fold(T::ZERO, |most, node| most.max(node.gradient.abs()));
        }
    }
}

/// State of a tangent that a part of a step has taken to a tangential force.
pub(crate) fn on_the_way<T: Real>(state: ContactState, tangential: T) -> ContactState {
    match state {
        ContactState::Open | ContactState::Closed if tangential < T::ZERO => ContactState::SlipDown,
        ContactState::Open | ContactState::Closed => ContactState::SlipUp,
        ContactState::Stick | ContactState::SlipUp | ContactState::SlipDown => state,
    }
}
