//! Three design problems on the preset `fea-80`, from the finger as it is to the best one, and what finite elements say of both ends.
//!
//! The search runs by the reduced model, and the report's numbers are those of the fine one. Where CalculiX is installed, it solves
//! the best design at the places of the goal; its time per place is printed next to the search's.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use fre::case::Document;
use fre::compare::{CompareError, with_elements};
use fre::fea::FeaError;
use fre::optimise::{Log, Problem, Report, Settings, optimise};
use fre::study::choice;
use fre::study::model::Options;

/// A problem in the words of `fre optimise`.
struct Design {
    name: &'static str,
    height_mm: f64,
    goal: &'static str,
    limits: &'static [&'static str],
    vary: &'static [&'static str],
    /// The other objects' numbers.
    also: &'static [&'static [(&'static str, f64)]],
    /// Places where finite elements solve the best design.
    confirmed_deg: &'static [f64],
}

/// What every problem is free in. No hinge is thicker than 0.6 of a beam: the necks of thicker ones stiffen the beam that they grow out of,
/// which the model leaves out.
const DIMENSIONS: [&str; 5] = [
    "finger.front.thickness_mm=1.2:3",
    "finger.back.thickness_mm=1.2:3",
    "finger.hinge.thickness_mm=0.5:0.7",
    "finger.hinge.length_mm=1:2.5",
    "finger.back.base_mm.0=-36:-24",
];

const DESIGNS: [Design; 3] = [
    Design {
        name: "constant force over 4 to 10°",
        height_mm: 60.0,
        goal: "constant-force over 4:10:1",
        limits: &["mean-force over 4:10:1 >= 3", "no-snap before 10"],
        vary: &DIMENSIONS,
        also: &[],
        confirmed_deg: &[4.0, 6.0, 8.0, 10.0],
    },
    Design {
        name: "stiffest below 10 % strain",
        height_mm: 45.0,
        goal: "largest stiffness at 8",
        limits: &["strain up to 8 <= 10%", "no-snap before 8"],
        vary: &DIMENSIONS,
        also: &[],
        confirmed_deg: &[6.0, 8.0],
    },
    Design {
        name: "conform to a cylinder of 40 mm as to one of 80 mm",
        height_mm: 45.0,
        goal: "largest conformity at 10",
        limits: &["no-snap before 10"],
        vary: &DIMENSIONS,
        also: &[&[("object.radius_mm", 20.0), ("object.centre_mm.0", 21.0)]],
        confirmed_deg: &[8.0, 10.0],
    },
];

/// Random starts beside the preset.
const STARTS: usize = 6;

/// Searches all designs; prints each as it comes.
pub fn measure() -> Result<()> {
    for design in &DESIGNS {
        print!("{}", one(design).with_context(|| design.name.to_owned())?);
    }
    Ok(())
}

fn options(words: &str) -> Result<Options> {
    let mut options = Options::default();
    options.discretisation.elements = choice::elements(words).map_err(|error| anyhow!(error))?;
    Ok(options)
}

/// The case of a problem: the preset on a cylinder of 80 mm.
fn document(design: &Design) -> Result<Document> {
    let angles: Vec<String> = design.confirmed_deg.iter().map(f64::to_string).collect();
    let text = format!(
        "finger = \"preset:fea-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, {:?}]\n\
         [motion]\nmotor_angles_deg = [{}]\n",
        design.height_mm,
        angles.join(", ")
    );
    Ok(Document::resolve(design.name, &text, Path::new(""))?)
}

fn problem(design: &Design, words: &str) -> Result<Problem> {
    let read = |error: String| anyhow!(error);
    let vary = design.vary.iter().map(|text| text.parse().map_err(read)).collect::<Result<_>>()?;
    let limits = design.limits.iter().map(|text| text.parse().map_err(read)).collect::<Result<_>>()?;
    let goal = design.goal.parse().map_err(read)?;
    let also: Vec<Vec<(String, f64)>> =
        design.also.iter().map(|one| one.iter().map(|(key, number)| ((*key).to_owned(), *number)).collect()).collect();
    Ok(Problem::new(document(design)?, vary, (goal, limits), &also, options(words)?)?)
}

fn one(design: &Design) -> Result<String> {
    let (coarse, fine) = (problem(design, "reduced")?, problem(design, "fine")?);
    let settings = Settings { starts: STARTS, ..Settings::default() };
    let mut log = Log::open(None, &coarse, &settings)?;
    let begin = Instant::now();
    let tries = optimise(&coarse, &settings, &mut log, |_| ControlFlow::Continue(()))?;
    let seconds = begin.elapsed().as_secs_f64();
    let rate = coarse.solved() as f64 / seconds;
    // From there on, by the fine model.
    let best = fre::optimise::best(&tries).context("no start")?;
    let last = fre::optimise::search(&fine, &best.x, &settings, &mut |_, _| ControlFlow::Continue(()));
    let report = Report::of(&fine, &[last], seconds).context("no start")?;
    let mut text = format!("\n{}\n{}", design.name, report.text());
    let _ = writeln!(text, "search by the reduced model: {} cases, {rate:.0} per second", coarse.solved());
    for object in 0..fine.objects() {
        let mut case = fine.document(&report.x, object).context("the best design")?.case()?;
        case.path.places = design.confirmed_deg.to_vec();
        let folder = tempfile::tempdir()?;
        match with_elements(&case, &Options::default(), 1, folder.path()) {
            Ok(comparison) => {
                let _ = write!(text, "{}", comparison.text(&case));
            }
            Err(CompareError::Fea(FeaError::NoCalculix)) => text += "CalculiX is not installed: not compared\n",
            Err(error) => return Err(anyhow!("{error}")),
        }
    }
    Ok(text)
}
