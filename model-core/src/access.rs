//! Access to slices that cannot panic.
//!
//! An index out of range is a fault of this crate: tests, with debug assertions, stop at it. A control loop must not: there the
//! blank value is read and nothing is written, the residuals do not vanish, and the status says so.

use crate::size::Blank;
use core::ops::{AddAssign, Range};

/// Reading and writing without a way to panic.
pub(crate) trait Access<X> {
    /// The value at an index.
    fn at(&self, index: usize) -> X;
    /// Sets the value at an index.
    fn put(&mut self, index: usize, value: X);
    /// Adds to the value at an index.
    fn add(&mut self, index: usize, value: X)
    where
        X: AddAssign;
    /// The values of a range.
    fn run(&self, range: Range<usize>) -> &[X];
    /// The values of a range.
    fn run_mut(&mut self, range: Range<usize>) -> &mut [X];
}

impl<X: Blank> Access<X> for [X] {
    #[inline(always)]
    fn at(&self, index: usize) -> X {
        debug_assert!(index < self.len(), "{index} of {}", self.len());
        match self.get(index) {
            Some(&value) => value,
            None => X::BLANK,
        }
    }

    #[inline(always)]
    fn put(&mut self, index: usize, value: X) {
        debug_assert!(index < self.len(), "{index} of {}", self.len());
        if let Some(slot) = self.get_mut(index) {
            *slot = value;
        }
    }

    #[inline(always)]
    fn add(&mut self, index: usize, value: X)
    where
        X: AddAssign,
    {
        debug_assert!(index < self.len(), "{index} of {}", self.len());
        if let Some(slot) = self.get_mut(index) {
            *slot += value;
        }
    }

    #[inline(always)]
    fn run(&self, range: Range<usize>) -> &[X] {
        debug_assert!(range.end <= self.len(), "{range:?} of {}", self.len());
        self.get(range).unwrap_or(&[])
    }

    #[inline(always)]
    fn run_mut(&mut self, range: Range<usize>) -> &mut [X] {
        debug_assert!(range.end <= self.len(), "{range:?} of {}", self.len());
        self.get_mut(range).unwrap_or(&mut [])
    }
}
