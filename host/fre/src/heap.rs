//! The model's size on a machine with a heap: any resolution.

use model_core::equilibrium::PRONY_TERMS;
use model_core::size::{Blank, Size, Storage};

/// A run of values on the heap; it grows to what the model needs and keeps its contents.
#[derive(Clone, Debug)]
pub struct Heap<X>(Vec<X>);

impl<X> AsRef<[X]> for Heap<X> {
    fn as_ref(&self) -> &[X] {
        &self.0
    }
}

impl<X> AsMut<[X]> for Heap<X> {
    fn as_mut(&mut self) -> &mut [X] {
        &mut self.0
    }
}

impl<X: Blank> Storage<X> for Heap<X> {
    const EMPTY: Self = Self(Vec::new());

    fn fit(&mut self, count: usize) -> bool {
        if self.0.len() < count {
            self.0.resize(count, X::BLANK);
        }
        true
    }
}

/// Room for any number of elements; 720 contact rows: a front beam of 170 elements with four samples each that touches everywhere. With
/// friction, and in a derivative, a sample takes two.
#[derive(Clone, Copy, Debug)]
pub struct Host;

impl Size for Host {
    type Nodes<X: Blank> = Heap<X>;
    type Members<X: Blank> = Heap<X>;
    type Cells<X: Blank> = Heap<X>;
    type Unknowns<X: Blank> = Heap<X>;
    type Samples<X: Blank> = Heap<X>;
    type Contacts<X: Blank> = Heap<X>;
    type Pairs<X: Blank> = Heap<X>;
    type Rows<X: Blank> = Heap<X>;
    const CONTACTS: usize = 720;
    fn stride(rows: usize) -> usize {
        rows
    }
    const RUBS: bool = true;
    type SlipNodes<X: Blank> = Heap<X>;
    type SlipCells<X: Blank> = Heap<X>;
    type SlipContacts<X: Blank> = Heap<X>;
    type SlipOnce<X: Blank> = Heap<X>;
    const TERMS: usize = PRONY_TERMS;
    type Terms<X: Blank> = [X; PRONY_TERMS];
    type Past<X: Blank> = Heap<X>;
}

#[cfg(test)]
mod tests {
    use super::Heap;
    use model_core::size::Storage as _;

    #[test]
    fn growing_keeps_what_is_there() {
        let mut heap = Heap::<f32>::EMPTY;
        assert!(heap.fit(2));
        heap.as_mut().copy_from_slice(&[1.0, 2.0]);
        assert!(heap.fit(4) && heap.fit(1));
        assert_eq!(heap.as_ref(), [1.0, 2.0, 0.0, 0.0]);
    }
}
