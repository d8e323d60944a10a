//! Pieces of the good case replaced by bad ones: every key, every kind of mistake.

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
pub(crate) type Change = (&'static str, &'static str, usize, &'static str, &'static str);

/// One of everything that is refused.
pub(crate) const CHANGES: &[Change] = &[
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
    ("rigid_above_mm = 74.0", "rigid_above_mm = \"top\"", 36, "finger.tip.rigid_above_mm", "allowed is \"auto\""),
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
