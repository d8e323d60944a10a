//! Every bad object is refused with its line, key and what is allowed; one that stands in the finger is warned of.

use fre::case::Case;
use fre::study::overlap;
use fre::study::place::{At, Effort, Place};
use model_core::status::Status;

/// One corner more than there is room for.
const SIXTY_FIVE_CORNERS: &str = "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [\
    [0,0],[1,1],[2,4],[3,9],[4,16],[5,25],[6,36],[7,49],[8,64],[9,81],[10,100],[11,121],[12,144],[13,169],[14,196],\
    [15,225],[16,256],[17,289],[18,324],[19,361],[20,400],[21,441],[22,484],[23,529],[24,576],[25,625],[26,676],[27,729],\
    [28,784],[29,841],[30,900],[31,961],[32,1024],[33,1089],[34,1156],[35,1225],[36,1296],[37,1369],[38,1444],[39,1521],\
    [40,1600],[41,1681],[42,1764],[43,1849],[44,1936],[0,1936],[-1,1935],[-2,1934],[-3,1933],[-4,1932],[-5,1931],\
    [-6,1930],[-7,1929],[-8,1928],[-9,1927],[-10,1926],[-11,1925],[-12,1924],[-13,1923],[-14,1922],[-15,1921],\
    [-16,1920],[-17,1919],[-18,1918],[-19,1917]]";

/// An object's lines below `[object]`, which is a case's second; the line and key that the error must name, and a piece of its words.
const OBJECTS: &[(&str, usize, &str, &str)] = &[
    ("shape = \"ellipse\"", 2, "object.centre_mm", "is missing; needed is [x, y]"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]", 2, "object.semi_axes_mm", "is missing"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = 40", 5, "object.semi_axes_mm", "needed is [a, b]"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [1, 2, 3]", 5, "object.semi_axes_mm", "has 3"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, 0]", 5, "object.semi_axes_mm[1]", "0.1 to 1000"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, -3]", 5, "object.semi_axes_mm[1]", "0.1 to 1000"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, nan]", 5, "object.semi_axes_mm[1]", "finite"),
    ("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, 1]", 5, "object.semi_axes_mm", "0.025 mm"),
    (
        "shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, 20]\nangle_deg = 400",
        6,
        "object.angle_deg",
        "allowed is -360 to 360 degrees",
    ),
    (
        "shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, 20]\nangle_deg = \"45\"",
        6,
        "object.angle_deg",
        "is a text",
    ),
    ("shape = \"ellipse\"\ncentre_mm = [9e9, 60]\nsemi_axes_mm = [40, 20]", 4, "object.centre_mm[0]", "-2000 to 2000"),
    ("shape = \"ellipse\"\nangle_rad = 1", 4, "object.angle_rad", "unknown key"),
    ("shape = \"polygon\"", 2, "object.corners_mm", "in order around the object"),
    ("shape = \"polygon\"\ncorners_mm = [[30, 30], [60, 30], [60, 60]]", 2, "object.rounding_mm", "is missing"),
    ("shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [30, 30]", 5, "object.corners_mm[0]", "needed is [x, y]"),
    ("shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [[30]]", 5, "object.corners_mm[0]", "has 1 entries"),
    ("shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = []", 5, "object.corners_mm", "is empty"),
    (SIXTY_FIVE_CORNERS, 5, "object.corners_mm", "has 65 entries; at most 64"),
    (
        "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [\n[30, 30],\n[60, 3e9]]",
        7,
        "object.corners_mm[1][1]",
        "-2000 to 2000",
    ),
    ("shape = \"polygon\"\nrounding_mm = 0\ncorners_mm = [[30, 30]]", 4, "object.rounding_mm", "0.1 to 1000"),
    (
        "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [[30, 30], [60, 30],\n [30, 30]]",
        6,
        "object.corners_mm[2]",
        "the same as another corner",
    ),
    (
        "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [[30, 30], [60, 30],\n [40, 35], [60, 60]]",
        6,
        "object.corners_mm[2]",
        "not convex",
    ),
    // A corner on a straight edge is no corner.
    (
        "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [[30, 30], [45, 30], [60, 30], [60, 60]]",
        5,
        "object.corners_mm[1]",
        "not convex",
    ),
    // A star turns the same way everywhere, but twice round.
    (
        "shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = [[10, 0], [-8, 6], [3, -10], [3, 10], [-8, -6]]",
        5,
        "object.corners_mm[3]",
        "not convex",
    ),
    ("shape = \"half-plane\"", 2, "object.point_mm", "is missing"),
    ("shape = \"half-plane\"\npoint_mm = [1, 0]", 2, "object.normal", "out of the object"),
    ("shape = \"half-plane\"\npoint_mm = [1, 0]\nnormal = [0, 0]", 5, "object.normal", "no length"),
    ("shape = \"half-plane\"\npoint_mm = [1, 0]\nnormal = [-1, 0, 0]", 5, "object.normal", "has 3 entries"),
    ("shape = \"half-plane\"\npoint_mm = [1, 0]\nnormal = [inf, 0]", 5, "object.normal[0]", "finite"),
    ("shape = \"half-plane\"\npoint_mm = [1, -1e5]\nnormal = [-1, 0]", 4, "object.point_mm[1]", "-2000 to 2000"),
    ("shape = \"half-plane\"\npoint_mm = [1, 0]\nnormal = [-1, 0]\nangle_deg = 3", 6, "object.angle_deg", "normal"),
];

/// A case with an object of these lines.
fn with_object(lines: &str) -> String {
    format!("finger = \"preset:ladder-80\"\n[object]\n{lines}\n[motion]\nmotor_angles_deg = [6]\n")
}

#[test]
fn every_bad_object_names_line_and_key() {
    let mut wrong = Vec::new();
    for &(object, line, key, words) in OBJECTS {
        match Case::parse("bad.toml", &with_object(object)) {
            Ok(_) => wrong.push(format!("{object:?} was accepted")),
            Err(error) => {
                let message = error.to_string();
                if error.line() != Some(line) || error.key() != Some(key) || !message.contains(words) {
                    wrong.push(format!("{object:?} (line {line}, key {key}, {words:?}) gave: {message}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), OBJECTS.len(), wrong.join("\n"));
}

#[test]
fn an_object_that_stands_in_the_finger_is_warned_of() {
    let warned = |object: &str| {
        let case = Case::parse("case.toml", &with_object(object)).unwrap();
        let run = fre::study::run::solve(&case, &Default::default()).unwrap();
        run.warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let circle = |x: f64, y: f64| format!("shape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [{x:?}, {y:?}]");
    for clear in [circle(41.0, 45.0), circle(41.0, 70.0), circle(300.0, 0.0)] {
        assert_eq!(warned(&clear), Vec::<String>::new(), "{clear}");
    }
    // A sign forgotten: the finger would have to come from behind and be laid over.
    for inside in [circle(0.0, 40.0), circle(-10.0, 40.0)] {
        let told = warned(&inside).join("\n");
        assert!(told.contains("the object reaches") && told.contains("check where"), "{inside}: {told:?}");
    }
}

/// In a deep grasp the object is where the back beam is at rest. That matters where the solver says that the case is at fault.
#[test]
fn a_failure_of_the_solver_is_no_overlap() {
    let grasp = "shape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 60.0]";
    let case = Case::parse("case.toml", &with_object(grasp)).unwrap();
    let depth = |status: Status| {
        let (at, effort) = (At::Angle(12.0), Effort::default());
        let place = Place { at, time_s: None, status, effort, branch: None, overlap_mm: None, state: None };
        overlap::depth(&case, &place)
    };
    for status in [Status::Stagnated, Status::Unsettled, Status::MaxIterations, Status::Folded, Status::Precision] {
        assert_eq!(depth(status), None, "{status}");
    }
    assert!(depth(Status::OutOfRange).is_some_and(|depth| (14.0..15.0).contains(&depth)));
}
