//! A portal: the facet of a simplex of wrenches through which a load's ray goes.

/// Force in the plane, couple over the arm, force across.
pub(super) type Wrench = [f64; DIMENSIONS];
pub(super) const DIMENSIONS: usize = 4;

/// Wrenches, as many as dimensions count, whose cone has the ray in it.
#[derive(Clone, Debug)]
pub(super) struct Portal {
    corners: [Wrench; DIMENSIONS],
    /// The ray as their sum.
    parts: [f64; DIMENSIONS],
    dimensions: usize,
}

impl Portal {
    /// Of small wrenches along the axes.
    pub(super) fn new(ray: &Wrench, dimensions: usize, size: f64) -> Self {
        let mut corners = [[0.0; DIMENSIONS]; DIMENSIONS];
        for (i, corner) in corners.iter_mut().enumerate() {
            let one = if ray.get(i).is_some_and(|&part| part < 0.0) { -size } else { size };
            if let Some(part) = corner.get_mut(i) {
                *part = one;
            }
        }
        Self { corners, parts: ray.map(|part| part.abs() / size), dimensions }
    }

    /// How far along the ray it is.
    pub(super) fn reach(&self) -> f64 {
        1.0 / self.parts.iter().sum::<f64>()
    }

    /// Its plane, as the direction along which every corner is at 1.
    pub(super) fn plane(&self) -> Option<Wrench> {
        solve(self.corners, [1.0; DIMENSIONS], self.dimensions)
    }

    /// Takes a wrench for the corner that then keeps the ray within. False: the numbers do not serve any more.
    pub(super) fn take(&mut self, wrench: &Wrench) -> bool {
        let mut columns = [[0.0; DIMENSIONS]; DIMENSIONS];
        for (i, row) in columns.iter_mut().enumerate() {
            *row = self.corners.map(|corner| corner.get(i).copied().unwrap_or_default());
        }
        let Some(made_of) = solve(columns, *wrench, self.dimensions) else { return false };
        let within = self.parts.iter().zip(&made_of).enumerate().take(self.dimensions);
        let ratios = within.filter(|(_, (_, of))| **of > 0.0).map(|(k, (part, of))| (k, part / of));
        let Some((leaving, weight)) = ratios.min_by(|a, b| a.1.total_cmp(&b.1)) else { return false };
        for (part, of) in self.parts.iter_mut().zip(&made_of) {
            *part = (*part - weight * of).max(0.0);
        }
        if let (Some(part), Some(corner)) = (self.parts.get_mut(leaving), self.corners.get_mut(leaving)) {
            (*part, *corner) = (weight, *wrench);
        }
        true
    }
}

pub(super) fn dot(a: &Wrench, b: &Wrench) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Swaps an entry with one that is not before it, without a way to panic.
fn exchange<T>(list: &mut [T], first: usize, second: usize) -> Option<()> {
    let (before, rest) = list.split_at_mut_checked(second)?;
    if second > first {
        core::mem::swap(before.get_mut(first)?, rest.first_mut()?);
    }
    Some(())
}

/// Solves rows · x = right in the first so many dimensions by elimination with pivoting; the others are 0.
fn solve(mut rows: [Wrench; DIMENSIONS], mut right: Wrench, dimensions: usize) -> Option<Wrench> {
    let n = dimensions.min(DIMENSIONS);
    for k in 0..n {
        let size = |i: &usize| rows.get(*i).and_then(|row| row.get(k)).map_or(0.0, |entry| entry.abs());
        let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        exchange(&mut rows, k, pivot)?;
        exchange(&mut right, k, pivot)?;
        let (top, below) = rows.split_at_mut_checked(k + 1)?;
        let (top_right, below_right) = right.split_at_mut_checked(k + 1)?;
        let (row, value) = (top.last()?, *top_right.last()?);
        let diagonal = *row.get(k)?;
        if diagonal == 0.0 || !diagonal.is_finite() {
            return None;
        }
        for (other, of) in below.iter_mut().zip(below_right) {
            let factor = other.get(k)? / diagonal;
            for (entry, above) in other.iter_mut().zip(row).skip(k) {
                *entry -= factor * above;
            }
            *of -= factor * value;
        }
    }
    let mut x = [0.0; DIMENSIONS];
    for k in (0..n).rev() {
        let row = rows.get(k)?;
        let known: f64 = row.iter().zip(&x).skip(k + 1).map(|(entry, of)| entry * of).sum();
        *x.get_mut(k)? = (right.get(k)? - known) / row.get(k)?;
    }
    Some(x)
}
