//! Finite elements: the same finger as a plane continuum, pressed on the same object by CalculiX (`ccx`).
//!
//! The finger is meshed with its real thicknesses, hinge necks, lamella bars, fillets and solid tip, in second-order elements; the
//! object is a rigid surface that moves in the finger frame as the motion says. Contact is known to the front beam's outer face and
//! the tip's end face; a place at which the object nevertheless reaches into the deformed mesh has no force. A pinned lamella is a
//! stiff link between the centrelines. Coulomb friction while the finger closes; St. Venant–Kirchhoff material. Forces are those on the object.

mod analysis;
mod ccx;
mod deck;
mod error;
mod fillet;
mod frd;
mod grading;
mod mesh;
mod place;
mod plan;
mod region;
mod start;
mod surface;

pub use analysis::{Analysis, DECK, Pose, Progress};
pub use ccx::{Effort, Printed, parse_dat, parse_sta};
pub use deck::deck;
pub use error::{FeaError, MAX_REFINEMENT};
pub use fillet::Fillet;
pub use frd::parse_frd;
pub use mesh::{Element, Layer, Mesh, Part, Side};
pub use place::{in_finger, object_line};
pub use plan::{HOLD_STEPS, Plan, STEP};
pub use region::{Faces, Joint, Point, Region};
pub use surface::Surface;
