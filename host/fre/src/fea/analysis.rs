//! An analysis: CalculiX run on a plan, and what it found at each place.

use std::collections::{BTreeMap, HashMap};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use model_core::design::Design;
use model_core::object::{Object as _, Shape};

use super::ccx::{self, Effort, Printed, parse_dat, parse_sta};
use super::deck::{self, deck};
use super::error::FeaError;
use super::frd::parse_frd;
use super::place::BEHIND;
use super::plan::Plan;
use super::region::{self, Point};
use crate::case::Case;

/// Name of the files that CalculiX reads and writes.
const JOB: &str = "finger";
/// Name of the deck, the first file that a run writes into its folder.
pub const DECK: &str = "finger.inp";

/// Forces below this part of E·w·t (a beam stretched to twice its length) are rounding errors: 2e-9 N of `fea-80`.
const NOISE: f64 = 1e-12;

/// How deep the object may reach into the deformed mesh, as a part of the front beam's thickness. The contact's penalty lets it sink in
/// by a hundredth or so; where it reaches deeper, contact was missed.
const MISSED: f64 = 0.1;

/// The result at one place that CalculiX reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Place, in the case's unit (degrees or mm).
    pub place: f64,
    /// Force on the object, finger frame, N.
    pub force: Point,
    /// Front centreline from where it is held to the tip, finger frame, mm.
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

/// How far CalculiX is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Elements of the finger.
    pub elements: usize,
    /// Steps of the path that are done.
    pub done: usize,
    /// All steps.
    pub total: usize,
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
    pub effort: Effort,
    /// CalculiX's time, s.
    pub seconds: f64,
}

impl Plan {
    /// The deck.
    pub fn deck(&self, case: &Case) -> String {
        deck(&case.finger.name, &case.finger.design, self)
    }

    /// Runs CalculiX in a folder, which is made and keeps all its files. `watch` is called before it starts and many times a second;
    /// it stops CalculiX by [`ControlFlow::Break`].
    ///
    /// # Errors
    /// If CalculiX is missing, reached no place, or was stopped.
    pub fn run(
        &self,
        case: &Case,
        folder: &Path,
        mut watch: impl FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Analysis, FeaError> {
        let (elements, total) = (self.mesh.elements.len(), self.path.len());
        let mut watch = |done| watch(Progress { elements, done, total });
        if watch(0).is_break() {
            return Err(FeaError::Stopped);
        }
        ccx::find()?;
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
        let status = ccx::run(folder, JOB, &lock, &mut watch)?;
        let ended = status.to_string();
        let seconds = began.elapsed().as_secs_f64();
        let printed = parse_dat(&std::fs::read_to_string(file("dat")).unwrap_or_default())?;
        let (deformed, unread) = match parse_frd(&std::fs::read_to_string(file("frd")).unwrap_or_default()) {
            Ok(deformed) => (deformed, None),
            Err(error) => (BTreeMap::new(), Some(error)),
        };
        let effort = parse_sta(&std::fs::read_to_string(file("sta")).unwrap_or_default());
        let pose = |(&place, step): (&f64, &usize)| self.pose(place, *step, &printed, deformed.get(step));
        let reached: Vec<Option<Pose>> = case.path.places.iter().zip(&self.stops).map(pose).collect();
        let complaint = ccx::complaint(folder, JOB);
        if reached.iter().all(Option::is_none) {
            return Err(FeaError::NothingReached { folder: folder.display().to_string(), ended, complaint });
        }
        let mut doubts = Vec::new();
        if !status.success() {
            let says = complaint.map(|words| format!("; it says: {words}")).unwrap_or_default();
            doubts.push(format!("CalculiX did not end well ({ended}){says}: only what it reached before is reported"));
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
        Ok(Analysis { poses, unread, doubts, elements, nodes: self.mesh.nodes.len(), effort, seconds })
    }

    /// What CalculiX reports of a place; none if it did not get there.
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

/// What may be wrong with a place that CalculiX reached, so that it has no force.
fn doubt(case: &Case, pose: &Pose) -> Option<String> {
    let at = format!("at {}{}", pose.place, case.path.unit());
    let numbers = pose.force.iter().chain(pose.front.iter().chain(&pose.back).flatten());
    if !numbers.copied().all(f64::is_finite) {
        return Some(format!("{at} CalculiX's result is not a number: no FEA force is reported"));
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
            "{at} the object reaches {depth:.2} mm into the deformed mesh, where only the front beam's outer face and the tip's end have \
             contact: no FEA force is reported"
        ));
    }
    // A small object fits into the windows between the lamellae.
    let gaps = pose.front.iter().map(|&p| object.gap(p.into())).enumerate();
    let (nearest, gap) = gaps.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))?;
    let [before, after] = [pose.front.get(nearest.checked_sub(1)?)?, pose.front.get(nearest + 1)?];
    let along = region::minus(*after, *before);
    let from_behind = (gap.normal.x * along[1] - gap.normal.y * along[0]) / along[0].hypot(along[1]);
    (from_behind > BEHIND)
        .then(|| format!("{at} the object has passed the front beam without touching it: no FEA force is reported"))
}
