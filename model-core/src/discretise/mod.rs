//! From a design to members and joints, by scheme, resolution and physics (design description → [`Model`]).
//!
//! All lengths and stiffnesses are computed in `f64` and rounded once, so the single-precision model has the best
//! constants it can have, and the same ones on every machine.

mod buckling;
mod natural;
mod plate;
mod rod;
mod rung;
mod samples;
mod section;
mod welded;

use crate::access::Access as _;
use crate::design::junction::flexible_ends;
use crate::design::weld::Weld;
use crate::design::{Design, DesignError, HingeFrom, PlaneStrain};
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{CLAMPED, Role, Rung};
use crate::units::Units;
pub use plate::{Plate, plate_factor};
use rod::{Piece, Rod, write_rod};
use rung::{MOST_JOINTS, Slot, rigid_tip, weld, with_parts, write_rung};
use samples::write_samples;
use section::compliance;
use welded::Welded;

/// How a member of N elements is discretised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Scheme {
    /// That of *Geometrico-Static Modelling of a FRE Finger*: rigid elements, springs EI/ℓe between neighbours and from the first
    /// element to the start joint; the last element is rigid with the end joint. First order.
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
    /// That of *Geometrico-Static Modelling of a FRE Finger*: inextensible, hinges from the centrelines, no rigid tip, plane stress.
    Paper,
    /// Stretch and shear in every member, a bending stiffness that follows the stretch by the material's law, effective hinges,
    /// rigid tip wedge and plate stiffening as the design says.
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
    /// So many per span. A beam of few spans has more: four times as many as a span, and four, each where elements are longest by then.
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
    /// Those of *Geometrico-Static Modelling of a FRE Finger*: 170 per beam, 20 per hinge.
    pub const PAPER: Self = Self::PerBeam { beam: 170, hinge: 20 };

    /// Those of each beam of a finger with so many lamellae.
    pub fn of_beam(self, lamellae: usize) -> usize {
        match self {
            Self::PerBeam { beam, .. } => usize::from(beam),
            Self::PerSpan { span, tip_span, .. } => {
                (lamellae * usize::from(span) + usize::from(tip_span)).max(least_of_beam(span))
            }
        }
    }
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

/// Softness ε_c of the contact: a touching sample's gap is −ε_c μ. It shares the force between neighbouring samples, which without it
/// are all but dependent.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Softness {
    /// That of the front beam itself at a point, 1/(E w), with E with the beam's stiffness factor and w the finger's largest width: the
    /// force is less by as small a part whatever the finger is made of.
    #[default]
    Local,
    /// So much, mm/N. Where an object is so sharp that it is looked for between the samples, no less than [`Self::Local`]; and with friction
    /// zero stands for that.
    Fixed(f64),
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
    /// Contact softness ε_c in g + ε_c μ = 0.
    pub softness: Softness,
    /// Physics.
    pub physics: Physics,
}

impl Discretisation {
    /// The microcontroller's resolution: `simpson`, reduced, 4 samples per element, the beam's own softness.
    pub const fn reduced(physics: Physics) -> Self {
        Self {
            scheme: Scheme::Simpson,
            elements: Elements::REDUCED,
            sampling: Sampling::PerElement(4),
            softness: Softness::Local,
            physics,
        }
    }

    /// The estimator's on the microcontroller: as [`Self::reduced`], 5 samples per element.
    ///
    /// The force ripples as samples come into and out of contact. Largest difference from `trapezoid` 170/20 on an 80 mm
    /// circle at High, as a vector, in shares of max(1.5 %, 0.05 N): physics paper 4 samples 1.13, 5 samples 0.91,
    /// 6 samples 0.66; extended 0.56 with 4 and 0.40 with 5 (test `closing_and_opening`).
    pub const fn estimator(physics: Physics) -> Self {
        Self { sampling: Sampling::PerElement(5), ..Self::reduced(physics) }
    }

    /// The PC's default: as [`Self::reduced`], 4 elements per span and 2 per hinge.
    pub const fn fine(physics: Physics) -> Self {
        Self { elements: Elements::FINE, ..Self::reduced(physics) }
    }

    /// 170 elements per beam and 20 per hinge with contact at nodes and ε_c = 0: `paper` or `trapezoid`.
    pub const fn full(scheme: Scheme, physics: Physics) -> Self {
        Self { scheme, elements: Elements::PAPER, sampling: Sampling::Nodes, softness: Softness::Fixed(0.0), physics }
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

/// Elements per span by largest remainder: each span's share of `total` by length, at least one, ties to the tip.
fn spread(total: u16, lengths: &[f64], counts: &mut [u16]) -> Result<(), DiscretiseError> {
    let spans = lengths.len();
    if usize::from(total) < spans {
        return Err(DiscretiseError::TooFewElements { found: total, needed: spans as u16 });
    }
    let sum: f64 = lengths.iter().sum();
    let share = |span: usize| f64::from(total) * lengths.at(span) / sum;
    let mut used = 0_u32;
    for span in 0..spans {
        let count = (libm::floor(share(span) + 1e-9) as u16).max(1);
        counts.put(span, count);
        used += u32::from(count);
    }
    while used != u32::from(total) {
        let add = used < u32::from(total);
        let mut best: Option<(usize, f64)> = None;
        for span in 0..spans {
            if !add && counts.at(span) == 1 {
                continue;
            }
            let remainder = share(span) - f64::from(counts.at(span));
            let key = if add { remainder } else { -remainder };
            if best.is_none_or(|(_, least)| key >= least - 1e-9) {
                best = Some((span, key));
            }
        }
        let Some((span, _)) = best else { break };
        if add {
            counts.put(span, counts.at(span) + 1);
            used += 1;
        } else {
            counts.put(span, counts.at(span) - 1);
            used -= 1;
        }
    }
    Ok(())
}

/// Discretises a design into a model, in place.
///
/// # Errors
/// A [`DesignError`] for a description that is refused, otherwise what does not fit; the model must then be
/// discretised again before use.
pub fn discretise<T: Real, S: Size>(
    design: &Design,
    how: &Discretisation,
    model: &mut Model<T, S>,
) -> Result<(), DiscretiseError> {
    discretise_in(design, how, None, model)
}

/// As [`discretise`], but in the units given: those of a finger that differs a little.
pub(crate) fn discretise_in<T: Real, S: Size>(
    design: &Design,
    how: &Discretisation,
    units: Option<Units<f64>>,
    model: &mut Model<T, S>,
) -> Result<(), DiscretiseError> {
    let mut design = design.clone();
    if how.physics == Physics::Paper {
        design.hinge.from = HingeFrom::Centreline;
        design.rigid_above = None;
        design.plane_strain = PlaneStrain::Stress;
    }
    design.validate()?;
    let units = units.unwrap_or_else(|| natural::units(&design));
    natural::express(&mut design, &units);
    let design = &design;
    if let Softness::Fixed(found) = how.softness
        && !(0.0..=1.0).contains(&found)
    {
        return Err(DiscretiseError::Softness { found });
    }
    if let Sampling::PerElement(samples) = how.sampling
        && (how.scheme != Scheme::Simpson || samples == 0 || samples > 16)
    {
        return Err(DiscretiseError::Samples { found: samples });
    }
    let lamellae = design.lamella_count();
    let cells = lamellae + 1;
    model.reset(cells).then_some(()).ok_or(DiscretiseError::Capacity)?;
    model.units = Units { length: T::of(units.length), force: T::of(units.force) };
    let widest = design.width.knots.iter().fold(0.0_f64, |most, knot| most.max(knot[1]));
    let local = 1.0 / (design.material.youngs_modulus * design.front.factors()[1] * widest);
    model.softness = match how.softness {
        Softness::Local => [T::of(local); 2],
        Softness::Fixed(softness) => [T::of(softness * units.force / units.length), T::of(local)],
    };
    model.softness_is_own = how.softness == Softness::Local;

    let ends = flexible_ends(design);
    let beams = [&design.front, &design.back];
    // Arc length at which span `cell` of a beam starts or, one further, ends.
    let arc = |side: usize, joint: usize| match joint {
        0 => beams[side].clamp,
        _ if joint == cells => ends[side],
        _ => design.attachment_arcs(joint - 1)[side],
    };
    // The weld at an end of a span.
    let at_joint = |joint: usize| match joint {
        0 => Weld::default(),
        _ if joint == cells => Weld::default(),
        _ => weld(design, how, joint - 1),
    };
    // Arc lengths between which a span bends.
    let span = |side: usize, cell: usize| {
        let from = (arc(side, cell) + at_joint(cell).reach[side][1]).max(beams[side].clamp);
        (from, arc(side, cell + 1) - at_joint(cell + 1).reach[side][0])
    };
    let (counts, hinge_elements) = element_counts(how, cells, |cell| {
        let (from, to) = span(0, cell);
        to - from
    })?;
    let e_modulus = design.material.youngs_modulus;

    let mut node = 0;
    let mut closure = model.topology.add_closure();
    // Where the spans of front and back begin.
    let mut starts = [CLAMPED; 2];
    for cell in 0..cells {
        // The unknowns of a cell: its closure's, those of the joints at its upper end, front to back, and the next closure's.
        let mut joints = [CLAMPED; MOST_JOINTS];
        let mut count = 1;
        if cell < lamellae {
            with_parts(design, how, cell, hinge_elements, &mut |parts| count = Rung::joints(parts));
        }
        // The joint on a back beam that is held does not turn; the others are then numbered from there on, as a member leads from a joint
        // that does not turn, or from one of a lower number.
        let held = cell < lamellae && at_joint(cell + 1).held;
        let joints_used = joints.get_mut(..count - usize::from(held)).ok_or(DiscretiseError::Capacity)?;
        if held {
            joints_used.iter_mut().rev().for_each(|joint| *joint = model.topology.add_joint());
        } else {
            joints_used.fill_with(|| model.topology.add_joint());
        }
        let ends_at = [joints.at(0), joints.at(count - 1)];
        let above = if cell < lamellae { model.topology.add_closure() } else { closure };

        for side in 0..if held { 1 } else { 2 } {
            let beam = beams[side];
            let (from, to) = span(side, cell);
            let section = |at: f64| {
                let position = from + at * (to - from);
                let thickness = beam.thickness.at(position);
                let width = design.width.at(beam.point(position)[1]);
                (width, thickness)
            };
            let [bending_factor, stretch_factor] = beam.factors();
            let plate = Plate::of_beam(design, side, 0.5 * (from + to));
            let plain = |at: f64| {
                let (w, t) = section(at);
                let plate = Plate { width: w, thickness: t, ..plate };
                e_modulus * bending_factor * w * t * t * t / 12.0 * plate_factor(design, &plate)
            };
            let thickness = |at: f64| section(at).1;
            let (w, t) = section(0.5);
            let compliance = compliance(design, how.physics, stretch_factor * w * t);
            let stiffening = 3.0 * design.material.law.second_order() * compliance[0];
            let arms = [at_joint(cell).above(side), at_joint(cell + 1).below(side)];
            let welded = Welded::new(compliance, arms, to - from, plain(0.5));
            let bending = |at: f64| plain(at) * welded.bending(at);
            let piece =
                Piece { elements: counts.at(cell), length: to - from, bending: &bending, thickness: &thickness };
            let rod = Rod {
                pieces: &[piece],
                direction: &|at: f64| beam.direction(from + at * (to - from)),
                compliance: welded.compliance,
                stiffening,
                backwards: false,
            };
            let mut member = write_rod(model, how.scheme, node, &rod)?;
            node = member.nodes().end;
            let [down, up] = at_joint(cell + 1).reach[side];
            let rigid = down + up;
            if cell == lamellae {
                member.rigid_end = rigid_tip(design, side, ends).map(T::of);
            } else if rigid > 0.0 {
                // The joint, and with it the next span's start, lies at the upper end of the weld.
                let (p, q) = (beam.point(to), beam.point(to + rigid));
                member.rigid_end = [q[0] - p[0], q[1] - p[1]].map(T::of);
            }
            let (role, sign) = if side == 0 { (Role::Front(cell as u8), 1.0) } else { (Role::Back(cell as u8), -1.0) };
            (member.role, member.start, member.end) = (role, starts[side], ends_at[side]);
            let added = model.topology.add_member(member, &[(closure, sign)]);
            let index = added.ok_or(DiscretiseError::Capacity)?;
            model.topology.add_scale(index, bending(0.5) / (to - from), to - from);
        }
        if cell < lamellae {
            let slot = Slot { lamella: cell, joints, closures: [closure, above], held, node };
            let mut written = Err(DiscretiseError::Capacity);
            with_parts(design, how, cell, hinge_elements, &mut |parts| {
                written = write_rung(model, how, &slot, parts);
            });
            node = written?;
        }
        (closure, starts) = (above, ends_at);
    }
    if !model.topology.fits_the_band() {
        return Err(DiscretiseError::Capacity);
    }
    model.node_count = node;
    write_samples(model, design, how, counts.run(0..cells))?;
    let [f, b] = beams.map(|beam| beam.point(beam.clamp));
    model.base_rung = [T::of(b[0] - f[0]), T::of(b[1] - f[1])];
    model.base = f.map(T::of);
    model.clamps = beams.map(|beam| T::of(beam.clamp));
    let held = design.front.base;
    model.held = [T::of(held[0] - f[0]), T::of(held[1] - f[1])];
    model.complete_stiffness();
    model.find_buckling_loads();
    model.close_at_rest();
    Ok(())
}

/// The fewest elements of a beam that has so many per span.
fn least_of_beam(span: u16) -> usize {
    4 * (usize::from(span) + 1)
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
                lengths.put(cell, length(cell));
            }
            spread(beam, lengths.run(0..cells), counts.run_mut(0..cells))?;
            hinge
        }
        Elements::PerSpan { span, tip_span, hinge } => {
            counts.run_mut(0..cells).fill(span);
            counts.put(cells - 1, tip_span);
            let counts = counts.run_mut(0..cells);
            let found: usize = counts.iter().map(|&count| usize::from(count)).sum();
            let wanted = if counts.contains(&0) { 0 } else { least_of_beam(span) };
            for _ in found..wanted {
                let longest = |cell: &usize| length(*cell) / f64::from(counts.at(*cell));
                let cell = (0..cells).max_by(|a, b| longest(a).total_cmp(&longest(b)));
                counts.add(cell.unwrap_or(cells), 1);
            }
            hinge
        }
    };
    let least = counts.run(0..cells).iter().copied().min().unwrap_or(0).min(hinge);
    if least == 0 {
        return Err(DiscretiseError::TooFewElements { found: 0, needed: 1 });
    }
    Ok((counts, hinge))
}
