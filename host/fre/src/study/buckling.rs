//! A rib that is about to bow, or has done so.

use model_core::equilibrium::Buckling;
use serde::{Deserialize, Serialize};

/// A rib is reported from this part of its buckling load between clamped ends on. In a finger its ends turn with the beams: the ribs of
/// `umi` bow at 0.88 to 0.92 of it (`ribs_that_bow_are_warned_of`). This is a tenth below.
pub const NEAR: f64 = 0.8;

/// The rib as JSON has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Written {
    /// Its name, such as `rib 3`.
    pub rib: String,
    /// Its force over its buckling load between clamped ends.
    pub load_share: f64,
}

impl From<Buckling> for Written {
    fn from(Buckling { rib, share }: Buckling) -> Self {
        Self { rib: format!("rib {}", rib + 1), load_share: share }
    }
}
