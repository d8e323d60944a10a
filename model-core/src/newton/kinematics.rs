//! Kinematics: directions of the links, the forces through them, and what those do to them.

use super::memory::Memory;
use crate::access::Access;
use crate::contact::{Row, Sample, cell_of, own_rows};
use crate::element::{Constants, Depth, NoPast, Node, Pull, Strain, Tangents};
use crate::model::{Model, turned, vec2_of};
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size, Storage};
use crate::state::State;

/// Increment of an angle up to which [`Kinematics::turn`] is exact, rad.
pub(crate) const SMALL: f64 = 1e-3;

/// The strained finger at a state: what the walks over its members find. The front spans come first, as gaps need no others.
pub(crate) struct Kinematics<T: Real, S: Size> {
    pub nodes: S::Nodes<Node<T>>,
    pub members: S::Members<Strain<T>>,
    /// Position of each front span's start, mm.
    pub start: S::Cells<[T; 2]>,
    /// The last walk found residuals only: second derivatives are those of an earlier state.
    pub lacks_tangent: bool,
}

/// A member's constants, angles, nodes and what is found of it as a whole.
type MemberPart<'a, T> = (Constants<'a, T>, &'a [T], &'a mut [Node<T>], &'a mut Strain<T>);

impl<T: Real, S: Size> Kinematics<T, S> {
    pub const EMPTY: Self = Self {
        nodes: <S::Nodes<Node<T>> as Storage<Node<T>>>::EMPTY,
        members: <S::Members<Strain<T>> as Storage<Strain<T>>>::EMPTY,
        start: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        lacks_tangent: false,
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        // What no element ends up writing must not be left from another model.
        self.nodes.as_mut().fill(Node::BLANK);
        self.nodes.fit(model.node_count)
            && self.members.fit(model.topology.member_count())
            && self.start.fit(model.cells())
    }

    /// Directions of all links and turned rigid parts at the angles θ of a state.
    pub fn direct(&mut self, model: &Model<T, S>, state: &State<T, S>) {
        let (nodes, rest) = (self.nodes.as_mut(), model.direction.as_ref());
        // Joint angles come once per member that meets there: that is cheaper than to look for them.
        let count = model.node_count;
        let (angles, nodes) = (state.angle.as_ref().run(0..count), nodes.run_mut(0..count));
        T::turn_each(angles, nodes, rest.run(0..count), |node, &rest, sin, cos| node.e = turned(rest, cos, sin));
        self.turn_rigid_parts(model);
    }

    /// Directions after increments Δθ of the nodes, none larger than [`SMALL`]: turned by them, at half the cost of [`Self::direct`].
    pub fn turn(&mut self, model: &Model<T, S>, increments: &[T]) {
        let (half, third) = (T::of(0.5), T::of(1.0 / 3.0));
        for (node, &delta) in self.nodes.as_mut().run_mut(0..model.node_count).iter_mut().zip(increments) {
            let [x, y] = node.e;
            // 1 − cos δ to δ⁴ and sin δ to δ³, both within 1e-17 of the true ones.
            let z = half * (delta * delta);
            let (back, side) = (z - z * z * (half * third), delta - delta * (z * third));
            node.e = [x - (x * back + y * side), y + (x * side - y * back)];
        }
        self.turn_rigid_parts(model);
    }

    /// Turned rigid parts of all members.
    fn turn_rigid_parts(&mut self, model: &Model<T, S>) {
        let (nodes, rest) = (self.nodes.as_ref(), model.direction.as_ref());
        // A rigid part turns as the node at its end.
        let like = |part: [T; 2], node: usize| match (rest.get(node), nodes.get(node)) {
            (Some(&[x, y]), Some(&Node { e: [u, v], .. })) if part != [T::ZERO; 2] => {
                turned(part, x * u + y * v, x * v - y * u)
            }
            _ => [T::ZERO; 2],
        };
        for (member, out) in model.members().iter().zip(self.members.as_mut()) {
            out.rigid_start = like(member.rigid_start, usize::from(member.first));
            out.rigid_end = like(member.rigid_end, usize::from(member.first + member.interior) + 1);
        }
    }

    /// Strains and places the front spans under the multipliers λ of a state and the contact forces μ n of the rows, as deep as asked;
    /// gaps can then be measured.
    pub fn place_front<D: Depth>(
        &mut self,
        model: &Model<T, S>,
        memory: &Memory<T, S>,
        state: &State<T, S>,
        rows: &[Row<T>],
    ) {
        self.load(model, state, rows);
        let mut from = 0;
        for cell in 0..model.cells() {
            let own = own_rows(rows, cell, from);
            from = own.end;
            self.strain::<D>(model, memory, state, cell, rows.run(own));
        }
        self.start_spans(model);
    }

    /// Strains all other members and adds everybody's bending moments to the gradient.
    pub fn complete<D: Depth>(&mut self, model: &Model<T, S>, memory: &Memory<T, S>, state: &State<T, S>) {
        self.lacks_tangent = !D::TANGENT && model.members().iter().any(|member| member.kind.spares_tangent::<T>());
        for index in 0..model.topology.member_count() {
            if index >= model.cells() {
                self.strain::<D>(model, memory, state, index, &[]);
            }
            self.bend(model, state, index);
        }
    }

    /// Strains all members at a state, without their bending moments.
    pub fn place_all(&mut self, model: &Model<T, S>, memory: &Memory<T, S>, state: &State<T, S>, rows: &[Row<T>]) {
        self.direct(model, state);
        self.place_front::<Tangents>(model, memory, state, rows);
        for index in model.cells()..model.topology.member_count() {
            self.strain::<Tangents>(model, memory, state, index, &[]);
        }
    }

    /// Forces through the members (15): the multipliers of the closures that a member's vector enters, and in a front span less the load
    /// and Σ μ n of the contacts above.
    fn load(&mut self, model: &Model<T, S>, state: &State<T, S>, mut rows: &[Row<T>]) {
        let lambda = state.lambda.as_ref();
        let members = self.members.as_mut();
        for (member, out) in model.members().iter().zip(&mut *members) {
            let mut force = [T::ZERO; 2];
            for term in member.terms() {
                let [x, y] = lambda.at(usize::from(term.closure));
                force = [force[0] + term.sign * x, force[1] + term.sign * y];
            }
            (out.force, out.end_force) = (force, force);
        }
        let mut sum = [T::ZERO; 2];
        for (cell, front) in members.iter_mut().take(model.cells()).enumerate().rev() {
            if cell == state.load_cell {
                // A dead load acts like a contact just above this span.
                sum = [sum[0] + state.load[0], sum[1] + state.load[1]];
            }
            front.force = [front.force[0] - sum[0], front.force[1] - sum[1]];
            front.end_force = front.force;
            while let Some((touching, below)) = rows.split_last()
                && cell_of(touching) == cell
            {
                rows = below;
                let part = touching.place.rigid;
                for i in 0..2 {
                    let f = touching.multiplier * touching.normal[i];
                    sum[i] += f;
                    front.end_force[i] -= part * f;
                }
            }
        }
    }

    /// Strains a member under its force, as deep as asked; `rows` touch it.
    // Long and called once per member: a copy at every call would cost flash and spare nothing.
    #[inline(never)]
    fn strain<D: Depth>(
        &mut self,
        model: &Model<T, S>,
        memory: &Memory<T, S>,
        state: &State<T, S>,
        index: usize,
        rows: &[Row<T>],
    ) {
        let Some((of, angle, nodes, out)) = self.part(model, state, index) else { return };
        let kind = of.member.kind;
        if memory.is_heard() {
            kind.walk::<T, D, _>(of, memory.of(of.member.nodes()), angle, rows, nodes, out);
        } else {
            kind.walk::<T, D, _>(of, NoPast, angle, rows, nodes, out);
        }
    }

    /// Adds a strained member's bending moments to its gradient.
    #[inline(always)]
    fn bend(&mut self, model: &Model<T, S>, state: &State<T, S>, index: usize) {
        if let Some((of, angle, nodes, out)) = self.part(model, state, index) {
            of.member.kind.bend(of, angle, nodes, out);
        }
    }

    #[inline(always)]
    fn part<'a>(
        &'a mut self,
        model: &'a Model<T, S>,
        state: &'a State<T, S>,
        index: usize,
    ) -> Option<MemberPart<'a, T>> {
        let member = model.member(index)?;
        Some((
            model.constants(member)?,
            state.angle.as_ref().get(member.nodes())?,
            self.nodes.as_mut().get_mut(member.nodes())?,
            self.members.as_mut().get_mut(index)?,
        ))
    }

    /// Starts of the front spans from their end-to-end vectors.
    fn start_spans(&mut self, model: &Model<T, S>) {
        let mut position = model.base;
        for (start, front) in self.start.as_mut().iter_mut().zip(self.members.as_ref()).take(model.cells()) {
            *start = position;
            let d = front.end_to_end();
            position = [position[0] + d[0], position[1] + d[1]];
        }
    }

    /// Derivatives of a sample's position with respect to the angles of three nodes, from the sample's own on, mm (7).
    pub fn lever(&self, model: &Model<T, S>, index: usize, sample: &Sample<T>) -> [[T; 2]; 3] {
        let none = [[T::ZERO; 2]; 3];
        let Some(member) = model.member(index) else { return none };
        let nodes = member.nodes();
        // The wedge's samples lie beyond the last node.
        let Some(first) = usize::from(sample.node).checked_sub(nodes.start).filter(|&node| node < nodes.len()) else {
            return none;
        };
        let (Some(of), Some(list)) = (model.constants(member), self.nodes.as_ref().get(nodes)) else { return none };
        member.kind.lever(of, first, sample, list)
    }

    /// Position of a sample, finger frame, mm.
    pub fn position(&self, model: &Model<T, S>, sample: &Sample<T>) -> Vec2<T> {
        let cell = usize::from(sample.cell);
        let rigid_end = self.members.as_ref().get(cell).map_or([T::ZERO; 2], |front| front.rigid_end);
        let ends = [self.start.as_ref().at(cell), rigid_end];
        position(model, sample, ends, self.nodes.as_ref(), |node| node.strained)
    }

    /// Position of the front tip (deformed), finger frame, mm.
    pub fn tip(&self, model: &Model<T, S>) -> [T; 2] {
        let mut tip = model.base;
        for front in self.members.as_ref().iter().take(model.cells()) {
            let d = front.end_to_end();
            tip = [tip[0] + d[0], tip[1] + d[1]];
        }
        tip
    }

    /// Energy of stretch and shear, N·mm.
    pub fn energy(&self, model: &Model<T, S>, rows: &[Row<T>]) -> T {
        let (mut from, mut twice) = (0, T::ZERO);
        for (index, (member, out)) in model.members().iter().zip(self.members.as_ref()).enumerate() {
            let own = own_rows(rows, index, from);
            from = own.end;
            let mut pull = Pull::new(rows.get(own).unwrap_or(&[]), out.force);
            let [stretch, shear] = member.compliance;
            for node in member.nodes().rev() {
                let (Some(&w), Some(&[x, y])) =
                    (model.weight.as_ref().get(node), self.nodes.as_ref().get(node).map(|node| &node.e))
                else {
                    continue;
                };
                let force = pull.force(node, w);
                let (a, b) = (force[0] * x + force[1] * y, force[1] * x - force[0] * y);
                twice += w * (stretch * a * a + shear * b * b);
            }
        }
        T::of(0.5) * twice
    }
}

/// Position of a sample from its span's start and rigid end and the strained directions of all nodes, finger frame, mm: the same bits from the
/// same pose, whoever keeps it.
#[inline(always)]
pub(crate) fn position<T: Real, S: Size, X: Blank>(
    model: &Model<T, S>,
    sample: &Sample<T>,
    [start, rigid_end]: [[T; 2]; 2],
    nodes: &[X],
    strained: impl Fn(&X) -> [T; 2],
) -> Vec2<T> {
    let cell = usize::from(sample.cell);
    let (first, node) = (model.member(cell).map_or(0, |front| usize::from(front.first)), usize::from(sample.node));
    let mut position = vec2_of(start);
    for (on, &weight) in nodes.run(first..node).iter().zip(model.weight.as_ref().run(first..node)) {
        position += vec2_of(strained(on)) * weight;
    }
    for (k, &w) in sample.weights.iter().enumerate() {
        if w != T::ZERO {
            position += vec2_of(strained(&nodes.at(node + k))) * w;
        }
    }
    position + vec2_of(rigid_end) * sample.rigid
}
