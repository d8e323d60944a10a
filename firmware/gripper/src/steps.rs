//! An estimate in as many iterations as there is time for.

use grip::Budget;
use model_core::estimator::{CONVERGES_WITHIN, Estimate};
use model_core::status::Status;

use crate::Model;

/// Estimates at a motor angle, rad, so many seconds after the estimate before, in so much time, and says what it took, both in ticks of the
/// cost clock: all iterations at once where there is time for what an estimate without friction may need, otherwise one after the other for as long
/// as there is.
///
/// For the control loop alone, and inlined into it: the solver is then in the image once, and as that image is optimised.
#[inline]
pub fn estimate(
    model: &mut Model,
    budget: &Budget,
    angle: f64,
    seconds: f64,
    left: u32,
    clock: impl Fn() -> u32,
) -> (Estimate, u32) {
    let start = clock();
    let allowed = budget.iterations(left);
    // With friction an iteration may take several times as long as another.
    let at_once = allowed >= CONVERGES_WITHIN && !model.rubs();
    model.set_budget(if at_once { allowed } else { 1 });
    let mut estimate = model.update_after(angle, seconds);
    let (mut steps, mut before) = (1, 0);
    loop {
        let spent = since(start, &clock);
        let waits = matches!(estimate.status, Status::Updating | Status::MaxIterations);
        let goes_on = !at_once && waits && steps < budget.most();
        if !goes_on || !budget.allows_another(left, spent, spent.wrapping_sub(before)) {
            return (estimate, spent);
        }
        (steps, before) = (steps + 1, spent);
        estimate = model.go_on(angle);
    }
}

/// What has passed since a start. Not inlined: `cargo xtask bench rates` finds an estimate by where the clock is read at its end.
#[inline(never)]
fn since(start: u32, clock: &impl Fn() -> u32) -> u32 {
    clock().wrapping_sub(start)
}
