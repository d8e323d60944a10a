//! What the control task has besides its bus, and how its ticks pass.

use core::future::Future;
use core::marker::PhantomData;
use core::pin::pin;

use dynamixel::StatusError;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use heapless::Vec;
use messages::{Event, FINGERS, Outcome, Settings};

use crate::Model;
use crate::board::Board;
use crate::estimation::Estimation;
use crate::hand::Hand;
use crate::leadership::Leadership;
use crate::orders::Orders;
use crate::scheduler::Scheduler;
use crate::servo::{Goals, Reading, Turn};
use crate::setup::Key;
use crate::shared::{Command, Order, Shared};
use crate::unit::Unit;

/// The records that there are: settings, and each finger's design and object.
const UNKEPT: usize = 1 + 2 * FINGERS;

/// Everything but the bus.
pub(crate) struct Core<'a, B> {
    pub(crate) hand: Hand<'a>,
    pub(crate) scheduler: Scheduler,
    pub(crate) estimation: Estimation,
    pub(crate) leadership: Leadership,
    pub(crate) orders: Orders,
    /// The servos are being asked, or are going to be.
    pub(crate) is_asking: bool,
    /// In this tick the bus was busy with something else than the question: an answer that comes late for that is not missing.
    pub(crate) is_busy: bool,
    /// What the last question took.
    pub(crate) took: Duration,
    /// An order that waits for a transaction's end.
    pub(crate) waiting: Option<Order>,
    /// What the bus's master has set and the flash has not got yet.
    pub(crate) unkept: Vec<Key, UNKEPT>,
    /// When it last set an object.
    pub(crate) placed: Instant,
    /// The bus's master wants a restart.
    pub(crate) restart: bool,
    board: PhantomData<B>,
}

impl<'a, B: Board> Core<'a, B> {
    /// Begins with the fingers as they were kept in flash, in a place where there is none yet.
    // In place, and what that takes is on the stack in here only: a value that is returned lies on the caller's as well.
    #[inline(never)]
    pub(crate) fn begun<'p>(
        place: &'p mut Vec<Self, 1>,
        shared: &'a Shared,
        models: impl Iterator<Item = &'a mut Model>,
    ) -> Option<&'p mut Self> {
        // There is room for one.
        let _ = place.push(Self::new(shared));
        let core = place.first_mut()?;
        core.hand.take_in::<B>(models);
        core.scheduler = Scheduler::new(core.hand.settings.rate_hz);
        core.estimation = Estimation::new(core.hand.settings.support);
        Some(core)
    }

    /// No finger yet.
    fn new(shared: &'a Shared) -> Self {
        Self {
            hand: Hand::new(shared),
            scheduler: Scheduler::new(Settings::DEFAULT.rate_hz),
            estimation: Estimation::new(Settings::DEFAULT.support),
            leadership: Leadership::new(),
            orders: Orders::NONE,
            is_asking: false,
            is_busy: false,
            took: Duration::from_ticks(0),
            waiting: None,
            unkept: Vec::new(),
            placed: Instant::MIN,
            restart: false,
            board: PhantomData,
        }
    }

    /// Waits for the next period and obeys one order.
    pub(crate) async fn begin(&mut self) {
        // What went on beyond the last tick counts for this one.
        self.is_busy &= Instant::now() >= self.scheduler.end;
        self.scheduler.wait().await;
        self.advance();
        self.obey(!self.is_asking);
    }

    fn advance(&mut self) {
        self.scheduler.advance(self.hand.shared);
        self.estimation.begin(&mut self.hand);
    }

    fn obey(&mut self, between: bool) {
        self.orders.obey::<B>(&mut self.waiting, &mut self.hand, &mut self.estimation, between);
    }

    /// Does at once what is asked for.
    pub(crate) fn execute(&mut self, command: &Command) -> Outcome {
        self.orders.execute::<B>(&mut self.hand, &mut self.estimation, command)
    }

    /// Where the servos go next.
    pub(crate) fn goals(&mut self) -> Goals {
        Leadership::goals(&mut self.hand, self.scheduler.seconds())
    }

    /// Whether the next question need not wait for what comes of these answers.
    pub(crate) fn may_ask_ahead(&self, turns: &[Turn<B::Bus>]) -> bool {
        let is_alert = |finger: usize| self.hand.units.get(finger).is_some_and(|unit| unit.alert);
        let as_ever =
            |turn: &Turn<B::Bus>| matches!(turn.result, Ok(reading) if reading.alert == is_alert(turn.finger));
        let has_orders = self.waiting.is_some() || self.orders.scan || self.orders.settings_changed;
        turns.iter().all(as_ever) && !has_orders && !self.hand.shared.quiet.is_wanted()
    }

    /// A servo has answered, or has not. Nothing is estimated from a position that is too old.
    pub(crate) fn answered(&mut self, turn: &Turn<B::Bus>, is_old: bool) {
        // Meanwhile the settings may have named another one.
        let is_its = |unit: &Unit<'_>| unit.id() == Some(turn.id) && unit.health.is_present();
        if !self.hand.units.get(turn.finger).is_some_and(is_its) {
            return;
        }
        match &turn.result {
            Ok(reading) => {
                if let Some((position, error)) = reading.refused {
                    let shared = self.hand.shared;
                    shared.add(|counters| &mut counters.bus_refused);
                    shared.tell(Event::GoalRefused { finger: turn.finger as u8, position, error: error.code() });
                    if let Some(unit) = self.hand.units.get_mut(turn.finger) {
                        // Its limits, or its Bus Watchdog: then it takes no other one either.
                        unit.doubted |= error == StatusError::DataRange;
                    }
                }
                if !is_old {
                    self.fresh(turn.finger, reading);
                }
            }
            Err(error) => {
                // A port that is slow waits for longer than a period.
                let seconds = self.scheduler.seconds().max(self.took.as_micros() as f64 * 1e-6);
                self.leadership.failed::<B::Bus>(&mut self.hand, turn.finger, error, seconds);
            }
        }
    }

    /// A position came: estimates and reports.
    pub(crate) fn fresh(&mut self, finger: usize, reading: &Reading) {
        self.estimation.fresh::<B>(&mut self.hand, &self.scheduler, finger, reading);
    }

    /// Ends a tick.
    pub(crate) fn finish(&mut self) {
        self.estimation.finish::<B>(&mut self.hand, &self.scheduler, true);
    }

    /// Takes another period.
    pub(crate) fn pace(&mut self, period_us: u64) {
        self.scheduler.pace(period_us, self.hand.settings.rate_hz, self.hand.shared);
    }

    /// Waits for a transaction of its own on the bus; periods that pass meanwhile are reported as stale.
    pub(crate) async fn patiently<F: Future>(&mut self, transaction: F) -> F::Output {
        let _asking = self.hand.shared.quiet.ask();
        self.is_busy = true;
        self.meanwhile(transaction).await
    }

    /// The same for a transaction of the bus task.
    pub(crate) async fn meanwhile<F: Future>(&mut self, transaction: F) -> F::Output {
        let mut transaction = pin!(transaction);
        loop {
            match select(transaction.as_mut(), Timer::at(self.scheduler.end)).await {
                Either::First(output) => return output,
                Either::Second(()) => self.go_without(),
            }
        }
    }

    /// A period ends without what is waited for. An answer is missing by then only if nothing else can have held it up: another transaction,
    /// or another servo, which is waited for.
    #[inline(never)]
    fn go_without(&mut self) {
        let is_alone = self.hand.units.iter().filter(|unit| unit.health.is_present()).count() == 1;
        let is_missed = self.is_asking && !self.is_busy && is_alone;
        self.estimation.finish::<B>(&mut self.hand, &self.scheduler, is_missed);
        self.advance();
        self.obey(false);
    }

    /// Waits without a transaction, for so many µs.
    pub(crate) async fn pause(&mut self, us: u64) {
        let until = Instant::now() + Duration::from_micros(us);
        while self.scheduler.end < until {
            Timer::at(self.scheduler.end).await;
            self.go_without();
        }
        Timer::at(until).await;
    }
}
