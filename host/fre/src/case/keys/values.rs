//! Values that a file may give in more than one form.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number, or one that changes along the finger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Along {
    /// The same everywhere.
    Everywhere(f64),
    /// Pairs (position, value), linear between them.
    Taper(#[schemars(length(min = 1))] Vec<(f64, f64)>),
}

/// A number for all lamellae, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum PerRib {
    /// The same for all.
    All(f64),
    /// One for each, base to tip.
    Each(Vec<f64>),
}

/// Thickness of lamellae.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum RibThickness {
    /// The same for all.
    All(f64),
    /// One for each, base to tip.
    Each(Vec<f64>),
    /// For each, at its front and at its back end.
    #[schemars(extend("x-pair" = "[front, back]"))]
    Tapered(Vec<[f64; 2]>),
}

/// Where the tip begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum TipFrom {
    /// At a height.
    Height(f64),
    /// Where other keys say.
    Word(TipWord),
}

/// A tip's beginning by other keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(extend("type" = "string"))]
pub enum TipWord {
    /// Where the beams' inner faces meet.
    Auto,
}

impl PerRib {
    /// Zero for all.
    pub(in crate::case) fn zero() -> Self {
        Self::All(0.0)
    }
}
