//! The commands below `fre finger`.

use std::path::PathBuf;
use std::process::ExitCode;

use fre::cad::{self, CadError, Format};
use fre::case::{Case, Described};
use fre::finger::measure::{Front, Measured, case_text, measure};
use fre::finger::{Body, outline};

use super::urdf::{self, UrdfArgs};
use crate::exit::{bad_input, tell};
use crate::output::{ForceArgs, put_out, reads_case};
use crate::standard::{Target, is_standard};

/// Largest file that is read, bytes.
const MAX_BYTES: u64 = 256 << 20;
/// Height of the solid base that is drawn below beams that are held at their very start, mm.
const BASE: f64 = 5.0;

/// Write a finger's outline for a printer or a drawing, or measure a finger in one
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    Export(ExportArgs),
    Import(ImportArgs),
}

/// Write the closed outline of a finger as a drawing or a solid
///
/// It has beams, rungs, fillets, solid tip and base, as they are printed. As URDF, a finger or a whole gripper is described for rviz and
/// simulators, with a solid beside it.
#[derive(Debug, clap::Args)]
struct ExportArgs {
    /// A case, a finger file or preset:NAME
    #[arg(value_name = "FINGER")]
    finger: PathBuf,
    /// Format [default: by the ending of --output]
    #[arg(long, value_enum)]
    format: Option<FormatWord>,
    /// The file to write [default: standard output, but for a solid]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Height of the solid base below the starts of the beams, mm
    ///
    /// The default is 5, or 0 where both beams are held above their starts.
    #[arg(long, value_name = "MM", value_parser = base, allow_negative_numbers = true)]
    base_mm: Option<f64>,
    #[command(flatten)]
    urdf: UrdfArgs,
    #[command(flatten)]
    force: ForceArgs,
}

/// Measure an extruded finger and write a case, with what could not be decided marked
///
/// The drawing is turned upright. Walls, rungs, necks, fillets, the solid base and the tip are measured; material, motion and object are
/// placeholders. A finger that `fre solve` would refuse is refused.
#[derive(Debug, clap::Args)]
struct ImportArgs {
    /// The outline (DXF, SVG) or the solid (STL), mm
    #[arg(value_name = "FILE.dxf|FILE.svg|FILE.stl")]
    file: PathBuf,
    /// The case to write [default: standard output]
    #[arg(long, short, value_name = "CASE.toml")]
    output: Option<PathBuf>,
    /// Side of the upright drawing that touches objects
    #[arg(long, value_enum, default_value = "auto")]
    front: FrontWord,
    #[command(flatten)]
    force: ForceArgs,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FormatWord {
    /// Closed polylines, mm
    Dxf,
    /// A path on a page in mm
    Svg,
    /// The extruded solid, mm
    Stl,
    /// Links, joints and masses, with a solid beside them
    Urdf,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FrontWord {
    /// The straighter, or more upright, one
    Auto,
    /// The left one
    Left,
    /// The right one
    Right,
}

fn base(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if (0.0..=1000.0).contains(&value) => Ok(value),
        _ => Err("allowed is 0 to 1000 mm".to_owned()),
    }
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let done = match &args.command {
        Command::Export(args) => export(args),
        Command::Import(args) => import(args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => bad_input(&message),
    }
}

fn export(args: &ExportArgs) -> Result<(), String> {
    let is_urdf = |file: &PathBuf| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("urdf"));
    // A description has the solid of its finger.
    let (format, described) = match (args.format, &args.output) {
        (Some(FormatWord::Dxf), _) => (Format::Dxf, false),
        (Some(FormatWord::Svg), _) => (Format::Svg, false),
        (Some(FormatWord::Stl), _) => (Format::Stl, false),
        (Some(FormatWord::Urdf), _) => (Format::Stl, true),
        (None, Some(file)) if is_urdf(file) => (Format::Stl, true),
        (None, Some(file)) => (Format::of(file).map_err(|error| format!("{error}, and .urdf"))?, false),
        (None, None) => return Err("--format or --output is missing; needed is dxf, svg, stl or urdf".to_owned()),
    };
    if let Some(option) = args.urdf.first().filter(|_| !described) {
        return Err(format!("{option} is for URDF only: --format urdf"));
    }
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", args.finger.display());
    let mut files = args.force.files();
    if !args.finger.to_string_lossy().starts_with("preset:") {
        reads_case(&mut files, &args.finger).map_err(|error| error.to_string())?;
    }
    let found = Described::read(&args.finger).map_err(|error| error.to_string())?;
    let body = Body::of(&found.keys).map_err(|error| named(&error))?;
    let held = body.base();
    let base = args.base_mm.unwrap_or(if held[0] > 0.0 && held[1] > 0.0 { 0.0 } else { BASE });
    let loops = outline(&body, base).map_err(|error| named(&error))?;
    let bytes = cad::encode(&loops, body.width, format).map_err(|error| named(&error))?;
    if body.tapers_in_width && format == Format::Stl {
        tell!("fre: warning: the width changes along the finger; the solid has that of the base, {} mm", body.width);
    }
    if described {
        let file = args.output.as_ref().filter(|file| !is_standard(file));
        let file = file
            .ok_or("--output is missing; needed is FILE.urdf: the finger's solid is written beside the description")?;
        return urdf::write(&args.urdf, &args.finger, &found, &loops, &bytes, file, &mut files);
    }
    match (&args.output, String::from_utf8(bytes)) {
        (Some(file), text) => {
            let bytes = text.map_or_else(|error| error.into_bytes(), String::into_bytes);
            Target::of(&mut files, file, "--output").map_err(|error| error.to_string())?.write(&bytes)
        }
        (None, Ok(text)) if format != Format::Stl => put_out(&text),
        (None, _) => Err("--output is missing; needed is a file for the solid".to_owned()),
    }
}

fn import(args: &ImportArgs) -> Result<(), String> {
    let file = args.file.display();
    let format = Format::of(&args.file).map_err(|error| error.to_string())?;
    let mut files = args.force.files();
    files.input(&args.file, "the outline").map_err(|error| error.to_string())?;
    let unreadable = |reason: String| CadError::Unreadable { file: file.to_string(), reason }.to_string();
    let length = std::fs::metadata(&args.file).map_err(|error| unreadable(error.to_string()))?.len();
    if length > MAX_BYTES {
        return Err(unreadable(format!("it has {length} bytes; allowed is {MAX_BYTES}")));
    }
    let bytes = std::fs::read(&args.file).map_err(|error| unreadable(error.to_string()))?;
    let drawing = cad::decode(&bytes, format).map_err(|error| format!("{file}: {error}"))?;
    for note in &drawing.notes {
        tell!("fre: {file}: {note}");
    }
    let front = match args.front {
        FrontWord::Auto => Front::Auto,
        FrontWord::Left => Front::Left,
        FrontWord::Right => Front::Right,
    };
    let measured = measure(&drawing.loops, drawing.width, drawing.has_origin, front)
        .map_err(|error| format!("{file}: {error}"))?;
    let name = args.file.file_stem().map_or_else(|| "finger".into(), |stem| stem.to_string_lossy());
    let text = case_text(&measured, &name);
    report(&measured);
    Case::parse(&file.to_string(), &text)
        .map_err(|error| format!("{file}: what was measured cannot be solved: {}", error.without_place()))?;
    match &args.output {
        None => put_out(&text),
        Some(path) => {
            Target::of(&mut files, path, "the case").map_err(|error| error.to_string())?.write(text.as_bytes())
        }
    }
}

/// What was found, and what is left to decide, on standard error: the case may go to standard output.
fn report(measured: &Measured) {
    let thickness = |knots: &[[f64; 2]]| match knots {
        [[_, only]] => format!("{only:.2} mm"),
        knots => format!("{:.2} to {:.2} mm", knots[0][1], knots[knots.len() - 1][1]),
    };
    tell!(
        "fre: front wall {}, back wall {}, {} rungs, solid above {:.2} mm{}",
        thickness(&measured.front.thickness),
        thickness(&measured.back.thickness),
        measured.rungs.len(),
        measured.solid_above,
        measured.width.map_or_else(String::new, |width| format!(", {width:.2} mm wide"))
    );
    for (k, rung) in measured.rungs.iter().enumerate() {
        let necks = rung.necks.map_or_else(String::new, |necks| {
            format!(
                ", necks {:.2} mm thick, {:.2} and {:.2} mm long",
                necks.thickness, necks.lengths[0], necks.lengths[1]
            )
        });
        tell!(
            "fre: rung {}: height {:.2} mm, angle {:.2}°, thickness {:.2} to {:.2} mm, clear length {:.2} mm{necks}",
            k + 1,
            rung.height,
            // No minus before a zero.
            (100.0 * rung.angle_deg).round() / 100.0 + 0.0,
            rung.thickness[0],
            rung.thickness[1],
            rung.clear
        );
    }
    for undecided in &measured.undecided {
        tell!("fre: to decide: {}: {}", undecided.key, undecided.why);
    }
}
