//! Cost of ribs that bend: seven of them, and the finger of the Universal Manipulation Interface with fifteen, on the target.

#![no_std]
#![no_main]

mod sweep;

use model_core::discretise::{Discretisation, Physics, Sampling};
use model_core::equilibrium::Follower;
use model_core::size::Ribs;
use reference_tests::closing::{RIBS_7, UMI};
use static_cell::ConstStaticCell;

static FOLLOWER: ConstStaticCell<Follower<f32, Ribs>> = ConstStaticCell::new(Follower::EMPTY);

#[cortex_m_rt::entry]
fn main() -> ! {
    let _board = mps2::init();
    let models: &[sweep::Model] = &[
        (2, |physics| Discretisation { sampling: Sampling::PerElement(2), ..Discretisation::reduced(physics) }),
        (5, Discretisation::estimator),
    ];
    let closings = &[RIBS_7, UMI];
    sweep::run(FOLLOWER.take(), sweep::Cases { closings, models, physics: &[Physics::Extended], frictions: &[0] })
}
