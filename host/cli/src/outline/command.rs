//! `fre outline` with the feature of its name.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::object::Motion;

use crate::exit::{bad_input, tell};
use crate::output::{ForceArgs, put_out, reads, reads_case};
use crate::progress::ProgressLine;
use crate::standard::{self, is_standard};
use fre::case::{Case, MAX_ANGLE, MAX_DISTANCE};
use fre::draw;
use fre::files::{FileError, Files, Output};
use fre::fit::outline::boards::{self, Board};
use fre::fit::outline::camera::Camera;
use fre::fit::outline::marks::{self, Mark};
use fre::fit::outline::photo::{Colour, Photo};
use fre::fit::outline::plane::{Agreement, Plane};
use fre::fit::outline::{Options, Outline, OutlineError, camera_file, dots, extract, overlay};

/// Take the front beam's shape from a photograph, for `fre compare --measured`
///
/// The finger is in front of a plain background.
///
/// The finger must be darker or brighter than the background, or of another colour. An object that it touches must be darker
/// or brighter than the finger. Transparent pixels count as white.
///
/// The case gives the finger's dimensions; --angle-deg (or --distance-mm) says where along its motion the photograph was taken.
///
/// Marks give scale and perspective. They are at least four points in the plane of the finger's near side whose position in mm
/// is known: --marks 412,1530=-14,-5 … with the pixel first (x to the right, y down, picture upright). On printed round dots
/// (--dot-mm) a pixel near the dot is enough. Marks that turn with the finger have their mm in the finger frame (origin at the
/// front beam's base, y towards the tip, x towards the object); marks that do not turn have them in the world frame (--frame
/// world: the finger frame at motor angle 0). The camera may see the plane from either side, tilted or not.
///
/// Without a camera four marks cannot be checked. With more, the residual is checked: a warning is printed above 0.1 mm, and
/// for marks whose error the residual would not show (such as marks on a line with two others).
///
/// A lens bends lines. To correct for it, take at least three pictures of a checkerboard, tilted differently, with the same
/// camera, zoom and focus (--checkerboard). --save-camera keeps the result for the next photographs (--camera).
///
/// Standard output is a CSV with motor_angle_deg (or distance_mm), front_x_mm, front_y_mm (front centreline, finger frame),
/// arc_mm and deviation_mm, one row per point. Notes on the pictures go to standard error.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("known").required(true).args(["marks", "marks_file"]))]
#[command(group = clap::ArgGroup::new("place").required(true).args(["angle_deg", "distance_mm"]))]
#[command(group = clap::ArgGroup::new("lens").args(["checkerboard", "camera"]))]
pub struct Args {
    /// The photograph: PNG, JPEG, TIFF, BMP or WebP; - for standard input
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// The case with the finger; - for standard input
    #[arg(long, value_name = "CASE.toml")]
    case: PathBuf,
    /// Motor angle at which the photograph was taken
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    angle_deg: Option<f64>,
    /// Distance by which the base had moved, for a case with distances
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    distance_mm: Option<f64>,
    /// Measured force, written into the same file
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    force_n: Option<f64>,
    /// A mark: its pixel and its position in mm; at least four
    #[arg(long, value_name = "PX,PY=X,Y", num_args = 1..)]
    marks: Vec<Mark>,
    /// The marks from a file: tables [[mark]] with pixel = [PX, PY] and mm = [X, Y]
    #[arg(long, value_name = "FILE.toml")]
    marks_file: Option<PathBuf>,
    /// Diameter of round dots at the marks, whose centres are searched
    #[arg(long, value_name = "MM")]
    dot_mm: Option<f64>,
    /// Frame of the marks' mm
    #[arg(long, value_enum, default_value = "finger")]
    frame: Frame,
    /// Pictures of a checkerboard, at least three
    #[arg(long, value_name = "IMAGE", num_args = 1.., requires = "squares")]
    checkerboard: Vec<PathBuf>,
    /// Squares of the checkerboard, such as 10x7
    #[arg(long, value_name = "NxM", value_parser = squares)]
    squares: Option<[usize; 2]>,
    /// Side of a square; affects the board's distance only
    #[arg(long, value_name = "MM", default_value_t = 10.0)]
    square_mm: f64,
    /// The camera as --save-camera wrote it
    #[arg(long, value_name = "FILE.toml")]
    camera: Option<PathBuf>,
    /// Writes the camera found from the checkerboards
    #[arg(long, value_name = "FILE.toml", requires = "checkerboard", conflicts_with = "camera")]
    save_camera: Option<PathBuf>,
    /// First arc length along the front beam [default: its thickness]
    #[arg(long, value_name = "MM")]
    from_mm: Option<f64>,
    /// Last arc length [default: the beam's length less its thickness]
    #[arg(long, value_name = "MM")]
    to_mm: Option<f64>,
    /// Distance of the points
    #[arg(long, value_name = "MM", default_value_t = 1.0)]
    spacing_mm: f64,
    /// Smooths a point over this distance to either side; 0 does not smooth
    #[arg(long, value_name = "MM", default_value_t = 2.5)]
    smooth_mm: f64,
    /// Writes the CSV to a file, or as - to standard output; --append adds to it
    #[arg(long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Adds the rows to a file that has this command's columns
    ///
    /// One file holds a series of photographs that way.
    #[arg(long, requires = "output")]
    append: bool,
    /// Draws the outline over the photograph
    #[arg(long, value_name = "FILE.png")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
}

/// The largest residual of the marks that is not warned of, mm: what an outline may be off by at a tenth of a millimetre per pixel.
const MOST_RESIDUAL_MM: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Frame {
    /// Origin at the front beam's base; moves with the finger.
    Finger,
    /// The finger frame at motor angle 0; does not move.
    World,
}

fn squares(words: &str) -> Result<[usize; 2], String> {
    let read = words.split_once(['x', '×']).and_then(|(n, m)| Some([n.trim().parse().ok()?, m.trim().parse().ok()?]));
    match read {
        Some(squares) if squares.iter().all(|n| (3..=100).contains(n)) => Ok(squares),
        _ => Err("allowed is NxM with 3 to 100 squares each way".to_owned()),
    }
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match outline(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}

fn outline(args: &Args) -> Result<(), OutlineError> {
    if let Some(file) = &args.plot
        && !matches!(draw::Format::of(file), Ok(draw::Format::Png))
    {
        return Err(OutlineError::Option(format!("{}: a picture over a photograph ends in .png", file.display())));
    }
    let outputs = Outputs::of(args).map_err(|error| OutlineError::Option(error.to_string()))?;
    let case = standard::case(&args.case).map_err(|error| OutlineError::Option(error.to_string()))?;
    let place = place(args, &case)?;
    let beam = &case.finger.design.front;
    let options = options(args, Options::of(beam), beam.length())?;
    let photo = if is_standard(&args.image) {
        let bytes = standard::bytes(&args.image).map_err(OutlineError::Option)?;
        Photo::decode(standard::name(&args.image), std::io::Cursor::new(bytes))?
    } else {
        Photo::read(&args.image)?
    };
    let camera = camera(args, outputs.camera, photo.size())?;
    let marks = match &args.marks_file {
        Some(file) => marks::read(file)?,
        None => args.marks.clone(),
    };
    let marks = match args.dot_mm {
        Some(diameter) if diameter > 0.0 && diameter.is_finite() => {
            // Said first: a mark outside the picture is on no dot either.
            Plane::through(&marks, None, &photo)?;
            dots::centred(&marks, diameter, &photo)?
        }
        Some(diameter) => return Err(OutlineError::Option(format!("--dot-mm is {diameter}; allowed is more than 0"))),
        None => marks,
    };
    let (plane, agreement) = Plane::through(&marks, camera, &photo)?;
    let plane = match args.frame {
        Frame::Finger => plane,
        Frame::World => match case.path.motion {
            // World from finger: M + R(−α)(p − M).
            Motion::Rotating { axis: [x, y] } => {
                let (sin, cos) = place.to_radians().sin_cos();
                plane.in_frame(-place.to_radians(), [x - cos * x - sin * y, y + sin * x - cos * y])
            }
            Motion::Translating { direction: [x, y] } => plane.in_frame(0.0, [place * x, place * y]),
        },
    };
    let outline = extract(&photo, &plane, beam, &options)?;
    if let Some(file) = outputs.plot {
        let picture = overlay::png(&photo, &plane, &marks, &outline, |arc| 0.5 * beam.thickness.at(arc))?;
        write(file, &picture)?;
    }
    let column = if args.angle_deg.is_some() { "motor_angle_deg" } else { "distance_mm" };
    let header = format!("{column},force_n,front_x_mm,front_y_mm,arc_mm,deviation_mm");
    let rows = rows(place, args.force_n, &outline);
    match outputs.table {
        Some(Table::More(file)) => append(&file, &header, &rows)?,
        Some(Table::New(file)) => write(file, format!("{header}\n{rows}").as_bytes())?,
        None => put_out(&format!("{header}\n{rows}")).map_err(OutlineError::Option)?,
    }
    if photo.is_transparent() {
        tell!("picture      transparent in places: taken as before white");
    }
    tell!("{}", report(&outline, &agreement, marks.len()).trim_end());
    Ok(())
}

/// The files that are written.
struct Outputs {
    plot: Option<Output>,
    camera: Option<Output>,
    table: Option<Table>,
}

/// The CSV.
enum Table {
    New(Output),
    /// One that is there, which rows are added to.
    More(PathBuf),
}

impl Outputs {
    /// Takes note of all files, before the photograph is read.
    fn of(args: &Args) -> Result<Self, FileError> {
        let mut files = args.force.files();
        reads(&mut files, &args.image, "the photograph")?;
        reads_case(&mut files, &args.case)?;
        args.marks_file.iter().try_for_each(|path| files.input(path, "--marks-file"))?;
        args.checkerboard.iter().try_for_each(|path| files.input(path, "--checkerboard"))?;
        args.camera.iter().try_for_each(|path| files.input(path, "--camera"))?;
        let table = match &args.output {
            Some(path) if is_standard(path) => None,
            Some(path) if args.append && path.exists() => {
                files.continued(path, "--output")?;
                Some(Table::More(path.clone()))
            }
            Some(path) => Some(Table::New(files.output(path, "--output")?)),
            None => None,
        };
        let mut output = |path: &Option<PathBuf>, what| path.as_ref().map(|path| files.output(path, what)).transpose();
        Ok(Self { plot: output(&args.plot, "--plot")?, camera: output(&args.save_camera, "--save-camera")?, table })
    }
}

fn place(args: &Args, case: &Case) -> Result<f64, OutlineError> {
    let (found, wanted, limit) = match case.path.motion {
        Motion::Rotating { .. } => (args.angle_deg, "--angle-deg", MAX_ANGLE),
        Motion::Translating { .. } => (args.distance_mm, "--distance-mm", MAX_DISTANCE),
    };
    let place =
        found.ok_or_else(|| OutlineError::Option(format!("the motion of {} needs {wanted}", args.case.display())))?;
    if !(-limit..=limit).contains(&place) {
        return Err(OutlineError::Option(format!("{wanted} is {place}; allowed is {} to {limit}", -limit)));
    }
    match args.force_n {
        Some(force) if !(force.is_finite() && force >= 0.0) => {
            Err(OutlineError::Option(format!("--force-n is {force}; allowed is a magnitude of 0 and more")))
        }
        _ => Ok(place),
    }
}

fn options(args: &Args, default: Options, length: f64) -> Result<Options, OutlineError> {
    let from = args.from_mm.unwrap_or(default.from);
    let to = args.to_mm.unwrap_or(default.to);
    let checks = [
        ("--from-mm", from, 0.0, length),
        ("--to-mm", to, from + 5.0, length),
        ("--spacing-mm", args.spacing_mm, 0.05, length),
        ("--smooth-mm", args.smooth_mm, 0.0, 0.25 * length),
        ("--square-mm", args.square_mm, 0.1, 1000.0),
    ];
    for (name, value, low, high) in checks {
        if !(low..=high).contains(&value) {
            return Err(OutlineError::Option(format!("{name} is {value}; allowed is {low} to {high}")));
        }
    }
    Ok(Options { from, to, smooth: args.smooth_mm, spacing: args.spacing_mm })
}

fn camera(args: &Args, save: Option<Output>, size: [u32; 2]) -> Result<Option<Camera>, OutlineError> {
    if let Some(file) = &args.camera {
        return camera_file::read(file).map(Some);
    }
    let Some(squares) = args.squares.filter(|_| !args.checkerboard.is_empty()) else { return Ok(None) };
    let mut line = ProgressLine::new(false);
    let board = Board { squares, square_mm: args.square_mm };
    let found = boards::calibrate(&args.checkerboard, board, size, |progress| {
        line.show(false, || format!("corners: {} of {} pictures", progress.done, progress.total));
        ControlFlow::Continue(())
    });
    line.wipe();
    let found = found?;
    let Camera { focal_px, centre_px, radial, tangential, .. } = found.camera;
    tell!(
        "camera       {} pictures, residual {:.3} px rms; focal length {:.1} ± {:.1}, {:.1} px, centre {:.1}, {:.1} px, \
         k1 {:.4}, k2 {:.4}, p1 {:.5}, p2 {:.5}",
        args.checkerboard.len(),
        found.rms_px,
        focal_px[0],
        found.focal_deviation_px,
        focal_px[1],
        centre_px[0],
        centre_px[1],
        radial[0],
        radial[1],
        tangential[0],
        tangential[1]
    );
    for (file, largest) in args.checkerboard.iter().zip(&found.largest_px) {
        if *largest > 5.0 * found.rms_px.max(0.1) {
            tell!(
                "             {}: a corner is {largest:.1} px off; leave this picture out if it is blurred",
                file.display()
            );
        }
    }
    if let Some(file) = save {
        let text = format!(
            "# A camera from {} pictures of a checkerboard, residual {:.3} px rms: for this zoom and focus.\n{}",
            args.checkerboard.len(),
            found.rms_px,
            camera_file::text(&found.camera)
        );
        write(file, text.as_bytes())?;
    }
    Ok(Some(found.camera))
}

fn rows(place: f64, force: Option<f64>, outline: &Outline) -> String {
    let mut text = String::new();
    for (index, on) in outline.points.iter().enumerate() {
        // One row of a place carries its force.
        let force = force.filter(|_| index == 0).map(|force| force.to_string()).unwrap_or_default();
        let [x, y] = on.point;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{place},{force},{x:.4},{y:.4},{:.3},{:.4}", on.arc, on.deviation);
    }
    text
}

fn report(outline: &Outline, agreement: &Agreement, marks: usize) -> String {
    let mut text = String::new();
    let residual = match (agreement.rms_px, agreement.rms_mm) {
        (Some(pixels), Some(mm)) => format!("residual {pixels:.3} px ({mm:.4} mm) rms"),
        _ => "no residual: four marks fit any perspective, a fifth or a camera would check them".to_owned(),
    };
    let _ = writeln!(text, "marks        {marks}, {residual}");
    if let Some(mm) = agreement.rms_mm.filter(|&mm| mm > MOST_RESIDUAL_MM) {
        let _ = writeln!(
            text,
            "             {mm:.2} mm is more than {MOST_RESIDUAL_MM} mm: a mark's pixel or millimetres are probably wrong, the marks lie \
             in no plane, or the lens bends lines (--checkerboard); the outline is off by as much"
        );
    }
    if agreement.rms_px.is_some() && !agreement.unchecked.is_empty() {
        let names: Vec<String> = agreement
            .unchecked
            .iter()
            .map(|Mark { pixel: [px, py], mm: [x, y] }| format!("{px:.0},{py:.0}={x},{y}"))
            .collect();
        let _ = writeln!(
            text,
            "             an error of {} may not show in the residual: the others do not check it in every direction; more \
             marks, off the lines between these, or a camera would",
            names.join(" or ")
        );
    }
    let (first, last) = (outline.points.first(), outline.points.last());
    let ends = [first, last].map(|on| on.map_or(f64::NAN, |on| on.arc));
    let gaps: Vec<String> = outline.gaps.iter().map(|[from, to]| format!("{from:.1} to {to:.1}")).collect();
    let _ = writeln!(
        text,
        "outline      {} points, arc length {:.1} to {:.1} mm, {:.4} mm per pixel{}",
        outline.points.len(),
        ends[0],
        ends[1],
        outline.mm_per_pixel,
        if gaps.is_empty() { String::new() } else { format!("; no edge from {} mm", gaps.join(", ")) }
    );
    let _ = writeln!(
        text,
        "edges        contrast {:.0} % of white{}, blur {:.1} px, scatter {:.4} mm before smoothing",
        100.0 * outline.look.contrast.abs(),
        match outline.colour {
            Colour::White => String::new(),
            colour => format!("'s {}", colour.word()),
        },
        outline.blur_px,
        outline.scatter
    );
    let percent = 100.0 * (outline.look.ratio - 1.0);
    // No minus before a zero.
    let shown = (10.0 * percent).round() / 10.0 + 0.0;
    let _ = writeln!(text, "thickness    {shown:+.1} % of the design's");
    if percent.abs() > 8.0 {
        let _ = writeln!(text, "             so far off, the marks' scale or the design's thickness is probably wrong");
    }
    text
}

fn write(file: Output, bytes: &[u8]) -> Result<(), OutlineError> {
    file.write(bytes).map_err(|error| OutlineError::Option(error.to_string()))
}

/// Adds rows to a file that begins with the same header, or is empty.
fn append(file: &Path, header: &str, rows: &str) -> Result<(), OutlineError> {
    let name = file.display().to_string();
    if !file.is_file() {
        return Err(OutlineError::Option(format!("{name}: is not a file; --append adds to one")));
    }
    let before = std::fs::read_to_string(file)
        .map_err(|error| OutlineError::Unreadable { file: name.clone(), reason: error.to_string() })?;
    let own = before.lines().next().is_none_or(|first| first == header);
    if !own {
        return Err(OutlineError::Option(format!("{name}:1: --append needs the header {header}")));
    }
    let end = if before.ends_with('\n') { "" } else { "\n" };
    let text = if before.is_empty() { format!("{header}\n{rows}") } else { format!("{before}{end}{rows}") };
    // Whole or not at all: a full disk or a lost process must not cost the series that the file holds.
    let written = Files::new(true).output(file, "--output").and_then(|output| output.write(text.as_bytes()));
    written.map_err(|error| OutlineError::Option(error.to_string()))
}
