//! A force through the spans below a contact: what the columns of all contact rows share.
//!
//! A row pulls with its normal n at the force of every span below its own, so that up to the joint at which its span begins its
//! column is E n, with the same two columns E for all rows. They are forward-substituted once, L⁻¹E, and what they make of
//! D = −Z + Qᵀ KKT⁻¹ Q is summed once over the unknowns so far, as a tensor of two by two: how far a force moves the point at which
//! the span begins, with all that lies below it eliminated. A column of its own begins at its span.

use super::factorisation::Factorisation;
use crate::access::Access;
use crate::linear::banded::{self, BAND};
use crate::model::Model;
use crate::real::Real;
use crate::size::{Size, Storage};
use crate::topology::CLAMPED;

/// The force through the spans below the one that was passed to last.
pub(super) struct Through<T: Real, S: Size> {
    /// E of a force along x and along y; L⁻¹E up to where the span begins.
    columns: [S::Unknowns<T>; 2],
    /// Spans below, and unknowns whose entries are substituted.
    spans: usize,
    unknowns: usize,
    /// Σ XX of the spans below less (L⁻¹E)ᵀ D⁻¹ L⁻¹E of the unknowns: xx, xy and yy, mm/N.
    yielding: [T; 3],
    /// Σ rx of the spans below, less (L⁻¹E)ᵀ D⁻¹ of the condensed residual: mm.
    found: [T; 2],
}

impl<T: Real, S: Size> Through<T, S> {
    pub const EMPTY: Self = Self {
        columns: [const { <S::Unknowns<T> as Storage<T>>::EMPTY }; 2],
        spans: 0,
        unknowns: 0,
        yielding: [T::ZERO; 3],
        found: [T::ZERO; 2],
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.columns.iter_mut().all(|column| column.fit(model.unknowns()))
    }

    /// Begins below the first span.
    pub fn begin(&mut self, model: &Model<T, S>) {
        for column in &mut self.columns {
            column.as_mut().run_mut(0..model.unknowns()).fill(T::ZERO);
        }
        (self.spans, self.unknowns) = (0, 0);
        (self.yielding, self.found) = ([T::ZERO; 3], [T::ZERO; 2]);
    }

    /// Goes on to a span, never back. `right` is the condensed residual, substituted.
    pub fn pass_to(&mut self, model: &Model<T, S>, kkt: &Factorisation<T, S>, right: &[T], span: usize) {
        let [along_x, along_y] = self.columns.each_mut().map(AsMut::as_mut);
        let ([xx, xy, yy], [x, y]) = (&mut self.yielding, &mut self.found);
        let mut add = |unknown: usize, [x, y]: [T; 2]| {
            along_x.add(unknown, -x);
            along_y.add(unknown, -y);
        };
        let spans = self.spans..span.max(self.spans);
        for (c, member) in kkt.fronts.as_ref().run(spans.clone()).iter().zip(model.topology.fronts().run(spans)) {
            if member.start != CLAMPED {
                add(usize::from(member.start), c.ax);
            }
            add(usize::from(member.end), c.bx);
            add(member.force_unknown(), [c.xx, c.xy]);
            add(member.force_unknown() + 1, [c.xy, c.yy]);
            (*xx, *xy, *yy) = (*xx + c.xx, *xy + c.xy, *yy + c.yy);
            (*x, *y) = (*x + c.rx[0], *y + c.rx[1]);
        }
        let (from, end) = (self.unknowns, shared(model, span).max(self.unknowns));
        let band = kkt.band.as_ref().run(0..end);
        let [along_x, along_y] = [along_x.run_mut(0..end), along_y.run_mut(0..end)];
        banded::forward_both(band, along_x, along_y, from);
        let entries = along_x.run(from..end).iter().zip(along_y.run(from..end)).zip(right.run(from..end));
        for (row, ((&ex, &ey), &right)) in band.run(from..end).iter().zip(entries) {
            let (scaled_x, scaled_y) = (ex * row[BAND], ey * row[BAND]);
            (*xx, *xy, *yy) = (*xx - scaled_x * ex, *xy - scaled_x * ey, *yy - scaled_y * ey);
            (*x, *y) = (*x - scaled_x * right, *y - scaled_y * right);
        }
        (self.spans, self.unknowns) = (span, end);
    }

    /// The column of a force n: E n, substituted as far as the spans have been passed. Beyond the joint at which the span begins it
    /// is zero.
    #[inline]
    pub fn fill(&self, column: &mut [T], [x, y]: [T; 2]) {
        let [along_x, along_y] = self.columns.each_ref().map(AsRef::as_ref);
        let end = column.len().min(self.unknowns + BAND);
        let (column, beyond) = column.split_at_mut_checked(end).unwrap_or_default();
        beyond.fill(T::ZERO);
        for (entry, (&through_x, &through_y)) in column.iter_mut().zip(along_x.iter().zip(along_y)) {
            *entry = through_x * x + through_y * y;
        }
    }

    /// How far a force n moves the point at which the span begins, but for what its own unknowns and those above it do: mm.
    pub fn moves(&self, [x, y]: [T; 2]) -> [T; 2] {
        let [xx, xy, yy] = self.yielding;
        [xx * x + xy * y, xy * x + yy * y]
    }

    /// How far the residuals move it, mm.
    pub fn found(&self) -> [T; 2] {
        self.found
    }

    /// The columns, once they have served, as room for two others.
    pub fn room(&mut self, unknowns: usize) -> [&mut [T]; 2] {
        self.columns.each_mut().map(|column| column.as_mut().run_mut(0..unknowns))
    }
}

/// Unknowns before a span begins, a multiple of the bandwidth: at these a row's column is that of the force alone.
pub(super) fn shared<T: Real, S: Size>(model: &Model<T, S>, span: usize) -> usize {
    let begins = match model.topology.fronts().get(span) {
        Some(member) if member.start != CLAMPED => usize::from(member.start),
        _ => 0,
    };
    begins - begins % BAND
}
