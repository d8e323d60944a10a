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
    let mut said = String::new();
    for (front, back, heights, line, key) in [
        ("thickness_mm = 2, sagitta_mm = -23", BACK, "", 5, "finger.front.sagitta_mm"),
        ("thickness_mm = 2, sagitta_mm = -23", BACK, "9", 5, "finger.front.sagitta_mm"),
        (PLAIN, "tip_mm = [0, 80], thickness_mm = 2, sagitta_mm = 23", "", 6, "finger.back.sagitta_mm"),
        (PLAIN, "tip_mm = [19, 80], thickness_mm = 2", "9", 6, "finger.back.tip_mm"),
        (
            "thickness_mm = [[0, 2], [19, 2], [22.5, 40], [26, 2]]",
            BACK,
            "9, 18, 27, 36",
            5,
            "finger.front.thickness_mm",
        ),
    ] {
        let error = Case::parse("bad.toml", &case(front, back, heights)).unwrap_err();
        assert_eq!((error.line(), error.key()), (Some(line), Some(key)), "{error}");
        said += &format!("{error}\n");
    }
    snapbox::assert_data_eq!(
        said,
        snapbox::str![[r#"
bad.toml:5: finger.front.sagitta_mm = -23: the beams cross above the base: the front beam's centreline is 2.9007 mm behind the back beam's there
bad.toml:5: finger.front.sagitta_mm = -23: the beams cross above lamella 1: the front beam's centreline is 0.3926 mm behind the back beam's there
bad.toml:6: finger.back.sagitta_mm = 23: the beams cross above the base: the front beam's centreline is 9.0777 mm behind the back beam's there
bad.toml:6: finger.back.tip_mm = [19, 80]: the beams cross above lamella 1: the front beam's centreline is 1.6198 mm behind the back beam's there
bad.toml:5: finger.front.thickness_mm = [[0, 2], [19, 2], [22.5, 40], [26, 2]]: the beams reach into each other between lamella 2 and lamella 3: they are 40 and 2 mm thick, their centrelines 20.125 mm apart; both thicknesses together must be less than 40.25 mm

"#]]
    );
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
