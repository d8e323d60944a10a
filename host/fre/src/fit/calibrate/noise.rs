//! How measurements scatter, and how a residual counts.

/// How a residual of so many standard deviations counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Loss {
    /// Squared, whatever its size.
    Square,
    /// Squared within 1.345 standard deviations, linear beyond: 95 % efficient if nothing is amiss.
    #[default]
    Huber,
    /// Tukey's biweight: of no weight beyond 4.685. The same efficiency; outliers are rejected, but so is all that a bad start
    /// puts far off.
    Tukey,
}

const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;

impl Loss {
    /// ρ(u), its derivative ψ over u (the weight) and ψ′.
    pub(super) fn of(self, u: f64) -> (f64, f64, f64) {
        let size = u.abs();
        match self {
            Self::Huber if size > HUBER => (HUBER * (size - 0.5 * HUBER), HUBER / size, 0.0),
            Self::Tukey => {
                let rest = 1.0 - (u / TUKEY).powi(2);
                let flat = TUKEY * TUKEY / 6.0;
                if rest <= 0.0 {
                    return (flat, 0.0, 0.0);
                }
                let slope = rest * (rest - 4.0 * (u / TUKEY).powi(2));
                (flat * (1.0 - rest.powi(3)), rest * rest, slope)
            }
            _ => (0.5 * u * u, 1.0, 1.0),
        }
    }
}

/// What is known of the measurements, and how residuals count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of a measured force, N.
    pub force_n: f64,
    /// Of a measured motor torque, N·mm.
    pub torque_nmm: f64,
    /// Of a measured angle, degrees.
    pub angle_deg: f64,
    /// Of a point of an outline, mm.
    pub outline_mm: f64,
    /// The loss.
    pub loss: Loss,
}

impl Default for Noise {
    /// A force sensor of 0.02 N, a torque sensor or a scale on a lever of 2 N·mm, angles rounded to a servo's count (0.088°/√12), outlines within
    /// 0.3 mm.
    fn default() -> Self {
        let angle_deg = 360.0 / 4096.0 / 12_f64.sqrt();
        Self { force_n: 0.02, torque_nmm: 2.0, angle_deg, outline_mm: 0.3, loss: Loss::default() }
    }
}
