//! Lists every servo on the bus: a broadcast ping at every rate.
//!
//! A simulated bus carries bytes at any rate, and its servos answer at all of them: each is reported at the rate that its register has.
//!
//! Devices answer one after the other by their addresses, which takes three quarters of a second a rate. The servos that are controlled
//! are not read meanwhile: their estimates are stale, and a gripping finger is not left alone like that. In between the link is
//! heard as ever.

use dynamixel::Found;
use messages::Event;

use crate::board::{Board, Watchdog};
use crate::leadership::count;
use crate::servo::Servos;
use crate::ticks::Core;

/// Devices reported per rate, the first ones that answer.
const ROOM: usize = 16;
/// Time that the link gets for telling of one, µs.
const TELLING_US: u64 = 500;

/// Searches the bus at these rates and reports what is there; it goes on at `bus` then.
pub(crate) async fn scan<B: Board>(
    core: &mut Core<'_, B>,
    servos: &mut Servos<B::Bus>,
    rates: &[u32],
    bus: Option<u32>,
    watchdog: &mut B::Watchdog,
) {
    core.orders.is_scanning = true;
    let (mut all, mut tried) = (0_u16, 0);
    for &baud in rates {
        // A change of the role waits for the bus, and whatever is asked for waits for that. So does torque that is to be off.
        if core.waiting.is_some() || core.hand.is_any_falling() {
            break;
        }
        tried += 1;
        watchdog.feed();
        let mut found: [Option<Found>; ROOM] = [None; ROOM];
        if let Err(error) = core.patiently(servos.discover(baud, &mut found)).await {
            count::<B::Bus>(core.hand.shared, &error);
        }
        for Found { id, identity, alert } in found.into_iter().flatten() {
            let own = core.patiently(servos.rate_of(id)).await;
            if own.is_some_and(|own| own != baud && rates.contains(&own)) {
                continue;
            }
            all = all.saturating_add(1);
            let (id, model, firmware) = (id.get(), identity.model, identity.firmware);
            core.hand.shared.tell(Event::DeviceFound { id, model, firmware, baud, alert });
            core.pause(TELLING_US).await;
        }
        // What waits for a moment without a transaction, too.
        core.pause(TELLING_US).await;
    }
    servos.go_on_at(bus);
    // For some seconds nobody has seen what became of them.
    core.hand.units.iter_mut().for_each(|unit| unit.doubted = true);
    core.orders.is_scanning = false;
    core.hand.shared.tell(Event::ScanDone { found: all, rates: tried });
}
