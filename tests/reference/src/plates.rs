//! `plates.csv`: spans of a wall between ribs, bent, by finite elements in three dimensions (CalculiX).
//!
//! A quarter of one pitch of a wall with ribs on one side: symmetric about the rib's middle, the span's middle and the middle of the width.
//! The span's middle turns as a plane, without a force along the wall. All lengths are in thicknesses of the wall. The factor is the moment
//! per width over that of a thin slice of the same mesh, which is in plane stress.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::string::String;
use std::vec::Vec;
use std::{env, format, fs};

use model_core::discretise::Plate;

/// Height of the ribs.
const HEIGHT: f64 = 10.0;
/// Thickness of the slice in plane stress.
const SLICE: f64 = 1e-3;
/// Modulus, MPa: large, as CalculiX prints few digits of small forces.
const MODULUS: f64 = 1e3;
/// Name of the job.
const JOB: &str = "plate";

/// A span between ribs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Width.
    pub width: f64,
    /// Clear length between the ribs.
    pub clear: f64,
    /// Thickness of the ribs.
    pub rib: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Curvature; 0 for a linear solution.
    pub curvature: f64,
}

impl Span {
    /// The same as the model has it, with a wall of 1 mm.
    pub fn plate(&self) -> Plate {
        Plate { width: self.width, thickness: 1.0, clear: self.clear, holders: [self.rib; 2] }
    }

    /// The factor by the model's formula.
    pub fn formula(&self) -> f64 {
        1.0 + self.plate().share(self.nu) * self.nu * self.nu / (1.0 - self.nu * self.nu)
    }

    /// The factor by finite elements.
    ///
    /// # Errors
    /// What went wrong with the files or CalculiX (`ccx`).
    pub fn elements(&self, folder: &Path) -> Result<f64, String> {
        Ok(self.moment(folder, self.width)? / self.moment(folder, SLICE)?)
    }

    /// Moment per width of the wall or of a slice of it.
    fn moment(&self, folder: &Path, width: f64) -> Result<f64, String> {
        let mesh = Mesh::new(self, width);
        let io = |error: std::io::Error| format!("{}: {error}", folder.display());
        fs::write(folder.join(format!("{JOB}.inp")), self.deck(&mesh)).map_err(io)?;
        let run = Command::new("ccx").arg(JOB).current_dir(folder).env("OMP_NUM_THREADS", "1").output().map_err(io)?;
        let printed = fs::read_to_string(folder.join(format!("{JOB}.dat"))).map_err(io)?;
        let [mut forces, mut moves] = [HashMap::new(), HashMap::new()];
        let mut are_forces = false;
        for line in printed.lines().filter(|line| !line.trim().is_empty()) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let numbers = words.iter().map(|word| word.parse::<f64>()).collect::<Result<Vec<f64>, _>>();
            match numbers.as_deref() {
                Ok(&[node, x, _, z]) => {
                    if are_forces {
                        forces.insert(node as usize, x)
                    } else {
                        moves.insert(node as usize, z)
                    };
                }
                _ => are_forces = line.contains("forces"),
            }
        }
        if forces.is_empty() {
            return Err(format!("{self:?}: CalculiX ended without forces: {}", String::from_utf8_lossy(&run.stdout)));
        }
        let moment: f64 = forces.iter().map(|(node, x)| x * (mesh.points[node - 1][2] + moves[node])).sum();
        Ok(moment / (0.5 * width))
    }

    fn deck(&self, mesh: &Mesh) -> String {
        let mut out = String::from("*NODE,NSET=NALL\n");
        let mut put = |text: core::fmt::Arguments<'_>| {
            // Writing to a string cannot fail.
            let _ = out.write_fmt(text);
        };
        for (n, [x, y, z]) in mesh.points.iter().enumerate() {
            put(format_args!("{},{x:.9},{y:.9},{z:.9}\n", n + 1));
        }
        // Two more: how far the middle moves along the wall, and its turn.
        let [along, turn] = [mesh.points.len() + 1, mesh.points.len() + 2];
        put(format_args!("{along},0.,0.,0.\n{turn},0.,0.,0.\n*ELEMENT,TYPE=C3D20,ELSET=E\n"));
        for (n, element) in mesh.elements.iter().enumerate() {
            put(format_args!("{}", n + 1));
            for (k, node) in element.iter().enumerate() {
                put(format_args!(",{}{}", if k == 15 { "\n" } else { "" }, node + 1));
            }
            put(format_args!("\n"));
        }
        put(format_args!(
            "*MATERIAL,NAME=M\n*ELASTIC\n{MODULUS},{}\n*SOLID SECTION,ELSET=E,MATERIAL=M\n*BOUNDARY\n",
            self.nu
        ));
        let is_at = |value: f64, place: f64| (value - place).abs() < 1e-9;
        for (n, [x, y, _]) in mesh.points.iter().enumerate() {
            if is_at(*x, 0.0) {
                put(format_args!("{},1,1\n", n + 1));
            }
            if is_at(*y, 0.0) {
                put(format_args!("{},2,2\n", n + 1));
            }
        }
        put(format_args!("{},3,3\n{along},2,3\n{turn},2,3\n*EQUATION\n", mesh.corner + 1));
        let half = mesh.half;
        let angle = if self.curvature == 0.0 { 1e-4 } else { self.curvature * half };
        let (sin, cos) = if self.curvature == 0.0 { (angle, 1.0) } else { angle.sin_cos() };
        for (n, [x, _, z]) in mesh.points.iter().enumerate().filter(|(_, p)| is_at(p[0], half)) {
            // Normal displacement in the plane's last position.
            let terms = [(n + 1, 1, cos), (n + 1, 3, if cos < 1.0 { sin } else { 0.0 }), (along, 1, -1.0)];
            let last = (turn, 1, (cos - 1.0) * x + sin * z);
            let terms: Vec<_> = terms.into_iter().chain([last]).filter(|term| term.2.abs() > 1e-14).collect();
            put(format_args!("{}\n", terms.len()));
            for (node, axis, factor) in terms {
                put(format_args!("{node},{axis},{factor:.12},"));
            }
            put(format_args!("\n"));
        }
        put(format_args!("*NSET,NSET=NRIB\n"));
        for (n, _) in mesh.points.iter().enumerate().filter(|(_, p)| is_at(p[0], 0.0)) {
            put(format_args!("{},\n", n + 1));
        }
        let (step, size) = if self.curvature == 0.0 { ("", "") } else { (",NLGEOM,INC=200", "0.5,1.,1e-4,1.\n") };
        put(format_args!(
            "*STEP{step}\n*STATIC\n{size}*BOUNDARY\n{turn},1,1,1.\n*NODE PRINT,NSET=NRIB,FREQUENCY=1000\nU,RF\n*END STEP\n"
        ));
        out
    }
}

/// Elements of twenty nodes on a grid.
struct Mesh {
    points: Vec<[f64; 3]>,
    elements: Vec<[usize; 20]>,
    /// The node below the rib, at the middle of the width.
    corner: usize,
    /// Half the pitch.
    half: f64,
}

/// Places of an element's nodes in half elements.
const NODES: [[usize; 3]; 20] = [
    [0, 0, 0],
    [2, 0, 0],
    [2, 2, 0],
    [0, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [2, 2, 2],
    [0, 2, 2],
    [1, 0, 0],
    [2, 1, 0],
    [1, 2, 0],
    [0, 1, 0],
    [1, 0, 2],
    [2, 1, 2],
    [1, 2, 2],
    [0, 1, 2],
    [0, 0, 1],
    [2, 0, 1],
    [2, 2, 1],
    [0, 2, 1],
];

/// Lines of a grid over a length, whose distances grow from the first size to the last.
fn graded(length: f64, first: f64, end: f64, most: f64) -> Vec<f64> {
    let mut lines = std::vec![0.0];
    let mut at = 0.0;
    while at < length - 1e-12 {
        at += (first + 0.4 * at).min(most).min(end.max(end + 0.3 * (length - at - end)));
        lines.push(at);
    }
    lines.iter().map(|line| line * length / at).collect()
}

impl Mesh {
    fn new(span: &Span, width: f64) -> Self {
        let root = 0.5 * span.rib;
        let half = root + 0.5 * span.clear;
        let mut x = std::vec![0.0, 0.5 * root];
        x.extend(graded(0.5 * span.clear, 0.3, 0.5, 0.8).iter().map(|line| root + line));
        let y: Vec<f64> = if width == SLICE {
            std::vec![0.0, 0.5 * width]
        } else {
            graded(0.5 * width, 0.25, 1.0, 1.2).iter().rev().map(|line| 0.5 * width - line).collect()
        };
        let mut z = std::vec![-0.5, -1.0 / 6.0, 1.0 / 6.0];
        z.extend(graded(HEIGHT, 0.3, 1.2, 1.2).iter().map(|line| 0.5 + line));
        let mut mesh = Self { points: Vec::new(), elements: Vec::new(), corner: 0, half };
        let mut known: HashMap<[usize; 3], usize> = HashMap::new();
        let at = |lines: &[f64], k: usize| {
            if k.is_multiple_of(2) { lines[k / 2] } else { 0.5 * (lines[k / 2] + lines[k / 2 + 1]) }
        };
        for i in 0..x.len() - 1 {
            for j in 0..y.len() - 1 {
                for k in 0..z.len() - 1 {
                    // Above the wall there is the rib.
                    if k >= 3 && i >= 2 {
                        continue;
                    }
                    mesh.elements.push(NODES.map(|node| {
                        let place = [2 * i + node[0], 2 * j + node[1], 2 * k + node[2]];
                        *known.entry(place).or_insert_with(|| {
                            mesh.points.push([at(&x, place[0]), at(&y, place[1]), at(&z, place[2])]);
                            mesh.points.len() - 1
                        })
                    }));
                }
            }
        }
        mesh.corner = known[&[0, 0, 0]];
        mesh
    }
}

/// Rows of the series: the span, the factor by finite elements, and whether the formula's constants were chosen with it.
///
/// # Panics
/// On a malformed file: the data are part of the tests.
pub fn spans() -> impl Iterator<Item = (Span, f64, bool)> {
    let mut lines = include_str!("../plates.csv").lines();
    let header = lines.next().expect("plates.csv has a header");
    assert!(header.starts_with("width,clear,rib,nu,curvature,factor"), "unexpected header {header}");
    lines.map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|field| field.parse().expect("a number")).collect();
        let [width, clear, rib, nu, curvature, factor] = numbers.try_into().expect("six columns");
        let fitted = nu == 0.45 && [2.0, 8.0, 32.0].contains(&clear) && curvature == 0.0;
        (Span { width, clear, rib, nu, curvature }, factor, fitted)
    })
}

/// A folder for CalculiX's files.
///
/// # Errors
/// If it cannot be made.
pub fn folder() -> Result<std::path::PathBuf, String> {
    let folder = env::temp_dir().join(format!("fre-plates-{}", std::process::id()));
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    Ok(folder)
}
