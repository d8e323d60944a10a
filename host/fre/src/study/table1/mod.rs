//! Table 1 of *Geometrico-Static Modelling of a FRE Finger* (the paper): twenty grasps of the preset `dhas-80`, by the paper's physics and
//! the extended one, at full and at reduced resolution, with the paper's measures between them.
//!
//! The paper prints the motor angles, not the objects' positions nor the finger's dimensions. Here every series has the
//! contact height of its name and an object placed so that first contact is 6° before its first angle.

mod bars;
mod page;
mod table;

use std::path::PathBuf;

use model_core::discretise::{Discretisation, DiscretiseError, Physics, Scheme};
use model_core::object::ObjectDesign;
use model_core::status::Status;

use crate::case::{Case, CaseError, Coordinate, MotionPath, preset};
use crate::delimited::line;
use crate::draw;
use crate::files::{FileError, Folder};
use crate::metrics::{Deviation, deviation, force_error};
use crate::study::csv::{head, records};
use crate::study::model::Options;
use crate::study::place::Place;
use crate::study::run::{self, Run};

/// The finger.
pub const PRESET: &str = "dhas-80";
/// Degrees from first contact to a series' first angle.
pub const APPROACH_DEG: f64 = 6.0;
/// Degrees before first contact at which the path begins.
const CLEARANCE_DEG: f64 = 1.0;
/// Runs of each path; the fastest time counts, the others were held up by something else.
const RUNS: usize = 3;
/// Cases of the table.
pub const CASES: usize = 20;

/// Grasps of one object at one height, at four motor angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// Name of the height in the paper.
    pub height: &'static str,
    /// First contact on the front beam, mm above its base (chosen here).
    pub height_mm: f64,
    /// The cylinder's diameter, mm.
    pub diameter_mm: f64,
    /// Motor angles, degrees (the paper's Table 1).
    pub angles_deg: [f64; 4],
}

const HIGH: (&str, f64) = ("High", 60.0);
const MID: (&str, f64) = ("Mid", 45.0);
const LOW: (&str, f64) = ("Low", 25.0);

const fn series(diameter_mm: f64, (height, height_mm): (&'static str, f64), angles_deg: [f64; 4]) -> Series {
    Series { height, height_mm, diameter_mm, angles_deg }
}

/// The five series.
pub const SERIES: [Series; 5] = [
    series(80.0, HIGH, [11.0, 13.0, 15.0, 17.0]),
    series(80.0, MID, [12.0, 15.0, 17.0, 19.0]),
    series(80.0, LOW, [13.0, 15.0, 17.0, 19.0]),
    series(60.0, HIGH, [18.0, 20.0, 22.0, 24.0]),
    series(60.0, LOW, [22.0, 24.0, 26.0, 28.0]),
];

impl Series {
    /// Name of a case of this series.
    pub fn name(&self, angle: usize) -> String {
        format!("Ø{} {} α{}", self.diameter_mm, self.height, angle + 1)
    }

    /// The case: the path begins 1° before first contact and leads through the four angles.
    ///
    /// # Errors
    /// None with the fingers that come with the program.
    pub fn case(&self) -> Result<Case, CaseError> {
        let missing =
            || CaseError::Unreadable { file: PRESET.to_owned(), reason: "there is no such preset".to_owned() };
        let finger = preset(PRESET).ok_or_else(missing)??;
        let touch_deg = self.angles_deg[0] - APPROACH_DEG;
        let (front, radius) = (&finger.design.front, self.diameter_mm / 2.0);
        let arc = front.arc_at_height(self.height_mm);
        // At first contact the undeformed front face, upright in the finger's frame, is tangent to the cylinder.
        let [x, y] = front.point(arc);
        let [ux, uy] = front.direction(arc);
        let away = radius + front.thickness.at(arc) / 2.0;
        let [mx, my] = finger.design.motor_axis;
        let (from_x, from_y) = (x + uy * away - mx, y - ux * away - my);
        let (sin, cos) = touch_deg.to_radians().sin_cos();
        let centre = [mx + cos * from_x + sin * from_y, my - sin * from_x + cos * from_y];
        let mut places = vec![touch_deg - CLEARANCE_DEG];
        places.extend(self.angles_deg);
        let path = MotionPath::rotating(&finger, places);
        Ok(Case { finger, object: ObjectDesign::Circle { centre, radius }, path })
    }
}

/// A physics at a resolution: one of those compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// Its name in tables.
    pub name: &'static str,
    /// Its discretisation.
    pub discretisation: Discretisation,
}

/// The paper's model as it is written.
pub const PAPER_FULL: usize = 0;
/// The paper's physics at the microcontroller's resolution.
pub const PAPER_REDUCED: usize = 1;
/// The extended physics at the paper's resolution.
pub const EXTENDED_FULL: usize = 2;
/// The extended physics at the microcontroller's resolution.
pub const EXTENDED_REDUCED: usize = 3;

/// The variants, in the order of the indices above.
pub fn variants() -> [Variant; 4] {
    let model = |name, discretisation| Variant { name, discretisation };
    [
        model("paper 170/20", Discretisation::full(Scheme::Paper, Physics::Paper)),
        model("paper reduced", Discretisation::reduced(Physics::Paper)),
        model("extended 170/20", Discretisation::full(Scheme::Trapezoid, Physics::Extended)),
        model("extended reduced", Discretisation::reduced(Physics::Extended)),
    ]
}

/// Which model is measured against which.
pub const COMPARED: [(usize, usize); 3] =
    [(PAPER_REDUCED, PAPER_FULL), (EXTENDED_REDUCED, EXTENDED_FULL), (PAPER_FULL, EXTENDED_FULL)];

/// One model's measures against another's in one case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Comparison {
    /// Both are trustworthy and on the same branch.
    Same {
        /// Of the model's front nodes from the reference's front centreline.
        shape: Deviation,
        /// Of the net force's magnitude, percent of the reference's.
        force_percent: f64,
    },
    /// One of them has snapped through and the other has not.
    OtherBranch,
    /// One of them has no trustworthy solution.
    None,
}

/// A case solved by every variant of the model.
#[derive(Clone, Debug)]
pub struct Row {
    /// The series.
    pub series: Series,
    /// Which of its angles, from 0.
    pub angle: usize,
    /// Object and path.
    pub case: Case,
    /// One per variant, with this place only.
    pub runs: Vec<Run>,
    /// True for a variant that has snapped through at this angle or before.
    pub snapped: Vec<bool>,
}

impl Row {
    /// Name of the case.
    pub fn name(&self) -> String {
        self.series.name(self.angle)
    }

    /// The result of a variant.
    pub fn place(&self, variant: usize) -> Option<&Place> {
        self.runs.get(variant)?.places.first()
    }

    /// Measures of one variant against a reference.
    pub fn compare(&self, model: usize, reference: usize) -> Comparison {
        let (Some(a), Some(b)) = (self.place(model), self.place(reference)) else { return Comparison::None };
        let (Some(force), Some(expected)) = (a.force_magnitude_n(), b.force_magnitude_n()) else {
            return Comparison::None;
        };
        // The finer line is the one to be near to: a coarse one's chords lie beside the beam.
        let Some(shape) = deviation(b.front_mm(), a.front_mm()) else { return Comparison::None };
        let Some(force_percent) = force_error(force, expected).percent else { return Comparison::None };
        if self.snapped.get(model) != self.snapped.get(reference) {
            return Comparison::OtherBranch;
        }
        Comparison::Same { shape, force_percent }
    }
}

/// Why the table cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Table1Error {
    /// The preset.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The preset's discretisation.
    #[error("{PRESET}: {0}")]
    Discretise(#[from] DiscretiseError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The picture cannot be written.
    #[error(transparent)]
    Draw(#[from] draw::DrawError),
}

/// Solves the twenty cases with every model, one after the other so that the times mean something.
///
/// # Errors
/// None with the fingers that come with the program.
pub fn solve() -> Result<Vec<Row>, Table1Error> {
    let mut rows = Vec::with_capacity(CASES);
    for series in SERIES {
        let case = series.case()?;
        let mut runs = Vec::new();
        for variant in variants() {
            let options = Options { discretisation: variant.discretisation, ..Options::default() };
            let mut run = run::solve(&case, &options)?;
            for _ in 1..RUNS {
                for (kept, again) in run.places.iter_mut().zip(run::solve(&case, &options)?.places) {
                    kept.effort.elapsed_us = kept.effort.elapsed_us.min(again.effort.elapsed_us);
                }
            }
            runs.push(run);
        }
        for angle in 0..series.angles_deg.len() {
            let upto = |run: &Run| run.places.iter().take(angle + 2).any(|place| place.status == Status::Snapped);
            rows.push(Row {
                series,
                angle,
                case: case.clone(),
                // The first place of the path is the start without contact.
                runs: runs.iter().filter_map(|run| run.only(angle + 1)).collect(),
                snapped: runs.iter().map(upto).collect(),
            });
        }
    }
    Ok(rows)
}

/// Names of the files that [`write()`] makes.
pub const FILES: [&str; 5] = ["report.html", "table1.md", "table1.csv", "errors.svg", "errors.png"];

/// Writes report, table and data ([`FILES`]) into a folder; gives their paths.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &mut Folder, rows: &[Row]) -> Result<Vec<PathBuf>, Table1Error> {
    let bars = bars::scene(rows);
    let picture = |format| draw::encode(&bars, format, draw::Theme::Light);
    let contents = [
        page::html(rows).into_bytes(),
        markdown(rows).into_bytes(),
        csv(rows).into_bytes(),
        picture(draw::Format::Svg)?,
        picture(draw::Format::Png)?,
    ];
    FILES.iter().zip(contents).map(|(name, bytes)| Ok(folder.write(name, &bytes)?)).collect()
}

/// The tables as Markdown.
pub fn markdown(rows: &[Row]) -> String {
    table::markdown(rows)
}

/// One line per case and variant, with the columns of `fre solve`.
pub fn csv(rows: &[Row]) -> String {
    let own = ["diameter_mm", "height", "height_mm", "angle", "model"].map(str::to_owned);
    let mut out = line(own.into_iter().chain(head(Coordinate::Angle)));
    for row in rows {
        let Series { diameter_mm, height, height_mm, .. } = row.series;
        for (run, variant) in row.runs.iter().zip(variants()) {
            let angle = (row.angle + 1).to_string();
            let own =
                [diameter_mm.to_string(), height.to_owned(), height_mm.to_string(), angle, variant.name.to_owned()];
            for record in records(run) {
                out += &line(own.iter().cloned().chain(record));
            }
        }
    }
    out
}
