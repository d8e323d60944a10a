//! Fingers whose beams cross, or reach into each other, are refused wherever they do so.

use fre::case::Case;

/// A finger of these beams and lamellae, from the fourth line on.
fn case(front: &str, back: &str, heights: &str) -> String {
    format!(
        "finger.width_mm = 20\n\
         finger.material = {{ youngs_modulus_pa = 4.95e7, poissons_ratio = 0.48 }}\n\
         finger.lamellae = {{ heights_mm = [{heights}], thickness_mm = 2 }}\n\
         finger.hinge = {{ length_mm = 1.5, thickness_mm = 0.8 }}\n\
         finger.front = {{ base_mm = [0, 0], tip_mm = [0, 80], {front} }}\n\
         finger.back = {{ base_mm = [-28, 0], {back} }}\n\
         finger.motor.axis_mm = [-14, -20]\n\
         object = {{ shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }}\n\
         motion.motor_angles_deg = [4]\n"
    )
}

/// Thickness alone, and a tip where the front beam's is.
const PLAIN: &str = "thickness_mm = 2";
const BACK: &str = "tip_mm = [0, 80], thickness_mm = 2";

#[test]
fn beams_that_cross_are_refused() {
    for (front, back, heights, line, key, words) in [
        ("thickness_mm = 2, sagitta_mm = -23", BACK, "", 5, "finger.front.sagitta_mm", "cross above the base"),
        ("thickness_mm = 2, sagitta_mm = -23", BACK, "9", 5, "finger.front.sagitta_mm", "cross above lamella 1"),
        (PLAIN, "tip_mm = [0, 80], thickness_mm = 2, sagitta_mm = 23", "", 6, "finger.back.sagitta_mm", "cross above"),
        (PLAIN, "tip_mm = [19, 80], thickness_mm = 2", "9", 6, "finger.back.tip_mm", "cross above lamella 1"),
        (
            "thickness_mm = [[0, 2], [19, 2], [22.5, 40], [26, 2]]",
            BACK,
            "9, 18, 27, 36",
            5,
            "finger.front.thickness_mm",
            "reach into each other between lamella 2 and lamella 3",
        ),
    ] {
        let error = Case::parse("bad.toml", &case(front, back, heights)).unwrap_err();
        assert_eq!((error.line(), error.key()), (Some(line), Some(key)), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
}

/// What only comes near, or is thick where there is room, is a finger.
#[test]
fn beams_that_stay_apart_are_taken() {
    for (front, back, heights) in [
        (PLAIN, BACK, ""),
        ("thickness_mm = 2, sagitta_mm = -4", BACK, "9, 18"),
        ("thickness_mm = 2, sagitta_mm = 6", "tip_mm = [0, 80], thickness_mm = 2, sagitta_mm = 6", "9, 18, 27, 36"),
        ("thickness_mm = [[0, 9], [40, 4], [80, 8]]", BACK, "9, 18"),
    ] {
        let text = case(front, back, heights);
        assert!(
            Case::parse("good.toml", &text).is_ok(),
            "{:?}",
            Case::parse("good.toml", &text).unwrap_err().to_string()
        );
    }
}
