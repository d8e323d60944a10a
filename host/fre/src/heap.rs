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

/// A size with room for any number of elements and so many samples that touch at the same time.
macro_rules! size {
    ($(#[$doc:meta])* $name:ident, $contacts:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;

        impl Size for $name {
            type Nodes<X: Blank> = Heap<X>;
            type Members<X: Blank> = Heap<X>;
            type Cells<X: Blank> = Heap<X>;
            type Unknowns<X: Blank> = Heap<X>;
            type Samples<X: Blank> = Heap<X>;
            type Contacts<X: Blank> = Heap<X>;
            type Pairs<X: Blank> = Heap<X>;
            type Rows<X: Blank> = Heap<X>;
            const CONTACTS: usize = $contacts;
            const RUBS: bool = true;
            type SlipNodes<X: Blank> = Heap<X>;
            type SlipCells<X: Blank> = Heap<X>;
            type SlipContacts<X: Blank> = Heap<X>;
            type SlipOnce<X: Blank> = Heap<X>;
            const TERMS: usize = PRONY_TERMS;
            type Terms<X: Blank> = [X; PRONY_TERMS];
            type Past<X: Blank> = Heap<X>;
        }
    };
}

size!(
    /// Room for any number of elements; up to 128 samples touch at the same time.
    Host,
    128
);
size!(
    /// As [`Host`], with room for 720 touching samples: a front beam of 170 elements with four samples each that touches
    /// everywhere; derivatives, which need two rows each, for 360. A matrix of contact pairs takes 4 MB.
    Wide,
    720
);

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
