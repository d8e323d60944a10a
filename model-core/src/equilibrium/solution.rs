//! What can be read off an equilibrium: forces, torque, energy, shape, contacts, strains.
//!
//! Shapes are in the finger frame, mm; forces act on the object, N. [`Follower::to_world`] turns points into the world frame.

use super::{Follower, Phase};
use crate::access::Access;
use crate::contact::{Contact, ContactState, Direction, SlipState};
use crate::model::{Model, vec2_of};
use crate::newton::{Effort, Workspace};
use crate::object::{Displacement, Motion, Object};
use crate::real::{Real, Vec2, cross, vec2};
use crate::size::Size;
use crate::state::State;
use crate::topology::Role;
use crate::units::Units;

/// The follower's parts that a derivative needs.
pub(crate) struct Parts<'a, T: Real, S: Size> {
    pub(crate) model: &'a Model<T, S>,
    pub(crate) work: &'a mut Workspace<T, S>,
}

/// What can be read off the last accepted equilibrium.
impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Coordinate of the last accepted equilibrium, rad or mm.
    pub fn coordinate(&self) -> f64 {
        self.timeline.at().to_f64()
    }

    /// What was computed so far: the cost of a call is the difference before and after it.
    pub fn effort(&self) -> Effort {
        self.work.effort
    }

    /// Number of angles of the model.
    pub fn unknowns(&self) -> usize {
        self.model.angles()
    }

    pub(crate) fn has_equilibrium(&self) -> bool {
        self.model.cells() > 0 && self.phase == Phase::Following
    }

    /// The last factorisation is that of the accepted state, or nearly.
    pub(crate) fn is_factored(&self) -> bool {
        self.factored
    }

    pub(crate) fn has_snapped(&self) -> bool {
        self.snapped
    }

    pub(crate) fn youngs_modulus(&self) -> T {
        self.modulus * self.youngs_modulus
    }

    pub(crate) fn parts(&mut self) -> Parts<'_, T, S> {
        Parts { model: &self.model, work: &mut self.work }
    }

    /// The accepted state, which the workspace shows, beside the parts.
    pub(crate) fn state_and_parts(&mut self) -> (&State<T, S>, Parts<'_, T, S>) {
        (&self.timeline.present, Parts { model: &self.model, work: &mut self.work })
    }

    /// Another model has the same unknowns and samples.
    pub(crate) fn is_like(&self, other: &Model<T, S>) -> bool {
        self.model.cells() == other.cells()
            && self.model.unknowns() == other.unknowns()
            && self.model.node_count == other.node_count
            && self.model.sample_count == other.sample_count
    }

    /// Number of samples that touch.
    pub fn touching(&self) -> usize {
        self.timeline.present.touching_count
    }

    /// Smallest distance to the object over all samples, mm; slightly negative in contact (softness).
    pub fn distance(&self) -> T {
        self.sweep.nearest * self.model.units.length
    }

    pub(crate) fn displacement(&self) -> Displacement<T> {
        self.motion.world_to_finger(self.timeline.at())
    }

    /// Force of the finger on the object in the finger frame, N.
    pub fn force_finger(&self) -> [T; 2] {
        let mut force = [T::ZERO; 2];
        for contact in self.contacts() {
            let [x, y] = contact.on_object();
            force = [force[0] + x, force[1] + y];
        }
        force
    }

    /// Force of the finger on the object in the world frame, N.
    pub fn force_world(&self) -> [T; 2] {
        let f = self.force_finger();
        let world = self.displacement().vector_back(Vec2::new(f[0], f[1]));
        [world.x, world.y]
    }

    /// Torque that the contact demands of the motor, N·mm: τ = −((C − M) × F)_z, positive when the motor must push to
    /// close. For a translated base: the force against its motion, N.
    pub fn motor_torque(&self) -> T {
        match self.motion {
            Motion::Rotating { axis } => {
                let m = vec2::<T>(axis);
                let mut torque = T::ZERO;
                for contact in self.contacts() {
                    let arm = Vec2::new(contact.position[0], contact.position[1]) - m;
                    torque -= cross(arm, vec2_of(contact.on_object()));
                }
                torque
            }
            Motion::Translating { direction } => {
                let f = self.force_world();
                let d = vec2::<T>(direction);
                f[0] * d.x + f[1] * d.y
            }
        }
    }

    /// What the clamped base exerts on the front and on the back beam: force (finger frame, N) and moment about the end of the beam's own
    /// held part, N·mm, counter-clockwise. What it exerts on rungs that end on the held back beam is part of the second.
    ///
    /// The derivatives of the Lagrangian with respect to the clamped places and angles: with the contacts they hold the finger in
    /// balance.
    pub fn base_reactions(&self) -> [([T; 2], T); 2] {
        let mut reactions = [0, 1].map(|side| self.beam_reaction(side));
        let unit = self.model.units.moment();
        for cell in 0..self.model.cells() {
            if let Some((force, moment)) = self.rung_reaction(cell) {
                let (sum, total) = &mut reactions[1];
                let force = self.model.units.newtons(force);
                *sum = [sum[0] + force[0], sum[1] + force[1]];
                *total += moment * unit;
            }
        }
        reactions
    }

    fn beam_reaction(&self, side: usize) -> ([T; 2], T) {
        // Spans that are held are no members.
        let mut cells = 0..self.model.cells() as u8;
        let role = |cell| if side == 0 { Role::Front(cell) } else { Role::Back(cell) };
        let index = cells.find_map(|cell| self.model.topology.find(role(cell))).unwrap_or(usize::MAX);
        let (Some(member), Some(work)) = (self.model.member(index), self.work.kinematics.members.as_ref().get(index))
        else {
            return ([T::ZERO; 2], T::ZERO);
        };
        let moment =
            self.work.kinematics.nodes.as_ref().get(usize::from(member.first)).map_or(T::ZERO, |node| node.gradient);
        let mut force = work.force;
        if side == 0 {
            // A member's force is the one at its end: contacts on the span itself come on top.
            for row in self.work.contacts.rows().iter() {
                if row.place.cell == 0 {
                    force = [0, 1].map(|i| force[i] - row.multiplier * row.normal[i]);
                }
            }
        }
        (self.model.units.newtons(force), moment * self.model.units.moment())
    }

    /// Elastic energy V (without the contact term), N·mm.
    pub fn energy(&self) -> T {
        let energy = self.timeline.present.bending_energy(&self.model)
            + self.work.kinematics.energy(&self.model, self.work.contacts.rows());
        energy * self.model.units.moment()
    }

    /// Elastic energy with the contact's softness, V + ½ ε_c Σ μ² + ½ Σ ε_t τ², N·mm: without friction what torque and force are derivatives of.
    pub fn potential(&self) -> T {
        let half = T::of(0.5) * self.softness();
        let stored = self.contacts().fold(self.energy(), |sum, contact| sum + half * contact.force * contact.force);
        if !self.rubs() {
            return stored;
        }
        let unit = T::of(0.5) * self.model.units.moment();
        let along = self.work.contacts.rows().iter().filter(|row| row.direction == Direction::Tangent);
        along.fold(stored, |sum, row| sum + unit * row.softness * row.multiplier * row.multiplier)
    }

    /// There is friction.
    #[inline(always)]
    pub(crate) fn rubs(&self) -> bool {
        self.work.history.slip.rubs()
    }

    /// Coefficient of friction.
    pub fn friction(&self) -> T {
        self.work.history.slip.coefficient
    }

    /// Energy that friction has dissipated since the hand was open, N·mm: with the potential it is the work that closing has taken.
    pub fn dissipated(&self) -> T {
        self.work.history.slip.dissipated * self.model.units.moment()
    }

    /// Contact softness ε_c in use, mm/N: a touching place is pressed into the object by ε_c times its force.
    pub fn softness(&self) -> T {
        let Units { length, force } = self.model.units;
        self.model.contact_softness() * length / force
    }

    /// Deformed tip of the front beam, finger frame, mm.
    pub fn tip(&self) -> [T; 2] {
        self.model.units.millimetres(self.work.kinematics.tip(&self.model))
    }

    /// Touching samples, base to tip, finger frame.
    pub fn contacts(&self) -> impl Iterator<Item = Contact<T>> + '_ {
        let rows = self.work.contacts.rows();
        rows.iter().enumerate().filter(|(_, row)| row.touches()).map(|(j, row)| {
            let tangent = j.checked_sub(1).filter(|_| S::RUBS).and_then(|before| rows.get(before));
            let tangent = tangent.filter(|row| row.direction == Direction::Tangent);
            let sample = &row.place;
            let centre = self.work.kinematics.position(&self.model, sample);
            let units = &self.model.units;
            Contact {
                arc: sample.arc * units.length,
                position: units.millimetres([
                    centre.x - sample.half_thickness * row.normal[0],
                    centre.y - sample.half_thickness * row.normal[1],
                ]),
                normal: row.normal,
                force: row.multiplier * units.force,
                tangential: tangent.map_or(T::ZERO, |row| row.multiplier * units.force),
                slip: tangent.and_then(|row| match row.state {
                    ContactState::Stick => Some(SlipState::Stick),
                    ContactState::SlipUp => Some(SlipState::Up),
                    ContactState::SlipDown => Some(SlipState::Down),
                    ContactState::Open | ContactState::Closed => None,
                }),
            }
        })
    }

    /// Arc lengths of all contact samples, touching or not, mm, base to tip.
    pub fn sample_arcs(&self) -> impl Iterator<Item = T> + '_ {
        self.model.samples.as_ref()[..self.model.sample_count].iter().map(|sample| sample.arc * self.model.units.length)
    }

    /// Deformed centreline of the front beam, finger frame, mm, from where its held part ends to the tip: the ends of its links, or the ends
    /// and middles of its quadratic elements.
    pub fn front(&self) -> impl Iterator<Item = [T; 2]> + '_ {
        self.centreline(0)
    }

    /// Deformed centreline of the back beam; as [`Self::front`].
    pub fn back(&self) -> impl Iterator<Item = [T; 2]> + '_ {
        self.centreline(1)
    }

    fn centreline(&self, side: usize) -> impl Iterator<Item = [T; 2]> + '_ {
        let mut base = self.model.base;
        if side == 1 {
            base[0] += self.model.base_rung[0];
            base[1] += self.model.base_rung[1];
        }
        let mut end = base;
        let indices = (0..self.model.cells()).filter_map(move |cell| {
            // Spans that are held are no members.
            let role = if side == 0 { Role::Front(cell as u8) } else { Role::Back(cell as u8) };
            self.model.topology.find(role)
        });
        let spans = indices.flat_map(move |index| {
            let work = self.work.kinematics.members.as_ref().at(index);
            let nodes = self.model.topology.members.as_ref().at(index).nodes();
            let start = end;
            let d = work.end_to_end();
            end = [start[0] + d[0], start[1] + d[1]];
            let rigid = work.rigid_end[0] != T::ZERO || work.rigid_end[1] != T::ZERO;
            let mut at = start;
            let links = (nodes.start + 1..nodes.end).filter_map(move |node| self.link(index, node, &mut at));
            links.chain(rigid.then_some(end))
        });
        core::iter::once(base).chain(spans).map(|point| self.model.units.millimetres(point))
    }

    /// The point of a member's centreline that belongs to a node after the first; `at` is the last link's or element's
    /// end and moves on.
    pub(super) fn link(&self, index: usize, node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let (e, weight) =
            (|node: usize| self.work.kinematics.nodes.as_ref().at(node).strained, self.model.weight.as_ref());
        let nodes = self.model.topology.members.as_ref().at(index).nodes();
        if !self.model.quadratic || nodes.len() < 3 {
            let w = weight.at(node);
            *at = [at[0] + w * e(node)[0], at[1] + w * e(node)[1]];
            return (w > T::ZERO).then_some(*at);
        }
        let local = node - nodes.start;
        let middle = if local % 2 == 1 { node } else { node - 1 };
        // Simpson's weight of the middle is 4h/6.
        let h = weight.at(middle) * T::of(1.5);
        let (a, m, b) = (e(middle - 1), e(middle), e(middle + 1));
        let sixth = h * T::of(1.0 / 6.0);
        let chord = [0, 1].map(|i| sixth * (a[i] + T::of(4.0) * m[i] + b[i]));
        if local % 2 == 1 {
            // The cubic Hermite curve at ξ = 1/2.
            return Some([0, 1].map(|i| at[i] + T::of(0.5) * chord[i] + T::of(0.125) * h * (a[i] - b[i])));
        }
        *at = [at[0] + chord[0], at[1] + chord[1]];
        Some(*at)
    }

    /// Where the motion has taken the base: how far it has moved, world frame, mm, and how far the motor has turned it about its axis, rad.
    pub fn base(&self) -> ([T; 2], T) {
        match self.motion {
            Motion::Rotating { .. } => ([T::ZERO; 2], self.timeline.at()),
            Motion::Translating { direction } => (direction.map(|part| T::of(part) * self.timeline.at()), T::ZERO),
        }
    }

    /// Turns a finger-frame point into the world frame, mm.
    pub fn to_world(&self, point: [T; 2]) -> [T; 2] {
        let d = self.displacement();
        let p = d.vector_back(Vec2::new(point[0], point[1]) - d.translation);
        [p.x, p.y]
    }
}
