//! Options that commands share: how the model is discretised and solved.

use clap::{Args, ValueEnum};
use model_core::discretise::{DiscretiseError, Elements, Physics, Scheme};
use model_core::drive::Drive;
use model_core::newton::Hessian;

use fre::study::choice::{Choice, elements};
use fre::study::model::{Options, Precision};

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SchemeWord {
    /// Rigid elements, first order: "Geometrico-Static Modelling of a FRE Finger".
    Paper,
    /// All element angles free, second order.
    Trapezoid,
    /// Quadratic elements, fourth order.
    Simpson,
}

/// What a finger is made of.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum PhysicsWord {
    /// Inextensible, hinges from the centrelines, no rigid tip, plane stress.
    Paper,
    /// What the finger says, with stretch.
    Extended,
}

impl PhysicsWord {
    /// The physics that it names.
    pub fn physics(self) -> Physics {
        match self {
            Self::Paper => Physics::Paper,
            Self::Extended => Physics::Extended,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum HessianWord {
    /// With the exact geometric stiffness.
    Newton,
    /// The energy's alone; slow, and without a stability test.
    GaussNewton,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PrecisionWord {
    /// Double.
    F64,
    /// Single, as on the microcontroller.
    F32,
}

/// How the model is discretised and solved.
#[derive(Debug, Args)]
#[command(next_help_heading = "Model")]
pub struct ModelArgs {
    /// Scheme of beams and hinges
    #[arg(long, value_enum, default_value = "simpson")]
    scheme: SchemeWord,
    /// Elements per beam / per hinge, or paper, reduced or fine
    ///
    /// B/H, 1 to 2000 each; paper is 170/20, reduced 2 per span, 3 in the tip span and 1 per hinge, fine 4 per span and 2 per
    /// hinge. A beam of few spans has at least 12 with reduced and 20 with fine.
    #[arg(long, value_name = "B/H", default_value = "fine", value_parser = elements)]
    elements: Elements,
    /// Contact samples per element of scheme simpson (1 to 16) [default: 4]
    ///
    /// The other schemes sample at their nodes.
    #[arg(long, value_name = "N", value_parser = samples)]
    samples: Option<u8>,
    /// Contact softness ε in gap + ε·force = 0, mm/N, 0 to 1
    ///
    /// The default is the front beam's own with samples, 1/(E·width), and 0 with nodes.
    /// With friction 0 stands for the beam's own.
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    softness_mm_per_n: Option<f64>,
    /// Physics
    #[arg(long, value_enum, default_value = "extended")]
    physics: PhysicsWord,
    /// Second derivative of the Newton step
    #[arg(long, value_enum, default_value = "newton")]
    hessian: HessianWord,
    /// Floating-point precision
    #[arg(long, value_enum, default_value = "f64")]
    precision: PrecisionWord,
}

impl ModelArgs {
    /// The options as the library takes them.
    pub fn options(&self) -> Options {
        let choice = Choice {
            scheme: match self.scheme {
                SchemeWord::Paper => Scheme::Paper,
                SchemeWord::Trapezoid => Scheme::Trapezoid,
                SchemeWord::Simpson => Scheme::Simpson,
            },
            elements: self.elements,
            samples: self.samples,
            softness: self.softness_mm_per_n,
            physics: self.physics.physics(),
            hessian: match self.hessian {
                HessianWord::Newton => Hessian::Newton,
                HessianWord::GaussNewton => Hessian::GaussNewton,
            },
            precision: match self.precision {
                PrecisionWord::F64 => Precision::F64,
                PrecisionWord::F32 => Precision::F32,
            },
        };
        choice.options()
    }
}

/// What was wrong with the options, by the option's name.
pub fn refused(error: &DiscretiseError) -> String {
    match error {
        DiscretiseError::Softness { found } => format!("--softness-mm-per-n is {found}; allowed is 0 to 1"),
        error => format!("--{error}"),
    }
}

/// Reads a number of contact samples.
fn samples(text: &str) -> Result<u8, String> {
    text.parse().map_err(|_| "allowed is 1 to 16".to_owned())
}

/// How a motor moves its finger, from an argument.
pub fn drive(words: &str) -> Result<Drive, String> {
    let drive = fre::drive::read(words).ok_or_else(|| format!("allowed is {}", fre::drive::ALLOWED))?;
    drive.validate().map_err(|error| error.to_string())?;
    Ok(drive)
}
