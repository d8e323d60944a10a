//! What a source reports.

use messages::{Grasp, Notice, Report, Shape};

use super::setup::Setup;

/// What a source reports.
#[derive(Clone, Debug, PartialEq)]
pub enum Told {
    /// A finger's part of a tick of the control loop.
    Report(Report),
    /// What the fingers come to together.
    Grasp(Grasp),
    /// The deformed finger.
    Shape(Box<Shape>),
    /// Something that happened.
    Event(Notice),
    /// The set-up from here on: settings, designs or objects have changed.
    Setup(Box<Setup>),
}
