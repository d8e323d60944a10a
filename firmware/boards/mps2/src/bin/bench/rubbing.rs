//! Cost of friction: the estimator's model with room for it, without friction and with a coefficient of 0.6.

#![no_std]
#![no_main]

mod sweep;

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::size::Rubbing;
use reference_tests::closing::LADDER;
use static_cell::ConstStaticCell;

static FOLLOWER: ConstStaticCell<Follower<f32, Rubbing>> = ConstStaticCell::new(Follower::EMPTY);

#[cortex_m_rt::entry]
fn main() -> ! {
    let _board = mps2::init();
    let models: &[sweep::Model] = &[(4, Discretisation::reduced), (5, Discretisation::estimator)];
    sweep::run(
        FOLLOWER.take(),
        sweep::Cases { closings: &[LADDER], models, physics: &[Physics::Extended], frictions: &[0, 60] },
    )
}
