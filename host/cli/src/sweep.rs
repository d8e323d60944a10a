//! `fre sweep`: a case over ranges of angles and a grid of its numbers.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use model_core::discretise::Elements;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::exit::{INTERRUPTED, UNTRUSTWORTHY, bad_input, tell};
use crate::options::ModelArgs;
use crate::output::{ForceArgs, reads_case};
use crate::progress::ProgressLine;
use crate::standard::{self, Target, is_standard, only_file};
use fre::case::MAX_ANGLE;
use fre::files::{Files, Output};
use fre::study::choice;
use fre::study::remedy::Remedy;
use fre::study::sweep::{self, Axis, LISTED, Ledger, Merge, Progress, Shard, Sweep, SweepError, Tally, Tuned};
use fre::study::warnings;

/// Most threads that --jobs may ask for.
const MOST_JOBS: i64 = 1024;

/// Solve a case over ranges of angles and a grid of any of its numbers, in parallel, as CSV.
///
/// The CSV has one row per grid point and angle, each with its status. Every grid point starts without contact and is followed
/// through all angles. If several resolutions are given, a table of error against time is printed on standard error at the
/// end (use --jobs 1 for times that nothing else disturbs). With --out, a sweep that was stopped or killed continues where it
/// was when it is started again with the same arguments; FILE.sweep next to the file says which sweep it is. Several machines
/// solve a shard each (--shard), and `fre sweep merge` makes one file of them.
///
/// Exit status: 0 all rows converged; 1 bad input; 2 some row has no trustworthy solution.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Args {
    #[command(subcommand)]
    action: Option<Action>,
    /// The case file; - for standard input
    #[arg(value_name = "CASE.toml", required = true)]
    case: Option<PathBuf>,
    /// Motor angles, degrees, instead of the case's own
    ///
    /// Ranges and numbers, separated by commas: 0:12:1,12:0:-1 closes and opens.
    #[arg(long, value_name = "A:B:STEP", allow_hyphen_values = true, value_parser = Angles::parse)]
    angles: Option<Angles>,
    /// A number of the case by its dotted key, with its values
    ///
    /// object.radius_mm, object.centre_mm.1, finger.front.thickness_mm, …, or elements=24/3,48/4,170/20. Repeated, the grid is
    /// the product.
    #[arg(long, value_name = "KEY=A:B:STEP|KEY=v1,v2,…")]
    vary: Vec<String>,
    /// The CSV file, in which a stopped sweep continues [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Solves a part of the points only: the I-th of N
    ///
    /// The parts cost alike. `fre sweep merge` makes one file of theirs.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Adds the points of both centrelines to every row
    ///
    /// They are lists separated by blanks, in the finger frame.
    #[arg(long)]
    shapes: bool,
    /// Writes the complete sweep as Parquet, too
    ///
    /// An older file of this name is replaced. Needs a build with `--features parquet`.
    #[arg(long, value_name = "FILE", requires = "out", value_parser = only_file)]
    parquet: Option<PathBuf>,
    /// Threads, 0 for one per core
    #[arg(short, long, value_name = "N", default_value_t = 0, env = "FRE_JOBS", hide_env_values = true, value_parser = clap::value_parser!(u16).range(0..=MOST_JOBS))]
    jobs: u16,
    /// Shows progress even if standard error is not a terminal
    #[arg(long)]
    progress: bool,
    #[command(flatten)]
    model: ModelArgs,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Make one file of all shards of a sweep
    ///
    /// The file is that of the whole sweep on one machine, but for the times. The shards' own files stay. The rows' statuses are counted, and
    /// failures listed, as at the end of a sweep.
    ///
    /// Exit status: 0 all rows converged; 1 bad input; 2 some row has no trustworthy solution.
    Merge {
        /// The shards' files, in any order, each with its .sweep file beside it
        #[arg(value_name = "SHARD.csv", required = true)]
        shards: Vec<PathBuf>,
        /// The merged file; - for standard output
        #[arg(short, long, value_name = "FILE")]
        out: PathBuf,
        /// Writes the merged sweep as Parquet, too
        ///
        /// Needs a build with `--features parquet`.
        #[arg(long, value_name = "FILE", value_parser = only_file)]
        parquet: Option<PathBuf>,
        #[command(flatten)]
        force: ForceArgs,
    },
}

impl Args {
    /// The file of the rows, if there is one.
    fn rows(&self) -> Option<&Path> {
        self.out.as_deref().filter(|path| !is_standard(path))
    }
}

/// Motor angles of an option.
#[derive(Clone, Debug)]
struct Angles(Vec<f64>);

impl Angles {
    fn parse(text: &str) -> Result<Self, String> {
        let angles = sweep::numbers(text)?;
        match angles.iter().find(|angle| angle.abs() > MAX_ANGLE) {
            Some(angle) => Err(format!("{angle} degrees; allowed is {} to {MAX_ANGLE}", -MAX_ANGLE)),
            None => Ok(Self(angles)),
        }
    }
}

/// Reads a resolution by the words of --elements.
fn elements(word: &str) -> Result<Elements, String> {
    choice::elements(word)
        .map_err(|_| format!("\"{word}\" is not a resolution; allowed is B/H (1 to 2000 each), paper, reduced or fine"))
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let done = match &args.action {
        Some(Action::Merge { shards, out, parquet, force }) => merge(shards, out, parquet.as_deref(), *force),
        None => work(args),
    };
    match done {
        Ok(tally) if tally.failures.is_empty() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(UNTRUSTWORTHY),
        // A reader that stops early (`fre … | head`) is no failure.
        Err(SweepError::File { source, .. }) if source.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        // That it was stopped has been said.
        Err(SweepError::Stopped) => ExitCode::from(INTERRUPTED),
        Err(error) => bad_input(&error),
    }
}

/// What the file is called that says of which sweep another one is.
const BESIDE: &str = "the file beside --out";

/// Makes one file of shards, and says what came of them.
fn merge(shards: &[PathBuf], out: &Path, parquet: Option<&Path>, force: ForceArgs) -> Result<Tally, SweepError> {
    let mut files = force.files();
    for shard in shards {
        files.input(shard, "a shard")?;
        files.input(&Ledger::beside(shard), "the file beside a shard")?;
    }
    let rows = Target::of(&mut files, out, "--out")?;
    if !is_standard(out) {
        drop(files.output(&Ledger::beside(out), BESIDE)?);
    }
    let parquet = parquet_of(&mut files, parquet, Some(out).filter(|path| !is_standard(path)))?;
    let merge = Merge::of(shards)?;
    if is_standard(out) {
        // What has been printed cannot be taken back: a shard that is not complete is found before the first row.
        merge.write(&mut std::io::sink())?;
    }
    let mut draft = rows.draft()?;
    let merged = merge.write(&mut draft)?;
    draft.finish()?;
    let place = if is_standard(out) { String::new() } else { format!(" are in {}", out.display()) };
    if !is_standard(out) {
        merge.name(out)?;
    }
    if let Some(parquet) = parquet {
        write_parquet(out, parquet)?;
    }
    let rows = merged.rows;
    tell!("fre: {rows} rows of {} shards{place}: {}", shards.len(), counts(&merged.tally));
    list(&merged.tally, rows, |row| merged.place(row).to_owned());
    Ok(merged.tally)
}

/// The Parquet file, if one is asked for. It is made of the file of the rows.
fn parquet_of(files: &mut Files, path: Option<&Path>, rows: Option<&Path>) -> Result<Option<Output>, SweepError> {
    let Some(path) = path else { return Ok(None) };
    if rows.is_none() {
        let reason = "is made of the file that --out names, which is needed; - is standard output".to_owned();
        return Err(SweepError::Part { file: format!("--parquet {}", path.display()), reason });
    }
    if cfg!(not(feature = "parquet")) {
        let reason = "--parquet: this `fre` was built without Parquet; build it with: cargo run --release -p fre-cli --features \
                      parquet --bin fre -- …";
        return Err(SweepError::Part { file: path.display().to_string(), reason: reason.to_owned() });
    }
    Ok(Some(files.output(path, "--parquet")?))
}

/// Writes the file of a complete sweep as Parquet.
#[cfg(feature = "parquet")]
fn write_parquet(rows: &Path, output: Output) -> Result<(), SweepError> {
    Ok(sweep::write_parquet(rows, output.draft()?)?.finish()?)
}

/// Never called: the option is refused before.
#[cfg(not(feature = "parquet"))]
fn write_parquet(_: &Path, output: Output) -> Result<(), SweepError> {
    drop(output);
    Ok(())
}

fn work(args: &Args) -> Result<Tally, SweepError> {
    // Without a case there is another command, which clap sees to.
    let path = args.case.as_deref().unwrap_or(Path::new(""));
    let document = standard::document(path)?;
    let case = document.case()?;
    let axes = args.vary.iter().map(|text| Axis::parse(text, elements)).collect::<Result<Vec<_>, _>>()?;
    let angles = args.angles.as_ref().map(|angles| angles.0.as_slice());
    let options = args.model.options();
    let sweep = Sweep::new(document, angles, axes, options)?.only(args.shard).with_shapes(args.shapes);
    // The Parquet file is made of the rows: it is replaced whenever they are complete.
    let mut files = Files::new(true);
    reads_case(&mut files, path)?;
    let path_of_rows = args.rows();
    if let Some(out) = path_of_rows {
        // Continued, never overwritten: another sweep's file, or any other, is refused.
        files.continued(out, "--out")?;
        files.continued(&Ledger::beside(out), BESIDE)?;
    }
    let parquet = parquet_of(&mut files, args.parquet.as_deref(), path_of_rows)?;
    let mut ledger = path_of_rows.map(|path| Ledger::open(path, &sweep)).transpose()?;
    if let Some(ledger) = ledger.as_ref().filter(|ledger| ledger.found() > 0) {
        tell!("fre: {} of {} rows are known already", ledger.found(), sweep.own_rows());
    }
    let stopped = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, stopped.clone())
            .map_err(|source| SweepError::File { file: "signals".to_owned(), source })?;
    }
    let mut line = ProgressLine::new(args.progress);
    let watch = |progress: Progress| {
        if stopped.load(Ordering::Relaxed) {
            line.keep();
            tell!("fre: stopped; {}", left_words(args, progress));
            return ControlFlow::Break(());
        }
        line.show(progress.done == progress.total, || progress_words(progress));
        ControlFlow::Continue(())
    };
    let stdout = std::io::BufWriter::new(std::io::stdout().lock());
    let mut out = Kept { out: stdout, keep: sweep.has_resolutions(), text: Vec::new() };
    let tally = sweep::run(&sweep, ledger.as_mut(), &mut out, usize::from(args.jobs), watch);
    line.keep();
    let tally = tally?;
    if let (Some(rows), Some(parquet)) = (path_of_rows, parquet) {
        write_parquet(rows, parquet)?;
    }
    summarise(&sweep, &tally);
    let mut helps = Vec::new();
    for &(row, status) in &tally.failures {
        if let Some(remedy) = Remedy::of(&case, &options, status).filter(|remedy| !helps.contains(remedy)) {
            tell!("fre: warning: row {row}: {status}: {remedy}");
            helps.push(remedy);
        }
    }
    for warning in warnings::warnings(&case, &options, &[]) {
        tell!("fre: warning: {warning}");
    }
    if sweep.has_resolutions() {
        let text = match path_of_rows {
            Some(file) => std::fs::read_to_string(file)
                .map_err(|source| SweepError::File { file: file.display().to_string(), source })?,
            None => String::from_utf8_lossy(&out.text).into_owned(),
        };
        if let Some(found) = sweep::study(&sweep, &text) {
            tell!("{}", study_words(&found).trim_end());
        }
    }
    Ok(tally)
}

/// A stream whose text is kept as well if it is wanted at the end.
struct Kept<W> {
    out: W,
    keep: bool,
    text: Vec<u8>,
}

impl<W: std::io::Write> std::io::Write for Kept<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.out.write(bytes)?;
        if self.keep {
            self.text.extend(bytes.iter().take(written));
        }
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Error against time, one line per resolution.
fn study_words(found: &[Tuned]) -> String {
    let mut text = "fre: error of the force against the resolution with the most unknowns, and time\n".to_owned();
    text += "     elements  unknowns  time ms  mean error %  max error %  rows compared\n";
    for Tuned { elements, unknowns, time_ms, compared, error_percent } in found {
        let [mean, most] = error_percent.map_or(["–".to_owned(), "–".to_owned()], |e| e.map(|e| format!("{e:.4}")));
        text += &format!("     {elements:>8}  {unknowns:>8}  {time_ms:>7.3}  {mean:>12}  {most:>11}  {compared:>13}\n");
    }
    text
}

/// What a sweep that was stopped leaves behind.
fn left_words(args: &Args, progress: Progress) -> String {
    let Progress { done, total, .. } = progress;
    match args.rows() {
        Some(file) => {
            format!("{done} of {total} rows are in {}; run the same command again to continue", file.display())
        }
        None => format!("{done} of {total} rows were computed; with --out a stopped sweep can be continued"),
    }
}

fn progress_words(progress: Progress) -> String {
    let Progress { checked, done, total, rate, left_s } = progress;
    if let Some([checked, points]) = checked {
        return format!("checking the grid: {checked}/{points} points");
    }
    let share = 100.0 * done as f64 / total.max(1) as f64;
    let filled = 24 * done / total.max(1);
    let bar: String = (0..24).map(|i| if i < filled { '█' } else { '·' }).collect();
    let left = left_s.map_or_else(|| "–".to_owned(), duration);
    format!("{bar} {share:3.0} %  {done}/{total} rows  {rate:.0} rows/s  {left} left")
}

fn duration(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, m, s) => format!("{m} min {s:02} s"),
        (h, m, _) => format!("{h} h {m:02} min"),
    }
}

/// A row's point and place for people: "object.radius_mm=20 at 8°".
fn place_words(sweep: &Sweep, row: usize) -> String {
    let count = sweep.places().len().max(1);
    let place = sweep.places().get(row % count).copied().unwrap_or_default();
    let point = sweep.describe(row / count);
    format!("{point}{}{place}{}", if point.is_empty() { "" } else { " at " }, sweep.unit())
}

/// Prints the outcome on standard error, with the first failures.
fn summarise(sweep: &Sweep, tally: &Tally) {
    let earlier = if tally.resumed > 0 { format!(", {} from before", tally.resumed) } else { String::new() };
    tell!("fre: {} rows ({} computed{earlier}): {}", sweep.own_rows(), tally.computed, counts(tally));
    list(tally, sweep.own_rows(), |row| place_words(sweep, row));
}

/// How many rows have which status.
fn counts(tally: &Tally) -> String {
    tally.statuses.iter().map(|(word, count)| format!("{count} {word}")).collect::<Vec<_>>().join(", ")
}

/// Lists the first failures, and the first row of each warning.
fn list(tally: &Tally, all: usize, place: impl Fn(usize) -> String) {
    for &(row, status) in tally.failures.iter().take(LISTED) {
        tell!("fre: row {row}: {status}: {}", place(row));
    }
    if tally.failures.len() > LISTED {
        tell!("fre: and {} more; see the status in their rows", tally.failures.len() - LISTED);
    }
    for (rows, what) in [
        (
            &tally.strained,
            "are strained beyond finger.material.max_strain, or beyond 30 % without it (true in column beyond_max_strain)",
        ),
        (
            &tally.overlapping,
            "have the object inside a part of the finger that the model lets it pass through (column overlap_mm)",
        ),
    ] {
        if let Some(&first) = rows.first() {
            tell!("fre: warning: {} of {all} rows {what}; the first is row {first}: {}", rows.len(), place(first));
        }
    }
}
