//! Rows of the contact border: what each is an equation for, and whether it is one.

use super::sample::Sample;
use crate::real::Real;
use crate::size::Blank;

/// Whether a row is an equation g + ε_c μ = 0, and what a tangent is instead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum ContactState {
    /// It is not: its multiplier is zero. First, so that a blank row is all zeros.
    #[default]
    Open,
    /// It is.
    Closed,
    /// It is, as a tangent: the place moves with the object, but for what its softness gives way.
    Stick,
    /// It is not: the place slips, with the tangential force m μ towards the tip.
    SlipUp,
    /// It is not: the place slips, with the tangential force m μ towards the base.
    SlipDown,
}

impl Blank for ContactState {
    const BLANK: Self = Self::Open;
}

/// What a row's gap is measured along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// The object's normal: the multiplier pushes only, μ ≥ 0.
    Normal,
    /// Its tangent, towards the finger's tip: the slip of the beam's surface, and the force of friction (see `newton::slip`).
    Tangent,
    /// Its tangent, for the turning of the contact force (see `newton::turning`): the multiplier has no bounds.
    Turning,
}

/// A row of the contact border: a place that touches or is about to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row<T> {
    /// Index of the place (see `Model::place`).
    pub sample: u16,
    pub direction: Direction,
    /// Of the present state; what a law makes of it is its own.
    pub state: ContactState,
    /// The place itself.
    pub place: Sample<T>,
    /// Signed gap g, mm.
    pub gap: T,
    /// Normal out of the object: of a sample that touches the one that strains the beam.
    pub normal: [T; 2],
    /// How far the object's normal at the sample is turned from it, rad, counter-clockwise; of a turning, Στ/Σμ of its patch, towards the tip.
    pub tilt: T,
    /// Curvature of the object's level line there, 1/mm.
    pub curvature: T,
    /// Softness ε_c of the row, mm/N.
    pub softness: T,
    /// Multiplier μ, N; 0 for a row that is open.
    pub multiplier: T,
}

impl<T: Real> Blank for Row<T> {
    const BLANK: Self = Self {
        sample: 0,
        direction: Direction::Normal,
        state: ContactState::Open,
        place: Sample::BLANK,
        gap: T::ZERO,
        normal: [T::ZERO; 2],
        tilt: T::ZERO,
        curvature: T::ZERO,
        softness: T::ZERO,
        multiplier: T::ZERO,
    };
}

impl<T> Row<T> {
    /// The sample touches the object in the present state.
    #[inline(always)]
    pub fn touches(&self) -> bool {
        self.direction == Direction::Normal && self.state == ContactState::Closed
    }

    /// The multiplier must not be negative.
    #[inline(always)]
    pub fn only_pushes(&self) -> bool {
        self.direction == Direction::Normal
    }
}

/// Cell whose front span a row touches.
#[inline]
pub(crate) fn cell_of<T: Real>(row: &Row<T>) -> usize {
    usize::from(row.place.cell)
}

/// The rows that touch a member, in order: none but for the front spans; `from` is where to begin to look.
#[inline]
pub(crate) fn own_rows<T: Real>(rows: &[Row<T>], index: usize, from: usize) -> core::ops::Range<usize> {
    let above = rows.get(from..).unwrap_or(&[]);
    from..from + above.iter().take_while(|row| cell_of(row) == index).count()
}
