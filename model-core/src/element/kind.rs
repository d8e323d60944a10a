//! The elements of a member, asked by its kind: [`Element`]'s functions, each passed on to the one that implements it.

use super::{Constants, Depth, Element, EndGap, Link, Node, Past, Quadratic, Strain};
use crate::contact::{Row, Sample};
use crate::real::Real;
use crate::topology::Kind;

/// Asks the elements of a kind.
macro_rules! ask {
    ($kind:expr, $function:ident($($argument:expr),*)) => {
        match $kind {
            Kind::Quadratic => Quadratic::$function($($argument),*),
            Kind::Link => Link::$function($($argument),*),
            Kind::Gap => EndGap::$function($($argument),*),
        }
    };
}

impl Kind {
    /// [`Element::walk`].
    #[inline(always)]
    pub(crate) fn walk<T: Real, D: Depth, P: Past<T>>(
        self,
        of: Constants<'_, T>,
        past: P,
        angle: &[T],
        rows: &[Row<T>],
        nodes: &mut [Node<T>],
        out: &mut Strain<T>,
    ) {
        match self {
            Self::Quadratic => Quadratic::walk::<D, P>(of, past, angle, rows, nodes, out),
            Self::Link => Link::walk::<D, P>(of, past, angle, rows, nodes, out),
            Self::Gap => EndGap::walk::<D, P>(of, past, angle, rows, nodes, out),
        }
    }

    /// [`Element::bend`].
    #[inline(always)]
    pub(crate) fn bend<T: Real>(self, of: Constants<'_, T>, angle: &[T], nodes: &mut [Node<T>], out: &mut Strain<T>) {
        ask!(self, bend(of, angle, nodes, out));
    }

    /// [`Element::lever`].
    #[inline(always)]
    pub(crate) fn lever<T: Real>(
        self,
        of: Constants<'_, T>,
        first: usize,
        sample: &Sample<T>,
        nodes: &[Node<T>],
    ) -> [[T; 2]; 3] {
        ask!(self, lever(of, first, sample, nodes))
    }

    /// [`Element::SPARES_TANGENT`].
    #[inline(always)]
    pub(crate) fn spares_tangent<T: Real>(self) -> bool {
        match self {
            Self::Quadratic => <Quadratic as Element<T>>::SPARES_TANGENT,
            Self::Link => <Link as Element<T>>::SPARES_TANGENT,
            Self::Gap => <EndGap as Element<T>>::SPARES_TANGENT,
        }
    }

    /// [`Element::between`].
    #[inline(always)]
    pub(crate) fn between<T: Real>(self, weight: &[T], first: u16, sample: &Sample<T>, xi: T) -> (u16, [T; 3]) {
        ask!(self, between(weight, first, sample, xi))
    }

    /// [`Element::turns`].
    #[inline(always)]
    pub(crate) fn turns<T: Real>(self, place: &Sample<T>, xi: T) -> (usize, [T; 3]) {
        ask!(self, turns(place, xi))
    }

    /// [`Element::section`].
    pub(crate) fn section<T: Real>(self, angle: &[T], stretch: impl Fn(usize) -> T, section: usize) -> (T, T) {
        ask!(self, section(angle, stretch, section))
    }

    /// [`Element::arc`].
    pub(crate) fn arc<T: Real>(self, weight: &[T], section: usize) -> T {
        ask!(self, arc(weight, section))
    }

    /// [`Element::point`].
    pub(crate) fn point<T: Real>(
        self,
        weight: &[T],
        strained: impl Fn(usize) -> [T; 2],
        node: usize,
        at: &mut [T; 2],
    ) -> Option<[T; 2]> {
        ask!(self, point(weight, strained, node, at))
    }

    /// [`Element::point_back`].
    pub(crate) fn point_back<T: Real>(
        self,
        weight: &[T],
        strained: impl Fn(usize) -> [T; 2],
        node: usize,
        at: &mut [T; 2],
    ) -> Option<[T; 2]> {
        ask!(self, point_back(weight, strained, node, at))
    }
}
