//! The microcontroller's estimator: single precision, its sizes, its discretisation.

use model_core::discretise::{Discretisation, Physics};
use model_core::estimator::Estimator as Core;
use model_core::object::Motion;
use model_core::size::RubbingRibs;
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{case_error, of_discretise, value};
use crate::options::word;

/// The status's word; motor angle, force (x, y, magnitude), contact centre (x, y), extent, torque, distance, residual, derivative of
/// the force (x, y), standard deviation; iterations, age, age of the derivatives; the intervals of the force's magnitude, the normal force and
/// the torque, where there are any; the rib that is near its buckling load, from 1, and its percentage of that, or zeros.
type Estimate = (&'static str, [f32; 13], [u32; 3], [Option<(f32, f32)>; 3], [u32; 2]);

/// An estimator of one finger on one object.
#[pyclass(module = "fre._core")]
pub(crate) struct Estimator(Box<Core<f32, RubbingRibs>>);

#[pymethods]
impl Estimator {
    #[new]
    fn new(case: &Case, physics: &str) -> PyResult<Self> {
        let physics = word("physics", physics, &[("paper", Physics::Paper), ("extended", Physics::Extended)])?;
        let case = &case.case;
        if matches!(case.path.motion, Motion::Translating { .. }) {
            let reason = "motion.direction: an estimator needs a motor; allowed is motion.motor_angles_deg";
            return Err(case_error(reason, Some("motion.direction"), None));
        }
        let mut estimator: Box<Core<f32, RubbingRibs>> = Box::new(Core::EMPTY);
        let how = Discretisation::estimator(physics);
        estimator.configure(&case.finger.design, &how).map_err(|error| of_discretise(&error))?;
        estimator.set_object(case.object).map_err(|error| value(error.to_string()))?;
        estimator.set_friction(case.friction).map_err(|error| value(error.to_string()))?;
        estimator.set_prony(&case.finger.prony).map_err(|error| value(error.to_string()))?;
        Ok(Self(estimator))
    }

    /// The estimate at a motor angle, rad, `dt_s` after the one before. An elastic finger does not depend on the time.
    fn update(&mut self, angle_rad: f64, dt_s: f64) -> PyResult<Estimate> {
        if !(dt_s >= 0.0 && dt_s.is_finite()) {
            return Err(case_error(format!("dt_s = {dt_s}: allowed is 0 and more"), Some("dt_s"), None));
        }
        if angle_rad.is_nan() {
            return Err(case_error("angle_rad is not a number".to_owned(), Some("angle_rad"), None));
        }
        let found = self.0.update_after(angle_rad, dt_s);
        let numbers = [
            found.motor_angle,
            found.force[0],
            found.force[1],
            found.force_magnitude(),
            found.contact_centre[0],
            found.contact_centre[1],
            found.contact_extent,
            found.torque,
            found.distance,
            found.residual,
            found.force_per_angle[0],
            found.force_per_angle[1],
            found.standard_deviation,
        ];
        let ends = found
            .interval
            .map(|known| [known.magnitude, known.normal, known.torque].map(|[low, high]| Some((low, high))));
        let counts = [found.iterations.into(), found.age, found.sensitivity_age.into()];
        let loaded = found.loaded_rib.map_or([0; 2], |loaded| [u32::from(loaded.rib) + 1, loaded.percent.into()]);
        Ok((found.status.word(), numbers, counts, ends.unwrap_or_default(), loaded))
    }
}
