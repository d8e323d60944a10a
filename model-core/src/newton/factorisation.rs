//! The factorisation: condensed members, the banded KKT matrix as L D Lᵀ, and the rows it was made with.
//!
//! A factorisation is a value that later residuals may be solved with: a chord step instead of Newton's (35). With the stiffness of a state
//! that is e away from the solution, an error shrinks by a factor of the order of e, for no second derivatives, no condensation, no
//! factorisation and no border: a third of the cost. At a servo's count e is about 1e-3, and a step with the stiffness of the tick's first
//! iteration shrinks the residuals about as much as one with the present stiffness.

use super::Hessian;
use super::assembly::{add_corrections, add_member, put_closures};
use super::condense::{Diagonal, Interior, condense};
use super::condensed::{Condensed, Front};
use super::end_gaps;
use super::evaluated::Evaluated;
use super::gaps::Contacts;
use super::kinematics::Kinematics;
use super::residual::Residual;
use super::settings::NewtonSettings;
use super::turning::{self, Patches};
use crate::access::Access;
use crate::contact::{Direction, Row};
use crate::linear::banded::{self, BAND};
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};

/// Gap of a row that is no longer one: nothing presses it shut, mm.
const ABSENT: f64 = 1e9;

/// Condensed members and the banded KKT, factorised.
pub(crate) struct Factorisation<T: Real, S: Size> {
    /// It has the second derivatives of the force's part: it takes the nodes' coupling, not the model's.
    pub curved: bool,
    /// Factorised interiors: inverse pivot and the two multipliers towards the next nodes.
    pub interiors: S::Nodes<[T; 3]>,
    /// Condensed front spans: what the contact rows on the spans above pull at.
    pub fronts: S::Cells<Front<T>>,
    /// Lower band of the condensed KKT matrix, then its factors; the last entry of a row is the diagonal.
    pub band: S::Unknowns<[T; BAND + 1]>,
    /// Its negative pivots, less the 2(K+1) that the closures give.
    pub excess: isize,
    /// Samples of the rows that it was made with, and how many, if it may be kept; the turnings among them, and their softnesses.
    samples: S::Contacts<u16>,
    noted: Option<u16>,
    patches: Patches,
    turnings: [T; turning::MOST],
}

impl<T: Real, S: Size> Factorisation<T, S> {
    pub const EMPTY: Self = Self {
        curved: false,
        interiors: <S::Nodes<[T; 3]> as Storage<[T; 3]>>::EMPTY,
        fronts: <S::Cells<Front<T>> as Storage<Front<T>>>::EMPTY,
        band: <S::Unknowns<[T; BAND + 1]> as Storage<[T; BAND + 1]>>::EMPTY,
        excess: 0,
        samples: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        noted: None,
        patches: Patches::NONE,
        turnings: [T::ZERO; turning::MOST],
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.interiors.fit(model.node_count)
            && self.fronts.fit(model.cells())
            && self.band.fit(model.unknowns())
            && self.samples.fit(S::CONTACTS)
    }

    /// Condenses the members at the evaluated state (28), (29) and factorises the banded KKT matrix (30); `right` becomes the condensed
    /// residual with its sign changed, forward-substituted.
    pub fn make(
        &mut self,
        at: Evaluated<'_, T, S>,
        residual: &Residual<T, S>,
        diagonal: Diagonal<T>,
        right: &mut [T],
    ) -> usize {
        let Evaluated { model, kinematics, .. } = at;
        let n = model.unknowns();
        self.noted = None;
        self.curved = diagonal.curvature != T::ZERO;
        self.band.as_mut().run_mut(0..n).fill([T::ZERO; BAND + 1]);
        begin_right(model, residual, right);
        let mut negative = 0;
        for (index, member) in model.members().iter().enumerate() {
            let (condensed, below_zero) = self.condense(model, kinematics, index, diagonal);
            negative += below_zero;
            add_corrections(right, member, &condensed.corrections);
            add_member(self.band.as_mut(), member, &condensed);
            if index < model.cells() {
                self.fronts.as_mut().put(index, condensed.front());
            }
        }
        end_gaps::note(model, kinematics, self.interiors.as_mut());
        negative += banded::factorise(self.band.as_mut().run_mut(0..n), model.topology.scale.as_ref());
        self.excess = negative as isize - 2 * model.cells() as isize;
        self.substitute(model, right);
        negative
    }

    /// Condenses a member; with it the number of negative pivots.
    #[inline(always)]
    pub fn condense(
        &mut self,
        model: &Model<T, S>,
        kinematics: &Kinematics<T, S>,
        index: usize,
        diagonal: Diagonal<T>,
    ) -> (Condensed<T>, usize) {
        let (Some(member), Some(out)) = (model.member(index), kinematics.members.as_ref().get(index)) else {
            return (Condensed::BLANK, 0);
        };
        let nodes = member.nodes();
        let (Some(at_rest), Some(constant), Some(list), Some(factors)) = (
            model.diagonal.as_ref().get(nodes.clone()),
            model.coupling.as_ref().get(nodes.clone()),
            kinematics.nodes.as_ref().get(nodes.clone()),
            self.interiors.as_mut().get_mut(nodes),
        ) else {
            return (Condensed::BLANK, 0);
        };
        condense(Interior { member, out, at_rest, constant, nodes: list, curved: self.curved }, factors, diagonal)
    }

    /// Changes the sign of a condensed residual and forward-substitutes it.
    pub fn substitute(&self, model: &Model<T, S>, right: &mut [T]) {
        let n = model.unknowns();
        for value in right.run_mut(0..n) {
            *value = -*value;
        }
        banded::forward(self.band.as_ref().run(0..n), right.run_mut(0..n), 0);
    }

    /// The same ends of ribs touch the back beam as when it was made.
    pub fn has_gaps_of(&self, model: &Model<T, S>, kinematics: &Kinematics<T, S>) -> bool {
        end_gaps::are_as_noted(model, kinematics, self.interiors.as_ref())
    }

    /// It is bordered by other rows than those noted.
    pub fn forget_rows(&mut self) {
        self.noted = None;
    }

    /// Notes which rows it has been made with, if it may be kept.
    pub fn note(&mut self, contacts: &Contacts<T, S>, rubs: bool) {
        if !NewtonSettings::<T>::of_precision().keeps_factors(rubs) {
            return;
        }
        for (sample, row) in self.samples.as_mut().iter_mut().zip(contacts.rows()) {
            *sample = row.sample;
        }
        self.noted = Some(contacts.count as u16);
        self.patches = contacts.patches;
        for (softness, patch) in self.turnings.iter_mut().zip(self.patches.list()) {
            *softness = contacts.rows.as_ref().at(usize::from(patch.row)).softness;
        }
    }

    /// Brings the rows of the last evaluation to the places that they have in the factorisation. Those that it has besides become rows
    /// without a contact. False if it lacks one of them, or if what a turning is beside no longer touches: the rows are then as they were.
    pub fn takes(&self, model: &Model<T, S>, contacts: &mut Contacts<T, S>) -> bool {
        let Some(noted) = self.noted.map(usize::from) else { return false };
        let (samples, count) = (self.samples.as_ref().run(0..noted), contacts.count);
        let rows = contacts.rows.as_mut();
        let mut present = rows.iter().take(count).map(|row| row.sample).peekable();
        for (j, &sample) in samples.iter().enumerate() {
            if !self.patches.has(j) {
                present.next_if_eq(&sample);
            }
        }
        // The row at the middle of a patch's force, which its turning is beside.
        let touches = |sample: u16| rows.iter().take(count).any(|row| row.sample == sample && row.touches());
        let all_touch = self.patches.list().iter().all(|patch| touches(samples.at(usize::from(patch.row))));
        if present.next().is_some() || !all_touch {
            return false;
        }
        // From the last one, so that no row is overwritten before it has moved.
        let mut from = count;
        let mut above = None;
        for (j, &sample) in samples.iter().enumerate().rev() {
            // A tangent comes before its normal.
            let is_normal = above != Some(sample);
            above = Some(sample).filter(|_| is_normal && !self.patches.has(j));
            let last = from.checked_sub(1).and_then(|last| rows.get(last)).filter(|row| row.sample == sample);
            let row = match last {
                Some(&row) if !self.patches.has(j) => {
                    from -= 1;
                    row
                }
                _ => Row {
                    sample,
                    direction: if is_normal { Direction::Normal } else { Direction::Tangent },
                    place: model.place(sample),
                    gap: T::of(ABSENT),
                    softness: model.contact_softness(),
                    ..Row::BLANK
                },
            };
            rows.put(j, row);
        }
        contacts.count = noted;
        contacts.patches = self.patches;
        for (patch, &softness) in self.patches.list().iter().zip(&self.turnings) {
            let row = usize::from(patch.row);
            // It has its neighbour's sample.
            let beside = rows.at(row.saturating_sub(1));
            let turning = turning::turning_row(rows.run(patch.rows()), &beside, softness);
            rows.put(row, turning);
        }
        true
    }
}

/// Begins a condensed residual: the joints' gradients and the closures' errors.
pub(super) fn begin_right<T: Real, S: Size>(model: &Model<T, S>, residual: &Residual<T, S>, right: &mut [T]) {
    for (right, &gradient) in right.iter_mut().zip(residual.joints.as_ref()) {
        *right = gradient;
    }
    put_closures(model, residual, right);
}

impl<T: Real> Diagonal<T> {
    /// That of a second derivative, shifted.
    pub fn of(hessian: Hessian, shift: T) -> Self {
        Self { curvature: if hessian == Hessian::Newton { T::one() } else { T::ZERO }, shift }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactState;
    use crate::design::ladder_80;
    use crate::discretise::{Discretisation, Physics, discretise};
    use crate::size::Paper;
    use std::boxed::Box;

    /// Rows of these samples, which touch.
    fn touching(samples: &[u16]) -> Box<Contacts<f64, Paper>> {
        let mut contacts: Box<Contacts<f64, Paper>> = Box::new(Contacts::EMPTY);
        for (row, &sample) in contacts.rows.iter_mut().zip(samples) {
            let (state, normal) = (ContactState::Closed, [-0.8, 0.6]);
            *row = Row { sample, state, normal, tilt: 1e-3, curvature: 0.02, multiplier: 2.0, ..Row::BLANK };
        }
        contacts.count = samples.len();
        contacts
    }

    #[test]
    fn present_rows_move_to_the_places_of_a_kept_factorisation() {
        let mut model: Box<Model<f64, Paper>> = Box::new(Model::EMPTY);
        discretise(&ladder_80(), &Discretisation::reduced(Physics::Paper), &mut model).expect("a valid finger");
        let mut made = touching(&[3, 7, 9]);
        made.add_turning(Paper::CONTACTS);
        assert!(made.patches.list().len() == 1 && made.patches.has(2), "behind the middle one");
        let mut kept: Box<Factorisation<f64, Paper>> = Box::new(Factorisation::EMPTY);
        kept.note(&made, false);

        let mut contacts = touching(&[7, 9]);
        assert!(kept.takes(&model, &mut contacts));
        assert_eq!(contacts.rows().iter().map(|row| row.sample).collect::<std::vec::Vec<_>>(), [3, 7, 7, 9]);
        let [absent, middle, turning, last] = contacts.rows() else { panic!("four rows") };
        assert!(!absent.touches() && absent.gap >= ABSENT, "nothing presses it shut");
        assert!(middle.touches() && last.touches() && !turning.touches());
        assert_eq!((turning.direction, turning.normal), (Direction::Turning, [-0.6, -0.8]));
        assert!((turning.gap + turning.softness * 4e-3).abs() < 1e-15, "Σ μ tilt of the present rows");

        let is_refused = |mut contacts: Box<Contacts<f64, Paper>>| {
            let before = contacts.rows().to_vec();
            !kept.takes(&model, &mut contacts) && contacts.rows() == before
        };
        assert!(is_refused(touching(&[3, 8])), "a row that it lacks");
        assert!(is_refused(touching(&[3, 9])), "the turning's own row no longer touches");
    }

    /// With friction a place that no longer touches leaves both its rows, the tangent first.
    #[test]
    fn a_tangent_keeps_its_place_before_its_normal() {
        let mut model: Box<Model<f64, Paper>> = Box::new(Model::EMPTY);
        discretise(&ladder_80(), &Discretisation::reduced(Physics::Paper), &mut model).expect("a valid finger");
        let rubbing = |samples: &[u16]| {
            let mut contacts = touching(samples);
            for j in (0..samples.len()).rev() {
                let normal = contacts.rows[j];
                contacts.rows[2 * j + 1] = normal;
                let tangent = Row { direction: Direction::Tangent, state: ContactState::Stick, tilt: 0.0, ..normal };
                contacts.rows[2 * j] = tangent;
            }
            contacts.count = 2 * samples.len();
            contacts
        };
        let mut made = rubbing(&[3, 7, 9]);
        made.add_turning(Paper::CONTACTS);
        let mut kept: Box<Factorisation<f64, Paper>> = Box::new(Factorisation::EMPTY);
        kept.note(&made, true);
        let directions = |contacts: &Contacts<f64, Paper>| {
            contacts.rows().iter().map(|row| (row.sample, row.direction)).collect::<std::vec::Vec<_>>()
        };
        let mut contacts = rubbing(&[7]);
        assert!(kept.takes(&model, &mut contacts));
        assert_eq!(directions(&contacts), directions(&made));
        let states: std::vec::Vec<_> = contacts.rows().iter().map(|row| row.state).collect();
        use ContactState::{Closed, Open, Stick};
        assert_eq!(states, [Open, Open, Stick, Closed, Closed, Open, Open]);
    }
}
