//! Members: rods, and rigid links.

use super::{DiscretiseError, Scheme};
use crate::access::Access as _;
use crate::model::Model;
use crate::real::{Real, vec2};
use crate::size::{Blank, Size};
use crate::topology::{Kind, Member};

/// A part of a rod with elements of one length.
#[derive(Clone, Copy)]
pub(super) struct Piece<'a> {
    pub elements: u16,
    pub length: f64,
    /// Bending stiffness EI (N·mm²) against the position along the piece, 0 … 1.
    pub bending: &'a dyn Fn(f64) -> f64,
    /// Thickness, mm, against the same position.
    pub thickness: &'a dyn Fn(f64) -> f64,
}

impl Piece<'_> {
    fn bending(&self, element: f64) -> f64 {
        (self.bending)(element / f64::from(self.elements))
    }

    /// Half the thickness over a length.
    fn fibre<T: Real>(&self, element: f64, length: f64) -> T {
        T::of(0.5 * (self.thickness)(element / f64::from(self.elements)) / length)
    }
}

/// A flexible rod, about to become a member.
pub(super) struct Rod<'a> {
    /// From start to end; of links there is one alone, as they are all of one length.
    pub pieces: &'a [Piece<'a>],
    /// Undeformed direction against the position along the rod, 0 … 1; a rod of several pieces is straight.
    pub direction: &'a dyn Fn(f64) -> [f64; 2],
    /// 1/EA and 1/κGA, 1/N.
    pub compliance: [f64; 2],
    /// 3c/EA, 1/N (see [`Member`]).
    pub stiffening: f64,
    /// The member leads from the rod's end to its start.
    pub backwards: bool,
}

impl Rod<'_> {
    /// Length, mm, and bending stiffness 1/∫ds/EI, N·mm.
    pub fn size(&self) -> (f64, f64) {
        if let [only] = self.pieces {
            return (only.length, (only.bending)(0.5) / only.length);
        }
        let compliance: f64 = self.pieces.iter().map(|piece| piece.length / (piece.bending)(0.5)).sum();
        (self.pieces.iter().map(|piece| piece.length).sum(), 1.0 / compliance)
    }
}

/// Writes a member's nodes; what it belongs to and its joints are the caller's.
pub(super) fn write_rod<T: Real, S: Size>(
    model: &mut Model<T, S>,
    scheme: Scheme,
    first: usize,
    rod: &Rod<'_>,
) -> Result<Member<T>, DiscretiseError> {
    let n: usize = rod.pieces.iter().map(|piece| usize::from(piece.elements)).sum();
    let interior = match scheme {
        Scheme::Paper => n - 1,
        Scheme::Trapezoid => n,
        Scheme::Simpson => 2 * n - 1,
    };
    let count = interior + 2;
    if first + count > usize::from(u16::MAX) || !model.fit_nodes(first + count) {
        return Err(DiscretiseError::Capacity);
    }
    let end = first + count;
    for (node, slot) in model.direction.as_mut().run_mut(first..end).iter_mut().enumerate() {
        // A link lies about its middle; the joints' own nodes stand for the ends.
        let last = count - 1;
        let position = match scheme {
            Scheme::Simpson => node as f64 / (2 * n) as f64,
            Scheme::Paper | Scheme::Trapezoid if node == 0 => 0.0,
            Scheme::Trapezoid if node == last => 1.0,
            Scheme::Paper | Scheme::Trapezoid => (node as f64 - 0.5) / n as f64,
        };
        let direction = match rod.backwards {
            false => (rod.direction)(position),
            true => (rod.direction)(1.0 - position).map(|part| -part),
        };
        let direction = vec2::<T>(direction);
        *slot = [direction.x, direction.y];
    }
    let weights = &mut model.weight;
    let mut weight = |node: usize, value: f64| weights.as_mut().put(node, T::of(value));
    // The node's share of the element below, h/6, which may be another piece's.
    let mut shared = 0.0;
    let mut at = first;
    let pieces = rod.pieces.len();
    for piece in 0..pieces {
        let Some(piece) = rod.pieces.get(if rod.backwards { pieces - 1 - piece } else { piece }) else { continue };
        let n = usize::from(piece.elements);
        let h = piece.length / n as f64;
        let on = |element: f64| if rod.backwards { n as f64 - element } else { element };
        match scheme {
            Scheme::Paper => {
                for element in 0..n {
                    weight(at + 1, h);
                    model.coupling.as_mut().put(at, [T::of(-piece.bending(on(element as f64)) / h), T::ZERO]);
                    model.fibre.as_mut().put(at, piece.fibre(on(element as f64), h));
                    at += 1;
                }
            }
            Scheme::Trapezoid => {
                for spring in 0..=n {
                    let length = if spring == 0 || spring == n { 0.5 * h } else { h };
                    if spring < n {
                        weight(at + 1, h);
                    }
                    model.coupling.as_mut().put(at, [T::of(-piece.bending(on(spring as f64)) / length), T::ZERO]);
                    model.fibre.as_mut().put(at, piece.fibre(on(spring as f64), length));
                    at += 1;
                }
            }
            Scheme::Simpson => {
                // Summed in f64 before rounding: interior ends carry h/6 from both sides.
                for element in 0..n {
                    let c = piece.bending(on(element as f64 + 0.5)) / (3.0 * h);
                    weight(at, shared + h / 6.0);
                    weight(at + 1, 4.0 * h / 6.0);
                    weight(at + 2, h / 6.0);
                    model.coupling.as_mut().put(at, [T::of(-8.0 * c), T::of(c)]);
                    model.coupling.as_mut().put(at + 1, [T::of(-8.0 * c), T::ZERO]);
                    model.fibre.as_mut().run_mut(at..at + 2).fill(piece.fibre(on(element as f64 + 0.5), h));
                    (at, shared) = (at + 2, h / 6.0);
                }
            }
        }
    }
    Ok(Member {
        first: first as u16,
        interior: interior as u16,
        kind: kind(scheme),
        compliance: rod.compliance.map(T::of),
        stiffening: T::of(rod.stiffening),
        ..Member::BLANK
    })
}

/// What a scheme's members are made of.
pub(super) fn kind(scheme: Scheme) -> Kind {
    match scheme {
        Scheme::Simpson => Kind::Quadratic,
        Scheme::Paper | Scheme::Trapezoid => Kind::Link,
    }
}

/// Writes the node pair of a member that is rigid altogether.
pub(super) fn write_point<T: Real, S: Size>(
    model: &mut Model<T, S>,
    scheme: Scheme,
    first: usize,
) -> Result<Member<T>, DiscretiseError> {
    if !model.fit_nodes(first + 2) {
        return Err(DiscretiseError::Capacity);
    }
    model.direction.as_mut().run_mut(first..first + 2).fill([T::one(), T::ZERO]);
    Ok(Member { first: first as u16, kind: kind(scheme), ..Member::BLANK })
}

/// Writes the node pair of a gap: its first node has the gap's width and the direction across it.
pub(super) fn write_gap<T: Real, S: Size>(
    model: &mut Model<T, S>,
    scheme: Scheme,
    first: usize,
    (width, [x, y]): (f64, [f64; 2]),
) -> Result<Member<T>, DiscretiseError> {
    let point = write_point(model, scheme, first)?;
    model.direction.as_mut().run_mut(first..first + 2).fill([T::of(x), T::of(y)]);
    model.weight.as_mut().put(first, T::of(width));
    Ok(Member { kind: Kind::Gap, ..point })
}
