//! Derivatives of force, torque and contact centre, in the units of files.

use model_core::design::Design;
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::sensitivity::{Derivative, DesignParameter, Probe};
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::faces;
use crate::heap::Host;
use crate::study::model::Options;

/// Derivatives, world frame, the touching samples staying the same: of the force on the object, of the torque that the
/// contact demands of the motor, and of the contact centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// Of the force to the motor angle, N per degree; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_per_deg_n: Option<[f64; 2]>,
    /// To the distance, N per mm, of a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_per_mm_n: Option<[f64; 2]>,
    /// To the x and the y of the object's centre, N per mm.
    pub force_per_centre_mm_n: [[f64; 2]; 2],
    /// To the object's radius, N per mm; of an object without one to how far its surface lies outwards.
    pub force_per_radius_mm_n: [f64; 2],
    /// To Young's modulus, N per MPa, the contact softness staying the same.
    pub force_per_youngs_modulus_mpa_n: [f64; 2],
    /// To the front beam's thickness, N per mm, a rigid tip that is `"auto"` moving with it; `null` where the dimension cannot be varied.
    pub force_per_front_thickness_mm_n: Option<[f64; 2]>,
    /// To the back beam's thickness, N per mm.
    pub force_per_back_thickness_mm_n: Option<[f64; 2]>,
    /// To the hinges' thickness, N per mm.
    pub force_per_hinge_thickness_mm_n: Option<[f64; 2]>,
    /// To the hinges' length, N per mm.
    pub force_per_hinge_length_mm_n: Option<[f64; 2]>,
    /// To the x and the y of the motor axis, N per mm.
    pub force_per_motor_axis_mm_n: [[f64; 2]; 2],
    /// Stiffness dF/dC that the object meets, N/mm: row i, column j is the change of the i-th component of the force by the
    /// object's j-th. Where the finger pushes the object back, it is negative definite.
    pub stiffness_n_per_mm: [[f64; 2]; 2],
    /// Of the torque to the motor angle, N·mm per degree; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_per_deg_nmm: Option<f64>,
    /// Of the torque to the x and the y of the object's centre, N·mm per mm (of a translated base: of the force against its
    /// motion, N per mm).
    pub torque_per_centre_mm_nmm: [f64; 2],
    /// To the object's radius.
    pub torque_per_radius_mm_nmm: f64,
    /// Of the contact centre to the motor angle, mm per degree; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_centre_per_deg_mm: Option<[f64; 2]>,
}

impl Sensitivity {
    /// Of the force to the place on the motion, N per degree or per mm.
    pub fn force_along_motion(&self) -> Option<[f64; 2]> {
        self.force_per_deg_n.or(self.force_per_mm_n)
    }
}

/// Derivatives at the present place; `None` if more samples touch than there is room for.
pub(super) fn sensitivity<T: Real>(
    follower: &mut Follower<T, Host>,
    probe: &mut Probe<T, Host>,
    case: &Case,
    options: &Options,
) -> Option<Sensitivity> {
    let found = follower.sensitivity()?;
    let (design, how) = (&case.finger.design, &options.discretisation);
    let mut dimension = |parameter: DesignParameter| {
        let thickens = matches!(parameter, DesignParameter::FrontThickness | DesignParameter::BackThickness);
        let derivative = if thickens && case.finger.is_tip_auto {
            let step = T::EPSILON.to_f64().cbrt() * parameter.size(design);
            let [below, above] = [-step, step].map(|by| thickened(design, parameter, by));
            follower.design_derivative(probe, [&below?, &above?], how, step)
        } else {
            follower.design_sensitivity(probe, design, how, parameter)
        };
        derivative.map(|derivative| vector(derivative.force))
    };
    let force = |derivative: &Derivative<T>| vector(derivative.force);
    let rotating = matches!(case.path.motion, Motion::Rotating { .. });
    let coordinate = force(&found.coordinate);
    let centre = [force(&found.centre[0]), force(&found.centre[1])];
    let per_degree = 1_f64.to_radians();
    // A bore whose radius grows gives way.
    let to_radius = if matches!(case.object, ObjectDesign::Bore { .. }) { -1.0 } else { 1.0 };
    Some(Sensitivity {
        force_per_deg_n: rotating.then_some(coordinate.map(|per_radian| per_radian * per_degree)),
        force_per_mm_n: (!rotating).then_some(coordinate),
        force_per_centre_mm_n: centre,
        force_per_radius_mm_n: force(&found.radius).map(|outwards| outwards * to_radius + 0.0),
        force_per_youngs_modulus_mpa_n: force(&found.youngs_modulus),
        force_per_front_thickness_mm_n: dimension(DesignParameter::FrontThickness),
        force_per_back_thickness_mm_n: dimension(DesignParameter::BackThickness),
        force_per_hinge_thickness_mm_n: dimension(DesignParameter::HingeThickness),
        force_per_hinge_length_mm_n: dimension(DesignParameter::HingeLength),
        force_per_motor_axis_mm_n: [force(&found.axis[0]), force(&found.axis[1])],
        stiffness_n_per_mm: [0, 1].map(|i| [centre[0][i], centre[1][i]]),
        torque_per_deg_nmm: rotating.then_some(found.coordinate.torque.to_f64() * per_degree),
        torque_per_centre_mm_nmm: [found.centre[0].torque.to_f64(), found.centre[1].torque.to_f64()],
        torque_per_radius_mm_nmm: found.radius.torque.to_f64() * to_radius + 0.0,
        contact_centre_per_deg_mm: rotating.then_some(vector(found.coordinate.contact_centre).map(|x| x * per_degree)),
    })
}

/// A design of another thickness, mm, whose rigid tip begins where the inner faces then meet.
fn thickened(design: &Design, parameter: DesignParameter, by: f64) -> Option<Design> {
    let mut other = design.clone();
    parameter.shift(&mut other, by);
    other.rigid_above = Some(faces::solid_above(&other.front, &other.back)?);
    Some(other)
}

fn vector<T: Real>(v: [T; 2]) -> [f64; 2] {
    // Adding zero turns −0 into 0.
    v.map(|x| x.to_f64() + 0.0)
}
