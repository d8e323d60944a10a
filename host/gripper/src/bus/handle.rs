//! The bus as the rest of the program has it: its thread does the work.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use messages::Counters;

use super::address::BusAddress;
use super::error::BusError;
use super::options::BusOptions;
use super::shared::{Asked, Shared};
use super::ticks;
use crate::source::{Order, OrderError, Setup, Source, Statistics, Told};

/// How long an order waits for the bus's thread.
const PATIENCE: Duration = Duration::from_secs(5);

/// Servos on a bus; let go when dropped.
#[derive(Debug)]
pub struct Bus {
    shared: Arc<Shared>,
    orders: Mutex<Sender<Asked>>,
    notes: Vec<String>,
    thread: Option<JoinHandle<()>>,
}

impl Bus {
    /// Opens the port, finds the servos, and begins to estimate.
    ///
    /// # Errors
    /// No port, or nobody answers on it, or not those that the settings name; a finger or an object that is refused.
    pub fn open(address: &BusAddress, options: &BusOptions) -> Result<Self, BusError> {
        let (orders, asked) = channel();
        let (ready, opened) = channel();
        let (address, options) = (address.clone(), options.clone());
        // The bus lives in its thread alone; what came of opening it is told.
        let thread = std::thread::Builder::new().name("bus".into());
        let thread = thread.spawn(move || match ticks::Ticks::open(&address, &options) {
            Ok(mut ticks) => {
                let opened = (ticks.shared(), ticks.take_notes());
                if ready.send(Ok(opened)).is_ok() {
                    ticks.run(&asked);
                }
            }
            Err(error) => {
                let _ = ready.send(Err(error));
            }
        });
        let thread = thread.map_err(BusError::Start)?;
        let (shared, notes) =
            opened.recv().map_err(|_| BusError::Start(std::io::Error::other("its thread ended")))??;
        Ok(Self { shared, orders: Mutex::new(orders), notes, thread: Some(thread) })
    }

    /// What a person should know of this bus: what makes it slower than it could be.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}

impl Source for Bus {
    fn setup(&self) -> Result<Setup, OrderError> {
        Ok(self.shared.setup().clone())
    }

    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.shared.listeners.add(waiting)
    }

    fn statistics(&self) -> Statistics {
        let now = |count: &AtomicU64| count.load(Ordering::Relaxed);
        let Shared { frames, damaged, unheard, .. } = &*self.shared;
        Statistics { frames: now(frames), damaged: now(damaged), unheard: now(unheard), ..Statistics::default() }
    }

    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Ok(None)
    }

    fn order(&self, order: &Order) -> Result<(), OrderError> {
        if let Order::Open(_) | Order::Close(_) | Order::Grip(_) | Order::Hold(_) = order {
            return Err(OrderError::Never(
                "the servos on this bus are only read: whatever leads them moves the fingers",
            ));
        }
        let (outcome, answer) = channel();
        let asked = Asked { order: order.clone(), outcome };
        let closed = || OrderError::Never("the bus is closed");
        self.orders.lock().unwrap_or_else(PoisonError::into_inner).send(asked).map_err(|_| closed())?;
        answer.recv_timeout(PATIENCE).map_err(|_| closed())?
    }

    fn is_closed(&self) -> bool {
        self.shared.closed.load(Ordering::Acquire)
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
