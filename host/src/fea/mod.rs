//! Finite elements: the same finger as a plane continuum, pressed on the same object by CalculiX (`ccx`).
//!
//! The finger is meshed with its real thicknesses, hinge necks, lamella bars and solid tip, in second-order elements; the
//! object is a rigid surface that moves in the finger frame as the motion tells. A pinned lamella is a stiff link between the
//! centrelines. Frictionless; St. Venant–Kirchhoff material. Forces are those on the object.

mod ccx;
mod deck;
mod frd;
mod mesh;
mod outline;
mod surface;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::time::Instant;

use model_core::design::Design;
use model_core::object::{Motion, Object as _, ObjectDesign, Shape};

pub use ccx::{Printed, Progress, parse_dat, parse_sta};
pub use deck::{HOLD_STEPS, STEP, deck};
pub use frd::parse_frd;
pub use mesh::{Element, Mesh, Part, Side};
pub use outline::{Faces, Joint, Outline, Point};
pub use surface::Surface;

use crate::case::Case;

/// Largest refinement: 256 times the elements.
pub const MAX_REFINEMENT: usize = 16;

/// Name of the files that CalculiX reads and writes.
const JOB: &str = "finger";

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
    /// The object touches the undeformed finger wherever the motion began.
    #[error(
        "the object touches the undeformed finger at every place before the first; a place without contact is needed"
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
    /// The deformed mesh's outline, finger frame, mm: its pieces, a point that is not a number between each two. Empty where CalculiX left
    /// none.
    pub outline: Vec<Point>,
}

impl Pose {
    /// Magnitude of the force, N.
    pub fn magnitude(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// A finished analysis.
#[derive(Debug)]
pub struct Analysis {
    /// One entry per place of the case, none where CalculiX did not get.
    pub poses: Vec<Option<Pose>>,
    /// Why the deformed mesh could not be read; forces and centrelines do not need it.
    pub unread: Option<FeaError>,
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
        let outline = Outline::of(design)?;
        let thickness = design.front.thickness.at(0.0).min(design.back.thickness.at(0.0));
        let mesh = Mesh::finger(&outline, thickness, refinement);
        let begin = start(case, design)?;
        let touching = closest(case, design, begin).1;
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
                path.push(outline::minus(in_finger(case, pivot, at), origin));
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
        // Results of an earlier run must not be taken for this one's.
        for ending in ["dat", "sta", "frd"] {
            let _ = std::fs::remove_file(file(ending));
        }
        let deck = file("inp");
        std::fs::write(&deck, self.deck(case))
            .map_err(|source| FeaError::Io { file: deck.display().to_string(), source })?;
        let began = Instant::now();
        let ended = ccx::run(folder, JOB)?.to_string();
        let seconds = began.elapsed().as_secs_f64();
        let printed = parse_dat(&std::fs::read_to_string(file("dat")).unwrap_or_default())?;
        let (deformed, unread) = match parse_frd(&std::fs::read_to_string(file("frd")).unwrap_or_default()) {
            Ok(deformed) => (deformed, None),
            Err(error) => (BTreeMap::new(), Some(error)),
        };
        let progress = parse_sta(&std::fs::read_to_string(file("sta")).unwrap_or_default());
        let pose = |(&place, step): (&f64, &usize)| self.pose(place, *step, &printed, deformed.get(step));
        let poses: Vec<Option<Pose>> = case.path.places.iter().zip(&self.stops).map(pose).collect();
        if poses.iter().all(Option::is_none) {
            let complaint = ccx::complaint(folder, JOB);
            return Err(FeaError::NothingReached { folder: folder.display().to_string(), ended, complaint });
        }
        let (elements, nodes) = (self.mesh.elements.len(), self.mesh.nodes.len());
        Ok(Analysis { poses, unread, elements, nodes, progress, seconds })
    }

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
        let outline = deformed.map_or_else(Vec::new, |moved| self.outline(moved));
        Some(Pose { place, force, front: line[..count].to_vec(), back: line[count..].to_vec(), outline })
    }

    /// The mesh's outer edges where its nodes (from 1) have moved to; nothing if one of them is missing.
    fn outline(&self, moved: &HashMap<usize, Point>) -> Vec<Point> {
        let edges = self.mesh.outer_edges();
        let place = |node: usize| {
            let [x, y] = self.mesh.nodes[node];
            moved.get(&(node + 1)).map(|[u, v]| [x + u, y + v])
        };
        let pieces: Option<Vec<[Point; 3]>> =
            edges.iter().map(|edge| Some([place(edge[0])?, place(edge[1])?, place(edge[2])?])).collect();
        pieces.unwrap_or_default().into_iter().flat_map(|[a, b, c]| [a, b, c, [f64::NAN; 2]]).collect()
    }
}

/// The object's outline at a place of the motion, finger frame, mm: of a wall the part within `reach` of a point of that frame.
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
    let moved = outline::minus(point, [displacement.translation.x, displacement.translation.y]);
    let p = displacement.vector_back(moved.into());
    [p.x, p.y]
}

/// Distance of the undeformed front beam's outer face to the object, and the object's nearest point, finger frame, mm.
fn closest(case: &Case, design: &Design, place: f64) -> (f64, Point) {
    const SAMPLES: usize = 200;
    let faces = Faces::front(design);
    let by = case.path.motion.world_to_finger(case.path.coordinate(place));
    let object = Shape::<f64>::from(case.object).displaced(&by);
    let gap = |arc: f64| object.gap(faces.outer(arc).into());
    let step = faces.length() / SAMPLES as f64;
    let distances = (0..=SAMPLES).map(|i| (i, gap(step * i as f64).distance));
    let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |found| found.0);
    // Between the neighbours of the nearest sample, by thirds.
    let mut low = step * nearest.saturating_sub(1) as f64;
    let mut high = step * (nearest + 1).min(SAMPLES) as f64;
    for _ in 0..100 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if gap(a).distance < gap(b).distance { high = b } else { low = a }
    }
    let arc = 0.5 * (low + high);
    let (point, gap) = (faces.outer(arc), gap(arc));
    (gap.distance, [point[0] - gap.distance * gap.normal.x, point[1] - gap.distance * gap.normal.y])
}

/// The place where the motion begins: the first place if nothing touches there, else where the undeformed finger, opened
/// from there (or, failing that, closed), just touches.
fn start(case: &Case, design: &Design) -> Result<f64, FeaError> {
    let gap = |place: f64| closest(case, design, place).0;
    let first = case.path.places.first().copied().unwrap_or(0.0);
    // A rounding error of a tangent beginning is not a penetration.
    if gap(first) >= -1e-9 {
        return Ok(first);
    }
    for sign in [-1.0, 1.0] {
        let mut touching = first;
        for i in 1..=1800 {
            let place = first + sign * 0.05 * f64::from(i);
            if gap(place) >= 0.0 {
                let mut free = place;
                for _ in 0..60 {
                    let middle = 0.5 * (free + touching);
                    if gap(middle) >= 0.0 {
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
