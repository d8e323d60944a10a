//! How much room a model has: named sizes, so that every array's capacity is fixed when the program is built.
//!
//! Design, state and workspace are generic over [`Size`]. All their arrays start as constants ([`Storage::EMPTY`]), so
//! that a `static` holds them without passing through a stack, and are fitted to the model when it is discretised.

/// The most entries of the lists in a description: of a finger ([`crate::design::Design`]) or an object
/// ([`crate::object::ObjectDesign`]). A description is as large as its lists' capacities, so a microcontroller has shorter
/// ones; the wire carries entries, not capacities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Lists {
    /// Lamellae of a finger.
    pub lamellae: u8,
    /// Thicknesses of them: one for all, or one per lamella.
    pub thicknesses: u8,
    /// Knots of a taper.
    pub knots: u8,
    /// Points of a centreline between its ends.
    pub points: u8,
    /// Corners of a polygon.
    pub corners: u8,
}

impl Lists {
    /// A microcontroller's with little memory. 12 lamellae are what [`Paper`] has room for.
    /// Its lamellae have one thickness, or one taper, for all.
    pub const TARGET: Self = Self { lamellae: 12, thicknesses: 1, knots: 8, points: 2, corners: 8 };
    /// A microcontroller's with the memory for [`Ribs`] or [`RubbingRibs`] (feature `ribs`): every rib has a thickness of its own, or a taper, and
    /// walls curve and taper as those of printed fingers do. A description of a finger takes 1,104 bytes more than with [`Self::TARGET`].
    pub const RIBS: Self = Self { lamellae: 16, thicknesses: 16, knots: 16, points: 14, corners: 8 };
    /// Those of a machine with an operating system.
    pub const HOSTED: Self = Self { lamellae: 64, thicknesses: 64, knots: 64, points: 62, corners: 64 };
    /// Those of the machine that the program is built for.
    pub const HERE: Self = match (cfg!(target_os = "none"), cfg!(feature = "ribs")) {
        (false, _) => Self::HOSTED,
        (true, false) => Self::TARGET,
        (true, true) => Self::RIBS,
    };
}

/// A list of a description is longer than another machine has room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong {
    /// The list, by its key in a case file.
    pub key: &'static str,
    /// Its entries.
    pub found: usize,
    /// The most that are allowed.
    pub most: usize,
}

impl TooLong {
    /// Checks a list's length.
    pub(crate) fn check(key: &'static str, found: usize, most: impl Into<usize>) -> Result<(), Self> {
        let most = most.into();
        if found > most { Err(Self { key, found, most }) } else { Ok(()) }
    }
}

impl core::fmt::Display for TooLong {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} has {} entries; the microcontroller has room for {}", self.key, self.found, self.most)
    }
}

impl core::error::Error for TooLong {}

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
    /// Per member (front span and back span of each cell, one or two of each rung).
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
    /// Number of contact rows; with friction a sample takes two.
    const CONTACTS: usize;
    /// How far the rows of a matrix of pairs are apart where there are so many: as far as the room of an array says; on a heap no further
    /// than is needed.
    fn stride(rows: usize) -> usize {
        let _ = rows;
        Self::CONTACTS
    }
    /// There is room for what friction remembers.
    const RUBS: bool;
    /// Per node, if there is friction.
    type SlipNodes<X: Blank>: Storage<X>;
    /// Per cell, if there is friction.
    type SlipCells<X: Blank>: Storage<X>;
    /// Per contact row, if there is friction.
    type SlipContacts<X: Blank>: Storage<X>;
    /// One, if there is friction.
    type SlipOnce<X: Blank>: Storage<X>;
    /// The most terms of a material with memory, at most 4; 0 where there is no room for any.
    const TERMS: usize;
    /// Per term: an array, so that loops over it are unrolled.
    type Terms<X: Blank>: Storage<X> + Blank;
    /// Per node, if there are terms.
    type Past<X: Blank>: Storage<X>;
}

/// Defines a size of your own: `fixed_size!(/// …
/// Long, cells 13, nodes 206, samples 146, contacts 24);` for up to 12 lamellae. Cells are one more than the lamellae; nodes are
/// what the scheme has (`simpson`: 2N+1 per member of N elements, `trapezoid` N+2, `paper` N+1); a model that finds no room is
/// refused when it is discretised. With `friction` at the end there is room for what friction remembers, and a sample that touches takes
/// two of the contacts. With `memory N` at the very end there is room for N terms of a material with memory.
#[macro_export]
macro_rules! fixed_size {
    ($(#[$doc:meta])* $name:ident, cells $cells:literal, nodes $nodes:literal, samples $samples:literal, contacts $contacts:literal) => {
        $crate::fixed_size!(@ $(#[$doc])* $name, $cells, $nodes, $samples, $contacts, false, 0, 0, 0, 0, 0);
    };
    ($(#[$doc:meta])* $name:ident, cells $cells:literal, nodes $nodes:literal, samples $samples:literal, contacts $contacts:literal, memory $terms:literal) => {
        $crate::fixed_size!(@ $(#[$doc])* $name, $cells, $nodes, $samples, $contacts, false, 0, 0, 0, 0, $terms);
    };
    ($(#[$doc:meta])* $name:ident, cells $cells:literal, nodes $nodes:literal, samples $samples:literal, contacts $contacts:literal, friction) => {
        $crate::fixed_size!(@ $(#[$doc])* $name, $cells, $nodes, $samples, $contacts, true, $nodes, $cells, $contacts, 1, 0);
    };
    ($(#[$doc:meta])* $name:ident, cells $cells:literal, nodes $nodes:literal, samples $samples:literal, contacts $contacts:literal, friction, memory $terms:literal) => {
        $crate::fixed_size!(@ $(#[$doc])* $name, $cells, $nodes, $samples, $contacts, true, $nodes, $cells, $contacts, 1, $terms);
    };
    (@ $(#[$doc:meta])* $name:ident, $cells:literal, $nodes:literal, $samples:literal, $contacts:literal, $rubs:literal, $slip_nodes:literal, $slip_cells:literal, $slip_contacts:literal, $slip:literal, $terms:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name;
        impl $crate::size::Size for $name {
            type Nodes<X: $crate::size::Blank> = [X; $nodes];
            type Members<X: $crate::size::Blank> = [X; 4 * $cells - 2];
            type Cells<X: $crate::size::Blank> = [X; $cells];
            type Unknowns<X: $crate::size::Blank> = [X; 5 * $cells - 2];
            type Samples<X: $crate::size::Blank> = [X; $samples];
            type Contacts<X: $crate::size::Blank> = [X; $contacts];
            type Pairs<X: $crate::size::Blank> = [X; $contacts * $contacts];
            type Rows<X: $crate::size::Blank> = [X; $contacts * (5 * $cells - 2)];
            const CONTACTS: usize = $contacts;
            const RUBS: bool = $rubs;
            type SlipNodes<X: $crate::size::Blank> = [X; $slip_nodes];
            type SlipCells<X: $crate::size::Blank> = [X; $slip_cells];
            type SlipContacts<X: $crate::size::Blank> = [X; $slip_contacts];
            type SlipOnce<X: $crate::size::Blank> = [X; $slip];
            const TERMS: usize = $terms;
            type Terms<X: $crate::size::Blank> = [X; $terms];
            type Past<X: $crate::size::Blank> = [X; if $terms == 0 { 0 } else { $nodes }];
        }
    };
}

fixed_size!(
    /// The microcontroller's: `simpson`, 2 elements per span, 3 in the tip span, 1 per hinge, up to 7 lamellae and
    /// 5 samples per element.
    Reduced, cells 8, nodes 126, samples 96, contacts 22
);
fixed_size!(
    /// As [`Reduced`], with friction: up to 19 samples that touch or are about to. A finger closed on a cylinder by 11° has 17.
    Rubbing, cells 8, nodes 126, samples 96, contacts 39, friction
);
fixed_size!(
    /// As [`Reduced`], with two terms of a material with memory.
    Remembering, cells 8, nodes 126, samples 96, contacts 22, memory 2
);
fixed_size!(
    /// Up to 16 rungs of any kind on a microcontroller with the memory: `simpson`, 2 elements per span and rib, 3 in the tip span, 1 per
    /// hinge, 5 samples per element.
    Ribs, cells 17, nodes 270, samples 224, contacts 22
);
fixed_size!(
    /// As [`Ribs`], with friction: up to 19 samples that touch or are about to.
    RubbingRibs, cells 17, nodes 270, samples 224, contacts 39, friction
);
fixed_size!(
    /// The resolution of *Geometrico-Static Modelling of a FRE Finger*: 170 elements per beam and 20 per hinge with up to 7 lamellae, contact at nodes; fewer elements
    /// with up to 12.
    Paper, cells 13, nodes 704, samples 184, contacts 40
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::tests::set_heights;
    use crate::design::{HingeKind, RibEnds, ladder_80};
    use crate::discretise::{Discretisation, DiscretiseError, Physics, discretise};
    use crate::model::Model;
    use crate::newton::Workspace;
    use crate::newton::factored::Factored;
    use crate::state::State;
    use core::mem::size_of;

    /// Three states and the workspace, and the model's constants, bytes.
    fn ram<S: Size>() -> (usize, usize) {
        (
            3 * size_of::<State<f32, S>>() + size_of::<Workspace<f32, S>>() + size_of::<Factored<f32, S>>(),
            size_of::<Model<f32, S>>(),
        )
    }

    #[test]
    fn states_and_workspace_fit_the_microcontroller() {
        let (reduced, ribs, paper) = (ram::<Reduced>(), ram::<Ribs>(), ram::<Paper>());
        std::println!("state and workspace, constants: {reduced:?} bytes reduced, {ribs:?} ribs, {paper:?} paper");
        assert!(reduced.0 <= 24 * 1024, "{reduced:?}");
        assert!(ribs.0 <= 48 * 1024, "{ribs:?}");
        let terms = ram::<Remembering>().0 - reduced.0;
        std::println!("two terms of memory: {terms} bytes");
        assert!(terms <= 4096, "{terms}");
        assert!(paper.0 <= 96 * 1024, "{paper:?}");
    }

    /// A rigid tip needs samples of its own, and ribs with necks more nodes.
    #[test]
    fn reduced_has_room_for_seven_rungs_or_fewer_ribs() {
        let most = |ends: Option<RibEnds>, rigid_above: Option<f64>| {
            let fits = |count: &usize| {
                let mut design = ladder_80();
                set_heights(&mut design, *count);
                if let Some(ends) = ends {
                    crate::design::tests::ribs(&mut design, 3.0).ends = ends;
                }
                design.rigid_above = rigid_above;
                let mut model: std::boxed::Box<Model<f32, Reduced>> = std::boxed::Box::new(Model::EMPTY);
                discretise(&design, &Discretisation::estimator(Physics::Extended), &mut model).is_ok()
            };
            (1..=8).take_while(fits).last()
        };
        let (welded, hinged, tip) = (Some(RibEnds::Welded), Some(RibEnds::Hinged), Some(70.0));
        let found = [most(None, None), most(welded, None), most(welded, tip), most(hinged, None), most(hinged, tip)];
        assert_eq!(found, [Some(7), Some(7), Some(6), Some(5), Some(5)]);
    }

    /// Sixteen rungs of every kind find room, a seventeenth does not.
    #[test]
    fn ribs_has_room_for_sixteen_rungs() {
        let mut model: std::boxed::Box<Model<f32, Ribs>> = std::boxed::Box::new(Model::EMPTY);
        for kind in [HingeKind::Flexible, HingeKind::Pinned, HingeKind::Welded] {
            let mut design = ladder_80();
            design.hinge.kind = kind;
            set_heights(&mut design, 16);
            assert_eq!(
                discretise(&design, &Discretisation::estimator(Physics::Extended), &mut model),
                Ok(()),
                "{kind:?}"
            );
            // Welded ribs, between which the face is sampled as well.
            let mut ribbed = design.clone();
            crate::design::tests::ribs(&mut ribbed, 1.6);
            ribbed.rigid_above = Some(70.0);
            let found = discretise(&ribbed, &Discretisation::estimator(Physics::Extended), &mut model);
            assert_eq!(found, Ok(()), "ribs");
            set_heights(&mut design, 17);
            let found = discretise(&design, &Discretisation::estimator(Physics::Extended), &mut model);
            assert_eq!(found, Err(DiscretiseError::Capacity), "{kind:?}");
        }
    }
}
