//! Finite elements: the same finger as a plane continuum, pressed on the same object by CalculiX (`ccx`).
//!
//! The finger is meshed with its real thicknesses, hinge necks, lamella bars and solid tip, in second-order elements; the
//! object is a rigid surface that moves in the finger frame as the motion tells. Contact is known to the front beam's outer face and
//! the tip's end face; a place at which the object stands in the deformed mesh all the same has no force. A pinned lamella is a
//! stiff link between the centrelines. Frictionless; St. Venant–Kirchhoff material. Forces are those on the object.

mod ccx;
mod deck;
mod frd;
mod mesh;
mod region;
mod surface;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::Instant;

use model_core::design::{Design, PlaneStrain};
use model_core::object::{Motion, Object as _, ObjectDesign, Shape};

pub use ccx::{Printed, Progress, parse_dat, parse_sta};
pub use deck::{HOLD_STEPS, STEP, deck};
pub use frd::parse_frd;
pub use mesh::{Element, Layer, Mesh, Part, Side};
pub use region::{Faces, Joint, Point, Region};
pub use surface::Surface;

use crate::case::Case;

/// Largest refinement: 256 times the elements.
pub const MAX_REFINEMENT: usize = 16;

/// Name of the files that CalculiX reads and writes.
const JOB: &str = "finger";
/// Name of the deck, the first file that a run writes into its folder.
pub const DECK: &str = "finger.inp";

/// Forces below this part of E·w·t (a beam stretched to twice its length) are rounding errors: 2e-9 N of `fea-80`.
const NOISE: f64 = 1e-12;

/// How deep the object may stand in the deformed mesh, as a part of the front beam's thickness. The contact's penalty lets it sink in
/// by a hundredth or so; where it stands deeper, contact was missed.
const MISSED: f64 = 0.1;

/// The object is behind a face if its normal at the nearest point looks out of that face by more than this, as the model has it: 1
/// straight from behind, −1 straight from the front.
const BEHIND: f64 = 0.3;

/// Why there are no finite elements.
#[derive(Debug, thiserror::Error)]
pub enum FeaError {
    /// The program is not installed.
    #[error("CalculiX's `ccx` is not in PATH; `cargo xtask setup --fea` installs it")]
    NoCalculix,
    /// The finger has something that is not meshed.
    #[error("{what} cannot be meshed; allowed is {allowed}")]
    Unsupported {
        /// What it is, as a case file has it.
        what: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A part has no room.
    #[error("lamella {}: {what} is {value:.3} mm; more than 0.001 mm is needed", .lamella + 1)]
    NoRoom {
        /// Index of the lamella, from 0 at the base.
        lamella: usize,
        /// Which length.
        what: &'static str,
        /// The length, mm.
        value: f64,
    },
    /// The refinement is out of range.
    #[error("--mesh is {value}; allowed is 1 to {MAX_REFINEMENT}")]
    Refinement {
        /// What was asked for.
        value: usize,
    },
    /// The object touches the undeformed finger, or lies behind it, wherever the motion began.
    #[error(
        "the object touches the undeformed finger or lies behind its front beam at every place before the first; a place at \
         which it lies clear in front is needed"
    )]
    NoStart,
    /// A file could not be read or written.
    #[error("{file}: {source}")]
    Io {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// CalculiX wrote something unexpected.
    #[error("CalculiX's .{file}, line {line}: unexpected \"{text}\"")]
    Output {
        /// Ending of the file.
        file: &'static str,
        /// Line, from 1.
        line: usize,
        /// The line.
        text: String,
    },
    /// Another run works in the folder.
    #[error(
        "{folder}: another `fre compare --fea` works here, or a CalculiX (`ccx`) that outlived its own; wait for it, end it, or \
         name another folder (--folder)"
    )]
    Busy {
        /// The folder.
        folder: String,
    },
    /// CalculiX reached no place at all.
    #[error("CalculiX reached no place ({ended}); its files are in {folder}{}", .complaint.as_ref().map(|words| format!("; it says: {words}")).unwrap_or_default())]
    NothingReached {
        /// Where its files are.
        folder: String,
        /// How the program ended.
        ended: String,
        /// Its first error message.
        complaint: Option<String>,
    },
}

/// The result at one place that CalculiX reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Place, in the case's unit (degrees or mm).
    pub place: f64,
    /// Force on the object, finger frame, N.
    pub force: Point,
    /// Front centreline, base to tip, finger frame, mm.
    pub front: Vec<Point>,
    /// Back centreline up to the solid tip, finger frame, mm.
    pub back: Vec<Point>,
    /// The deformed mesh's edge, finger frame, mm: its pieces, a point that is not a number between each two. Empty where CalculiX left
    /// none.
    pub mesh_edge: Vec<Point>,
}

impl Pose {
    /// Magnitude of the force, N.
    pub fn magnitude(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }

    /// With no force where there are only the rounding errors of CalculiX's sums.
    fn without_noise(mut self, design: &Design) -> Self {
        let tension = design.material.youngs_modulus * design.width.at(0.0) * design.front.thickness.at(0.0);
        if self.magnitude() < NOISE * tension {
            self.force = [0.0; 2];
        }
        self
    }
}

/// A finished analysis.
#[derive(Debug)]
pub struct Analysis {
    /// One entry per place of the case, none where CalculiX did not get.
    pub poses: Vec<Option<Pose>>,
    /// Why the deformed mesh could not be read; forces and centrelines do not need it.
    pub unread: Option<FeaError>,
    /// What was wrong with the run or with one of its places, for the reader.
    pub doubts: Vec<String>,
    /// Elements of the finger.
    pub elements: usize,
    /// Nodes of the finger.
    pub nodes: usize,
    /// Increments and iterations.
    pub progress: Progress,
    /// CalculiX's time, s.
    pub seconds: f64,
}

/// A mesh and a path, ready to be written. Times are CalculiX's: one unit per increment.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The mesh.
    pub mesh: Mesh,
    /// The object's surface at the beginning, finger frame.
    pub surface: Surface,
    /// Displacement of the object's pivot at the times 1, 2, …, mm, finger frame.
    pub path: Vec<Point>,
    /// Turn of the object about its pivot since the beginning at those times, rad, counter-clockwise, finger frame; 0 for a
    /// round one.
    pub turns: Vec<f64>,
    /// The object's pivot at the beginning, finger frame, mm: the centre of a round one.
    pub pivot: Point,
    /// Time at which each place has been reached and held.
    pub stops: Vec<usize>,
}

impl Plan {
    /// Meshes a case's finger and divides its motion into steps.
    ///
    /// # Errors
    /// If the finger cannot be meshed, or the motion has no beginning without contact.
    pub fn of(case: &Case, refinement: usize) -> Result<Self, FeaError> {
        if !(1..=MAX_REFINEMENT).contains(&refinement) {
            return Err(FeaError::Refinement { value: refinement });
        }
        let design = &case.finger.design;
        let region = Region::of(design)?;
        let thickness = design.front.thickness.at(0.0).min(design.back.thickness.at(0.0));
        let layered = design.plane_strain == PlaneStrain::Auto;
        let mesh = Mesh::finger(&region, thickness, layered, refinement);
        let begin = start(case, &region)?;
        let touching = closest(case, &region, begin).object;
        let reach = 1.25 * design.front.length();
        let round = match case.object {
            ObjectDesign::Circle { centre, .. } => Some(centre),
            _ => None,
        };
        let middle = world_point(case, touching, begin);
        let surface = Surface::whole(&case.object, middle, reach, refinement)
            .near(middle, reach)
            .displaced(&case.path.motion.world_to_finger(case.path.coordinate(begin)));

        let pivot = round.unwrap_or(middle);
        let origin = in_finger(case, pivot, begin);
        let turn = |place: f64| match (case.path.motion, round) {
            (Motion::Rotating { .. }, None) => case.path.coordinate(place) - case.path.coordinate(begin),
            _ => 0.0,
        };
        let (mut path, mut turns, mut stops) = (Vec::new(), Vec::new(), Vec::new());
        let mut from = begin;
        for &place in &case.path.places {
            let moves = ((place - from).abs() / STEP - 1e-9).ceil().max(1.0) as usize;
            let moving = (1..=moves).map(|i| from + (place - from) * i as f64 / moves as f64);
            for at in moving.chain([place; HOLD_STEPS]) {
                path.push(region::minus(in_finger(case, pivot, at), origin));
                turns.push(turn(at));
            }
            stops.push(path.len());
            from = place;
        }
        Ok(Self { mesh, surface, path, turns, pivot: origin, stops })
    }

    /// The deck.
    pub fn deck(&self, case: &Case) -> String {
        deck(&case.finger.name, &case.finger.design, self)
    }

    /// Runs CalculiX in a folder, which is made and keeps all its files.
    ///
    /// # Errors
    /// If CalculiX is missing, or reached no place.
    pub fn run(&self, case: &Case, folder: &Path) -> Result<Analysis, FeaError> {
        std::fs::create_dir_all(folder)
            .map_err(|source| FeaError::Io { file: folder.display().to_string(), source })?;
        let file = |ending: &str| -> PathBuf { folder.join(format!("{JOB}.{ending}")) };
        // Held until the results are read.
        let lock = ccx::lock(folder, JOB)?;
        // Results of an earlier run must not be taken for this one's.
        for ending in ["dat", "sta", "frd"] {
            let _ = std::fs::remove_file(file(ending));
        }
        let deck = folder.join(DECK);
        std::fs::write(&deck, self.deck(case))
            .map_err(|source| FeaError::Io { file: deck.display().to_string(), source })?;
        let began = Instant::now();
        let status = ccx::run(folder, JOB, &lock)?;
        let ended = status.to_string();
        let seconds = began.elapsed().as_secs_f64();
        let printed = parse_dat(&std::fs::read_to_string(file("dat")).unwrap_or_default())?;
        let (deformed, unread) = match parse_frd(&std::fs::read_to_string(file("frd")).unwrap_or_default()) {
            Ok(deformed) => (deformed, None),
            Err(error) => (BTreeMap::new(), Some(error)),
        };
        let progress = parse_sta(&std::fs::read_to_string(file("sta")).unwrap_or_default());
        let pose = |(&place, step): (&f64, &usize)| self.pose(place, *step, &printed, deformed.get(step));
        let reached: Vec<Option<Pose>> = case.path.places.iter().zip(&self.stops).map(pose).collect();
        let complaint = ccx::complaint(folder, JOB);
        if reached.iter().all(Option::is_none) {
            return Err(FeaError::NothingReached { folder: folder.display().to_string(), ended, complaint });
        }
        let mut doubts = Vec::new();
        if !status.success() {
            let says = complaint.map(|words| format!("; it says: {words}")).unwrap_or_default();
            doubts.push(format!("CalculiX did not end well ({ended}){says}: only what it reached before is told"));
        }
        let poses = reached
            .into_iter()
            .map(|pose| {
                let pose = pose?;
                let doubt = doubt(case, &pose);
                let sound = doubt.is_none();
                doubts.extend(doubt);
                sound.then(|| pose.without_noise(&case.finger.design))
            })
            .collect();
        let (elements, nodes) = (self.mesh.elements.len(), self.mesh.nodes.len());
        Ok(Analysis { poses, unread, doubts, elements, nodes, progress, seconds })
    }

    /// What CalculiX tells of a place; none if it did not get there.
    fn pose(
        &self,
        place: f64,
        step: usize,
        printed: &Printed,
        deformed: Option<&HashMap<usize, Point>>,
    ) -> Option<Pose> {
        let (moved, reaction) = (printed.displacements.get(&step)?, printed.forces.get(&step)?);
        let count = self.mesh.front_line.len();
        if moved.len() != count + self.mesh.back_line.len() {
            return None;
        }
        let line: Vec<Point> = deck::lines(&self.mesh)
            .zip(moved)
            .map(|(node, u)| [self.mesh.nodes[node][0] + u[0], self.mesh.nodes[node][1] + u[1]])
            .collect();
        // The reaction holds the object against the finger. Adding zero turns −0 into 0.
        let force = reaction.map(|component| 0.0 - component);
        let mesh_edge = deformed.map_or_else(Vec::new, |moved| self.edge(moved));
        Some(Pose { place, force, front: line[..count].to_vec(), back: line[count..].to_vec(), mesh_edge })
    }

    /// The mesh's outer edges where its nodes (from 1) have moved to; nothing if one of them is missing or no number.
    fn edge(&self, moved: &HashMap<usize, Point>) -> Vec<Point> {
        let edges = self.mesh.outer_edges();
        let place = |node: usize| {
            let [x, y] = self.mesh.nodes[node];
            let at = moved.get(&(node + 1)).map(|[u, v]| [x + u, y + v]);
            at.filter(|at| at.iter().all(|x| x.is_finite()))
        };
        let pieces: Option<Vec<[Point; 3]>> =
            edges.iter().map(|edge| Some([place(edge[0])?, place(edge[1])?, place(edge[2])?])).collect();
        pieces.unwrap_or_default().into_iter().flat_map(|[a, b, c]| [a, b, c, [f64::NAN; 2]]).collect()
    }
}

/// The object's contour at a place of the motion, finger frame, mm: of a wall the part within `reach` of a point of that frame.
pub fn object_line(case: &Case, place: f64, middle: Point, reach: f64) -> Vec<Point> {
    Surface::whole(&case.object, world_point(case, middle, place), reach, 1)
        .displaced(&case.path.motion.world_to_finger(case.path.coordinate(place)))
        .line()
        .collect()
}

/// A world point in the finger frame at a place of the motion (degrees or mm), mm.
pub fn in_finger(case: &Case, point: Point, place: f64) -> Point {
    let p = case.path.motion.world_to_finger(case.path.coordinate(place)).point(point.into());
    [p.x, p.y]
}

/// A point of the finger frame in the world, mm.
fn world_point(case: &Case, point: Point, place: f64) -> Point {
    let displacement = case.path.motion.world_to_finger::<f64>(case.path.coordinate(place));
    let moved = region::minus(point, [displacement.translation.x, displacement.translation.y]);
    let p = displacement.vector_back(moved.into());
    [p.x, p.y]
}

/// What may be wrong with a place that CalculiX reached, so that it has no force.
fn doubt(case: &Case, pose: &Pose) -> Option<String> {
    let at = format!("at {}{}", pose.place, case.path.unit());
    let numbers = pose.force.iter().chain(pose.front.iter().chain(&pose.back).flatten());
    if !numbers.copied().all(f64::is_finite) {
        return Some(format!("{at} CalculiX's result is not a number: no FEA force is told"));
    }
    let design = &case.finger.design;
    let object =
        Shape::<f64>::from(case.object).displaced(&case.path.motion.world_to_finger(case.path.coordinate(pose.place)));
    let thickness = design.front.thickness.at(0.0);
    // Without a deformed mesh the front centreline must do, which lies half a thickness below the face.
    let depth = if pose.mesh_edge.is_empty() {
        let arcs = (0..pose.front.len()).map(|i| design.front.length() * i as f64 / pose.front.len() as f64);
        let below = pose.front.iter().zip(arcs);
        let depths = below.map(|(&p, arc)| 0.5 * design.front.thickness.at(arc) - object.gap(p.into()).distance);
        depths.fold(f64::NEG_INFINITY, f64::max)
    } else {
        let points = pose.mesh_edge.iter().filter(|p| p[0].is_finite());
        points.map(|&p| -object.gap(p.into()).distance).fold(f64::NEG_INFINITY, f64::max)
    };
    if depth > MISSED * thickness {
        return Some(format!(
            "{at} the object stands {depth:.2} mm in the deformed mesh, whose front beam's outer face and tip's end face alone know \
             contact: no FEA force is told"
        ));
    }
    // A small object fits into the windows between the lamellae.
    let gaps = pose.front.iter().map(|&p| object.gap(p.into())).enumerate();
    let (nearest, gap) = gaps.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))?;
    let [before, after] = [pose.front.get(nearest.checked_sub(1)?)?, pose.front.get(nearest + 1)?];
    let along = region::minus(*after, *before);
    let from_behind = (gap.normal.x * along[1] - gap.normal.y * along[0]) / along[0].hypot(along[1]);
    (from_behind > BEHIND)
        .then(|| format!("{at} the object has passed the front beam without touching it: no FEA force is told"))
}

/// The undeformed finger and the object at a place.
#[derive(Clone, Copy, Debug)]
struct Closest {
    /// Distance of the object to the faces that may touch, mm; negative inside of it.
    distance: f64,
    /// The object's nearest point, finger frame, mm.
    object: Point,
    /// How far the object's normal there looks out of the front face; see [`BEHIND`].
    from_behind: f64,
}

impl Closest {
    /// The object neither touches the finger nor has passed it. A rounding error of a tangent beginning is not a penetration.
    fn is_clear(&self) -> bool {
        self.distance >= -1e-9 && self.from_behind <= BEHIND
    }
}

/// Where the object is nearest to the faces of the undeformed finger that may touch: the front beam's outer face and the tip's end
/// face.
fn closest(case: &Case, region: &Region<'_>, place: f64) -> Closest {
    const SAMPLES: usize = 200;
    let by = case.path.motion.world_to_finger(case.path.coordinate(place));
    let object = Shape::<f64>::from(case.object).displaced(&by);
    let (faces, [corner, _, last]) = (region.front, region.top);
    let (length, across) = (faces.length(), region::minus(last, corner));
    let end = across[0].hypot(across[1]);
    // Along the outer face, then on across the end face.
    let point = |arc: f64| match arc - length {
        on if on > 0.0 => [0, 1].map(|axis| corner[axis] + on / end * across[axis]),
        _ => faces.outer(arc),
    };
    let gap = |arc: f64| object.gap(point(arc).into());
    let step = (length + end) / SAMPLES as f64;
    // The corner between the faces is often the nearest and lies between two samples.
    let arcs = (0..=SAMPLES).map(|i| step * i as f64).chain([length]);
    let distances = arcs.map(|arc| (arc, gap(arc).distance));
    let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |found| found.0);
    // To the neighbours of the nearest sample, by thirds.
    let (mut low, mut high) = ((nearest - step).max(0.0), (nearest + step).min(length + end));
    for _ in 0..100 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if gap(a).distance < gap(b).distance { high = b } else { low = a }
    }
    let arc = [0.5 * (low + high), nearest].into_iter().min_by(|&a, &b| gap(a).distance.total_cmp(&gap(b).distance));
    let arc = arc.unwrap_or(nearest);
    let (point, gap) = (point(arc), gap(arc));
    let inward = faces.inward(0.0);
    Closest {
        distance: gap.distance,
        object: [point[0] - gap.distance * gap.normal.x, point[1] - gap.distance * gap.normal.y],
        from_behind: -(gap.normal.x * inward[0] + gap.normal.y * inward[1]),
    }
}

/// The place where the motion begins: the first place if the object lies clear in front of the undeformed finger there, else where
/// it just touches the finger that is opened from there (or, failing that, closed). A finger that has passed the object, be it as
/// small as a window between lamellae, is opened past it again: as in the model, contact comes from the front.
fn start(case: &Case, region: &Region<'_>) -> Result<f64, FeaError> {
    let is_clear = |place: f64| closest(case, region, place).is_clear();
    let first = case.path.places.first().copied().unwrap_or(0.0);
    if is_clear(first) {
        return Ok(first);
    }
    for sign in [-1.0, 1.0] {
        let mut touching = first;
        for i in 1..=1800 {
            let place = first + sign * 0.05 * f64::from(i);
            if is_clear(place) {
                let mut free = place;
                for _ in 0..60 {
                    let middle = 0.5 * (free + touching);
                    if is_clear(middle) {
                        free = middle;
                    } else {
                        touching = middle;
                    }
                }
                return Ok(free);
            }
            touching = place;
        }
    }
    Err(FeaError::NoStart)
}
