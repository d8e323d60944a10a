//! The region that the finger fills as it is built: the beams' faces, the tip, and where the lamellae are joined.

use model_core::design::{Beam, Design, HingeKind, PlaneStrain};

use super::error::FeaError;
use super::fillet::Fillet;
pub use crate::faces::{Faces, Point};
pub(super) use crate::faces::{cross, dot, minus};
use crate::shape::insets;

/// Height below the notch from which on a solid tip has an edge of its own, mm.
const NARROWEST: f64 = 0.05;

/// What fillets leave free.
const FRONT: &str = "the front beam beside its fillets";
const BACK: &str = "the back beam beside its fillets";

/// Where a lamella is joined to the two beams, and its bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Arcs of the front beam across from the lower and the upper edge of the neck.
    pub front: [f64; 2],
    /// The same of the back beam.
    pub back: [f64; 2],
    /// Middle of the bar's front end; for a welded lamella on the front centreline.
    pub start: Point,
    /// Unit vector along the lamella, front to back.
    pub along: Point,
    /// Unit vector across the lamella, towards the tip.
    pub up: Point,
    /// Length of the bar.
    pub length: f64,
    /// Half the thickness of the neck (for a welded lamella of the bar, the mean).
    pub neck: f64,
    /// Half the thickness of the bar.
    pub bar: f64,
    /// It ends on the held part of the back beam.
    pub held: bool,
    /// Distance of a rib's free end from the back beam's face along the rib.
    pub gap: Option<f64>,
    /// Fillets of a welded rib at the front and the back beam, below and above it.
    pub fillets: Option<[[Fillet; 2]; 2]>,
}

impl Joint {
    /// Arcs of the front beam (0) or the back beam (1) between which the joint and its fillets lie.
    pub fn extent(&self, faces: &Faces<'_>, beam: usize) -> [f64; 2] {
        let [low, high] = if beam == 0 { self.front } else { self.back };
        match self.fillets {
            Some(fillets) => {
                let [below, above] = fillets[beam].map(|fillet| faces.arc_beside(fillet.at(0.0)));
                [below.min(low), above.max(high)]
            }
            None => [low, high],
        }
    }
}

/// The region.
#[derive(Clone, Debug)]
pub struct Region<'d> {
    /// Faces of the front beam.
    pub front: Faces<'d>,
    /// Faces of the back beam.
    pub back: Faces<'d>,
    /// The lamellae, base to tip.
    pub joints: Vec<Joint>,
    /// How the lamellae are joined to the beams.
    pub kind: HingeKind,
    /// Arcs (front, back) at which the beams' inner faces meet, or at which they reach the lower edge of a solid tip that begins below.
    pub merge: [f64; 2],
    /// Point where they meet, or the middle of that edge.
    pub notch: Point,
    /// Corners of the tip: on the front beam's outer face, on its centreline, on the back beam's outer face.
    pub top: [Point; 3],
    /// Arcs (front, back) at which the outer faces end in the tip's corners.
    pub ends: [f64; 2],
}

impl<'d> Region<'d> {
    /// The region of a design.
    ///
    /// # Errors
    /// If a part has no room, or the finger has something that finite elements here do not know.
    pub fn of(design: &'d Design) -> Result<Self, FeaError> {
        let (front, back) = (Faces::front(design), Faces::back(design));
        let merge = Faces::meeting(&front, &back).ok_or(FeaError::Unsupported {
            what: "a tip where the beams' inner faces do not meet",
            allowed: "inner faces apart at the base and meeting below the tip",
        })?;
        let (merge, notch) = solid(design, [&front, &back], merge);
        let tip = design.front.tip;
        let across = front.inward(front.length());
        let top_arc = Faces::crossing(|s| back.outer(s), tip, across, back.length());
        let top = [front.outer(front.length()), tip, back.outer(top_arc)];

        let joints = (0..design.lamella_count()).map(|k| joint(design, k, &front, &back, merge));
        let joints: Vec<Joint> = joints.collect::<Result<_, _>>()?;
        for (k, joint) in joints.iter().enumerate().filter(|(_, joint)| joint.fillets.is_some()) {
            for (beam, (faces, what)) in [(front, FRONT), (back, BACK)].into_iter().enumerate() {
                let below = k.checked_sub(1).map_or(faces.clamp(), |k| joints[k].extent(&faces, beam)[1]);
                let [from, to] = joint.extent(&faces, beam);
                let room = (from - below).min(merge[beam] - to);
                if room <= 1e-3 && !(beam == 1 && joint.held) {
                    return Err(FeaError::NoRoom { lamella: k, what, value: room });
                }
            }
        }
        let ends = [front.length(), top_arc];
        Ok(Self { joints, front, back, kind: design.joint(), merge, notch, top, ends })
    }
}

/// Where the tip begins to be solid: arcs of the beams (front, back), and the middle between their inner faces there. That is where the inner
/// faces meet, unless a solid tip begins further down.
fn solid(design: &Design, [front, back]: [&Faces<'_>; 2], merge: [f64; 2]) -> ([f64; 2], Point) {
    let notch = front.inner(merge[0]);
    match design.rigid_above {
        Some(height) if height < notch[1] - NARROWEST => {
            let arc = |faces: &Faces<'_>, beam: &Beam| {
                Faces::crossing(|s| faces.inner(s), [0.0, height], [1.0, 0.0], beam.arc_at_height(height))
            };
            let arcs = [arc(front, &design.front), arc(back, &design.back)];
            let (a, b) = (front.inner(arcs[0]), back.inner(arcs[1]));
            (arcs, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
        }
        _ => (merge, notch),
    }
}

/// Something of the design is stiffer in bending than in stretch by another factor than its section has: as a plate, or as it was printed.
pub fn is_layered(design: &Design) -> bool {
    let apart = |[bending, stretch]: [f64; 2]| bending != stretch;
    let ribs = design.lamellae.ribs().is_some_and(|ribs| apart([ribs.bending_factor, ribs.stretch_factor]));
    design.plane_strain == PlaneStrain::Auto
        || ribs
        || [&design.front, &design.back].iter().any(|beam| apart(beam.factors()))
}

fn joint(
    design: &Design,
    lamella: usize,
    front: &Faces<'_>,
    back: &Faces<'_>,
    merge: [f64; 2],
) -> Result<Joint, FeaError> {
    let halves = design.lamella_thickness(lamella).map(|thickness| 0.5 * thickness);
    let welded = design.joint() == HingeKind::Welded;
    if halves[0] != halves[1] && !welded {
        return Err(FeaError::Unsupported {
            what: "a tapered lamella with hinges",
            allowed: "one with the same thickness at both ends",
        });
    }
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = design.lamella_width(lamella);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let up = [along[1], -along[0]];
    let inset = insets(design, lamella);
    let start = [p[0] + inset[0] * along[0], p[1] + inset[0] * along[1]];
    let bar = 0.5 * (halves[0] + halves[1]);
    let neck = match design.joint() {
        HingeKind::Flexible => 0.5 * design.hinge.thickness,
        _ => bar,
    };
    // A tapered rib's edges run from the one face to the other.
    let ends = if welded { halves } else { [neck; 2] };
    let inner = |faces: &Faces<'_>, arc: f64, sign: f64| {
        let face = Faces::crossing(|s| faces.inner(s), p, along, arc);
        sign * dot(minus(faces.inner(face), if sign > 0.0 { p } else { q }), along)
    };
    let gap = design.lamellae.gap().map(|gap| gap / dot(back.inward(arcs[1]), along).abs().max(0.1));
    let faces_at = [inner(front, arcs[0], 1.0), width - inner(back, arcs[1], -1.0) - gap.unwrap_or(0.0)];
    let slope = (ends[1] - ends[0]) / (faces_at[1] - faces_at[0]);
    let half = |at: f64| ends[0] + slope * (at - faces_at[0]);
    let edges = |faces: &Faces<'_>, arc: f64| {
        [-1.0, 1.0].map(|side| {
            let corner = |at: f64| {
                let by = side * half(at);
                [0, 1].map(|i| p[i] + at * along[i] + by * up[i])
            };
            let (edge, end) = (corner(0.0), corner(width));
            Faces::crossing(|s| faces.inner(s), edge, minus(end, edge), arc)
        })
    };
    // A pin joins the centrelines; the elements beside it are as small as at a bar's edges.
    let pinned = design.joint() == HingeKind::Pinned;
    let sides = |faces: &Faces<'_>, arc: f64| if pinned { [arc - neck, arc + neck] } else { edges(faces, arc) };
    let ends = [sides(front, arcs[0]), sides(back, arcs[1])];
    let radius = design.lamellae.ribs().map_or(0.0, |ribs| ribs.fillet);
    if radius > 0.0 && gap.is_some() {
        return Err(FeaError::Unsupported {
            what: "a rib with fillets and a gap",
            allowed: "lamellae.fillet_mm = 0 beside lamellae.ends = \"gap\"",
        });
    }
    let joint = Joint {
        front: ends[0],
        back: ends[1],
        start,
        along,
        up,
        length: width - inset[0] - inset[1],
        neck,
        bar: bar.max(neck),
        held: arcs[1] <= design.back.clamp || ends[1][0] <= design.back.clamp,
        gap,
        fillets: (welded && radius > 0.0).then(|| fillets([front, back], ends, radius)),
    };
    let room = |value: f64, what: &'static str| {
        if value > 1e-3 { Ok(()) } else { Err(FeaError::NoRoom { lamella, what, value }) }
    };
    room(joint.length, "the bar's length")?;
    room(merge[0] - joint.front[1], "the front beam above it, below the solid tip")?;
    room(merge[1] - joint.back[1], "the back beam above it, below the solid tip")?;
    room(joint.front[0] - front.clamp(), "the front beam below it")?;
    if !joint.held {
        room(joint.back[0] - back.clamp(), "the back beam below it")?;
    }
    if design.joint() == HingeKind::Flexible {
        // Each corner of the bar's ends must stand clear of the face that the neck comes from.
        let at = |along_by: f64, up_by: f64| {
            [start[0] + along_by * along[0] + up_by * up[0], start[1] + along_by * along[1] + up_by * up[1]]
        };
        for side in [-joint.bar, joint.bar] {
            room(front.height_over_inner(at(0.0, side)).0, "the front neck's clear length")?;
            room(back.height_over_inner(at(joint.length, side)).0, "the back neck's clear length")?;
        }
    }
    Ok(joint)
}

/// The fillets at both beams, below and above a rib whose edges meet the faces across from these arcs.
fn fillets(beams: [&Faces<'_>; 2], ends: [[f64; 2]; 2], radius: f64) -> [[Fillet; 2]; 2] {
    let corner = |beam: usize, edge: usize| beams[beam].inner(ends[beam][edge]);
    [0, 1].map(|beam| {
        [0, 1].map(|edge| {
            let (here, there) = (corner(beam, edge), corner(1 - beam, edge));
            let way = minus(there, here);
            let size = way[0].hypot(way[1]);
            // A face leads away from the rib as it does beside the corner.
            let arc = ends[beam][edge];
            let by = if edge == 0 { -1e-3 } else { 1e-3 };
            let face = minus(beams[beam].inner(arc + by), here);
            let step = face[0].hypot(face[1]);
            Fillet::of(here, face.map(|x| x / step), way.map(|x| x / size), radius)
        })
    })
}
