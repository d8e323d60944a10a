//! `fre optimise`: numbers of a case searched for a goal within limits.

use std::io::{IsTerminal as _, Write as _};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::ValueEnum;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::exit::{INTERRUPTED, bad_input, tell, trusted};
use crate::options::ModelArgs;
use crate::output::{ForceArgs, put_out, reads_case};
use crate::standard::{self, only_folder};
use fre::draw::{self, Format, Scene, Theme};
use fre::files::{FileError, Folder};
use fre::optimise::{
    self, Front, Goal, Limit, Log, OptimiseError, Problem, ProblemError, Progress, Report, Settings, Variable,
    front_picture, front_text, optimise, page, pictures_of,
};

/// File of the finished starts.
const SEARCH: &str = "search.json";
const REPORT: &str = "report.html";
const DESIGN: &str = "design.toml";
const BEFORE: &str = "before.svg";
const AFTER: &str = "after.svg";
const FRONT: &str = "front.svg";

/// Search numbers of a case for a goal within limits.
///
/// A measure is one of: force at A, mean-force over A:B[:STEP], force-variation over A:B[:STEP] ((max − min)/mean), stiffness at A (N/mm
/// that the object meets along the contact force), contact-length at A, conformity at A (how far the contact force is spread along the
/// front beam, mm), strain up to A (a share), snap up to A (where the finger snaps through), mass [of KG_PER_M3]. A and B are motor
/// angles in degrees, or distances in mm of a parallel gripper; the finger closes from 0.
///
/// The optimiser is SLSQP. It starts from the case as it is and from random designs. Derivatives come from the solver, but those of
/// snap-throughs from differences of solved cases. With several objects (--also) a measure counts by its worst one. With --out, a search
/// that was stopped continues where it was when it is started again with the same arguments.
///
/// Exit status: 0 all limits are kept; 1 bad input; 2 no start keeps all limits.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The case file; - for standard input
    #[arg(value_name = "CASE.toml")]
    case: PathBuf,
    /// What is searched for: [largest|least] MEASURE, or constant-force over A:B
    #[arg(long, value_name = "GOAL")]
    goal: Goal,
    /// A limit (repeatable): MEASURE <= NUMBER, >= NUMBER, or no-snap before A
    ///
    /// NUMBER may be in per cent: 10% is 0.1.
    #[arg(long, value_name = "LIMIT")]
    subject_to: Vec<Limit>,
    /// A number of the case by its dotted key, and its bounds; may be repeated
    #[arg(long, value_name = "KEY=A:B", required = true)]
    vary: Vec<Variable>,
    /// Another object to grasp (repeatable): the numbers in which its case differs
    #[arg(long, value_name = "KEY=X,KEY=Y,…", value_parser = also)]
    also: Vec<Also>,
    /// Searches the front of the goal and this one, too
    #[arg(long, value_name = "GOAL")]
    front: Option<Goal>,
    /// Designs on the front
    #[arg(long, value_name = "N", default_value_t = 8, requires = "front", value_parser = clap::value_parser!(u16).range(2..=200))]
    points: u16,
    /// Starts: the case as it is, and random designs
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    starts: u16,
    /// What the random starts depend on
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Most evaluations of the goal per start
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    most: u32,
    /// Folder for report, design, pictures, and what a stopped search goes on from
    #[arg(long, value_name = "FOLDER", value_parser = only_folder)]
    out: Option<PathBuf>,
    /// Form of the results on standard output
    #[arg(long, value_enum, default_value = "text")]
    format: Form,
    /// Shows progress even if standard error is not a terminal
    #[arg(long)]
    progress: bool,
    #[command(flatten)]
    force: ForceArgs,
    #[command(flatten)]
    model: ModelArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Form {
    /// A table.
    Text,
    /// One object.
    Json,
}

/// The numbers of another object.
type Also = Vec<(String, f64)>;

/// Reads the numbers of another object.
fn also(text: &str) -> Result<Also, String> {
    text.split(',')
        .map(|part| {
            let refused = || format!("\"{part}\": allowed is KEY=NUMBER");
            let (key, value) = part.split_once('=').ok_or_else(refused)?;
            let value = value.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(refused)?;
            Ok((key.trim().to_owned(), value))
        })
        .collect()
}

/// Why there is no result.
enum Failure {
    /// It was stopped.
    Stopped,
    /// Anything else, in words.
    Words(String),
}

impl From<OptimiseError> for Failure {
    fn from(error: OptimiseError) -> Self {
        match error {
            OptimiseError::Stopped => Self::Stopped,
            error => Self::Words(error.to_string()),
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::Words(error.to_string())
    }
}

impl From<String> for Failure {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match work(args) {
        Ok(kept) => trusted(kept),
        Err(Failure::Stopped) => {
            let left = match &args.out {
                Some(_) => "run the same command again to continue",
                None => "with --out a stopped search can be continued",
            };
            tell!("fre: stopped; {left}");
            ExitCode::from(INTERRUPTED)
        }
        Err(Failure::Words(words)) => bad_input(&words),
    }
}

/// The reason why a problem is refused, with the option at fault.
fn refused(args: &Args, error: &ProblemError) -> String {
    match error {
        ProblemError::Object { object, error } => {
            let numbers = object.checked_sub(1).and_then(|index| args.also.get(index)).into_iter().flatten();
            let words: Vec<String> = numbers.map(|(key, number)| format!("{key}={number}")).collect();
            // Its own words are in no line of the file.
            let error = match &**error {
                ProblemError::Case(error) => error.without_place(),
                error => error.to_string(),
            };
            format!("--also {}: {error}", words.join(","))
        }
        ProblemError::Twice { .. } => format!("--vary: {error}"),
        ProblemError::Friction => format!("--vary {error}"),
        ProblemError::Beyond { measure, .. } if *measure == args.goal.measure.to_string() => format!("--goal {error}"),
        ProblemError::Beyond { .. } => format!("--subject-to {error}"),
        error => error.to_string(),
    }
}

fn work(args: &Args) -> Result<bool, Failure> {
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let document = standard::document(&args.case).map_err(|error| words(&error))?;
    let wanted = (args.goal, args.subject_to.clone());
    let problem = Problem::new(document, args.vary.clone(), wanted, &args.also, args.model.options())
        .map_err(|error| refused(args, &error))?;
    args.front.map_or(Ok(()), |second| problem.reaches(second.measure)).map_err(|error| format!("--front {error}"))?;
    let settings =
        Settings { starts: usize::from(args.starts), seed: args.seed, most: args.most as usize, ..Settings::default() };
    let kept = args.out.as_ref().map(|folder| folder.join(SEARCH));
    let mut log = Log::open(kept.as_deref(), &problem, &settings)?;
    // A folder with this search's own file is this search's.
    let continued = kept.is_some_and(|file| file.exists());
    let mut folder = args.out.as_deref().map(|path| folder(args, path, continued)).transpose()?;
    let watch = Watch::new(args)?;
    let begin = Instant::now();
    let tries = optimise(&problem, &settings, &mut log, |progress| watch.tell("", progress))?;
    let front = args.front.map(|second| {
        let points = usize::from(args.points);
        optimise::front(&problem, second, points, &settings, &mut log, |index, progress| {
            watch.tell(&format!("front {}/{points}, ", index + 1), progress)
        })
    });
    let front = front.transpose()?;
    watch.end();
    let report =
        Report::of(&problem, &tries, begin.elapsed().as_secs_f64()).ok_or_else(|| "there is no start".to_owned())?;
    put_out(&result(args, &problem, &report, front.as_ref())?)?;
    if let Some(folder) = &mut folder {
        write(folder, &problem, &report, front.as_ref())?;
        tell!("fre: the report and the design are in {}", folder.path().display());
    }
    Ok(report.kept)
}

/// The folder of the results.
fn folder(args: &Args, path: &Path, continued: bool) -> Result<Folder, FileError> {
    let mut files = if continued { fre::files::Files::new(true) } else { args.force.files() };
    reads_case(&mut files, &args.case)?;
    let mut names = vec![REPORT, DESIGN, BEFORE, AFTER];
    names.extend(args.front.map(|_| FRONT));
    files.folder(path, &names, "--out")
}

/// What goes to standard output.
fn result(args: &Args, problem: &Problem, report: &Report, front: Option<&Front>) -> Result<String, String> {
    match args.format {
        Form::Text => {
            let mut text = report.text();
            if let Some(front) = front {
                text.push('\n');
                text += &front_text(problem, front);
            }
            Ok(text)
        }
        Form::Json => {
            let front = front.map(|front| {
                let numbers = |x: &[f64]| problem.numbers(x);
                let points: Vec<_> = front
                    .points
                    .iter()
                    .map(|point| serde_json::json!({ "goals": point.goals, "variables": numbers(&point.x) }))
                    .collect();
                let goals = front.goals.map(|goal| goal.to_string());
                serde_json::json!({ "goals": goals, "before": front.before, "points": points })
            });
            let all = serde_json::json!({ "report": report, "front": front });
            serde_json::to_string_pretty(&all).map(|text| text + "\n").map_err(|error| error.to_string())
        }
    }
}

/// Writes the files.
fn write(folder: &mut Folder, problem: &Problem, report: &Report, front: Option<&Front>) -> Result<(), Failure> {
    folder.write(REPORT, page(problem, report, front).as_bytes())?;
    if let Some(design) = problem.document(&report.x, 0) {
        folder.write(DESIGN, design.text().as_bytes())?;
    }
    let svg = |scene: &Scene| draw::encode(scene, Format::Svg, Theme::Light).map_err(|error| error.to_string());
    for (name, scene) in [BEFORE, AFTER].into_iter().zip(pictures_of(problem, &report.x, 0)) {
        if let Some(scene) = scene {
            folder.write(name, &svg(&scene)?)?;
        }
    }
    if let Some(front) = front {
        folder.write(FRONT, &svg(&front_picture(problem, front))?)?;
    }
    Ok(())
}

/// Progress on standard error, and whether it goes on.
struct Watch {
    stopped: Arc<AtomicBool>,
    terminal: bool,
    shown: bool,
    told: std::cell::Cell<Instant>,
    unit: &'static str,
}

impl Watch {
    fn new(args: &Args) -> Result<Self, String> {
        let stopped = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, stopped.clone()).map_err(|error| format!("signals: {error}"))?;
        }
        let terminal = std::io::stderr().is_terminal();
        let shown = terminal || args.progress;
        let unit = args.goal.measure.unit();
        Ok(Self { stopped, terminal, shown, told: Instant::now().into(), unit })
    }

    fn tell(&self, what: &str, progress: Progress) -> ControlFlow<()> {
        if self.stopped.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        let Progress { done, starts, evaluations, best } = progress;
        let due = if self.terminal { 0.1 } else { 1.0 };
        if self.shown && (evaluations == 0 || self.told.get().elapsed().as_secs_f64() > due) {
            self.told.set(Instant::now());
            let best = best.map_or_else(|| "–".to_owned(), |best| format!("{best:.5} {}", self.unit));
            let (start, end) = if self.terminal { ("\r", "\u{1b}[K") } else { ("", "\n") };
            let line = format!("{start}{what}{done}/{starts} starts, {evaluations} evaluations, best {best}{end}");
            let _ = std::io::stderr().write_all(line.as_bytes());
            let _ = std::io::stderr().flush();
        }
        ControlFlow::Continue(())
    }

    fn end(&self) {
        if self.shown && self.terminal {
            tell!("");
        }
    }
}
