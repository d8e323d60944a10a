//! The models that are compared.

use model_core::discretise::{Discretisation, Physics, Scheme};

/// A physics at a resolution: one of those compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Its name in tables.
    pub name: &'static str,
    /// Its discretisation.
    pub discretisation: Discretisation,
}

/// The paper's model as it is written.
pub const PAPER_FULL: usize = 0;
/// The paper's physics at the microcontroller's resolution.
pub const PAPER_REDUCED: usize = 1;
/// The extended physics at the paper's resolution.
pub const EXTENDED_FULL: usize = 2;
/// The extended physics at the microcontroller's resolution.
pub const EXTENDED_REDUCED: usize = 3;

/// The variants, in the order of the indices above.
pub fn variants() -> [Variant; 4] {
    let model = |name, discretisation| Variant { name, discretisation };
    [
        model("paper 170/20", Discretisation::full(Scheme::Paper, Physics::Paper)),
        model("paper reduced", Discretisation::reduced(Physics::Paper)),
        model("extended 170/20", Discretisation::full(Scheme::Trapezoid, Physics::Extended)),
        model("extended reduced", Discretisation::reduced(Physics::Extended)),
    ]
}

/// Which model is measured against which.
pub const COMPARED: [(usize, usize); 3] =
    [(PAPER_REDUCED, PAPER_FULL), (EXTENDED_REDUCED, EXTENDED_FULL), (PAPER_FULL, EXTENDED_FULL)];
