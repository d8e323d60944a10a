//! Cost of the microcontroller's model, `simpson` 17/1, on the target.

#![no_std]
#![no_main]

mod sweep;

use model_core::discretise::{Discretisation, Sampling};
use model_core::equilibrium::Follower;
use model_core::size::Reduced;
use static_cell::ConstStaticCell;

static FOLLOWER: ConstStaticCell<Follower<f32, Reduced>> = ConstStaticCell::new(Follower::EMPTY);

#[cortex_m_rt::entry]
fn main() -> ! {
    let _board = mps2::init();
    const MODELS: &[sweep::Model] = &[
        (2, |physics| Discretisation { sampling: Sampling::PerElement(2), ..Discretisation::reduced(physics) }),
        (4, Discretisation::reduced),
        (5, Discretisation::estimator),
    ];
    sweep::run(FOLLOWER.take(), sweep::Cases::without_friction(MODELS))
}
