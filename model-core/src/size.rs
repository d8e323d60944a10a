//! How much room a model has: named sizes, so that every array's capacity is fixed when the program is built.
//!
//! Design, state and workspace are generic over [`Size`]. All their arrays start as constants ([`Storage::EMPTY`]), so
//! that a `static` holds them without passing through a stack, and are fitted to the model when it is discretised.

/// A value that arrays are filled with before they are used.
pub trait Blank: Copy + 'static {
    /// The value.
    const BLANK: Self;
}

impl Blank for f32 {
    const BLANK: Self = 0.0;
}
impl Blank for f64 {
    const BLANK: Self = 0.0;
}
impl Blank for u16 {
    const BLANK: Self = 0;
}
impl Blank for bool {
    const BLANK: Self = false;
}
impl<X: Blank, const N: usize> Blank for [X; N] {
    const BLANK: Self = [X::BLANK; N];
}

/// A run of values with a capacity.
pub trait Storage<X>: AsRef<[X]> + AsMut<[X]> + 'static {
    /// The storage before anything was fitted.
    const EMPTY: Self;
    /// Makes room for `count` values; false if there is none.
    fn fit(&mut self, count: usize) -> bool;
}

impl<X: Blank, const N: usize> Storage<X> for [X; N] {
    const EMPTY: Self = [X::BLANK; N];
    fn fit(&mut self, count: usize) -> bool {
        count <= N
    }
}

/// Capacities of a model's arrays. The microcontroller's sizes are arrays; a program with a heap brings its own.
pub trait Size: 'static {
    /// Per node of the discretisation (interior unknowns and both ends of every member).
    type Nodes<X: Blank>: Storage<X>;
    /// Per member (front span, back span, front hinge, back hinge of each cell).
    type Members<X: Blank>: Storage<X>;
    /// Per cell of the ladder.
    type Cells<X: Blank>: Storage<X>;
    /// Per unknown of the condensed system (joint angles and closure multipliers).
    type Unknowns<X: Blank>: Storage<X>;
    /// Per contact sample.
    type Samples<X: Blank>: Storage<X>;
    /// Per contact row.
    type Contacts<X: Blank>: Storage<X>;
    /// Per pair of contact rows.
    type Pairs<X: Blank>: Storage<X>;
    /// Per contact row and unknown.
    type Rows<X: Blank>: Storage<X>;
    /// Number of contact rows.
    const CONTACTS: usize;
}

macro_rules! fixed_size {
    ($(#[$doc:meta])* $name:ident, cells $cells:literal, nodes $nodes:literal, samples $samples:literal, contacts $contacts:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;
        impl Size for $name {
            type Nodes<X: Blank> = [X; $nodes];
            type Members<X: Blank> = [X; 4 * $cells];
            type Cells<X: Blank> = [X; $cells];
            type Unknowns<X: Blank> = [X; 5 * $cells];
            type Samples<X: Blank> = [X; $samples];
            type Contacts<X: Blank> = [X; $contacts];
            type Pairs<X: Blank> = [X; $contacts * $contacts];
            type Rows<X: Blank> = [X; $contacts * 5 * $cells];
            const CONTACTS: usize = $contacts;
        }
    };
}

fixed_size!(
    /// The microcontroller's: `simpson`, 2 elements per span, 3 in the tip span, 1 per hinge, up to 12 lamellae and
    /// 5 samples per element.
    Reduced, cells 13, nodes 208, samples 136, contacts 24
);
fixed_size!(
    /// The paper's resolution: 170 elements per beam and 20 per hinge, up to 12 lamellae, contact at nodes.
    Paper, cells 13, nodes 928, samples 184, contacts 40
);
