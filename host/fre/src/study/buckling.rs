//! A rib that is about to bow, or has done so.

use model_core::equilibrium::Buckling;
use serde::{Deserialize, Serialize};

/// The rib as JSON has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Written {
    /// Its name, such as `rib 3`.
    pub rib: String,
    /// Its force over its buckling load between clamped ends, or with a free end where it has one.
    pub load_share: f64,
}

impl From<Buckling> for Written {
    fn from(Buckling { rib, share }: Buckling) -> Self {
        Self { rib: format!("rib {}", rib + 1), load_share: share }
    }
}
