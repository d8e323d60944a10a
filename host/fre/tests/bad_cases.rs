//! Every bad case file is refused with its file, line, key, value and what is allowed.

use fre::case::{Case, CaseError, read_finger};

/// A good case; the bad ones change one piece of it.
const GOOD: &str = r#"[finger]
name = "test"
width_mm = 20.0
plane_strain = "stress"

[finger.material]
youngs_modulus_pa = 4.95e7
poissons_ratio = 0.48

[finger.front]
base_mm = [0.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0

[finger.back]
base_mm = [-28.0, 0.0]
tip_mm = [0.0, 80.0]
thickness_mm = 2.0
stiffness_factor = 1.0

[finger.lamellae]
heights_mm = [
  9,
  18,
  27,
]
thickness_mm = 3.0

[finger.hinge]
kind = "flexible"
length_mm = 2.5
thickness_mm = 0.8
from = "centreline"

[finger.tip]
rigid_above_mm = 74.0

[finger.motor]
axis_mm = [-14.0, -20.0]

[object]
shape = "circle"
radius_mm = 40.0
centre_mm = [41.0, 60.0]

[motion]
motor_angles_deg = [6.0, 8]
"#;

/// One pair more than there is room for.
const SIXTY_FIVE_PAIRS: &str = "width_mm = [\
    [0,1],[1,1],[2,1],[3,1],[4,1],[5,1],[6,1],[7,1],[8,1],[9,1],[10,1],[11,1],[12,1],[13,1],[14,1],[15,1],[16,1],[17,1],\
    [18,1],[19,1],[20,1],[21,1],[22,1],[23,1],[24,1],[25,1],[26,1],[27,1],[28,1],[29,1],[30,1],[31,1],[32,1],[33,1],\
    [34,1],[35,1],[36,1],[37,1],[38,1],[39,1],[40,1],[41,1],[42,1],[43,1],[44,1],[45,1],[46,1],[47,1],[48,1],[49,1],\
    [50,1],[51,1],[52,1],[53,1],[54,1],[55,1],[56,1],[57,1],[58,1],[59,1],[60,1],[61,1],[62,1],[63,1],[64,1]]";
/// With the two before them one height more than there is room for.
const SIXTY_THREE_HEIGHTS: &str = "27,28,29,30,31,32,33,34,35,36,37,38,39,40,41,42,43,44,45,46,47,48,49,50,51,52,53,54,\
    55,56,57,58,59,60,61,62,63,64,65,66,67,68,69,70,71,72,73,74,75,76,77,78,79,80,81,82,83,84,85,86,87,88,89,";

/// What is replaced, by what; the line and key that the error must name, and a piece of its words.
type Change = (&'static str, &'static str, usize, &'static str, &'static str);

const CHANGES: &[Change] = &[
    // keys that mean nothing
    ("name = \"test\"", "nmae = \"test\"", 2, "finger.nmae", "unknown key"),
    ("name = \"test\"", "colour = 3", 2, "finger.colour", "width_mm"),
    ("[finger.motor]", "[finger.engine]", 38, "finger.engine", "unknown key"),
    ("poissons_ratio = 0.48", "poisson_ratio = 0.48", 8, "finger.material.poisson_ratio", "poissons_ratio"),
    ("stiffness_factor = 1.0", "stiffness = 1.0", 19, "finger.back.stiffness", "stiffness_factor"),
    ("kind = \"flexible\"", "type = \"flexible\"", 30, "finger.hinge.type", "kind"),
    ("rigid_above_mm = 74.0", "rigid_above = 74.0", 36, "finger.tip.rigid_above", "rigid_above_mm"),
    ("radius_mm = 40.0", "diameter_mm = 80.0", 43, "object.diameter_mm", "radius_mm"),
    ("[motion]", "[movement]", 46, "movement", "motion"),
    ("motor_angles_deg = [6.0, 8]", "motor_angles_rad = [0.1]", 47, "motion.motor_angles_rad", "motor_angles_deg"),
    // keys that are needed
    ("width_mm = 20.0\n", "\n", 1, "finger.width_mm", "is missing"),
    ("youngs_modulus_pa = 4.95e7\n", "\n", 6, "finger.material.youngs_modulus_pa", "Pa"),
    (
        "tip_mm = [0.0, 80.0]\nthickness_mm = 2.0\n\n[finger.back]",
        "\nthickness_mm = 2.0\n\n[finger.back]",
        10,
        "finger.front.tip_mm",
        "is missing",
    ),
    ("thickness_mm = 3.0\n", "\n", 21, "finger.lamellae.thickness_mm", "is missing"),
    ("length_mm = 2.5\n", "\n", 29, "finger.hinge.length_mm", "one per lamella"),
    ("axis_mm = [-14.0, -20.0]\n", "\n", 38, "finger.motor.axis_mm", "is missing"),
    ("[finger.motor]\naxis_mm = [-14.0, -20.0]\n", "\n\n", 47, "motion.motor_angles_deg", "motor.axis_mm"),
    ("shape = \"circle\"\n", "\n", 41, "object.shape", "circle"),
    ("radius_mm = 40.0\n", "\n", 41, "object.radius_mm", "is missing"),
    ("motor_angles_deg = [6.0, 8]\n", "\n", 46, "motion.motor_angles_deg", "is missing"),
    ("motor_angles_deg = [6.0, 8]", "direction = [1.0, 0.0]", 46, "motion.distances_mm", "is missing"),
    // wrong types
    ("name = \"test\"", "name = 3", 2, "finger.name", "is an integer; needed is a text"),
    ("width_mm = 20.0", "width_mm = \"20\"", 3, "finger.width_mm", "is a text; needed is a number"),
    ("width_mm = 20.0", "width_mm = true", 3, "finger.width_mm", "is true or false"),
    ("base_mm = [-28.0, 0.0]", "base_mm = -28.0", 16, "finger.back.base_mm", "needed is [x, y]"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [-28.0]", 16, "finger.back.base_mm", "has 1 entries"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [-28.0, \"0\"]", 16, "finger.back.base_mm[1]", "needed is a number"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [1, 2, 3]", 16, "finger.back.base_mm", "has 3 entries"),
    ("  18,", "  [18],", 24, "finger.lamellae.heights_mm[1]", "is an array; needed is a number"),
    ("[finger.tip]\nrigid_above_mm = 74.0\n", "[finger]\ntip = 74.0\n", 35, "", "not valid TOML"),
    ("centre_mm = [41.0, 60.0]", "centre_mm = 1979-05-27", 44, "object.centre_mm", "is a date"),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angles_deg = 6.0",
        47,
        "motion.motor_angles_deg",
        "needed is an array of degrees",
    ),
    // numbers out of range
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = -2.0\n\n[finger.back]",
        13,
        "finger.front.thickness_mm",
        "-2.0: allowed is 0.01 to 40 mm",
    ),
    ("width_mm = 20.0", "width_mm = 0", 3, "finger.width_mm", "allowed is 0.1 to 5000 mm"),
    ("width_mm = 20.0", "width_mm = nan", 3, "finger.width_mm", "finite"),
    ("width_mm = 20.0", "width_mm = [[0, 20.0], [40, -1.0]]", 3, "finger.width_mm[1][1]", "allowed is 0.1"),
    ("width_mm = 20.0", "width_mm = [[0, 20.0], [0, 10.0]]", 3, "finger.width_mm[1]", "larger than its predecessor"),
    ("width_mm = 20.0", "width_mm = []", 3, "finger.width_mm", "is empty"),
    ("width_mm = 20.0", SIXTY_FIVE_PAIRS, 3, "finger.width_mm", "has 65 entries; at most 64"),
    (
        "youngs_modulus_pa = 4.95e7",
        "youngs_modulus_pa = 49.5",
        7,
        "finger.material.youngs_modulus_pa",
        "allowed is 1e3 to 1e12 Pa",
    ),
    ("youngs_modulus_pa = 4.95e7", "youngs_modulus_pa = inf", 7, "finger.material.youngs_modulus_pa", "finite"),
    ("youngs_modulus_pa = 4.95e7", "youngs_modulus_pa = 1e999", 7, "finger.material.youngs_modulus_pa", "finite"),
    (
        "poissons_ratio = 0.48",
        "poissons_ratio = 0.48\nlaw = \"hookean\"",
        9,
        "finger.material.law",
        "\"st-venant-kirchhoff\", \"neo-hookean\"",
    ),
    ("poissons_ratio = 0.48", "poissons_ratio = 0.5", 8, "finger.material.poissons_ratio", "allowed is 0 to 0.499"),
    (
        "poissons_ratio = 0.48",
        "poissons_ratio = 0.48\nmax_strain = 0",
        9,
        "finger.material.max_strain",
        "to 10 (a share",
    ),
    (
        "poissons_ratio = 0.48",
        "poissons_ratio = 0.48\nmax_strain = 5e3",
        9,
        "finger.material.max_strain",
        "0.05 is 5 %",
    ),
    ("poissons_ratio = 0.48", "poissons_ratio = 0.48\nmax_strain = \"5 %\"", 9, "finger.material.max_strain", "a text"),
    ("stiffness_factor = 1.0", "stiffness_factor = 1.0\nsagitta_mm = 30.0", 20, "finger.back.sagitta_mm", "allowed is"),
    ("stiffness_factor = 1.0", "stiffness_factor = 0", 19, "finger.back.stiffness_factor", "allowed is 0.001 to 1000"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [3.0, 0.0]", 16, "finger.back.base_mm", "less than the front beam's 0"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [-28.0, 1e5]", 16, "finger.back.base_mm[1]", "allowed is -5000 to 5000 mm"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [-28.0, 90.0]", 17, "finger.back.tip_mm", "tenth"),
    (
        "base_mm = [-28.0, 0.0]\ntip_mm = [0.0, 80.0]",
        "base_mm = [-28.0, 0.0]\ntip_mm = [-28.0, 80.0]",
        17,
        "finger.back.tip_mm",
        "28 mm from front.tip_mm",
    ),
    ("  27,", "  81,", 25, "finger.lamellae.heights_mm[2]", "less than 74 mm"),
    ("  27,", "  17,", 25, "finger.lamellae.heights_mm[2]", "larger than its predecessor 18"),
    (
        "  27,",
        "  20,",
        25,
        "finger.lamellae.heights_mm[2]",
        "2 mm from the lamella below's; its thickness of 3 mm needs 3 mm",
    ),
    ("  9,", "  1,", 23, "finger.lamellae.heights_mm[0]", "1 mm from the base's; its thickness of 3 mm needs 1.5 mm"),
    ("  9,", "  0,", 23, "finger.lamellae.heights_mm[0]", "more than 0"),
    ("  9,", "  nan,", 23, "finger.lamellae.heights_mm[0]", "finite"),
    ("  27,", SIXTY_THREE_HEIGHTS, 22, "finger.lamellae.heights_mm", "has 65 entries; at most 64"),
    ("  27,\n]", "  27,\n]\nfront_arc_mm = [1]", 22, "finger.lamellae.heights_mm", "one or the other"),
    ("heights_mm", "front_arc_mm", 21, "finger.lamellae.back_arc_mm", "is missing"),
    ("heights_mm", "back_arc_mm = [9]\nfront_arc_mm", 22, "finger.lamellae.back_arc_mm", "as many"),
    ("length_mm = 2.5", "length_mm = [2.5, 2.5]", 31, "finger.hinge.length_mm", "one per lamella (3)"),
    ("length_mm = 2.5", "length_mm = [2.5, 12, 2.5]", 31, "finger.hinge.length_mm[1]", "lamella 2 (counted"),
    ("length_mm = 2.5", "length_mm = 0.0", 31, "finger.hinge.length_mm", "allowed is 0.01"),
    ("thickness_mm = 0.8", "thickness_mm = 1e-9", 32, "finger.hinge.thickness_mm", "allowed is 0.01"),
    ("kind = \"flexible\"", "kind = \"bendy\"", 30, "finger.hinge.kind", "\"flexible\", \"pinned\", \"welded\""),
    ("from = \"centreline\"", "from = \"center\"", 33, "finger.hinge.from", "\"centreline\", \"face\""),
    ("plane_strain = \"stress\"", "plane_strain = 1", 4, "finger.plane_strain", "is an integer"),
    ("rigid_above_mm = 74.0", "rigid_above_mm = 2.0", 36, "finger.tip.rigid_above_mm", "allowed is 8 to 5000 mm"),
    ("axis_mm = [-14.0, -20.0]", "axis_mm = [-14.0, -2e4]", 39, "finger.motor.axis_mm[1]", "allowed is -5000"),
    // A circle's keys mean nothing to other shapes.
    ("shape = \"circle\"", "shape = \"ellipse\"", 43, "object.radius_mm", "semi_axes_mm, angle_deg"),
    ("shape = \"circle\"", "shape = \"polygon\"", 43, "object.radius_mm", "corners_mm, rounding_mm"),
    ("shape = \"circle\"", "shape = \"half-plane\"", 43, "object.radius_mm", "point_mm, normal"),
    ("shape = \"circle\"", "shape = \"blob\"", 42, "object.shape", "\"polygon\""),
    ("radius_mm = 40.0", "radius_mm = -40.0", 43, "object.radius_mm", "allowed is 0.1 to 1000 mm"),
    ("centre_mm = [41.0, 60.0]", "centre_mm = [41.0, 6e9]", 44, "object.centre_mm[1]", "allowed is -2000"),
    ("motor_angles_deg = [6.0, 8]", "motor_angles_deg = []", 47, "motion.motor_angles_deg", "is empty"),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angles_deg = [6.0,\n 800]",
        48,
        "motion.motor_angles_deg[1]",
        "allowed is -180 to 180 degrees",
    ),
    ("motor_angles_deg = [6.0, 8]", "motor_angles_deg = [6.0, -nan]", 47, "motion.motor_angles_deg[1]", "finite"),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angles_deg = [6.0]\ndistances_mm = [1]",
        48,
        "motion.distances_mm",
        "one motion or the other",
    ),
    ("motor_angles_deg = [6.0, 8]", "direction = [0, 0]\ndistances_mm = [1]", 47, "motion.direction", "no length"),
    (
        "motor_angles_deg = [6.0, 8]",
        "direction = [1, 0]\ndistances_mm = [1e9]",
        48,
        "motion.distances_mm[0]",
        "allowed is -1000",
    ),
    // not TOML
    ("width_mm = 20.0", "width_mm = 20.0.0", 3, "", "not valid TOML"),
    ("width_mm = 20.0", "width_mm = 20.0\nwidth_mm = 21.0", 4, "", "not valid TOML"),
    ("[object]", "[object", 41, "", "not valid TOML"),
];

/// The same, of what people get wrong: near misses of names, other units, dimensions swapped or impossible, types, notations.
const SLIPS: &[Change] = &[
    ("width_mm = 20.0", "widht_mm = 20.0", 3, "finger.widht_mm", "did you mean width_mm?"),
    ("width_mm = 20.0", "width = 20.0", 3, "finger.width", "did you mean width_mm?"),
    ("width_mm = 20.0", "width_m = 0.02", 3, "finger.width_m", "did you mean width_mm?"),
    ("width_mm = 20.0", "Width_mm = 20.0", 3, "finger.Width_mm", "did you mean width_mm?"),
    (
        "youngs_modulus_pa = 4.95e7",
        "youngs_modulus_mpa = 49.5",
        7,
        "finger.material.youngs_modulus_mpa",
        "did you mean youngs_modulus_pa?",
    ),
    (
        "youngs_modulus_pa = 4.95e7",
        "E = 4.95e7",
        7,
        "finger.material.E",
        "unknown key; allowed here: youngs_modulus_pa",
    ),
    ("plane_strain = \"stress\"", "plane_stress = true", 4, "finger.plane_stress", "did you mean plane_strain?"),
    ("[finger.lamellae]", "[finger.lamella]", 21, "finger.lamella", "did you mean lamellae?"),
    ("[finger.hinge]", "[finger.hinges]", 29, "finger.hinges", "did you mean hinge?"),
    ("centre_mm = [41.0, 60.0]", "center_mm = [41.0, 60.0]", 44, "object.center_mm", "did you mean centre_mm?"),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angle_deg = [6.0, 8]",
        47,
        "motion.motor_angle_deg",
        "did you mean motor_angles_deg?",
    ),
    (
        "motor_angles_deg = [6.0, 8]",
        "direction = [1, 0]\ndistances_m = [0.005]",
        48,
        "motion.distances_m",
        "did you mean distances_mm?",
    ),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "count = 7",
        22,
        "finger.lamellae.count",
        "unknown key; allowed here: heights_mm",
    ),
    ("[motion]", "[solver]\nelements = \"8/2\"\n[motion]", 46, "solver", "allowed here: finger, object, motion"),
    ("youngs_modulus_pa = 4.95e7", "youngs_modulus_pa = 213", 7, "finger.material.youngs_modulus_pa", "1e3 to 1e12 Pa"),
    (
        "youngs_modulus_pa = 4.95e7",
        "youngs_modulus_pa = \"49.5 MPa\"",
        7,
        "finger.material.youngs_modulus_pa",
        "is a text; needed is a number",
    ),
    (
        "youngs_modulus_pa = 4.95e7",
        "youngs_modulus_pa = -4.95e7",
        7,
        "finger.material.youngs_modulus_pa",
        "1e3 to 1e12 Pa",
    ),
    ("poissons_ratio = 0.48", "poissons_ratio = 48", 8, "finger.material.poissons_ratio", "0 to 0.499"),
    ("poissons_ratio = 0.48", "poissons_ratio = -0.3", 8, "finger.material.poissons_ratio", "0 to 0.499"),
    ("width_mm = 20.0", "width_mm = 0.02", 3, "finger.width_mm", "0.1 to 5000 mm"),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = 0.002\n\n[finger.back]",
        13,
        "finger.front.thickness_mm",
        "0.01 to 40 mm",
    ),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = 2000\n\n[finger.back]",
        13,
        "finger.front.thickness_mm",
        "0.01 to 40 mm",
    ),
    ("radius_mm = 40.0", "radius_mm = 0.04", 43, "object.radius_mm", "0.1 to 1000 mm"),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "heights_mm = [0.009, 0.018, 0.027]",
        22,
        "finger.lamellae.heights_mm[0]",
        "needs 1.5 mm",
    ),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angles_deg = [366.0]",
        47,
        "motion.motor_angles_deg[0]",
        "-180 to 180 degrees",
    ),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = 36\n\n[finger.back]",
        13,
        "finger.front.thickness_mm",
        "reach into each other between lamella 2",
    ),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = [[0, 2], [27, 38]]\n\n[finger.back]",
        13,
        "finger.front.thickness_mm",
        "less than",
    ),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = [[0, 2], [80, 0]]\n\n[finger.back]",
        13,
        "finger.front.thickness_mm[1][1]",
        "0.01 to 40 mm",
    ),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = [0, 2, 80, 1]\n\n[finger.back]",
        13,
        "finger.front.thickness_mm[0]",
        "needed is a pair",
    ),
    (
        "thickness_mm = 2.0\n\n[finger.back]",
        "thickness_mm = [[40, 2], [0, 1]]\n\n[finger.back]",
        13,
        "finger.front.thickness_mm[1]",
        "larger than its predecessor",
    ),
    (
        "thickness_mm = 0.8",
        "thickness_mm = 9.5",
        24,
        "finger.lamellae.heights_mm[1]",
        "its hinges' thickness of 9.5 mm needs 9.5 mm",
    ),
    ("thickness_mm = 3.0", "thickness_mm = 30", 23, "finger.lamellae.heights_mm[0]", "needs 15 mm"),
    (
        "[finger.lamellae]\nheights_mm = [\n  9,\n  18,\n  27,\n]\nthickness_mm = 3.0\n",
        "",
        1,
        "finger.lamellae",
        "heights_mm = []",
    ),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "heights_mm = [9, 9, 9]",
        22,
        "finger.lamellae.heights_mm[1]",
        "larger than its predecessor 9",
    ),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "heights_mm = [-9, 18]",
        22,
        "finger.lamellae.heights_mm[0]",
        "more than 0",
    ),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "heights_mm = \"9, 18\"",
        22,
        "finger.lamellae.heights_mm",
        "an array of numbers",
    ),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "heights_mm = 9",
        22,
        "finger.lamellae.heights_mm",
        "an array of numbers",
    ),
    (
        "heights_mm = [\n  9,\n  18,\n  27,\n]",
        "front_arc_mm = [9, 40]\nback_arc_mm = [60, 61]",
        22,
        "finger.lamellae.front_arc_mm[1]",
        "1.3049 mm from the lamella below",
    ),
    ("length_mm = 2.5", "length_mm = 20", 31, "finger.hinge.length_mm", "24.85 mm wide, its two hinges need 40 mm"),
    ("length_mm = 2.5", "length_mm = []", 31, "finger.hinge.length_mm", "one for all or one per lamella (3)"),
    ("length_mm = 2.5", "length_mm = [[2.5, 2.5, 2.5]]", 31, "finger.hinge.length_mm[0]", "is an array"),
    ("rigid_above_mm = 74.0", "rigid_above_mm = 20.0", 25, "finger.lamellae.heights_mm[2]", "less than 20 mm"),
    (
        "tip_mm = [0.0, 80.0]\nthickness_mm = 2.0\n\n[finger.back]",
        "tip_mm = [0.0, 0.08]\nthickness_mm = 2.0\n\n[finger.back]",
        12,
        "finger.front.tip_mm",
        "0.08 mm above",
    ),
    ("base_mm = [0.0, 0.0]", "base_mm = [0.0, 160.0]", 12, "finger.front.tip_mm", "-80 mm above"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [0.0, 0.0]", 16, "finger.back.base_mm", "less than the front beam's 0"),
    ("stiffness_factor = 1.0", "sagitta_mm = nan", 19, "finger.back.sagitta_mm", "finite"),
    ("width_mm = 20.0", "width_mm = [20.0]", 3, "finger.width_mm[0]", "needed is a pair"),
    ("width_mm = 20.0", "width_mm = { base = 20 }", 3, "finger.width_mm", "is a table; needed is a number"),
    ("width_mm = 20.0", "width_mm = 2020-01-01", 3, "finger.width_mm", "is a date"),
    ("width_mm = 20.0", "width_mm = 99999999999999999999999999", 3, "finger.width_mm", "0.1 to 5000 mm"),
    ("width_mm = 20.0", "width_mm = 0xFFFFFFFFFFFFFFFFFF", 3, "finger.width_mm", "finite"),
    ("width_mm = 20.0", "width_mm = 1e-320", 3, "finger.width_mm", "0.1 to 5000 mm"),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angles_deg = \"0:1:8\"",
        47,
        "motion.motor_angles_deg",
        "is a text; needed is an array of degrees",
    ),
    (
        "motor_angles_deg = [6.0, 8]",
        "motor_angles_deg = [6.0, false]",
        47,
        "motion.motor_angles_deg[1]",
        "is true or false",
    ),
    (
        "motor_angles_deg = [6.0, 8]",
        "direction = [1, 0, 0]\ndistances_mm = [1]",
        47,
        "motion.direction",
        "has 3 entries",
    ),
    ("motor_angles_deg = [6.0, 8]", "distances_mm = [5]", 46, "motion.direction", "is missing"),
    (
        "[motion]\nmotor_angles_deg = [6.0, 8]",
        "[[motion]]\nmotor_angles_deg = [6.0, 8]",
        46,
        "motion",
        "is an array; needed is a table",
    ),
    ("[object]", "[[object]]", 41, "object", "is an array; needed is a table"),
    ("centre_mm = [41.0, 60.0]", "centre_mm = { x = 41, y = 60 }", 44, "object.centre_mm", "needed is [x, y] in mm"),
    ("shape = \"circle\"", "shape = \"Circle\"", 42, "object.shape", "\"circle\", \"ellipse\""),
    ("shape = \"circle\"", "shape = [\"circle\"]", 42, "object.shape", "is an array; needed is one of"),
    ("axis_mm = [-14.0, -20.0]", "axis_mm = \"-14,-20\"", 39, "finger.motor.axis_mm", "is a text"),
    (
        "poissons_ratio = 0.48",
        "poissons_ratio = 0,48",
        8,
        "",
        "(decimals have a point); the line is: poissons_ratio = 0,48",
    ),
    ("poissons_ratio = 0.48", "poisson's_ratio = 0.48", 8, "", "the line is: poisson's_ratio = 0.48"),
    ("width_mm = 20.0", "width_mm = 20 mm", 3, "", "the line is: width_mm = 20 mm"),
    ("width_mm = 20.0", "width_mm: 20.0", 3, "", "the line is: width_mm: 20.0"),
    ("width_mm = 20.0", "width_mm =", 3, "", "the line is: width_mm ="),
    ("width_mm = 20.0", "width_mm\u{a0}= 20.0", 3, "", "the line is: width_mm\\u{a0}= 20.0"),
    ("base_mm = [-28.0, 0.0]", "base_mm = [\u{2212}28.0, 0.0]", 16, "", "the line is: base_mm = ["),
    ("[finger.motor]", "[finger.material]", 38, "", "the line is: [finger.material]"),
    ("motor_angles_deg = [6.0, 8]", "motor_angles_deg = [6.0, 8", 47, "", "unclosed array"),
    ("name = \"test\"", "name = \"test", 2, "", "the line is: name = \"test"),
];

#[test]
fn the_good_case_is_good() {
    Case::parse("good.toml", GOOD).unwrap();
}

#[test]
fn every_bad_case_names_line_and_key() {
    let mut wrong = Vec::new();
    for &(old, new, line, key, words) in CHANGES.iter().chain(SLIPS) {
        assert_eq!(
            GOOD.matches(old).count(),
            if old == "thickness_mm = 2.0" { 2 } else { 1 },
            "change {old:?} is not unique"
        );
        let text = GOOD.replacen(old, new, 1);
        match Case::parse("bad.toml", &text) {
            Ok(_) => wrong.push(format!("{new:?} was accepted")),
            Err(error) => {
                let message = error.to_string();
                let right = error.line() == Some(line)
                    && error.key().unwrap_or("") == key
                    && message.contains(words)
                    && message.starts_with(&format!("bad.toml:{line}: "));
                if !right {
                    wrong.push(format!("{new:?} (line {line}, key {key}, {words:?}) gave: {message}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), CHANGES.len() + SLIPS.len(), wrong.join("\n"));
}

#[test]
fn messages_read_well() {
    let message = |old: &str, new: &str| Case::parse("case.toml", &GOOD.replacen(old, new, 1)).unwrap_err().to_string();
    assert_eq!(
        message("kind = \"flexible\"", "kind = \"bendy\""),
        "case.toml:30: finger.hinge.kind = \"bendy\": allowed is \"flexible\", \"pinned\", \"welded\""
    );
    assert_eq!(
        message("radius_mm = 40.0", "radius = 40.0"),
        "case.toml:43: object.radius = 40.0: unknown key (did you mean radius_mm?); allowed here: shape, radius_mm, centre_mm"
    );
    assert_eq!(
        message("  27,", "  81,"),
        "case.toml:25: finger.lamellae.heights_mm[2] = 81: lies outside the flexible beam; \
         allowed is more than 0 and less than 74 mm"
    );
}

#[test]
fn messages_are_one_line_whatever_the_file_holds() {
    for text in ["\"a\\nb\\u001b[2J\" = 1", "finger = \"\\u0007\"", "finger = 1\n\"fin\\u0067er\" = 2\n\u{1b}"] {
        let message = Case::parse("case.toml", text).unwrap_err().to_string();
        assert!(!message.chars().any(char::is_control), "{message:?}");
    }
    let message = Case::parse("case.toml", "\"a\\nb\" = 1").unwrap_err().to_string();
    assert!(message.starts_with("case.toml:1: a\\nb = 1: unknown key"), "{message}");
}

#[test]
fn an_empty_text_and_other_formats_are_refused() {
    let error = Case::parse("empty.toml", "").unwrap_err();
    assert_eq!((error.line(), error.key()), (Some(1), Some("finger")));
    assert!(matches!(Case::parse("x.json", "{\"finger\": 1}").unwrap_err(), CaseError::Syntax { line: 1, .. }));
    let error = Case::parse("x.toml", "finger = 3").unwrap_err();
    assert!(matches!(&error, CaseError::WrongType { .. }), "{error}");
    let deep = format!("finger = {}{}", "[".repeat(100_000), "]".repeat(100_000));
    assert!(Case::parse("deep.toml", &deep).is_err());
}

#[test]
fn unknown_presets_and_absent_finger_files_are_refused() {
    let tail = &GOOD[GOOD.find("[object]").unwrap()..];
    let case = |finger: &str| Case::parse("case.toml", &format!("{finger}\n{tail}"));
    assert_eq!(case("finger = \"preset:ladder-80\"").unwrap().finger.name, "ladder-80");
    let message = case("finger = \"preset:ladder\"").unwrap_err().to_string();
    assert!(message.starts_with("case.toml:1: finger = \"preset:ladder\""), "{message}");
    assert!(message.contains("preset:fea-80"), "{message}");
    let message = case("finger = \"absent.toml\"").unwrap_err().to_string();
    assert!(message.starts_with("case.toml:1: finger = \"absent.toml\""), "{message}");
    assert!(message.contains("cannot be read"), "{message}");
}

#[test]
fn files_that_are_no_cases_are_refused() {
    let own = tempfile::tempdir().unwrap();
    let folder = own.path();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        Case::read(&path).unwrap_err()
    };
    assert!(matches!(file("empty.toml", b""), CaseError::Missing { .. }));
    assert!(matches!(file("binary.toml", b"a = 1\n\xff\xfe\x00"), CaseError::NotText { line: 2, .. }));
    let utf_16: Vec<u8> = format!("\u{feff}{GOOD}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = file("utf-16.toml", &utf_16);
    assert!(matches!(error, CaseError::NotText { line: 1, .. }) && error.to_string().contains("is UTF-16"), "{error}");
    std::os::unix::fs::symlink(folder.join("loop.toml"), folder.join("loop.toml")).unwrap();
    assert!(matches!(Case::read(&folder.join("loop.toml")).unwrap_err(), CaseError::Unreadable { .. }));
    // A mark at the beginning and other ends of lines are no faults.
    std::fs::write(folder.join("marked.toml"), format!("\u{feff}{}", GOOD.replace('\n', "\r\n"))).unwrap();
    assert_eq!(Case::read(&folder.join("marked.toml")).unwrap(), Case::parse("case.toml", GOOD).unwrap());
    assert!(matches!(file("nul.toml", b"a = \0\n"), CaseError::Syntax { line: 1, .. }));
    assert!(matches!(file("huge.toml", &vec![b'#'; 2 << 20]), CaseError::TooLarge { bytes: 2_097_152, .. }));
    assert!(matches!(Case::read(&folder.join("absent.toml")).unwrap_err(), CaseError::Unreadable { .. }));
    assert!(matches!(Case::read(folder).unwrap_err(), CaseError::Unreadable { .. }));
    let finger = folder.join("finger.toml");
    std::fs::write(&finger, GOOD.replace("width_mm = 20.0", "width_mm = -1")).unwrap();
    let error = read_finger(&finger).unwrap_err();
    assert_eq!((error.line(), error.key()), (Some(3), Some("finger.width_mm")));
    // A fault in a finger file is named by that file, not by the case that mentions it.
    let tail = &GOOD[GOOD.find("[object]").unwrap()..];
    let error = file("case.toml", format!("finger = \"finger.toml\"\n{tail}").as_bytes());
    assert!(error.to_string().contains("finger.toml:3: finger.width_mm = -1"), "{error}");
}
