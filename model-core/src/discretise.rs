//! From a design to members and joints, by scheme, resolution and physics (design description → [`Ladder`]).
//!
//! All lengths and stiffnesses are computed in `f64` and rounded once, so the single-precision model has the best
//! constants it can have, and the same ones on every machine.

use crate::contact::Sample;
use crate::design::{Design, DesignError, HingeFrom, HingeKind, PlaneStrain};
use crate::ladder::{CLAMPED, Ladder, Member};
use crate::real::{Real, vec2};
use crate::size::{Size, Storage};

/// How a member of N elements is discretised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Scheme {
    /// The paper's: rigid elements, springs EI/ℓe between neighbours and from the first element to the start joint; the
    /// last element is rigid with the end joint. First order.
    Paper,
    /// All N element angles free; half-length springs (2EI/ℓe) to both end joints. Second order.
    Trapezoid,
    /// Quadratic elements with Simpson weights. Fourth order.
    #[default]
    Simpson,
}

/// Which physics the members have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Physics {
    /// The paper's: inextensible, hinges from the centrelines, no rigid tip, plane stress.
    Paper,
    /// Stretch in every member, effective hinges, rigid tip wedge and plate stiffening as the design says.
    #[default]
    Extended,
}

/// Number of elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Elements {
    /// So many per beam, spread over its spans by largest remainder of their lengths (at least one each, ties to the
    /// tip), and so many per hinge.
    PerBeam {
        /// Elements of the front beam; the back beam takes the same counts span by span.
        beam: u16,
        /// Elements of each hinge.
        hinge: u16,
    },
    /// So many per span.
    PerSpan {
        /// Elements of every span but the last.
        span: u16,
        /// Elements of the last span, below the tip.
        tip_span: u16,
        /// Elements of each hinge.
        hinge: u16,
    },
}

impl Elements {
    /// The microcontroller's: 2 per span, 3 in the tip span, 1 per hinge.
    pub const REDUCED: Self = Self::PerSpan { span: 2, tip_span: 3, hinge: 1 };
    /// The PC's: 4 per span, 2 per hinge.
    pub const FINE: Self = Self::PerSpan { span: 4, tip_span: 4, hinge: 2 };
    /// The paper's: 170 per beam, 20 per hinge.
    pub const PAPER: Self = Self::PerBeam { beam: 170, hinge: 20 };
}

/// Where the gap to the object is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Sampling {
    /// At element ends, the base excluded, joints and tip included.
    Nodes,
    /// At n points ξ = 1/n … 1 of each element's cubic Hermite curve (`simpson` only).
    PerElement(u8),
}

/// How a design becomes a model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Discretisation {
    /// Scheme of the members.
    pub scheme: Scheme,
    /// Number of elements.
    pub elements: Elements,
    /// Contact samples.
    pub sampling: Sampling,
    /// Contact softness ε_c in g + ε_c μ = 0, mm/N.
    pub softness: f64,
    /// Physics.
    pub physics: Physics,
}

impl Discretisation {
    /// The microcontroller's resolution: `simpson`, reduced, 4 samples per element, ε_c = 1e-3 mm/N.
    pub const fn reduced(physics: Physics) -> Self {
        Self {
            scheme: Scheme::Simpson,
            elements: Elements::REDUCED,
            sampling: Sampling::PerElement(4),
            softness: 1e-3,
            physics,
        }
    }

    /// The estimator's on the microcontroller: as [`Self::reduced`], 5 samples per element.
    ///
    /// The force ripples as samples come into and out of contact. Largest difference from `trapezoid` 170/20 on an 80 mm
    /// circle at High, as a vector, in shares of max(1.5 %, 0.05 N): 4 samples 1.13, 5 samples 0.91, 6 samples 0.66
    /// (test `closing_and_opening`).
    pub const fn estimator(physics: Physics) -> Self {
        Self { sampling: Sampling::PerElement(5), ..Self::reduced(physics) }
    }

    /// The PC's default: as [`Self::reduced`], 4 elements per span and 2 per hinge.
    pub const fn fine(physics: Physics) -> Self {
        Self { elements: Elements::FINE, ..Self::reduced(physics) }
    }

    /// 170 elements per beam and 20 per hinge with contact at nodes and ε_c = 0: `paper` or `trapezoid`.
    pub const fn full(scheme: Scheme, physics: Physics) -> Self {
        Self { scheme, elements: Elements::PAPER, sampling: Sampling::Nodes, softness: 0.0, physics }
    }
}

/// Why a design could not be discretised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscretiseError {
    /// The design itself is at fault.
    Design(DesignError),
    /// Fewer elements than spans, or none per hinge.
    TooFewElements {
        /// What was asked for.
        found: u16,
        /// The least that is needed.
        needed: u16,
    },
    /// The number of samples per element is not 1 to 16, or samples within elements were asked of another scheme.
    Samples {
        /// What was asked for.
        found: u8,
    },
    /// The softness is negative or not finite.
    Softness {
        /// What was asked for, mm/N.
        found: f64,
    },
    /// More nodes, members or samples than this size has room for.
    Capacity,
}

impl From<DesignError> for DiscretiseError {
    fn from(error: DesignError) -> Self {
        Self::Design(error)
    }
}

impl core::fmt::Display for DiscretiseError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Design(error) => error.fmt(f),
            Self::TooFewElements { found, needed } => {
                write!(f, "elements is {found}; at least {needed} are needed (one per span, one per hinge)")
            }
            Self::Samples { found } => {
                write!(f, "samples is {found}; allowed is 1 to 16 per element, and scheme `simpson` only")
            }
            Self::Softness { found } => write!(f, "softness is {found} mm/N; allowed is 0 to 1"),
            Self::Capacity => write!(f, "the model has more elements or samples than this build has room for"),
        }
    }
}

impl core::error::Error for DiscretiseError {}

/// A hinge's flexible length reaches this many hinge thicknesses into the beam. Fitted, with shear, to finite elements at
/// small forces (`tests/reference/examples/fea.rs`); without shear the neck needs 0.38 and 0.35 to give way as much.
pub(crate) const BEAM_ROOT: f64 = 0.35;
/// A hinge's flexible length reaches this many hinge thicknesses into the lamella (fitted to finite elements).
pub(crate) const BAR_ROOT: f64 = 0.32;

/// Distances (front, back), mm, from the centrelines to the beams' faces along lamella k:
/// half the thickness over the sine of the angle between beam and lamella.
pub(crate) fn face_distances(design: &Design, lamella: usize) -> [f64; 2] {
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = libm::hypot(q[0] - p[0], q[1] - p[1]);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let distance = |beam: &crate::design::Beam, arc: f64| {
        let e = beam.direction();
        let sine = (e[0] * along[1] - e[1] * along[0]).abs();
        0.5 * beam.thickness.at(arc) / sine.max(0.1)
    };
    [distance(&design.front, arcs[0]), distance(&design.back, arcs[1])]
}

/// Factor on EI for a beam that cannot curl across its width.
pub(crate) fn plate_factor(design: &Design, width: f64, thickness: f64) -> f64 {
    let nu = design.material.poissons_ratio;
    let strain = 1.0 / (1.0 - nu * nu);
    match design.plane_strain {
        PlaneStrain::Stress => 1.0,
        PlaneStrain::Strain => strain,
        PlaneStrain::Auto => {
            // Share of the width that is held flat: the free edges curl over about one thickness each
            // (boundary layer of a bent strip, Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells, §11).
            let held = (1.0 - thickness / width).clamp(0.0, 1.0);
            1.0 + (strain - 1.0) * held
        }
    }
}

/// Stretch and shear compliance 1/EA and 1/κGA, 1/N, of a rectangular section of this area, mm² (times a stiffness factor).
///
/// κ = 10(1+ν)/(12+11ν): Cowper, J. Appl. Mech. 33 (1966).
fn compliance(design: &Design, physics: Physics, area: f64) -> [f64; 2] {
    if physics == Physics::Paper {
        return [0.0; 2];
    }
    let nu = design.material.poissons_ratio;
    let stretch = 1.0 / (design.material.youngs_modulus * area);
    let kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
    [stretch, stretch * 2.0 * (1.0 + nu) / kappa]
}

/// Elements per span by largest remainder: each span's share of `total` by length, at least one, ties to the tip.
fn spread(total: u16, lengths: &[f64], counts: &mut [u16]) -> Result<(), DiscretiseError> {
    let spans = lengths.len();
    if usize::from(total) < spans {
        return Err(DiscretiseError::TooFewElements { found: total, needed: spans as u16 });
    }
    let sum: f64 = lengths.iter().sum();
    let share = |span: usize| f64::from(total) * lengths[span] / sum;
    let mut used = 0_u32;
    for span in 0..spans {
        counts[span] = (libm::floor(share(span) + 1e-9) as u16).max(1);
        used += u32::from(counts[span]);
    }
    while used != u32::from(total) {
        let add = used < u32::from(total);
        let mut best: Option<(usize, f64)> = None;
        for span in 0..spans {
            if !add && counts[span] == 1 {
                continue;
            }
            let remainder = share(span) - f64::from(counts[span]);
            let key = if add { remainder } else { -remainder };
            if best.is_none_or(|(_, least)| key >= least - 1e-9) {
                best = Some((span, key));
            }
        }
        let Some((span, _)) = best else { break };
        if add {
            counts[span] += 1;
            used += 1;
        } else {
            counts[span] -= 1;
            used -= 1;
        }
    }
    Ok(())
}

/// A straight flexible rod between two rigid ends, about to become a member.
struct Rod<'a> {
    elements: u16,
    length: f64,
    direction: [f64; 2],
    /// Bending stiffness EI (N·mm²) against the position along the rod, 0 … 1.
    bending: &'a dyn Fn(f64) -> f64,
    /// Thickness, mm, against the same position.
    thickness: &'a dyn Fn(f64) -> f64,
    /// 1/EA and 1/κGA, 1/N.
    compliance: [f64; 2],
    rigid_start: [f64; 2],
    rigid_end: [f64; 2],
}

/// Writes a member's nodes; returns the number of nodes written.
fn write_rod<T: Real, S: Size>(
    ladder: &mut Ladder<T, S>,
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
    if first + count > usize::from(u16::MAX) || !ladder.fit_nodes(first + count) {
        return Err(DiscretiseError::Capacity);
    }
    let end = first + count;
    let direction = vec2::<T>(rod.direction);
    ladder.direction.as_mut()[first..end].fill([direction.x, direction.y]);
    let mut weight = |node: usize, value: f64| {
        let entry = &mut ladder.weight.as_mut()[first + node];
        *entry = T::of(entry.to_f64() + value);
    };
    let bending = |element: f64| (rod.bending)(element / n as f64);
    let fibre = |element: f64, length: f64| T::of(0.5 * (rod.thickness)(element / n as f64) / length);
    match scheme {
        Scheme::Paper => {
            for element in 0..n {
                weight(element + 1, h);
                ladder.coupling.as_mut()[first + element][0] = T::of(-bending(element as f64) / h);
                ladder.fibre.as_mut()[first + element] = fibre(element as f64, h);
            }
        }
        Scheme::Trapezoid => {
            for element in 0..n {
                weight(element + 1, h);
            }
            for spring in 0..=n {
                let length = if spring == 0 || spring == n { 0.5 * h } else { h };
                ladder.coupling.as_mut()[first + spring][0] = T::of(-bending(spring as f64) / length);
                ladder.fibre.as_mut()[first + spring] = fibre(spring as f64, length);
            }
        }
        Scheme::Simpson => {
            // Summed in f64 before rounding: interior ends carry h/6 from both sides.
            for element in 0..n {
                let c = bending(element as f64 + 0.5) / (3.0 * h);
                let node = 2 * element;
                let shared = if element > 0 { h / 6.0 } else { 0.0 };
                ladder.weight.as_mut()[first + node] = T::of(shared + h / 6.0);
                ladder.weight.as_mut()[first + node + 1] = T::of(4.0 * h / 6.0);
                ladder.weight.as_mut()[first + node + 2] = T::of(h / 6.0);
                ladder.coupling.as_mut()[first + node] = [T::of(-8.0 * c), T::of(c)];
                ladder.coupling.as_mut()[first + node + 1] = [T::of(-8.0 * c), T::ZERO];
                ladder.fibre.as_mut()[first + node..first + node + 2].fill(fibre(element as f64 + 0.5, h));
            }
        }
    }
    Ok(Member {
        first: first as u16,
        interior: interior as u16,
        start: CLAMPED,
        end: CLAMPED,
        rigid_start: rod.rigid_start.map(T::of),
        rigid_end: rod.rigid_end.map(T::of),
        compliance: rod.compliance.map(T::of),
    })
}

/// Writes a member without length or stiffness (a pin, or the stand-in of a weld).
fn write_point<T: Real, S: Size>(
    ladder: &mut Ladder<T, S>,
    first: usize,
    rigid_start: [f64; 2],
) -> Result<Member<T>, DiscretiseError> {
    if !ladder.fit_nodes(first + 2) {
        return Err(DiscretiseError::Capacity);
    }
    ladder.direction.as_mut()[first..first + 2].fill([T::one(), T::ZERO]);
    Ok(Member {
        first: first as u16,
        interior: 0,
        start: CLAMPED,
        end: CLAMPED,
        rigid_start: rigid_start.map(T::of),
        rigid_end: [T::ZERO; 2],
        compliance: [T::ZERO; 2],
    })
}

/// Discretises a design into a ladder, in place.
///
/// # Errors
/// A [`DesignError`] for a description that is refused, otherwise what does not fit; the ladder must then be
/// discretised again before use.
pub fn discretise<T: Real, S: Size>(
    design: &Design,
    how: &Discretisation,
    ladder: &mut Ladder<T, S>,
) -> Result<(), DiscretiseError> {
    let paper;
    let design = match how.physics {
        Physics::Extended => design,
        Physics::Paper => {
            let mut simple = design.clone();
            simple.hinge.from = HingeFrom::Centreline;
            simple.rigid_above = None;
            simple.plane_strain = PlaneStrain::Stress;
            paper = simple;
            &paper
        }
    };
    design.validate()?;
    if !(0.0..=1.0).contains(&how.softness) {
        return Err(DiscretiseError::Softness { found: how.softness });
    }
    if let Sampling::PerElement(samples) = how.sampling
        && (how.scheme != Scheme::Simpson || samples == 0 || samples > 16)
    {
        return Err(DiscretiseError::Samples { found: samples });
    }
    let lamellae = design.lamella_count();
    let cells = lamellae + 1;
    ladder.reset(cells).then_some(()).ok_or(DiscretiseError::Capacity)?;
    ladder.softness = T::of(how.softness);
    ladder.quadratic = how.scheme == Scheme::Simpson;
    ladder.welded = design.hinge.kind == HingeKind::Welded;

    let ends = design.flexible_ends();
    let beams = [&design.front, &design.back];
    // Arc length at which span `cell` of a beam starts or, one further, ends.
    let arc = |side: usize, joint: usize| match joint {
        0 => 0.0,
        _ if joint == cells => ends[side],
        _ => design.attachment_arcs(joint - 1)[side],
    };
    let (counts, hinge_elements) = element_counts(how, cells, |cell| arc(0, cell + 1) - arc(0, cell))?;
    let e_modulus = design.material.youngs_modulus;

    let mut node = 0;
    for cell in 0..cells {
        for side in 0..2 {
            let beam = beams[side];
            let (from, to) = (arc(side, cell), arc(side, cell + 1));
            let section = |at: f64| {
                let position = from + at * (to - from);
                let thickness = beam.thickness.at(position);
                let width = design.width.at(beam.point(position)[1]);
                (width, thickness)
            };
            let bending = |at: f64| {
                let (w, t) = section(at);
                e_modulus * beam.stiffness_factor * w * t * t * t / 12.0 * plate_factor(design, w, t)
            };
            let thickness = |at: f64| section(at).1;
            let (w, t) = section(0.5);
            let tip = if cell == lamellae { rigid_tip(design, side, ends) } else { [0.0; 2] };
            let rod = Rod {
                elements: counts[cell],
                length: to - from,
                direction: beam.direction(),
                bending: &bending,
                thickness: &thickness,
                compliance: compliance(design, how.physics, beam.stiffness_factor * w * t),
                rigid_start: [0.0; 2],
                rigid_end: tip,
            };
            let mut member = write_rod(ladder, how.scheme, node, &rod)?;
            let slot = if side == 0 { 2 } else { 4 };
            member.start = if cell == 0 { CLAMPED } else { ladder.joint(cell - 1, slot) };
            member.end = ladder.joint(cell, slot);
            node = member.nodes().end;
            ladder.members.as_mut()[4 * cell + side] = member;
            ladder.add_scale(4 * cell + side, bending(0.5) / (to - from), to - from);
        }
        if cell < lamellae {
            node = write_hinges(ladder, design, how, cell, hinge_elements, node)?;
        }
    }
    ladder.node_count = node;
    write_samples(ladder, design, how, &counts[..cells])?;
    let (f, b) = (design.front.base, design.back.base);
    ladder.base_rung = [T::of(b[0] - f[0]), T::of(b[1] - f[1])];
    ladder.base = f.map(T::of);
    ladder.close_at_rest();
    Ok(())
}

fn element_counts(
    how: &Discretisation,
    cells: usize,
    length: impl Fn(usize) -> f64,
) -> Result<([u16; crate::design::MAX_LAMELLAE + 1], u16), DiscretiseError> {
    let mut counts = [0_u16; crate::design::MAX_LAMELLAE + 1];
    let hinge = match how.elements {
        Elements::PerBeam { beam, hinge } => {
            let mut lengths = [0.0; crate::design::MAX_LAMELLAE + 1];
            for cell in 0..cells {
                lengths[cell] = length(cell);
            }
            spread(beam, &lengths[..cells], &mut counts[..cells])?;
            hinge
        }
        Elements::PerSpan { span, tip_span, hinge } => {
            counts[..cells].fill(span);
            counts[cells - 1] = tip_span;
            hinge
        }
    };
    let least = counts[..cells].iter().copied().min().unwrap_or(0).min(hinge);
    if least == 0 {
        return Err(DiscretiseError::TooFewElements { found: 0, needed: 1 });
    }
    Ok((counts, hinge))
}

/// Rigid vector from the end of a beam's flexible part to the front beam's tip.
fn rigid_tip(design: &Design, side: usize, ends: [f64; 2]) -> [f64; 2] {
    let beam = [&design.front, &design.back][side];
    let end = beam.point(ends[side]);
    let tip = design.front.tip;
    let offset = [tip[0] - end[0], tip[1] - end[1]];
    // The front beam without a wedge ends at the tip: no rounding residue.
    if design.rigid_above.is_none() && side == 0 { [0.0; 2] } else { offset }
}

fn write_hinges<T: Real, S: Size>(
    ladder: &mut Ladder<T, S>,
    design: &Design,
    how: &Discretisation,
    lamella: usize,
    elements: u16,
    node: usize,
) -> Result<usize, DiscretiseError> {
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = design.lamella_width(lamella);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let scaled = |length: f64| [length * along[0], length * along[1]];
    let (mut front, mut back, stiffness, length) = if design.hinge.kind == HingeKind::Flexible {
        let t = design.hinge.thickness;
        let clear = design.hinge.length_of(lamella);
        let (length, starts, bar) = match design.hinge.from {
            HingeFrom::Centreline => (clear, [0.0; 2], width - 2.0 * clear),
            HingeFrom::Face => {
                let faces = face_distances(design, lamella);
                let bar = width - faces[0] - faces[1] - 2.0 * clear - 2.0 * BAR_ROOT * t;
                (clear + (BEAM_ROOT + BAR_ROOT) * t, faces.map(|face| face - BEAM_ROOT * t), bar)
            }
        };
        let w = design.width.at(0.5 * (p[1] + q[1]));
        let stiffness = design.material.youngs_modulus * w * t * t * t / 12.0 * plate_factor(design, w, t);
        let compliance = compliance(design, how.physics, w * t);
        let bending = |_: f64| stiffness;
        let thickness = |_: f64| t;
        let rod = |rigid_start, rigid_end| Rod {
            elements,
            length,
            direction: along,
            bending: &bending,
            thickness: &thickness,
            compliance,
            rigid_start,
            rigid_end,
        };
        let front = write_rod(ladder, how.scheme, node, &rod(scaled(starts[0]), [0.0; 2]))?;
        let back = write_rod(ladder, how.scheme, front.nodes().end, &rod(scaled(bar), scaled(starts[1])))?;
        (front, back, stiffness / length, length)
    } else {
        let front = write_point(ladder, node, [0.0; 2])?;
        let back = write_point(ladder, front.nodes().end, scaled(width))?;
        (front, back, 0.0, 0.0)
    };
    (front.start, front.end) = (ladder.joint(lamella, 2), ladder.joint(lamella, 3));
    (back.start, back.end) = (ladder.joint(lamella, 3), ladder.joint(lamella, 4));
    for (side, member) in [front, back].into_iter().enumerate() {
        ladder.members.as_mut()[4 * lamella + 2 + side] = member;
        ladder.add_scale(4 * lamella + 2 + side, stiffness, length);
    }
    Ok(back.nodes().end)
}

/// Places the contact samples along the front beam, base to tip, and on the face of the rigid wedge.
fn write_samples<T: Real, S: Size>(
    ladder: &mut Ladder<T, S>,
    design: &Design,
    how: &Discretisation,
    counts: &[u16],
) -> Result<(), DiscretiseError> {
    let ends = design.flexible_ends();
    let beam = &design.front;
    let mut total = 0;
    let mut push = |ladder: &mut Ladder<T, S>, sample: Sample<T>| {
        total += 1;
        let fits = ladder.samples.fit(total);
        if fits {
            ladder.samples.as_mut()[total - 1] = sample;
            ladder.sample_count = total;
        }
        fits.then_some(()).ok_or(DiscretiseError::Capacity)
    };
    let per_element = match how.sampling {
        Sampling::Nodes => 1,
        Sampling::PerElement(n) => usize::from(n),
    };
    let cells = counts.len();
    let mut from = 0.0;
    for (cell, &count) in counts.iter().enumerate() {
        let to = if cell + 1 == cells { ends[0] } else { design.attachment_arcs(cell)[0] };
        let h = (to - from) / f64::from(count);
        let first = usize::from(ladder.members.as_ref()[4 * cell].first);
        for element in 0..usize::from(count) {
            for k in 1..=per_element {
                let xi = k as f64 / per_element as f64;
                let arc = from + (element as f64 + xi) * h;
                let (node, weights) = match how.scheme {
                    Scheme::Paper | Scheme::Trapezoid => (first + element + 1, [h, 0.0, 0.0]),
                    Scheme::Simpson => {
                        let [a, m, b] = hermite_weights(xi, h);
                        let shared = if element > 0 { h / 6.0 } else { 0.0 };
                        (first + 2 * element, [shared + a, m, b])
                    }
                };
                push(
                    ladder,
                    Sample {
                        cell: cell as u16,
                        node: node as u16,
                        weights: weights.map(T::of),
                        rigid: T::ZERO,
                        arc: T::of(arc),
                        half_thickness: T::of(0.5 * beam.thickness.at(arc)),
                    },
                )?;
            }
        }
        from = to;
    }
    let wedge = beam.length() - ends[0];
    if design.rigid_above.is_some() && wedge > 1e-9 {
        // The wedge is sampled about as densely as the elements below it.
        let h = (ends[0] - if cells > 1 { design.attachment_arcs(cells - 2)[0] } else { 0.0 })
            / f64::from(counts[cells - 1]);
        let pieces = libm::ceil(wedge / h) as usize * per_element;
        let last = ladder.members.as_ref()[4 * (cells - 1)];
        for k in 1..=pieces {
            let part = k as f64 / pieces as f64;
            let arc = ends[0] + part * wedge;
            push(
                ladder,
                Sample {
                    cell: (cells - 1) as u16,
                    node: last.first + last.interior + 2,
                    weights: [T::ZERO; 3],
                    rigid: T::of(part),
                    arc: T::of(arc),
                    half_thickness: T::of(0.5 * beam.thickness.at(arc)),
                },
            )?;
        }
    }
    Ok(())
}

/// Weights of e(a), e(m), e(b) in P(ξ) − P₀ of an element of length h: the cubic Hermite curve through both ends, whose
/// chord is Simpson's rule h/6·(e(a) + 4 e(m) + e(b)) and whose end tangents are h·e(a) and h·e(b).
fn hermite_weights(xi: f64, h: f64) -> [f64; 3] {
    let h01 = xi * xi * (3.0 - 2.0 * xi);
    let h10 = xi * (1.0 - xi) * (1.0 - xi);
    let h11 = xi * xi * (xi - 1.0);
    [h * (h01 / 6.0 + h10), h * h01 * 4.0 / 6.0, h * (h01 / 6.0 + h11)]
}
