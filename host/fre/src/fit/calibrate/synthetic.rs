//! Measurements drawn from the model itself: to plan an experiment, and to check that a fit keeps what it states.

use model_core::discretise::DiscretiseError;
use model_core::object::ObjectDesign;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

use super::{Plan, Predictor, Reading, Readings, Trial};

/// Errors of drawn measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Standard deviation of the force's, normal, N.
    pub force_n: f64,
    /// The same of the motor torque's, N·mm; none where it is not measured.
    pub torque_nmm: Option<f64>,
    /// Half the width of the angle's, uniform, degrees: half a count of the servo.
    pub angle_deg: f64,
}

impl Errors {
    /// A force sensor's ±0.02 N, taken as a standard deviation (4.6 % of the errors are greater than twice that), and a servo's ±0.044°: half
    /// a count, which rounding never exceeds.
    pub const USUAL: Self = Self { force_n: 0.02, torque_nmm: None, angle_deg: 0.5 * COUNT_DEG };
}

/// Which objects are touched, and at which measured angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Protocol {
    /// One run each, world frame, mm.
    pub objects: Vec<ObjectDesign>,
    /// Degrees, the same for each.
    pub angles_deg: Vec<f64>,
    /// When each is reached, s; empty where the material has no memory.
    pub times_s: Vec<f64>,
    /// Coefficient of friction that the cases have.
    pub friction: f64,
}

impl Protocol {
    /// Cylinders in front of the open finger of `ladder-80`, 1 mm away: their heights and radii, mm; so many readings of each, at the
    /// servo's whole counts from 1.1° to 9.4°.
    pub fn cylinders(places: &[[f64; 2]], readings: u32) -> Self {
        let circle = |&[y, radius]: &[f64; 2]| ObjectDesign::Circle { centre: [1.0 + radius, y], radius };
        let angle = |i: u32| COUNT_DEG * (12.0 + 96.0 * f64::from(i) / f64::from(readings)).round();
        Self {
            objects: places.iter().map(circle).collect(),
            angles_deg: (0..readings).map(angle).collect(),
            times_s: Vec::new(),
            friction: 0.0,
        }
    }

    /// The same with half of the readings on the opening: what friction takes from the force then is what distinguishes it from the modulus.
    pub fn there_and_back(mut self) -> Self {
        let closing = self.angles_deg.iter().copied().step_by(2);
        let opening = self.angles_deg.iter().copied().skip(1).step_by(2).collect::<Vec<_>>();
        self.angles_deg = closing.chain(opening.into_iter().rev()).collect();
        self
    }

    /// What `docs/hardware.md` recommends: a thin and a thick cylinder, each as low and as high as the finger reaches around it. What a
    /// turn does to a force grows with the height, what a shift does not: that is how zero angle and place are distinguished; and a
    /// thin cylinder shows its height better than a thick one.
    pub fn recommended() -> Self {
        Self::cylinders(&[[20.0, 10.0], [65.0, 10.0], [20.0, 40.0], [65.0, 40.0]], 48)
    }

    /// The motion of a [`Plan`] in front of an object.
    pub fn planned(plan: &Plan, object: ObjectDesign) -> Self {
        let [times_s, angles_deg] = [0, 1].map(|part| plan.places.iter().map(|place| place[part]).collect());
        Self { objects: vec![object], angles_deg, times_s, friction: 0.0 }
    }

    /// How many readings that is.
    pub fn readings(&self) -> usize {
        self.objects.len() * self.angles_deg.len()
    }
}

/// A count of the servo, degrees.
const COUNT_DEG: f64 = 360.0 / 4096.0;

/// Draws runs: one per object, a reading at each angle, true values from `truth`. Readings without a trustworthy
/// solution are missing.
///
/// # Errors
/// If the true design is refused.
pub fn draw(
    model: &Predictor<'_>,
    truth: &Trial,
    protocol: &Protocol,
    errors: Errors,
    seed: u64,
) -> Result<Vec<Readings>, DiscretiseError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut runs = Vec::new();
    for (index, &object) in protocol.objects.iter().enumerate() {
        let mut readings = Vec::new();
        let mut shifted = Vec::new();
        for (place, &angle_deg) in protocol.angles_deg.iter().enumerate() {
            let time_s = protocol.times_s.get(place).copied();
            let line = place + 2;
            readings.push(Reading { line, angle_deg, time_s, force_n: None, torque_nmm: None, front_mm: Vec::new() });
            let share: f64 = StandardUniform.sample(&mut random);
            let rests = time_s.is_some() && place > 0 && protocol.angles_deg.get(place - 1) == Some(&angle_deg);
            match shifted.last().copied().filter(|_| rests) {
                // A motor that rests has one error.
                Some(angle_deg) => shifted.push(angle_deg),
                None => shifted.push(angle_deg + errors.angle_deg * (2.0 * share - 1.0)),
            }
        }
        let mut order: Vec<usize> = (0..shifted.len()).collect();
        if protocol.times_s.is_empty() && protocol.angles_deg.is_sorted() {
            // The finger closes on and on: it meets the true angles in their own order.
            order.sort_by(|&a, &b| shifted[a].total_cmp(&shifted[b]));
        }
        let closing = order.iter().map(|&i| Reading { angle_deg: shifted[i], ..readings[i].clone() });
        let name = format!("run {}", index + 1);
        let run = Readings { name: name.clone(), object, friction: protocol.friction, readings: closing.collect() };
        let predictions = model.predict(&run, truth, false)?;
        for (&i, prediction) in order.iter().zip(predictions) {
            let normal: f64 = StandardNormal.sample(&mut random);
            if prediction.status.is_trustworthy() {
                readings[i].force_n = Some((prediction.force.value + errors.force_n * normal).max(0.0));
                readings[i].torque_nmm = errors.torque_nmm.map(|error| {
                    let normal: f64 = StandardNormal.sample(&mut random);
                    prediction.torque.value + error * normal
                });
            }
        }
        readings.retain(|reading| reading.force_n.is_some());
        runs.push(Readings { name, object, friction: protocol.friction, readings });
    }
    Ok(runs)
}
