//! Members: rods, and rigid links.

use super::{DiscretiseError, Scheme};
use crate::access::Access as _;
use crate::model::Model;
use crate::real::{Real, vec2};
use crate::size::{Blank, Size};
use crate::topology::{Kind, Member};

/// A flexible rod, about to become a member.
pub(super) struct Rod<'a> {
    pub elements: u16,
    pub length: f64,
    /// Undeformed direction against the position along the rod, 0 … 1.
    pub direction: &'a dyn Fn(f64) -> [f64; 2],
    /// Bending stiffness EI (N·mm²) against the position along the rod, 0 … 1.
    pub bending: &'a dyn Fn(f64) -> f64,
    /// Thickness, mm, against the same position.
    pub thickness: &'a dyn Fn(f64) -> f64,
    /// 1/EA and 1/κGA, 1/N.
    pub compliance: [f64; 2],
    /// 3c/EA, 1/N (see [`Member`]).
    pub stiffening: f64,
}

/// Writes a member's nodes; what it belongs to and its joints are the caller's.
pub(super) fn write_rod<T: Real, S: Size>(
    model: &mut Model<T, S>,
    scheme: Scheme,
    first: usize,
    rod: &Rod<'_>,
) -> Result<Member<T>, DiscretiseError> {
    let n = usize::from(rod.elements);
    let h = rod.length / n as f64;
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
        let direction = vec2::<T>((rod.direction)(position));
        *slot = [direction.x, direction.y];
    }
    let mut weight = |node: usize, value: f64| {
        let sum = model.weight.as_ref().at(first + node).to_f64() + value;
        model.weight.as_mut().put(first + node, T::of(sum));
    };
    let bending = |element: f64| (rod.bending)(element / n as f64);
    let fibre = |element: f64, length: f64| T::of(0.5 * (rod.thickness)(element / n as f64) / length);
    match scheme {
        Scheme::Paper => {
            for element in 0..n {
                weight(element + 1, h);
                model.coupling.as_mut().put(first + element, [T::of(-bending(element as f64) / h), T::ZERO]);
                model.fibre.as_mut().put(first + element, fibre(element as f64, h));
            }
        }
        Scheme::Trapezoid => {
            for element in 0..n {
                weight(element + 1, h);
            }
            for spring in 0..=n {
                let length = if spring == 0 || spring == n { 0.5 * h } else { h };
                model.coupling.as_mut().put(first + spring, [T::of(-bending(spring as f64) / length), T::ZERO]);
                model.fibre.as_mut().put(first + spring, fibre(spring as f64, length));
            }
        }
        Scheme::Simpson => {
            // Summed in f64 before rounding: interior ends carry h/6 from both sides.
            for element in 0..n {
                let c = bending(element as f64 + 0.5) / (3.0 * h);
                let node = first + 2 * element;
                let shared = if element > 0 { h / 6.0 } else { 0.0 };
                model.weight.as_mut().put(node, T::of(shared + h / 6.0));
                model.weight.as_mut().put(node + 1, T::of(4.0 * h / 6.0));
                model.weight.as_mut().put(node + 2, T::of(h / 6.0));
                model.coupling.as_mut().put(node, [T::of(-8.0 * c), T::of(c)]);
                model.coupling.as_mut().put(node + 1, [T::of(-8.0 * c), T::ZERO]);
                model.fibre.as_mut().run_mut(node..node + 2).fill(fibre(element as f64 + 0.5, h));
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
