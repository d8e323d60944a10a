//! The estimator's ticks and nothing else. If the linker keeps a panic handler, there is a way to it.

#![no_std]
#![no_main]

use core::hint::black_box;
use model_core::estimator::Estimator;
use model_core::size::Reduced;

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut ESTIMATOR: Estimator<f32, Reduced> = Estimator::EMPTY;
    loop {
        // The optimiser knows neither what the estimator was told before nor what becomes of the estimate.
        let estimator = black_box(&mut *ESTIMATOR);
        let estimate = estimator.update(black_box(0.0));
        #[cfg(feature = "can-panic")]
        black_box([0.0, 1.0][usize::from(black_box(estimate.iterations))]);
        black_box(estimate);
    }
}

/// `cargo xtask test` fails if this is in the image.
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
