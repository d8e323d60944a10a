//! `fre finger export --format urdf`: a description, and the solid of its finger beside it.

use std::path::Path;

use fre::case::{Case, Described};
use fre::files::Files;
use fre::finger::{Body, Loop};
use fre::urdf::{Gripper, Solid, UrdfError};
use model_core::object::Motion;

use crate::output::put_out;

/// Without --density-kg-per-m3: printed TPU, kg/m³.
const DENSITY: f64 = 1200.0;
/// Range of a finger file, which has no motion, deg.
const RANGE_DEG: [f64; 2] = [0.0, 30.0];

/// What a description needs beside the finger.
#[derive(Debug, clap::Args)]
pub struct UrdfArgs {
    /// With URDF: how many equal fingers, 1 to 4 [default: 2]
    #[arg(long, value_name = "N")]
    fingers: Option<u8>,
    /// With URDF: distance between opposite fingers' bases at angle 0
    ///
    /// It is the distance of the front beams' centrelines at their bases, in mm. The default is twice the distance of the case's object.
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    gap_mm: Option<f64>,
    /// With URDF: range of the joint in degrees, or mm of a moved finger
    ///
    /// The default is from 0, or the least place of the case's motion below it, to the greatest; of a finger file 0:30.
    #[arg(long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// With URDF: density of the printed finger [default: 1200]
    #[arg(long, value_name = "KG/M3")]
    density_kg_per_m3: Option<f64>,
    /// With URDF: joints of the other fingers follow that of finger 0
    #[arg(long)]
    mimic: bool,
    /// With URDF: what comes before the name of the mesh
    ///
    /// As package://my_gripper/meshes/ or file:///home/me/gripper/, which rviz needs. Without it the name stands for a file beside the
    /// description.
    #[arg(long, value_name = "ADDRESS")]
    mesh_prefix: Option<String>,
}

impl UrdfArgs {
    /// The first of these options that is there.
    pub fn first(&self) -> Option<&'static str> {
        let given = [
            (self.fingers.is_some(), "--fingers"),
            (self.gap_mm.is_some(), "--gap-mm"),
            (self.range.is_some(), "--range"),
            (self.density_kg_per_m3.is_some(), "--density-kg-per-m3"),
            (self.mimic, "--mimic"),
            (self.mesh_prefix.is_some(), "--mesh-prefix"),
        ];
        given.into_iter().find(|(is_given, _)| *is_given).map(|(_, option)| option)
    }
}

fn range(words: &str) -> Result<[f64; 2], String> {
    let numbers = words.split_once(':').and_then(|(low, high)| Some([low.parse().ok()?, high.parse().ok()?]));
    numbers.ok_or_else(|| "needed is LOW:HIGH, as 0:30".to_owned())
}

/// Writes the description and the mesh, whose bytes these are.
pub fn write(
    args: &UrdfArgs,
    finger: &Path,
    described: &Described,
    loops: &[Loop],
    mesh: &[u8],
    file: &Path,
    files: &mut Files,
) -> Result<(), String> {
    let density = args.density_kg_per_m3.unwrap_or(DENSITY);
    if !(density > 0.0 && density <= 30_000.0) {
        return Err(UrdfError::Density(density).to_string());
    }
    let Surroundings { motion, range, gap } = Surroundings::of(finger, described)?;
    let fingers = args.fingers.unwrap_or(2);
    let gap = args.gap_mm.or(gap).or((fingers == 1).then_some(0.0)).ok_or_else(|| {
        format!("{}: no object says how far the fingers are apart; needed is --gap-mm", finger.display())
    })?;
    let width = Body::of(&described.keys).map_err(|error| format!("{}: {error}", finger.display()))?.width;
    let name = |path: &Path| path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let beside = format!("{}_finger.stl", name(file));
    let gripper = Gripper {
        name: name(file),
        fingers,
        gap,
        motion,
        range: args.range.unwrap_or(range),
        follows: args.mimic,
        mesh: format!("{}{beside}", args.mesh_prefix.as_deref().unwrap_or_default()),
        width,
        solid: Solid::of(loops, width, density),
    };
    let text = gripper.write().map_err(|error| error.to_string())?;
    let path = file.with_file_name(&beside);
    let description = files.output(file, "--output").map_err(|error| error.to_string())?;
    let solid = files.output(&path, "the finger's solid").map_err(|error| error.to_string())?;
    solid.write(mesh).map_err(|error| error.to_string())?;
    description.write(text.as_bytes()).map_err(|error| error.to_string())?;
    let grams = 1e3 * gripper.solid.mass;
    put_out(&format!("{}, {}: {fingers} finger{} of {grams:.1} g\n", file.display(), path.display(), plural(fingers)))
}

fn plural(count: u8) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// What a case says of the joint and of the other finger.
struct Surroundings {
    motion: Motion,
    /// deg or mm.
    range: [f64; 2],
    /// mm.
    gap: Option<f64>,
}

impl Surroundings {
    fn of(path: &Path, described: &Described) -> Result<Self, String> {
        if let Some(Case { object, path, .. }) = described.case().map_err(|error| error.to_string())? {
            let range = path.places.iter().fold([0.0_f64; 2], |[low, high], place| [low.min(*place), high.max(*place)]);
            // The object is midway between opposite fingers.
            let gap = object.reference().map(|([x, _], _)| 2.0 * x).filter(|gap| *gap > 0.0);
            return Ok(Self { motion: path.motion, range, gap });
        }
        let motor = described.keys.motor.as_ref().ok_or_else(|| {
            format!("{}: motor.axis_mm is missing, and no motion says how the finger is moved", path.display())
        })?;
        Ok(Self { motion: Motion::Rotating { axis: motor.axis_mm }, range: RANGE_DEG, gap: None })
    }
}
