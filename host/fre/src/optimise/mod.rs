//! Designs searched for: goals and limits in a designer's words over any numbers of a case.
//!
//! Files, each using only those after it:
//!
//! - `report` – before and after as text, JSON and a page with pictures
//! - `front` – the front of two goals
//! - `starts` – the search from every start, with progress
//! - `log` – finished starts in a file; `error` – why a search has no result
//! - `search` – SLSQP from several starts
//! - `problem` – goal and limits as functions of the variables, with their derivatives
//! - `goal`, `measure`, `mass` – what is asked for, and its numbers
//! - `grasp` – a case solved as far as measures need it
//!
//! Derivatives come from the solver: of forces, strains, stiffness and the spread of the contact, with the design, the object's place and
//! shape and the motor axis. Those of a mass are exact as well. The place of a snap-through is differenced between solved cases.

mod error;
mod front;
mod goal;
mod grasp;
mod log;
mod mass;
mod measure;
mod problem;
mod report;
mod search;
mod starts;

pub use error::OptimiseError;
pub use front::{Front, FrontPoint, front};
pub use goal::{Goal, Limit, Variable};
pub use grasp::{Grasp, Known, Line, Numbers, Wanted};
pub use log::Log;
pub use mass::mass;
pub use measure::{MEASURES, Measure, Range};
pub use problem::{Functions, Problem, ProblemError, Values, value};
pub use report::{Changed, Held, Reached, Report, front_picture, front_text, page, pictures_of};
pub use search::{KEPT, Settings, Try, best, search, start};
pub use starts::{Progress, optimise};
