//! The deformed finger as plain numbers, as results, pictures and recordings carry it.

use model_core::contact::SlipState;
use model_core::design::{Design, HingeFrom, HingeKind};
use model_core::equilibrium::Follower;
use model_core::real::Real;
use model_core::size::Size;

/// A contact force on one sample of the front beam.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Contact {
    /// Arc length along the front beam, mm.
    #[serde(rename = "arc_mm")]
    pub arc: f64,
    /// Point of the front beam's surface, finger frame, mm.
    #[serde(rename = "position_mm")]
    pub position: [f64; 2],
    /// Unit normal out of the object, towards the finger; finger frame.
    pub normal: [f64; 2],
    /// Magnitude, N: the object pushes the finger along the normal, the finger the object against it.
    #[serde(rename = "force_n")]
    pub force: f64,
    /// With friction: the tangential force that the object exerts on the finger, N, positive towards the finger's tip. The other is
    /// then the normal force.
    #[serde(rename = "tangential_n", default, skip_serializing_if = "Option::is_none")]
    pub tangential: Option<f64>,
    /// With friction: how the sample moves along the object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub state: Option<Slip>,
}

/// How a touching sample moves along the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Slip {
    /// It does not.
    #[serde(rename = "stick")]
    Stick,
    /// It slips, and the object pulls the finger towards its tip.
    #[serde(rename = "slip+")]
    Up,
    /// It slips, and the object pulls the finger towards its base.
    #[serde(rename = "slip-")]
    Down,
}

impl From<SlipState> for Slip {
    fn from(state: SlipState) -> Self {
        match state {
            SlipState::Stick => Self::Stick,
            SlipState::Up => Self::Up,
            SlipState::Down => Self::Down,
        }
    }
}

/// A deformed finger in its own frame, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Front centreline, base to tip.
    pub front: Vec<[f64; 2]>,
    /// Back centreline, base to tip.
    pub back: Vec<[f64; 2]>,
    /// Ends of every lamella's rigid bar, front end first, base to tip.
    pub lamellae: Vec<[[f64; 2]; 2]>,
    /// Centreline of every rib from where it begins to bend, front end first, base to tip; none of rigid lamellae.
    pub ribs: Vec<Vec<[f64; 2]>>,
    /// Samples that touch the object.
    pub contacts: Vec<Contact>,
}

impl Shape {
    /// What a follower is at.
    pub fn of<T: Real, S: Size>(follower: &Follower<T, S>) -> Self {
        let solution = follower.solution();
        let point = |p: [T; 2]| p.map(T::to_f64);
        let contact = |c: model_core::contact::Contact<T>| Contact {
            arc: c.arc.to_f64(),
            position: point(c.position),
            normal: point(c.normal),
            force: c.force.to_f64(),
            tangential: c.slip.map(|_| c.tangential.to_f64()),
            state: c.slip.map(Slip::from),
        };
        Self {
            front: solution.front().map(point).collect(),
            back: solution.back().map(point).collect(),
            lamellae: solution.lamellae().map(|bar| bar.map(point)).collect(),
            ribs: solution.ribs().map(|rib| rib.map(point).collect()).collect(),
            contacts: solution.contacts().map(contact).collect(),
        }
    }

    /// The undeformed finger.
    pub fn undeformed(design: &Design) -> Self {
        let line = |beam: &model_core::design::Beam| {
            (0..=40).map(|i| beam.point(beam.length() * f64::from(i) / 40.0)).collect::<Vec<_>>()
        };
        let lamellae: Vec<_> = (0..design.lamella_count()).map(|lamella| bar(design, lamella)).collect();
        let ribs = if design.lamellae.ribs().is_some() {
            lamellae.iter().map(|bar| bar.to_vec()).collect()
        } else {
            Vec::new()
        };
        Self { front: line(&design.front), back: line(&design.back), lamellae, ribs, contacts: Vec::new() }
    }
}

/// Ends (front, back) of lamella k's bar in the undeformed finger, mm; of a rib, where it begins to bend.
pub fn bar(design: &Design, lamella: usize) -> [[f64; 2]; 2] {
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = design.lamella_width(lamella);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let inset = insets(design, lamella);
    [[p[0] + inset[0] * along[0], p[1] + inset[0] * along[1]], [q[0] - inset[1] * along[0], q[1] - inset[1] * along[1]]]
}

/// Distances (front, back), mm, from the centrelines to the ends of lamella k's bar as it is built.
pub fn insets(design: &Design, lamella: usize) -> [f64; 2] {
    let (joint, gap) = (design.joint(), design.lamellae.gap());
    if joint != HingeKind::Flexible && gap.is_none() {
        return [0.0, 0.0];
    }
    let length = if joint == HingeKind::Flexible { design.hinge.length_of(lamella) } else { 0.0 };
    if joint == HingeKind::Flexible && design.hinge.from == HingeFrom::Centreline {
        return [length, length];
    }
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = design.lamella_width(lamella);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let reach = |beam: &model_core::design::Beam, arc: f64, gap: f64| {
        let e = beam.direction(arc);
        let sine = (e[0] * along[1] - e[1] * along[0]).abs().max(0.1);
        length + (0.5 * beam.thickness.at(arc) + gap) / sine
    };
    match gap {
        Some(gap) => [0.0, reach(&design.back, arcs[1], gap)],
        None => [reach(&design.front, arcs[0], 0.0), reach(&design.back, arcs[1], 0.0)],
    }
}
