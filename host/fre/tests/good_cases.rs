//! Files become designs in the solver's units.

use fre::case::{Case, PRESETS, preset};
use model_core::design::{Attachments, HingeFrom, HingeKind, MaterialLaw, PlaneStrain};
use model_core::object::{Corners, Motion, ObjectDesign};

#[test]
fn every_preset_is_valid_and_carries_its_name() {
    for name in PRESETS {
        assert_eq!(preset(name).unwrap().unwrap().name, name);
    }
    assert!(preset("no-such").is_none());
}

#[test]
fn the_presets_are_those_of_the_references() {
    let ladder = preset("ladder-80").unwrap().unwrap().design;
    assert_eq!(
        ladder.lamellae.attachments,
        Attachments::Heights([9.0, 18.0, 27.0, 36.0, 45.0, 54.0, 63.0].into_iter().collect())
    );
    assert_eq!((ladder.material.youngs_modulus, ladder.material.poissons_ratio), (49.5, 0.48));
    assert_eq!((ladder.hinge.from, ladder.plane_strain), (HingeFrom::Centreline, PlaneStrain::Stress));
    assert_eq!(ladder.motor_axis, [-14.0, -20.0]);
    let fea = preset("fea-80").unwrap().unwrap().design;
    assert_eq!((fea.hinge.from, fea.plane_strain), (HingeFrom::Face, PlaneStrain::Stress));
    assert_eq!(fea.hinge.length.as_slice(), [2.5, 2.5, 2.5, 2.5, 2.5, 1.97]);
    // The wedge begins where the inner faces meet: front face x = −1, back face offset by 1 mm along its normal.
    let slope: f64 = 28.0 / 80.0;
    let height = 80.0 - (1.0 + (1.0 + slope * slope).sqrt()) / slope;
    assert!((fea.rigid_above.unwrap() - height).abs() < 1e-3, "{height}");
}

#[test]
fn units_are_converted_once() {
    let case = Case::parse(
        "case.toml",
        "finger = \"preset:fea-80\"\nobject = { shape = \"circle\", radius_mm = 30, centre_mm = [31, 45] }\n\
         motion.motor_angles_deg = [18.0, 90]\n",
    )
    .unwrap();
    assert_eq!(case.object, ObjectDesign::Circle { centre: [31.0, 45.0], radius: 30.0 });
    assert_eq!(case.path.motion, Motion::Rotating { axis: [-14.0, -20.0] });
    assert_eq!(case.path.places, [18.0, 90.0]);
    assert_eq!(case.path.coordinate(180.0), std::f64::consts::PI);
}

#[test]
fn objects_of_every_shape() {
    let object = |lines: &str| {
        let text = format!("finger = \"preset:fea-80\"\nmotion.motor_angles_deg = [1]\n[object]\n{lines}\n");
        Case::parse("case.toml", &text).unwrap().object
    };
    let ellipse = |semi_axes, angle| ObjectDesign::Ellipse { centre: [41.0, 60.0], semi_axes, angle };
    assert_eq!(
        object("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [40, 20.5]\nangle_deg = 90"),
        ellipse([40.0, 20.5], std::f64::consts::FRAC_PI_2)
    );
    assert_eq!(object("shape = \"ellipse\"\ncentre_mm = [41, 60]\nsemi_axes_mm = [5, 7]"), ellipse([5.0, 7.0], 0.0));
    let polygon =
        |corners: &[[f64; 2]]| ObjectDesign::Polygon { corners: Corners::new(corners).unwrap(), rounding: 2.0 };
    let square = [[10.0, 30.0], [40.0, 30.0], [40.0, 60.0], [10.0, 60.0]];
    let mut clockwise = square;
    clockwise.reverse();
    for (corners, text) in [
        (&square[..], "[[10, 30], [40, 30], [40, 60], [10, 60]]"),
        (&clockwise, "[[10, 60], [40, 60], [40, 30], [10, 30]]"),
        (&square[..2], "[[10, 30], [40, 30]]"),
        (&square[..1], "[[10, 30]]"),
    ] {
        let read = object(&format!("shape = \"polygon\"\nrounding_mm = 2\ncorners_mm = {text}"));
        assert_eq!(read, polygon(corners));
    }
    assert_eq!(
        object("shape = \"half-plane\"\npoint_mm = [1, 40]\nnormal = [-3, 4]"),
        ObjectDesign::HalfPlane { point: [1.0, 40.0], normal: [-3.0, 4.0] }
    );
    assert_eq!(
        object("shape = \"bore\"\nradius_mm = 2e6\ncentre_mm = [-1.999e6, 60]"),
        ObjectDesign::Bore { centre: [-1.999e6, 60.0], radius: 2e6 }
    );
}

#[test]
fn a_finger_without_lamellae_hinges_or_motor_can_be_translated() {
    let case = Case::parse(
        "strips.toml",
        r#"
        [finger]
        width_mm = [[0, 20.0], [0x50, 10.0]]
        material = { youngs_modulus_pa = 2.13e11, poissons_ratio = 0.3, law = "neo-hookean" }
        front = { base_mm = [0, 0], tip_mm = [0, 80], thickness_mm = 0.2, stiffness_factor = 1.5 }
        back = { base_mm = [-28, 0], tip_mm = [0, 80], thickness_mm = [[0, 1.0], [40.5, 0.5]] }
        lamellae.heights_mm = []
        [object]
        shape = "circle"
        radius_mm = 1_0
        centre_mm = [-30, 66.5]
        [motion]
        direction = [-2.0, 0.0]
        distances_mm = [5, 10]
        "#,
    )
    .unwrap();
    let design = &case.finger.design;
    assert_eq!(case.finger.name, "finger");
    assert!(!case.finger.has_motor && design.lamellae.attachments.is_empty());
    assert_eq!(design.width.knots.as_slice(), [[0.0, 20.0], [80.0, 10.0]]);
    assert_eq!(design.plane_strain, PlaneStrain::Auto);
    assert_eq!(design.front.stiffness_factor, 1.5);
    assert!((design.material.youngs_modulus - 213_000.0).abs() < 1e-6);
    assert_eq!(design.material.law, MaterialLaw::NeoHookean);
    assert_eq!(case.path.motion, Motion::Translating { direction: [-1.0, 0.0] });
    assert_eq!(case.path.coordinate(5.0), 5.0);
}

#[test]
fn lamellae_by_arc_length_and_pinned_hinges() {
    let finger = "finger = { width_mm = 28, material = { youngs_modulus_pa = 2.13e11, poissons_ratio = 0.3 }, \
        front = { base_mm = [0, 0], tip_mm = [0, 150], thickness_mm = 0.2 }, \
        back = { base_mm = [-73.24, 0], tip_mm = [0, 150], thickness_mm = 0.2 }, \
        lamellae = { front_arc_mm = [27, 54], back_arc_mm = [45.67, 78.69], thickness_mm = 3 }, \
        hinge = { kind = \"pinned\" }, motor.axis_mm = [0, 0] }";
    let rest = "object = { shape = \"circle\", radius_mm = 30, centre_mm = [31, 45] }\nmotion.motor_angles_deg = [1]\n";
    let case = Case::parse("case.toml", &format!("{finger}\n{rest}")).unwrap();
    assert_eq!(case.finger.design.hinge.kind, HingeKind::Pinned);
    assert_eq!(case.finger.design.attachment_arcs(1), [54.0, 78.69]);
}
