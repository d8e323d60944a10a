//! `fre replay`: a recording through the view and the estimator.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::discretise::{Discretisation, Elements, Physics};

use crate::exit::{bad_input, tell, trusted};
use crate::options::PhysicsWord;
use crate::output::{ForceArgs, put_out, reads_case};
use crate::positions;
use crate::standard::{self, is_standard, only_file};
use crate::view::ViewArgs;
use fre::study::choice::elements;
use fre::study::model::Precision;

/// What a program without recordings says.
#[cfg(not(feature = "record"))]
pub const NOT_BUILT: &str = "this `fre` was built without recordings; build it with them: cargo run --release -p fre-cli --features \
                             record --bin fre -- …";

/// Play a recording, write it as a table, or run the estimator on it once more
///
/// Without options the recording is shown as `fre monitor` showed it, at its own speed. With --again the forces are estimated
/// again from the recorded positions, with the changes that the other options name, and compared with the recorded ones.
///
/// A plain CSV file of times (time_s) and motor positions (angle_deg, angle_rad or position_counts), whatever has recorded them, is
/// copied with the forces that belong to the positions: --again, --case and --csv are needed then. Semicolons or tabs may separate the
/// cells, and numbers may then have decimal commas; the copy is written in the same way. The exit status is 2 if some row has no trustworthy
/// force.
///
/// Recordings need a `fre` built with them:
/// cargo run --release -p fre-cli --features record --bin fre -- replay FILE
#[derive(Debug, clap::Args)]
#[cfg_attr(
    not(feature = "record"),
    expect(dead_code, reason = "parsed in every build, for its help and for the message of what to build")
)]
pub struct Args {
    /// The recording, or a table of positions; - is a table on standard input
    #[arg(value_name = "FILE.mcap|FILE.csv")]
    file: PathBuf,
    /// Writes every report as CSV instead of showing it; - for standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Writes every recorded report to a Parquet file instead of showing it
    ///
    /// Needs a build with `--features parquet`.
    #[arg(long, value_name = "FILE", value_parser = only_file, conflicts_with_all = ["again", "speed", "at_once"])]
    parquet: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
    /// Speed at which it is shown; 2 is twice as fast
    #[arg(long, value_name = "TIMES", default_value_t = 1.0, conflicts_with = "csv")]
    speed: f64,
    /// Shows it as fast as possible
    #[arg(long, conflicts_with_all = ["csv", "speed"])]
    at_once: bool,
    #[command(flatten)]
    view: ViewArgs,
    /// Estimates the forces again and compares them with the recorded ones
    ///
    /// --csv then has columns for both.
    #[arg(long)]
    again: bool,
    /// With --again: shows the new estimates instead of comparing them
    #[arg(long, requires = "again", conflicts_with_all = ["csv", "parquet"])]
    show: bool,
    /// With --again: finger and object of a case file
    ///
    /// Repeated, there is one per finger, and the last one is for all behind it.
    #[arg(long, value_name = "CASE.toml", requires = "again", conflicts_with = "parquet")]
    case: Vec<PathBuf>,
    /// With --again: another Young's modulus
    #[arg(long, value_name = "PA", requires = "again", conflicts_with = "parquet")]
    youngs_modulus_pa: Option<f64>,
    /// With --again: another setting, as finger.0.zero_counts=2050; may be repeated
    #[arg(long, value_name = "KEY=VALUE", requires = "again", conflicts_with = "parquet")]
    set: Vec<String>,
    /// With --again: elements as B/H, or paper, reduced, fine
    ///
    /// The default is as recorded, and fine for a --case.
    #[arg(long, value_name = "B/H", value_parser = elements, requires = "again", conflicts_with = "parquet")]
    elements: Option<Elements>,
    /// With --again: physics [default: as recorded; extended for a --case]
    #[arg(long, value_enum, requires = "again", conflicts_with = "parquet")]
    physics: Option<PhysicsWord>,
    /// With --again: floating-point precision; the microcontroller's is f32
    #[arg(long, value_enum, default_value = "f64", requires = "again", conflicts_with = "parquet")]
    precision: PrecisionWord,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PrecisionWord {
    F64,
    F32,
}

impl PrecisionWord {
    fn precision(self) -> Precision {
        match self {
            Self::F64 => Precision::F64,
            Self::F32 => Precision::F32,
        }
    }
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    if !positions::is_table(&args.file) {
        return recording(args);
    }
    match label(args) {
        Ok(whole) => trusted(whole),
        Err(error) => bad_input(&error),
    }
}

/// Gives a table of positions its forces; whether all of them are trustworthy.
fn label(args: &Args) -> Result<bool, Box<dyn std::error::Error>> {
    let needed = "a table of positions has no forces: --again --case CASE.toml --csv FILE estimates them";
    if args.case.len() > 1 {
        return Err(format!("--case is given {} times; a table of positions has one finger", args.case.len()).into());
    }
    let (Some(out), [case]) = (&args.csv, &args.case[..]) else { return Err(needed.into()) };
    if args.show || args.parquet.is_some() || args.youngs_modulus_pa.is_some() {
        return Err("a table of positions is written with --csv only; Young's modulus is that of the case".into());
    }
    let mut files = args.force.files();
    reads_case(&mut files, case)?;
    let mut how = Discretisation::fine(args.physics.map_or(Physics::Extended, |word| word.physics()));
    how.elements = args.elements.unwrap_or(how.elements);
    let (name, case, precision) = (standard::name(case), standard::case(case)?, args.precision.precision());
    let model = positions::Model { name, case, how, precision, settings: args.set.clone() };
    let positions::Labelled { words, whole } = positions::label(&args.file, out, &model, &mut files)?;
    remark(&words, is_standard(out))?;
    Ok(whole)
}

/// A line for people, on standard error where the table has standard output.
fn remark(words: &str, beside: bool) -> Result<(), String> {
    if beside {
        tell!("fre: {}", words.trim_end());
        return Ok(());
    }
    put_out(words)
}

#[cfg(not(feature = "record"))]
fn recording(_: &Args) -> ExitCode {
    bad_input(&NOT_BUILT)
}

#[cfg(feature = "record")]
fn recording(args: &Args) -> ExitCode {
    let done = match &args.csv {
        Some(path) => run::table(args, Some(path)),
        None if (args.again && !args.show) || args.parquet.is_some() => run::table(args, None),
        None => return run::show(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}

#[cfg(feature = "ros2")]
pub use run::times;

#[cfg(feature = "record")]
mod run {
    use std::io::Write;
    use std::path::Path;
    use std::process::ExitCode;
    use std::sync::Arc;

    use messages::{FINGERS, Finger, Report};
    use model_core::discretise::{Discretisation, Physics};

    use super::{Args, remark};
    use crate::exit::{bad_input, tell};
    use crate::output::reads_case;
    use crate::signals::stop_flag;
    use crate::standard::{self, Stream, Target, is_standard};
    use fre::files::Draft;
    use fre_gripper::record::{Again, Changes, Csv, Difference, Playback, Recorded, Recording, Speed, beginning};
    use fre_gripper::source::{Modelled, Setup, Source, Told};

    type Failure = Box<dyn std::error::Error>;

    /// Shows it.
    pub(super) fn show(args: &Args) -> ExitCode {
        let opened = || -> Result<_, Failure> {
            let speed = if args.at_once { Speed::AtOnce } else { times(args.speed)? };
            let again = args.again.then(|| changes(args)).transpose()?.map(Again::new);
            let stop = stop_flag()?;
            Ok((Arc::new(Playback::open(&args.file, speed, again)?), stop))
        };
        let (playback, stop) = match opened() {
            Ok(opened) => opened,
            Err(error) => return bad_input(&error),
        };
        let source: Arc<dyn Source> = playback.clone();
        let shown = args.view.show(&source, None, &stop);
        for damage in playback.damages() {
            tell!("fre: {}: {damage}; what comes after them was shown as well", args.file.display());
        }
        match (shown, playback.failed()) {
            (Err(stop), _) => stop.exit(),
            (Ok(()), Some(why)) => bad_input(&why),
            (Ok(()), None) => ExitCode::SUCCESS,
        }
    }

    /// What `--speed` names.
    pub fn times(times: f64) -> Result<Speed, String> {
        Speed::times(times).ok_or_else(|| format!("--speed is {times:?}; allowed is {}", Speed::ALLOWED))
    }

    /// What is changed.
    fn changes(args: &Args) -> Result<Changes, Failure> {
        let (mut models, mut motions) = (Vec::new(), Vec::new());
        for path in &args.case {
            let case = standard::case(path)?;
            let physics = args.physics.map_or(Physics::Extended, |word| word.physics());
            let how = Discretisation::fine(physics);
            let finger = Some(Finger::elastic(case.finger.design, how).relaxing(&case.finger.prony));
            let (object, friction) = (Some(case.object), case.friction);
            models.push(Modelled { finger, object, friction, uncertainty: None });
            motions.push(case.path.motion);
        }
        if let Some(modulus) = args.youngs_modulus_pa.filter(|pa| !(*pa > 0.0 && pa.is_finite())) {
            return Err(format!("--youngs-modulus-pa is {modulus}; allowed is above 0").into());
        }
        Ok(Changes {
            settings: args.set.clone(),
            models,
            motions,
            // Pa to MPa.
            youngs_modulus: args.youngs_modulus_pa.map(|pa| pa * 1e-6),
            elements: args.elements,
            physics: args.physics.map(|word| word.physics()),
            precision: args.precision.precision(),
        })
    }

    /// Goes through the whole file: a table, a comparison, or both.
    pub(super) fn table(args: &Args, csv: Option<&Path>) -> Result<(), Failure> {
        let mut files = args.force.files();
        files.input(&args.file, "the recording")?;
        args.case.iter().try_for_each(|path| reads_case(&mut files, path))?;
        let beside = csv.is_some_and(is_standard);
        let csv = csv.map(|path| Target::of(&mut files, path, "--csv")).transpose()?;
        let parquet = args.parquet.as_deref().map(|path| files.output(path, "--parquet")).transpose()?;
        let mut recording = Recording::open(&args.file)?;
        let setup = beginning(&args.file, &mut recording)?;
        let mut again = args.again.then(|| changes(args)).transpose()?.map(Again::new);
        if let Some(again) = &mut again {
            again.set_up(&setup)?;
        }
        let mut table = csv.map(|csv| Table::new(csv.draft()?, again.is_some())).transpose()?;
        let mut columns = parquet.map(|parquet| Columns::new(parquet.draft()?)).transpose()?;
        let mut differences = [Difference::default(); FINGERS];
        let (mut reports, mut events, mut gaps, mut missing) = (0_u64, 0_u64, 0_u64, 0_u64);
        let mut damages = Vec::new();
        for recorded in recording.by_ref() {
            match recorded?.1 {
                Recorded::Told(Told::Report(report)) => {
                    reports += 1;
                    let now = again.as_mut().map(|again| again.report(&report));
                    if let (Some(now), Some(difference)) = (&now, differences.get_mut(usize::from(report.finger))) {
                        difference.take(&report, now);
                    }
                    if let Some(table) = &mut table {
                        table.write(&report, now.as_ref())?;
                    }
                    if let Some(columns) = &mut columns {
                        columns.write(&report)?;
                    }
                }
                Recorded::Told(Told::Event(_)) => events += 1,
                Recorded::Told(Told::Setup(setup)) => {
                    if let Some(again) = &mut again {
                        again.set_up(&setup)?;
                    }
                }
                Recorded::Told(Told::Grasp(_) | Told::Shape(_)) => {}
                Recorded::Gap(gap) => {
                    gaps += 1;
                    missing += u64::from(gap.missing);
                }
                Recorded::Damage(damage) => damages.push(damage),
            }
        }
        if let Some(table) = table {
            table.finish()?;
        }
        if let Some(columns) = columns {
            columns.finish()?;
        }
        let mut text = format!(
            "{}: {reports} reports, {events} events; {missing} reports missing in {gaps} gaps\n",
            of(&args.file, &setup)
        );
        text.extend(damages.iter().map(|damage| format!("{damage}; what came before and after them is whole\n")));
        if recording.is_cut() {
            text += "the end of the file is missing: its recorder was stopped by force, what came before it is whole\n";
        }
        if args.again {
            text += &compare(&differences);
        }
        Ok(remark(&text, beside)?)
    }

    fn of(path: &Path, setup: &Setup) -> String {
        format!("{} (firmware {} on {}, {})", path.display(), setup.firmware, setup.board, setup.place)
    }

    fn compare(differences: &[Difference]) -> String {
        let mut text = "finger  reports  trustworthy before, now  in contact  mean force before, now / N  difference rms, max / N  at / s\n"
            .to_owned();
        for (finger, difference) in differences.iter().enumerate().filter(|(_, difference)| difference.reports > 0) {
            let Difference { reports, trustworthy: [before, now], compared, largest, .. } = difference;
            text += &format!("{finger:6}  {reports:7}  {before:17}  {now:5}  {compared:10}");
            match difference.means() {
                Some(([before, now], rms)) => {
                    let (most, at) = (largest.0, largest.1 as f64 * 1e-6);
                    text += &format!("  {before:17.3}  {now:7.3}  {rms:15.4}  {most:7.4}  {at:6.2}\n");
                }
                None => text += "  no contact in both\n",
            }
        }
        text
    }

    /// The Parquet file.
    #[cfg(feature = "parquet")]
    struct Columns {
        reports: fre_gripper::record::ReportTable,
        writer: fre::parquet::Writer<Draft>,
    }

    #[cfg(feature = "parquet")]
    impl Columns {
        /// Rows that are written at once.
        const AT_ONCE: usize = 1 << 16;

        fn new(file: Draft) -> Result<Self, Failure> {
            let reports = fre_gripper::record::ReportTable::default();
            let writer = fre::parquet::Writer::new(file, reports.table(), &[])?;
            Ok(Self { reports, writer })
        }

        fn write(&mut self, report: &Report) -> Result<(), Failure> {
            self.reports.take(report);
            if self.reports.table().rows() == Self::AT_ONCE {
                self.writer.write(self.reports.table())?;
                self.reports.clear();
            }
            Ok(())
        }

        fn finish(mut self) -> Result<(), Failure> {
            self.writer.write(self.reports.table())?;
            Ok(self.writer.finish()?.finish()?)
        }
    }

    /// Without Parquet there is none.
    #[cfg(not(feature = "parquet"))]
    enum Columns {}

    #[cfg(not(feature = "parquet"))]
    impl Columns {
        fn new(_: Draft) -> Result<Self, Failure> {
            Err("--parquet: this `fre` was built without Parquet; build it with: cargo run --release -p fre-cli --features \
                 record,parquet --bin fre -- …"
                .into())
        }

        fn write(&mut self, _: &Report) -> Result<(), Failure> {
            match *self {}
        }

        fn finish(self) -> Result<(), Failure> {
            match self {}
        }
    }

    /// The CSV, with columns for the new estimate and the recorded one.
    enum Table {
        Recorded(Csv<Stream>),
        Both(Stream),
    }

    impl Table {
        fn new(mut file: Stream, both: bool) -> Result<Self, Failure> {
            if !both {
                return Ok(Self::Recorded(Csv::new(file)?));
            }
            writeln!(
                file,
                "sequence,time_us,finger,position_counts,recorded_angle_deg,recorded_status,recorded_force_x_n,recorded_force_y_n,\
                 angle_deg,status,force_x_n,force_y_n,standard_deviation_n"
            )?;
            Ok(Self::Both(file))
        }

        fn write(&mut self, report: &Report, now: Option<&Report>) -> std::io::Result<()> {
            match (self, now) {
                (Self::Recorded(csv), _) => csv.write(report),
                (Self::Both(file), now) => {
                    let Report { sequence, time_us, finger, position, .. } = report;
                    write!(file, "{sequence},{time_us},{finger},{position}")?;
                    let now = now.unwrap_or(report);
                    for Report { estimate, .. } in [report, now] {
                        let [fx, fy] = estimate.force;
                        write!(file, ",{},{},{fx},{fy}", estimate.motor_angle.to_degrees(), estimate.status)?;
                    }
                    writeln!(file, ",{}", now.estimate.standard_deviation)
                }
            }
        }

        fn finish(self) -> Result<(), Failure> {
            let file = match self {
                Self::Recorded(csv) => csv.finish()?,
                Self::Both(file) => file,
            };
            Ok(file.finish()?)
        }
    }
}
