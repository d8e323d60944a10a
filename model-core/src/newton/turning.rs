//! The turning of the contact force as the beam slides along the object: the contact curvature in the Newton step.
//!
//! A touching sample that moves by dP turns its normal by κ t (t·dP), with t the tangent and κ the curvature of the object's
//! level line: its force changes by −ν t with ν = μκ t·dP. Exactly that is one row t·dP − ν/(μκ) = 0 per contact. Neighbouring
//! samples of a beam that hardly stretches move alike along the object, so that one row, at the middle of the force, with the
//! sum of the multipliers, does for a patch of them. It spares a sixth of the iterations of a closing in steps of 1°; being a matter of the step only,
//! it leaves the solution as it is.
//!
//! A round object touches in one patch. The corners of a box are one each: they are sharp and far apart, and do not slide alike.

use core::ops::Range;

use super::gaps::Contacts;
use crate::access::Access;
use crate::contact::{ContactState, Direction, Row};
use crate::real::Real;
use crate::size::{Blank, Size};

/// Patches that have a row of their own at most; those further up the beam are the last one's.
pub(crate) const MOST: usize = 4;
/// A stiffness μκ below which the turning does not matter, and its row would only spoil the scale of the others, N/mm.
const LEAST_STIFFNESS: f64 = 1e-3;
/// By how much less the normal turns between two contacts, rad, than along an outline as sharp as the sharper one, where they are of two patches.
const APART: f64 = 0.5;

/// A patch's turning row, and where its rows begin and end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Patch {
    pub row: u16,
    first: u16,
    end: u16,
}

impl Patch {
    /// Its rows, the turning among them.
    pub fn rows(&self) -> Range<usize> {
        usize::from(self.first)..usize::from(self.end)
    }
}

impl Blank for Patch {
    const BLANK: Self = Self { row: 0, first: 0, end: 0 };
}

/// The patches with a turning row, base to tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Patches {
    list: [Patch; MOST],
    count: u8,
}

impl Patches {
    pub const NONE: Self = Self { list: [Patch::BLANK; MOST], count: 0 };

    pub fn list(&self) -> &[Patch] {
        self.list.run(0..usize::from(self.count))
    }

    /// The row is a turning.
    pub fn has(&self, row: usize) -> bool {
        self.list().iter().any(|patch| usize::from(patch.row) == row)
    }

    fn push(&mut self, patch: Patch) {
        self.list.put(usize::from(self.count), patch);
        self.count += 1;
    }
}

/// What the contacts of a patch make of its turning.
struct Sums<T> {
    /// Σ μ, Σ μκ, Σ μϑ of the normals' tilt ϑ, and Σ τ.
    push: T,
    stiffness: T,
    tilted: T,
    along: T,
}

impl<T: Real> Sums<T> {
    fn of(rows: &[Row<T>]) -> Self {
        let mut sums = Self { push: T::ZERO, stiffness: T::ZERO, tilted: T::ZERO, along: T::ZERO };
        for row in rows {
            match row.direction {
                Direction::Normal => {
                    sums.push += row.multiplier;
                    sums.stiffness += row.multiplier * row.curvature;
                    sums.tilted += row.multiplier * row.tilt;
                }
                Direction::Tangent => sums.along += row.multiplier,
                Direction::Turning => {}
            }
        }
        sums
    }

    /// The turning row beside one of the patch's.
    fn row(&self, beside: &Row<T>, softness: T) -> Row<T> {
        Row {
            direction: Direction::Turning,
            state: ContactState::Closed,
            gap: -(softness * self.tilted),
            normal: [-beside.normal[1], beside.normal[0]],
            tilt: if self.push > T::ZERO { self.along / self.push } else { T::ZERO },
            softness,
            multiplier: T::ZERO,
            ..*beside
        }
    }
}

/// The turning row of a patch, beside one of its contacts.
pub(super) fn turning_row<T: Real>(patch: &[Row<T>], beside: &Row<T>, softness: T) -> Row<T> {
    Sums::of(patch).row(beside, softness)
}

/// Two contacts that follow one another up the beam are of two patches.
fn parts<T: Real>(below: &Row<T>, above: &Row<T>) -> bool {
    let sharper = below.curvature.abs().max(above.curvature.abs());
    let turned = below.normal[0] * above.normal[1] - below.normal[1] * above.normal[0];
    sharper * (above.place.arc - below.place.arc) - turned.abs() > T::of(APART)
}

impl<T: Real, S: Size> Contacts<T, S> {
    /// Puts a row beside that of the sample at the middle of each patch's force, if something touches and there is room for so many rows.
    pub fn add_turning(&mut self, capacity: usize) {
        self.patches = Patches::NONE;
        let (count, mut room) = (self.count, capacity.saturating_sub(self.count));
        let (mut added, mut first) = ([Row::BLANK; MOST], 0);
        while first < count && room > 0 {
            let is_last = usize::from(self.patches.count) + 1 == MOST;
            let end = if is_last { count } else { self.end_of_patch(first) };
            let patch = self.rows.as_ref().run(first..end);
            let sums = Sums::of(patch);
            let mut below = T::ZERO;
            let middle = patch.iter().position(|row| {
                below += if row.only_pushes() { row.multiplier } else { T::ZERO };
                below + below >= sums.push
            });
            if let Some(beside) =
                middle.filter(|_| sums.push > T::ZERO && sums.stiffness.abs() > T::of(LEAST_STIFFNESS))
            {
                let before = self.patches.list().len();
                added.put(before, sums.row(&patch.at(beside), -T::one() / sums.stiffness));
                // The rows below have moved already, by one for each patch.
                let [row, first, end] = [first + beside + 1, first, end + 1].map(|row| (row + before) as u16);
                self.patches.push(Patch { row, first, end });
                room -= 1;
            }
            first = end;
        }
        // Those above make room, from the last one.
        let mut from = count;
        self.count = count + self.patches.list().len();
        let mut left = self.patches.list().len();
        for slot in (0..self.count).rev() {
            if left == 0 {
                break;
            }
            let row = match self.patches.list().get(left - 1) {
                Some(patch) if usize::from(patch.row) == slot => {
                    left -= 1;
                    added.at(left)
                }
                _ => {
                    from -= 1;
                    self.rows.as_ref().at(from)
                }
            };
            self.rows.as_mut().put(slot, row);
        }
    }

    /// Behind the last row of the patch that begins at a row.
    fn end_of_patch(&self, first: usize) -> usize {
        let rows = self.rows();
        let mut below: Option<&Row<T>> = None;
        for (j, row) in rows.iter().enumerate().skip(first).filter(|(_, row)| row.touches() && row.multiplier > T::ZERO)
        {
            if below.is_some_and(|below| parts(below, row)) {
                // A tangent comes before its normal.
                let has_tangent =
                    j.checked_sub(1).and_then(|j| rows.get(j)).is_some_and(|row| row.direction == Direction::Tangent);
                return j - usize::from(has_tangent);
            }
            below = Some(row);
        }
        rows.len()
    }

    /// Negative eigenvalues that the turnings' rows have by themselves: one each on a convex object, none in a bore, whose normals turn the
    /// other way.
    pub fn turning_negative(&self) -> isize {
        let softness = |patch: &Patch| self.rows.as_ref().at(usize::from(patch.row)).softness;
        self.patches.list().iter().filter(|patch| softness(patch) < T::ZERO).count() as isize
    }

    /// How far the samples of a patch slide along the object by the rows' steps Δμ, mm; positive turns the normals counter-clockwise for a
    /// convex object.
    pub fn slide(&self, patch: &Patch, delta: &[T]) -> T {
        let index = usize::from(patch.row);
        match (self.rows.as_ref().get(index), delta.get(index)) {
            // ν = μκ t·dP + Σ μ tilt, and the row's softness is −1/(μκ).
            (Some(row), Some(&delta)) => -delta * row.softness - row.gap,
            _ => T::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::{Blank, Paper};
    use std::boxed::Box;

    /// Rows that touch with these multipliers, on a level line of this curvature.
    fn touching(multipliers: &[f64], curvature: f64) -> Box<Contacts<f64, Paper>> {
        let mut contacts: Box<Contacts<f64, Paper>> = Box::new(Contacts::EMPTY);
        for (j, &multiplier) in multipliers.iter().enumerate() {
            let (state, normal) = (ContactState::Closed, [-0.8, 0.6]);
            contacts.rows[j] =
                Row { sample: j as u16, state, normal, tilt: 1e-3, curvature, softness: 0.5, multiplier, ..Row::BLANK };
        }
        contacts.count = multipliers.len();
        contacts
    }

    #[test]
    fn one_row_at_the_middle_of_the_force_stands_for_all() {
        let mut contacts = touching(&[1.0, 1.0, 4.0, 1.0], 0.02);
        contacts.add_turning(5);
        assert_eq!((contacts.count, contacts.patches.list().len(), contacts.patches.has(3)), (5, 1, true));
        let stiffness = 7.0 * 0.02;
        let row = contacts.rows[3];
        assert!(!row.touches() && !row.only_pushes() && row.state == ContactState::Closed);
        assert_eq!((row.sample, row.multiplier, row.normal), (2, 0.0, [-0.6, -0.8]));
        assert!((row.gap - 7e-3 / stiffness).abs() < 1e-15 && (row.softness + 1.0 / stiffness).abs() < 1e-15);
        assert!(contacts.rows[4].sample == 3 && contacts.rows[4].touches(), "the row above has made room");
        // ν = μκ t·dP + Σ μ tilt.
        let slid = contacts.slide(&contacts.patches.list()[0], &[0.0, 0.0, 0.0, stiffness * 0.25 + 7e-3, 0.0]);
        assert!((slid - 0.25).abs() < 1e-12, "{slid}");
    }

    /// Two corners and the flat side between them: a row for each corner, and each sample slides as its own corner does.
    #[test]
    fn corners_are_patches_of_their_own() {
        let mut contacts = touching(&[1.0, 2.0, 5.0, 4.0, 1.0], 0.5);
        for (row, (arc, curvature)) in
            contacts.rows.iter_mut().zip([(10.0, 0.5), (10.5, 0.5), (30.0, 0.0), (50.0, 0.5), (50.5, 0.5)])
        {
            (row.place.arc, row.curvature) = (arc, curvature);
        }
        contacts.add_turning(8);
        let found: std::vec::Vec<_> = contacts.patches.list().iter().map(|patch| (patch.row, patch.rows())).collect();
        assert_eq!((contacts.count, found), (7, std::vec::Vec::from([(2, 0..3), (5, 4..7)])));
        let samples: std::vec::Vec<_> = contacts.rows().iter().map(|row| (row.sample, row.direction)).collect();
        use Direction::{Normal, Turning};
        let expected = [(0, Normal), (1, Normal), (1, Turning), (2, Normal), (3, Normal), (3, Turning), (4, Normal)];
        assert_eq!(samples, expected);
        assert_eq!(contacts.turning_negative(), 2);
        let softness: std::vec::Vec<_> =
            contacts.patches.list().iter().map(|patch| -1.0 / contacts.rows[usize::from(patch.row)].softness).collect();
        assert_eq!(softness, [1.5, 2.5]);
        // Room for one only: the first one's.
        let mut contacts = touching(&[1.0, 2.0], 0.5);
        contacts.rows[1].place.arc = 40.0;
        contacts.add_turning(3);
        assert_eq!((contacts.count, contacts.patches.list().len(), contacts.patches.has(1)), (3, 1, true));
        // On one arc the normals turn as far as the way between them says.
        let mut contacts = touching(&[1.0, 2.0], 0.5);
        (contacts.rows[1].place.arc, contacts.rows[1].normal) = (2.0, [-0.96, -0.28]);
        contacts.add_turning(8);
        assert_eq!(contacts.patches.list().len(), 1);
    }

    #[test]
    fn its_own_sign_is_negative_outside_of_an_object_and_positive_in_a_bore() {
        for (curvature, expected) in [(0.02, 1), (-0.02, 0)] {
            let mut contacts = touching(&[2.0, 3.0], curvature);
            contacts.add_turning(5);
            assert_eq!((contacts.patches.list().len(), contacts.turning_negative()), (1, expected));
        }
    }

    #[test]
    fn there_is_none_without_room_force_or_curvature() {
        for (multipliers, curvature, capacity) in
            [([1.0, 1.0], 0.02, 2), ([0.0, 0.0], 0.02, 5), ([1.0, 1.0], 0.0, 5), ([1.0, 1.0], 1e-4, 5)]
        {
            let mut contacts = touching(&multipliers, curvature);
            contacts.add_turning(capacity);
            assert_eq!((contacts.count, contacts.patches, contacts.turning_negative()), (2, Patches::NONE, 0));
        }
    }
}
