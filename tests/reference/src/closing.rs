//! What costs are quoted for: a finger that closes on an object a count at a time and opens again.

use crate::ribs::ribbed_80;
use crate::umi::umi;
use crate::{COUNT, circle_80};
use model_core::design::{Design, ladder_80};
use model_core::object::{Motion, ObjectDesign};

/// A finger, an object that it touches at 0, and how far it closes.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Its name in tables and documents.
    pub case: &'static str,
    /// The finger.
    pub design: fn() -> Design,
    /// The object.
    pub object: fn() -> ObjectDesign,
    /// A parallel jaw moves it, otherwise a motor turns it.
    pub is_jaw: bool,
    /// A count of the servo, rad or mm of jaw, and how many close the finger.
    pub count: (f64, i32),
    /// A step of about eleven counts, likewise: a degree of a motor.
    pub step: (f64, i32),
}

/// A motor's closing from 0 to 11°.
const TURNS: Closing = Closing {
    case: "",
    design: ladder_80,
    object: || circle_80(45.0),
    is_jaw: false,
    count: (COUNT, 11 * 4096 / 360),
    step: (core::f64::consts::PI / 180.0, 11),
};
/// `ladder-80`, seven rigid lamellae with hinges, on a cylinder of 80 mm at Mid height.
pub const LADDER: Closing = Closing { case: "ladder-80 R40-Mid", ..TURNS };
/// The same with a rigid tip and seven welded ribs of 1.2 mm.
pub const RIBS_7: Closing = Closing { case: "ribs-7", design: || ribbed_80(1.2, 0.0), ..TURNS };
/// The preset `umi` on a cylinder of 80 mm at a height of 65 mm, moved by 10 mm in counts of 0.05 mm.
pub const UMI: Closing = Closing {
    case: "umi",
    design: umi,
    object: || ObjectDesign::Circle { centre: [40.9, 65.0], radius: 40.0 },
    is_jaw: true,
    count: (0.05, 200),
    step: (0.5, 20),
};
/// All of them.
pub const CLOSINGS: [Closing; 3] = [LADDER, RIBS_7, UMI];
/// The most ticks of one of them.
pub const MOST_TICKS: usize = 2 * 200 + 1;

impl Closing {
    /// How its finger moves.
    pub fn motion(&self, design: &Design) -> Motion {
        if self.is_jaw {
            Motion::Translating { direction: [1.0, 0.0] }
        } else {
            Motion::Rotating { axis: design.motor_axis }
        }
    }

    /// Closing to the last of `count` or `step` and opening again.
    pub fn ticks((_, last): (f64, i32)) -> impl Iterator<Item = i32> {
        (0..=last).chain((0..last).rev())
    }
}
