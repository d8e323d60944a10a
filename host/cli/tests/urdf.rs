//! `fre finger export --format urdf`, read by a URDF parser and a mesh reader: frames and motion against the solver's, masses and inertia
//! against the mesh's own.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use fre::case::Case;
use model_core::object::Motion;
use urdf_rs::{Geometry, JointType, Pose, Robot};

fn fre(folder: &Path, words: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(words.split_whitespace()).current_dir(folder).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const FINGER: &str = "width_mm = 20\nmaterial = { youngs_modulus_pa = 1e7, poissons_ratio = 0.4 }\n\
    front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
    back = { base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = 2 }\n\
    lamellae = { heights_mm = [15, 30, 45], thickness_mm = 3.0 }\n\
    hinge = { kind = \"flexible\", length_mm = 2.5, thickness_mm = 0.8, from = \"face\" }\n";
const MOTOR: &str = "motor = { axis_mm = [-14, -20] }\n";
const OBJECT: &str = "[object]\nshape = \"circle\"\nradius_mm = 30\ncentre_mm = [41, 45]\n[motion]\n";

/// A folder with cases of a turned and of a moved finger, and with a finger file.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    write("finger.toml", format!("{FINGER}{MOTOR}"));
    write("jaw.toml", FINGER.to_owned());
    write("turned.toml", format!("finger = \"finger.toml\"\n{OBJECT}motor_angles_deg = [-3, 6, 12]\n"));
    write("moved.toml", format!("finger = \"jaw.toml\"\n{OBJECT}direction = [0.6, 0.8]\ndistances_mm = [5, 15]\n"));
    folder
}

fn export(folder: &Path, words: &str) -> Robot {
    let output = fre(folder, &format!("finger export {words} --output gripper.urdf --force"));
    assert!(output.status.success(), "{words}: {}", said(&output));
    urdf_rs::read_file(folder.join("gripper.urdf")).unwrap()
}

type Point = [f64; 3];

/// A rotation and what comes after it.
#[derive(Clone, Copy)]
struct Frame([Point; 3], Point);

impl Frame {
    const FIXED: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);

    /// About a unit vector.
    fn about([x, y, z]: Point, angle: f64) -> Self {
        let (s, c) = angle.sin_cos();
        let v = 1.0 - c;
        let rows = [
            [x * x * v + c, x * y * v - z * s, x * z * v + y * s],
            [y * x * v + z * s, y * y * v + c, y * z * v - x * s],
            [z * x * v - y * s, z * y * v + x * s, z * z * v + c],
        ];
        Self(rows, [0.0; 3])
    }

    fn of(pose: &Pose) -> Self {
        let [roll, pitch, yaw] = pose.rpy.0;
        let about = |axis: usize, angle| Self::about([0, 1, 2].map(|i| f64::from(u8::from(i == axis))), angle);
        Self(about(2, yaw).then(&about(1, pitch)).then(&about(0, roll)).0, pose.xyz.0)
    }

    fn vector(&self, v: Point) -> Point {
        self.0.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    fn point(&self, p: Point) -> Point {
        let turned = self.vector(p);
        [0, 1, 2].map(|i| turned[i] + self.1[i])
    }

    fn then(&self, other: &Self) -> Self {
        let columns = [0, 1, 2].map(|j| self.vector([0, 1, 2].map(|i| other.0[i][j])));
        Self([0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i])), self.point(other.1))
    }
}

/// Where a link is, with every joint at this value.
fn link(robot: &Robot, name: &str, value: f64) -> Frame {
    let Some(joint) = robot.joints.iter().find(|joint| joint.child.link == name) else { return Frame::FIXED };
    let parent = link(robot, &joint.parent.link, value).then(&Frame::of(&joint.origin));
    let axis = joint.axis.xyz.0;
    match joint.joint_type {
        JointType::Fixed => parent,
        JointType::Revolute => parent.then(&Frame::about(axis, value)),
        JointType::Prismatic => parent.then(&Frame(Frame::FIXED.0, axis.map(|x| value * x))),
        ref other => panic!("{other:?}"),
    }
}

fn near(what: &str, found: &[f64], wanted: &[f64], within: f64) {
    let far = found.iter().zip(wanted).any(|(a, b)| (a - b).abs() > within);
    assert!(found.len() == wanted.len() && !far, "{what}: {found:?} instead of {wanted:?}");
}

/// The motion of a mesh's points is that of the solver's finger, in the frame that forces are given in.
#[test]
fn a_finger_moves_as_the_solver_has_it() {
    let folder = folder();
    for (case, value) in [("turned.toml", 9f64.to_radians()), ("moved.toml", 12.0)] {
        let robot = export(folder.path(), case);
        let case = Case::read(&folder.path().join(case)).unwrap();
        let to_finger = case.path.motion.world_to_finger::<f64>(value);
        let is_turned = matches!(case.path.motion, Motion::Rotating { .. });
        let value = if is_turned { value } else { 1e-3 * value };
        let finger = link(&robot, "finger_0_base", value);
        // What a point of the mesh is in the still frame of its finger.
        let moving = &robot.joints.iter().find(|joint| joint.name == "finger_0_joint").unwrap();
        assert_eq!(moving.parent.link, "finger_0_base");
        let visual = robot.links.iter().find(|link| link.name == "finger_0").unwrap().visual[0].origin.clone();
        let in_gripper = link(&robot, "finger_0", value).then(&Frame::of(&visual));
        for point in [[0.0, 80.0], [-28.0, 0.0], [1.0, 33.0]] {
            let world = to_finger.point_back(point.into());
            let wanted = finger.point([1e-3 * world.x, 1e-3 * world.y, 0.0]);
            let found = in_gripper.point([1e-3 * point[0], 1e-3 * point[1], 0.01]);
            near("a point of the mesh's middle plane", &found, &wanted, 1e-12);
        }
    }
}

#[test]
fn fingers_are_around_the_axis_and_close_towards_it() {
    let folder = folder();
    for (count, options) in [(2, ""), (3, "--fingers 3 --mimic"), (4, "--fingers 4")] {
        let robot = export(folder.path(), &format!("turned.toml {options}"));
        let moving: Vec<_> = robot.joints.iter().filter(|joint| joint.joint_type == JointType::Revolute).collect();
        assert_eq!((moving.len(), robot.links.len()), (count, 1 + 2 * count));
        for (number, joint) in moving.iter().enumerate() {
            assert_eq!(joint.name, format!("finger_{number}_joint"));
            near("range", &[joint.limit.lower, joint.limit.upper], &[-3f64.to_radians(), 12f64.to_radians()], 1e-12);
            assert!(joint.limit.effort > 0.0 && joint.limit.velocity > 0.0);
            let followed = joint.mimic.as_ref().map(|mimic| mimic.joint.as_str());
            assert_eq!(followed, (options.contains("mimic") && number > 0).then_some("finger_0_joint"));
            let base = link(&robot, &format!("finger_{number}_base"), 0.0);
            let turn = 2.0 * PI * number as f64 / count as f64;
            let out = [0.0, turn.cos(), turn.sin()];
            near("base", &base.1, &out.map(|x| 0.041 * x), 1e-12);
            near("x to the object", &base.vector([1.0, 0.0, 0.0]), &out.map(|x| -x), 1e-12);
            near("y to the tips", &base.vector([0.0, 1.0, 0.0]), &[1.0, 0.0, 0.0], 1e-12);
            // The object of the case is on the axis.
            near("object", &base.point([0.041, 0.045, 0.0]), &[0.045, 0.0, 0.0], 1e-12);
            let tip = |value| {
                let [_, y, z] = link(&robot, &format!("finger_{number}"), value).point([0.014, 0.1, 0.0]);
                y.hypot(z)
            };
            assert!(tip(0.2) < tip(0.0) - 0.01, "a positive angle closes");
        }
    }
    let alone = export(folder.path(), "finger.toml --fingers 1 --range -5:20 --mesh-prefix package://hand/meshes/");
    assert_eq!((alone.links.len(), alone.joints.len()), (2, 1));
    near(
        "range",
        &[alone.joints[0].limit.lower, alone.joints[0].limit.upper].map(f64::to_degrees),
        &[-5.0, 20.0],
        1e-9,
    );
    let Geometry::Mesh { filename, scale } = &alone.links[1].visual[0].geometry else { panic!("a mesh") };
    assert_eq!((filename.as_str(), scale.unwrap().0), ("package://hand/meshes/gripper_finger.stl", [1e-3; 3]));
}

/// Volume, centre and moments of a mesh are sums over its tetrahedra with the origin: another way than that of the outline.
#[test]
fn mass_and_inertia_are_those_of_the_mesh() {
    let folder = folder();
    let robot = export(folder.path(), "turned.toml --density-kg-per-m3 1100");
    let link = robot.links.iter().find(|link| link.name == "finger_1").unwrap();
    let at = Frame::of(&link.visual[0].origin);
    let mut file = fs::File::open(folder.path().join("gripper_finger.stl")).unwrap();
    let mesh = stl_io::read_stl(&mut file).unwrap();
    mesh.validate().unwrap();
    let corner = |index: usize| at.point(mesh.vertices[index].0.map(|x| 1e-3 * f64::from(x)));
    let (mut volume, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for face in &mesh.faces {
        let [a, b, c] = face.vertices.map(corner);
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let six = a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2];
        volume += six / 6.0;
        for i in 0..3 {
            let sum = [a, b, c].map(|p| p[i]).iter().sum::<f64>();
            first[i] += six * sum / 24.0;
            for j in 0..3 {
                let other = [a, b, c].map(|p| p[j]).iter().sum::<f64>();
                let same: f64 = [a, b, c].iter().map(|p| p[i] * p[j]).sum();
                second[i][j] += six * (sum * other + same) / 120.0;
            }
        }
    }
    let (mass, centre) = (1100.0 * volume, first.map(|moment| moment / volume));
    near("mass", &[link.inertial.mass.value], &[mass], 1e-6 * mass);
    near("centre", &link.inertial.origin.xyz.0, &centre, 1e-7);
    let about = |i: usize, j: usize| 1100.0 * (second[i][j] - volume * centre[i] * centre[j]);
    let found = &link.inertial.inertia;
    let moments = [about(1, 1) + about(2, 2), about(0, 0) + about(2, 2), about(0, 0) + about(1, 1)];
    let most = moments[0].max(moments[2]);
    near("moments", &[found.ixx, found.iyy, found.izz], &moments, 1e-5 * most);
    near("products", &[found.ixy, found.ixz, found.iyz], &[-about(0, 1), -about(0, 2), -about(1, 2)], 1e-5 * most);
    assert!(about(0, 1).abs() > 0.01 * most, "this finger has a product of inertia");
    // A finger of 8 cm that is mostly air.
    assert!((0.005..0.05).contains(&mass), "{mass} kg");
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let folder = folder();
    let mut refusals = String::new();
    for words in [
        "turned.toml --fingers 5 --output a.urdf",
        "turned.toml --gap-mm=-1 --output a.urdf",
        "turned.toml --range 9:3 --output a.urdf",
        "turned.toml --range 9 --output a.urdf",
        "turned.toml --density-kg-per-m3 0 --output a.urdf",
        "turned.toml --mesh-prefix a&b --output a.urdf",
        "turned.toml --format urdf",
        "turned.toml --mimic --output a.stl",
        "finger.toml --output a.urdf",
        "jaw.toml --gap-mm 80 --output a.urdf",
    ] {
        let output = fre(folder.path(), &format!("finger export {words}"));
        assert_eq!(output.status.code(), Some(1), "{words}: {}", said(&output));
        refusals += &format!("$ fre finger export {words}\n{}\n", said(&output));
        let is_new = |entry: fs::DirEntry| entry.file_name().to_string_lossy().starts_with("a");
        assert!(!fs::read_dir(folder.path()).unwrap().any(|entry| is_new(entry.unwrap())), "{words}");
    }
    // A mesh that is there is kept, and then there is no description without one.
    fs::write(folder.path().join("a_finger.stl"), "mine").unwrap();
    let output = fre(folder.path(), "finger export turned.toml --output a.urdf");
    assert_eq!(output.status.code(), Some(1));
    refusals += &format!("$ fre finger export turned.toml --output a.urdf\n{}\n", said(&output));
    snapbox::assert_data_eq!(refusals, snapbox::file!["words/urdf.txt"].raw());
    assert!(!folder.path().join("a.urdf").exists());
    assert_eq!(fs::read_to_string(folder.path().join("a_finger.stl")).unwrap(), "mine");
}

/// Programs of others: the parser of ROS for Python, and trimesh.
#[cfg(feature = "python")]
#[test]
fn other_programs_read_the_description_and_its_mesh() {
    let folder = folder();
    export(folder.path(), "turned.toml --mimic");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/urdf.py");
    let python = test_bus::python_with("urdf_parser_py, trimesh");
    let output = Command::new(python).arg(script).arg(folder.path().join("gripper.urdf")).output().unwrap();
    assert!(output.status.success(), "{}{}", String::from_utf8_lossy(&output.stdout), said(&output));
}
