//! Keys of a case that have no effect because of another key's value.

use std::fmt;

use model_core::design::{Hinge, HingeFrom, HingeKind, RibEnds};

use crate::case::{Case, Memory, NO_NECK};

/// Keys that have no effect, and the value because of which they have none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Idle {
    /// `[finger.hinge]` beside ribs without necks.
    Hinge {
        /// The value of `finger.lamellae.ends`.
        ends: &'static str,
    },
    /// Measures of necks of hinges that have none.
    Necks {
        /// The value of `finger.hinge.kind`.
        kind: &'static str,
        /// Whether `length_mm`, `thickness_mm` and `from` are given.
        given: [bool; 3],
    },
    /// `finger.material.memory` of an elastic material.
    Memory,
}

impl fmt::Display for Idle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hinge { ends } => write!(
                f,
                "finger.hinge has no effect: ribs with finger.lamellae.ends = \"{ends}\" have no necks (ends = \"hinged\" gives them)"
            ),
            Self::Necks { kind, given } => {
                let names = ["length_mm", "thickness_mm", "from"].into_iter().zip(given).filter(|(_, given)| **given);
                let names: Vec<String> = names.map(|(name, _)| format!("finger.hinge.{name}")).collect();
                let have = if names.len() > 1 { "have" } else { "has" };
                write!(
                    f,
                    "{} {have} no effect: hinges with finger.hinge.kind = \"{kind}\" have no necks",
                    names.join(", ")
                )
            }
            Self::Memory => {
                f.write_str("finger.material.memory has no effect: without finger.material.prony nothing is remembered")
            }
        }
    }
}

/// What a case says without an effect. A finger without lamellae may keep its hinge, a finger that is moved along a line its motor: neither is
/// counted.
pub(super) fn idle(case: &Case) -> impl Iterator<Item = Idle> {
    let design = &case.finger.design;
    let given = given(&design.hinge);
    let is_given = given.contains(&true) || design.hinge.kind != HingeKind::Welded;
    let hinge = match (design.lamellae.ribs().map(|ribs| ribs.ends), design.hinge.kind) {
        _ if design.lamella_count() == 0 => None,
        (Some(RibEnds::Welded), _) => is_given.then_some(Idle::Hinge { ends: "welded" }),
        (Some(RibEnds::Gap(_)), _) => is_given.then_some(Idle::Hinge { ends: "gap" }),
        (Some(RibEnds::Hinged), _) | (None, HingeKind::Flexible) => None,
        (None, HingeKind::Pinned) => given.contains(&true).then_some(Idle::Necks { kind: "pinned", given }),
        (None, HingeKind::Welded) => given.contains(&true).then_some(Idle::Necks { kind: "welded", given }),
    };
    let memory = (case.finger.prony.is_empty() && case.finger.memory != Memory::default()).then_some(Idle::Memory);
    hinge.into_iter().chain(memory)
}

/// Whether a hinge's length, thickness and origin are other than those of a case that does not give them.
fn given(hinge: &Hinge) -> [bool; 3] {
    [!hinge.length.is_empty(), hinge.thickness != NO_NECK, hinge.from != HingeFrom::Centreline]
}
