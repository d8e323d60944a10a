//! Thinning of the rows that a kink of the motion makes.

use super::gaps::{Contacts, REACH};
use crate::access::Access;
use crate::contact::{Direction, Row};
use crate::real::Real;
use crate::size::Size;

impl<T: Real, S: Size> Contacts<T, S> {
    /// Thins the rows of samples that only penetrate if there are more than `many`: those near a touching sample stay, and of the
    /// others those that penetrate deepest among their neighbours.
    ///
    /// Where the motion has a kink, the extrapolated beam penetrates with many samples that will not touch, and a step costs the
    /// square of its rows. What is left out and still penetrates after the step is a row of the next iteration.
    /// With friction a tangent goes with its normal.
    pub fn thin(&mut self, many: usize) {
        let rows = self.rows_mut();
        let touches = |row: &Row<T>| row.touches();
        let places = rows.iter().filter(|row| row.only_pushes()).count();
        let new = rows.iter().filter(|row| row.only_pushes() && !touches(row)).count();
        if new <= many || new == places {
            return;
        }
        let mut count = 0;
        let mut below: Option<Row<T>> = None;
        let mut touching_below: Option<u16> = None;
        let mut tangent: Option<Row<T>> = None;
        for j in 0..rows.len() {
            let row = rows.at(j);
            if !row.only_pushes() {
                tangent = Some(row);
                continue;
            }
            let mut above = rows.get(j + 1..).unwrap_or(&[]).iter().filter(|row| row.only_pushes());
            let keeps = touches(&row) || {
                let near_below = touching_below.is_some_and(|k| row.sample - k <= REACH);
                let near_above = above.clone().take_while(|r| r.sample - row.sample <= REACH).any(touches);
                let deeper = |other: &Row<T>| other.sample.abs_diff(row.sample) > 1 || row.gap < other.gap;
                near_below || near_above || (below.as_ref().is_none_or(deeper) && above.next().is_none_or(deeper))
            };
            if touches(&row) {
                touching_below = Some(row.sample);
            }
            below = Some(row);
            let tangent = tangent.take();
            if keeps {
                for row in tangent.into_iter().chain([row]) {
                    rows.put(count, row);
                    count += 1;
                }
            }
        }
        self.count = count;
    }
}

impl<T: Real, S: Size> Contacts<T, S> {
    /// Keeps of the rows that do not touch the deepest ones, at most `most`: where there is time for a single step, its cost is bounded, and the
    /// next one sees what this one has left out. With friction a tangent goes with its normal.
    pub fn cut(&mut self, most: usize) {
        let is_new = |row: &Row<T>| row.only_pushes() && !row.touches();
        let mut new = self.rows().iter().filter(|row| is_new(row)).count();
        while new > most {
            let rows = self.rows().iter().enumerate().filter(|(_, row)| is_new(row));
            let farthest = rows.fold(None, |found: Option<(usize, T)>, (index, row)| match found {
                Some((_, gap)) if row.gap <= gap => found,
                _ => Some((index, row.gap)),
            });
            let Some((index, _)) = farthest else { return };
            let before = index.checked_sub(1).and_then(|before| self.rows().get(before));
            let paired = before.is_some_and(|row| row.direction == Direction::Tangent);
            let (from, by) = if paired { (index - 1, 2) } else { (index, 1) };
            for j in from + by..self.count {
                let row = self.rows.as_ref().at(j);
                self.rows.as_mut().put(j - by, row);
            }
            (self.count, new) = (self.count - by, new - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactState;
    use crate::size::{Blank, Paper};
    use std::boxed::Box;
    use std::vec::Vec;

    /// Rows with these gaps, from sample 10 on, of which some touch.
    fn contacts(gaps: &[f64], touching: &[u16]) -> Box<Contacts<f64, Paper>> {
        let mut contacts: Box<Contacts<f64, Paper>> = Box::new(Contacts::EMPTY);
        for (j, &gap) in gaps.iter().enumerate() {
            let sample = 10 + j as u16;
            let touches = touching.contains(&sample);
            let (state, multiplier) = if touches { (ContactState::Closed, 1.0) } else { (ContactState::Open, 0.0) };
            contacts.rows[j] = Row { sample, state, gap, multiplier, ..Row::BLANK };
        }
        contacts.count = gaps.len();
        contacts
    }

    /// Samples that are left.
    fn thinned(gaps: &[f64], touching: &[u16], many: usize) -> Vec<u16> {
        let mut contacts = contacts(gaps, touching);
        contacts.thin(many);
        contacts.rows().iter().map(|row| row.sample).collect()
    }

    const GAPS: [f64; 12] = [-0.1, 0.0, -0.1, -0.2, -0.3, -0.4, -0.3, -0.2, -0.3, -0.5, -0.6, -0.2];

    #[test]
    fn of_many_new_rows_the_deepest_and_those_beside_a_touching_one_stay() {
        // 11 touches: 10, 12 and 13 are near it; 15 and 20 are deeper than their neighbours.
        assert_eq!(thinned(&GAPS, &[11], 5), [10, 11, 12, 13, 15, 20]);
        // The last one touches as well.
        assert_eq!(thinned(&GAPS, &[11, 21], 5), [10, 11, 12, 13, 15, 19, 20, 21]);
    }

    #[test]
    fn of_rows_that_do_not_touch_the_deepest_are_kept() {
        let cut = |touching: &[u16], most: usize| {
            let mut contacts = contacts(&GAPS, touching);
            contacts.cut(most);
            contacts.rows().iter().map(|row| row.sample).collect::<Vec<_>>()
        };
        assert_eq!(cut(&[11, 12], 3), [11, 12, 15, 19, 20]);
        assert_eq!(cut(&[11, 20], 0), [11, 20]);
        assert_eq!(cut(&[], 20).len(), GAPS.len());
    }

    #[test]
    fn tangents_go_with_their_normals() {
        let mut contacts: Box<Contacts<f64, Paper>> = Box::new(Contacts::EMPTY);
        for (j, &gap) in GAPS.iter().enumerate() {
            let sample = 10 + j as u16;
            let (state, multiplier) =
                if sample == 11 { (ContactState::Closed, 1.0) } else { (ContactState::Open, 0.0) };
            let normal = Row { sample, state, gap, multiplier, ..Row::BLANK };
            contacts.rows[2 * j] = Row { direction: Direction::Tangent, ..normal };
            contacts.rows[2 * j + 1] = normal;
        }
        contacts.count = 2 * GAPS.len();
        contacts.thin(5);
        let pairs = contacts.rows().as_chunks::<2>().0;
        let kept: Vec<u16> = pairs
            .iter()
            .map(|[tangent, normal]| {
                assert!(
                    tangent.direction == Direction::Tangent && normal.only_pushes() && tangent.sample == normal.sample
                );
                normal.sample
            })
            .collect();
        assert_eq!((kept.as_slice(), contacts.count), ([10, 11, 12, 13, 15, 20].as_slice(), 12));
    }

    #[test]
    fn few_new_rows_and_those_of_a_first_contact_all_stay() {
        let all: Vec<u16> = (10..22).collect();
        assert_eq!(thinned(&GAPS, &[11], 11), all);
        assert_eq!(thinned(&GAPS, &[], 5), all);
    }
}
