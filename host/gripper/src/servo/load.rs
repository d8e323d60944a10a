//! What the finger asks of the servo: the contact's torque and force over the motor's angle, which turns the finger or moves it along a
//! line.
//!
//! The model is solved once, at every half count of the range, before the servo answers its first packet; an answer then
//! costs a look-up. Whole counts without play lie on nodes; between two nodes the straight line is up to 0.04 N off for
//! the reference model, whose contact moves from node to node. The finger can snap through with hysteresis, so there is
//! one table per branch: a branch that ends leads to another one, upwards and downwards.

use std::f64::consts::PI;

use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::drive::Drive;
use model_core::equilibrium::Follower;
use model_core::newton::Hessian;
use model_core::object::ObjectDesign;
use model_core::real::Real;
use model_core::status::Status;

use super::contact::{Contact, LoadError};
use super::rub::{Rough, Rub};
use fre::heap::Host;
use fre::study::follow::follower;
use fre::study::model::{Options, Precision};

/// Distance of two nodes of the table, rad: half a count of the servo.
const PITCH: f64 = PI / 4096.0;
/// Nodes of half a turn.
const HALF_TURN: i64 = 4096;
/// The table ends where the torque is above this, N·mm: more than the servo can give.
const MOST_TORQUE: f64 = 5_000.0;
/// A step of the table is a jump if torque departs from the line through the two nodes before it by more than this,
/// N·mm, and this share of it. (The solver's status says that the finger has snapped, not when.)
const JUMP: [f64; 2] = [5.0, 0.02];
/// Branches that are explored.
const MOST_BRANCHES: usize = 16;

/// One branch of equilibria: nodes at consecutive multiples of the pitch.
#[derive(Clone, Debug)]
struct Branch {
    first: i64,
    nodes: Vec<Contact>,
    /// Where the finger snaps to beyond either end.
    below: Option<usize>,
    above: Option<usize>,
}

impl Branch {
    fn last(&self) -> i64 {
        self.first + self.nodes.len() as i64 - 1
    }

    fn node(&self, index: i64) -> Option<&Contact> {
        usize::try_from(index - self.first).ok().and_then(|at| self.nodes.get(at))
    }
}

/// Torque and force over the finger's angle, on every branch that closing and opening meet.
#[derive(Clone, Debug, Default)]
pub struct Load {
    branches: Vec<Branch>,
    /// The finger with friction or memory: the branches are those of the same finger without.
    rough: Option<Rough>,
}

/// Which branch the finger is on. A finger starts open, on the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OnBranch(usize);

impl Load {
    /// A servo without a finger.
    pub fn none() -> Self {
        Self::default()
    }

    /// The model of the reference: scheme `paper` at 170/20 in the extended physics, which is the estimator's default.
    pub const REFERENCE: Options = Options {
        discretisation: Discretisation::full(Scheme::Paper, Physics::Extended),
        hessian: Hessian::Newton,
        precision: Precision::F64,
    };

    /// Of a finger that its motor moves against an object, up to a motor angle in degrees (or until the torque is more than
    /// the servo can give, or a drive's table ends).
    ///
    /// # Errors
    /// A model that cannot be made, or no angle without contact.
    pub fn of(
        design: &Design,
        object: ObjectDesign,
        drive: &Drive,
        options: &Options,
        highest_deg: f64,
    ) -> Result<Self, LoadError> {
        drive.validate().map_err(LoadError::Drive)?;
        match options.precision {
            Precision::F64 => explore::<f64>(design, object, drive, options, highest_deg),
            Precision::F32 => explore::<f32>(design, object, drive, options, highest_deg),
        }
    }

    /// The same with friction between finger and object, which the model follows as the motor moves. [`Self::at`] stays that without.
    ///
    /// # Errors
    /// As [`Load::of`], and a coefficient out of range.
    pub fn rough(
        design: &Design,
        object: ObjectDesign,
        friction: f64,
        drive: &Drive,
        options: &Options,
        highest_deg: f64,
    ) -> Result<Self, LoadError> {
        Self::remembering(design, &[], object, friction, drive, options, highest_deg)
    }

    /// The same with friction, and of a material with the Prony terms [gᵢ, τᵢ in s], which the model follows through time: every strain
    /// remembers. [`Self::at`] stays that without either.
    ///
    /// # Errors
    /// As [`Load::of`], and a coefficient or terms out of range.
    pub fn remembering(
        design: &Design,
        prony: &[[f64; 2]],
        object: ObjectDesign,
        friction: f64,
        drive: &Drive,
        options: &Options,
        highest_deg: f64,
    ) -> Result<Self, LoadError> {
        let smooth = Self::of(design, object, drive, options, highest_deg)?;
        if friction == 0.0 && prony.is_empty() {
            return Ok(smooth);
        }
        let prony = prony.to_vec();
        let rough = Rough { design: design.clone(), object, friction, prony, drive: *drive, options: *options };
        // What can be wrong with it, is said here.
        rough.open()?;
        Ok(Self { rough: Some(rough), ..smooth })
    }

    /// The finger with friction or memory, open.
    pub(super) fn rub(&self) -> Option<Rub> {
        self.rough.as_ref().and_then(|rough| rough.open().ok())
    }

    /// The contact at a motor angle without play, rad; the branch changes where the finger snaps.
    pub fn at(&self, angle: f64, on: &mut OnBranch) -> Contact {
        let place = angle / PITCH;
        // Every pass goes to a branch that is entered from this one's end; a ring of ends would be a flaw of the table.
        for _ in 0..2 * MOST_BRANCHES {
            let Some(branch) = self.branches.get(on.0) else {
                return Contact::NONE;
            };
            let next = if place < branch.first as f64 {
                branch.below
            } else if place > branch.last() as f64 {
                branch.above
            } else {
                None
            };
            match next {
                Some(next) => on.0 = next,
                None => return branch.between(place),
            }
        }
        Contact { status: Status::OutOfRange, ..Contact::NONE }
    }

    /// First angle at which the closing finger touches, rad; none if it never does.
    pub fn first_contact(&self) -> Option<f64> {
        let branch = self.branches.first()?;
        let touching = branch.nodes.iter().position(|node| node.status != Status::NoContact)?;
        Some((branch.first + touching as i64) as f64 * PITCH)
    }

    /// The greatest angle of the table, rad.
    pub fn highest(&self) -> Option<f64> {
        self.branches.iter().map(Branch::last).max().map(|last| last as f64 * PITCH)
    }

    /// Number of branches.
    pub fn branch_count(&self) -> usize {
        self.branches.len()
    }
}

impl Branch {
    /// Between two nodes; beyond the ends the last two nodes' line.
    fn between(&self, place: f64) -> Contact {
        if place < self.first as f64 {
            // The open end of the first branch is free of contact; another's goes on as it ends.
            let end = self.nodes.first().copied().unwrap_or(Contact::NONE);
            return if end.status == Status::NoContact { end } else { Contact { status: Status::OutOfRange, ..end } };
        }
        let low = (place.floor() as i64).min(self.last() - 1).max(self.first);
        let (Some(a), Some(b)) = (self.node(low), self.node(low + 1)) else {
            return self.nodes.first().copied().unwrap_or(Contact::NONE);
        };
        let share = place - low as f64;
        let mix = |a: f64, b: f64| a + (b - a) * share;
        let torque = mix(a.torque, b.torque);
        let status = if share > 1.0 {
            Status::OutOfRange
        } else if share >= 1.0 {
            b.status
        } else if share > 0.0 && b.status != Status::NoContact && a.status == Status::NoContact {
            Status::Converged
        } else {
            a.status
        };
        Contact { torque, force: [mix(a.force[0], b.force[0]), mix(a.force[1], b.force[1])], status }
    }
}

/// Whether the finger has snapped on the way to a node from those before it, the nearest first.
fn jumps<'a>(mut before: impl Iterator<Item = &'a Contact>, node: &Contact) -> bool {
    let (Some(near), Some(far)) = (before.next(), before.next()) else {
        return false;
    };
    if node.status != Status::Snapped {
        return false;
    }
    let bend = (node.torque - 2.0 * near.torque + far.torque).abs();
    near.status != Status::Snapped || bend > JUMP[0] + JUMP[1] * near.torque.abs()
}

/// The model on its drive.
struct Finger<'a, T: Real> {
    follower: Follower<T, Host>,
    drive: &'a Drive,
}

impl<T: Real> Finger<'_, T> {
    /// The base's coordinate (rad or mm) at a node and its derivative by the motor's angle, if the drive reaches it.
    fn coordinate(&self, index: i64) -> Option<[f64; 2]> {
        self.drive.coordinate(index as f64 * PITCH)
    }

    /// The contact at a node, if the model can be followed there.
    fn visit(&mut self, index: i64) -> Option<Contact> {
        let [coordinate, slope] = self.coordinate(index)?;
        let status = self.follower.follow(coordinate).status;
        status.is_trustworthy().then(|| Contact {
            // Of the motor: a force times the way per angle.
            torque: self.follower.solution().motor_torque().to_f64() * slope,
            force: self.follower.solution().force_world().map(Real::to_f64),
            status,
        })
    }

    /// Closes from the open finger; gives the first node, half a turn before 0 at most.
    fn open(&mut self) -> Result<i64, LoadError> {
        let [zero, _] = self.coordinate(0).ok_or(LoadError::NoZero)?;
        if !self.follower.start(zero) {
            return Err(LoadError::NoRoom);
        }
        let free = self.follower.solution().coordinate();
        let is_free = |index: &i64| self.coordinate(*index).is_some_and(|[coordinate, _]| coordinate <= free);
        (-HALF_TURN..=0).rev().find(is_free).ok_or(LoadError::NoRoom)
    }
}

fn explore<T: Real>(
    design: &Design,
    object: ObjectDesign,
    drive: &Drive,
    options: &Options,
    highest_deg: f64,
) -> Result<Load, LoadError> {
    let motion = drive.motion(design.motor_axis);
    let follower = follower(design, object, motion, options).map_err(LoadError::Discretise)?;
    let finger = &mut Finger::<T> { follower, drive };
    let first = finger.open()?;
    let range = LoadError::Range { highest_deg, lowest_deg: (first as f64 * PITCH).to_degrees() };
    if highest_deg.is_nan() || highest_deg > 180.0 {
        return Err(range);
    }
    let last = (highest_deg.to_radians() / PITCH).ceil() as i64;
    if last <= first {
        return Err(range);
    }
    let mut branches = vec![Branch { first, nodes: Vec::new(), below: None, above: None }];
    close(finger, first, last, &mut branches);
    // Opening: each branch but the first is followed down from its beginning.
    for from in 1..branches.len() {
        descend(finger, from, &mut branches)?;
    }
    Ok(Load { branches, rough: None })
}

/// Follows upwards; every snap begins a branch.
fn close<T: Real>(finger: &mut Finger<'_, T>, first: i64, last: i64, branches: &mut Vec<Branch>) {
    for index in first..=last {
        let Some(node) = finger.visit(index) else {
            break;
        };
        let count = branches.len();
        let nodes = &branches[count - 1].nodes;
        if jumps(nodes.iter().rev(), &node) && count < MOST_BRANCHES {
            branches[count - 1].above = Some(count);
            branches.push(Branch { first: index, nodes: vec![node], below: None, above: None });
        } else {
            branches[count - 1].nodes.push(node);
        }
        if node.torque > MOST_TORQUE {
            break;
        }
    }
}

/// Extends a branch downwards from its first node to where the finger snaps back, and so on down to a known branch.
fn descend<T: Real>(finger: &mut Finger<'_, T>, from: usize, branches: &mut Vec<Branch>) -> Result<(), LoadError> {
    let top = branches[from].first;
    let bottom = finger.open()?;
    // The same way up, in the same steps, leads to the same state.
    for index in bottom..=top {
        if finger.visit(index).is_none() {
            return Ok(());
        }
    }
    let mut at = from;
    for index in (bottom..top).rev() {
        let Some(node) = finger.visit(index) else {
            break;
        };
        let known = |branch: &Branch| branch.node(index).is_some_and(|known| known.is_like(&node));
        if let Some(joined) = (0..branches.len()).find(|&other| other != at && known(&branches[other])) {
            branches[at].below = Some(joined);
            break;
        }
        if jumps(branches[at].nodes.iter(), &node) && branches.len() < MOST_BRANCHES {
            // A branch that closing does not meet. What is above it is not known.
            let new = branches.len();
            branches[at].below = Some(new);
            branches.push(Branch { first: index, nodes: vec![node], below: None, above: None });
            at = new;
        } else {
            branches[at].nodes.insert(0, node);
            branches[at].first = index;
        }
    }
    Ok(())
}
