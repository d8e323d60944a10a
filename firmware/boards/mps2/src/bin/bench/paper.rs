//! Cost of the full resolution of *Geometrico-Static Modelling of a FRE Finger*, `paper` 170/20, on the target.

#![no_std]
#![no_main]

mod sweep;

use model_core::discretise::{Discretisation, Scheme};
use model_core::equilibrium::Follower;
use model_core::size::Paper;
use static_cell::ConstStaticCell;

static FOLLOWER: ConstStaticCell<Follower<f32, Paper>> = ConstStaticCell::new(Follower::EMPTY);

#[cortex_m_rt::entry]
fn main() -> ! {
    let _board = mps2::init();
    const MODELS: &[sweep::Model] = &[(1, |physics| Discretisation::full(Scheme::Paper, physics))];
    sweep::run(FOLLOWER.take(), sweep::Cases::without_friction(MODELS))
}
