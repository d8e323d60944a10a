//! A source's numbers, live in a terminal: status, force and what qualifies it, per finger, with the last seconds as a chart.
//!
//! Every report is heard; the picture is drawn 20 times a second. A key stops all fingers.

mod draw;
mod seen;

pub use seen::Seen;

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use messages::{Counters, Which};
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::source::{Ended, Order, OrderError, Source, Told, WAITING, alive};

/// Pictures are so far apart.
const PICTURE: Duration = Duration::from_millis(50);
/// How often a gripper's counters are asked for.
const COUNTERS: Duration = Duration::from_secs(1);

/// Why there is no live view.
#[derive(Debug, thiserror::Error)]
pub enum TerminalError {
    /// The source does not answer.
    #[error(transparent)]
    Source(Box<OrderError>),
    /// The terminal's.
    #[error("the terminal: {0}")]
    Terminal(#[from] io::Error),
}

impl From<OrderError> for TerminalError {
    fn from(error: OrderError) -> Self {
        Self::Source(Box::new(error))
    }
}

/// How soon a stop that was not taken is asked for again.
const AGAIN: Duration = Duration::from_millis(100);

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wish {
    Quit,
    Stop,
    Relax,
}

/// Shows a source until the time is over, somebody stops it, or nothing more comes.
///
/// # Errors
/// The source does not answer at the beginning; the terminal's.
pub fn show(source: &Arc<dyn Source>, length: Option<Duration>, stop: &AtomicBool) -> Result<Ended, TerminalError> {
    let told = source.hear(WAITING);
    let setup = source.setup()?;
    let counters = Mutex::new(None);
    let over = AtomicBool::new(false);
    let (orders, ordered) = channel();
    let answer = Mutex::new(None);
    let mut terminal = ratatui::try_init()?;
    let ended = std::thread::scope(|scope| {
        // Both ask the gripper, which may take its time: not where the picture is drawn.
        scope.spawn(|| count(&**source, &counters, &over));
        let (orderer, answer_to, is_over) = (&**source, &answer, &over);
        scope.spawn(move || {
            // The channel ends with the view.
            for wish in ordered {
                if wish == Wish::Relax {
                    let words = match orderer.order(&Order::Relax(Which::All)) {
                        Ok(()) => Ok("relaxed: the motors are without torque".to_owned()),
                        Err(error) => Err(error.to_string()),
                    };
                    *answer_to.lock().unwrap_or_else(PoisonError::into_inner) = Some((wish, words));
                    continue;
                }
                let mut is_taken = false;
                // Again until the gripper has taken it.
                while !is_taken && !is_over.load(Ordering::Relaxed) {
                    let words = match orderer.order(&Order::Hold(Which::All)) {
                        Ok(()) => Ok("stopped: all fingers hold".to_owned()),
                        Err(error) => Err(error.to_string()),
                    };
                    is_taken = words.is_ok();
                    *answer_to.lock().unwrap_or_else(PoisonError::into_inner) = Some((wish, words));
                    if !is_taken {
                        std::thread::sleep(AGAIN);
                    }
                }
            }
        });
        let mut seen = Seen::new(setup);
        let start = Instant::now();
        let watched = alive(&**source, || {
            loop {
                let closed = hear(&told, &mut seen);
                seen.statistics = source.statistics();
                seen.counters = *counters.lock().unwrap_or_else(PoisonError::into_inner);
                match answer.lock().unwrap_or_else(PoisonError::into_inner).take() {
                    Some((Wish::Relax, words)) => seen.relaxed(words),
                    Some((_, words)) => seen.answered(words),
                    None => {}
                }
                terminal.draw(|frame| draw::picture(frame, &seen))?;
                let late = length.is_some_and(|length| start.elapsed() >= length);
                if closed || late || stop.load(Ordering::Relaxed) {
                    return Ok(Ended { reports: seen.reports, after: start.elapsed(), closed });
                }
                while event::poll(Duration::ZERO)? {
                    match wish(&event::read()?) {
                        Some(Wish::Quit) => {
                            return Ok(Ended { reports: seen.reports, after: start.elapsed(), closed: false });
                        }
                        Some(Wish::Stop) if seen.moves() => {
                            if seen.stopping.is_none() {
                                // The thread lives as long as the view.
                                let _ = orders.send(Wish::Stop);
                            }
                            seen.asked();
                        }
                        Some(Wish::Relax) if seen.moves() && seen.stopping.is_none() => {
                            let _ = orders.send(Wish::Relax);
                        }
                        Some(Wish::Stop | Wish::Relax) | None => {}
                    }
                }
            }
        });
        over.store(true, Ordering::Relaxed);
        drop(orders);
        watched
    });
    // The person's terminal first, whatever happened.
    ratatui::try_restore()?;
    ended
}

fn wish(event: &Event) -> Option<Wish> {
    let Event::Key(KeyEvent { code, modifiers, kind: KeyEventKind::Press, .. }) = event else { return None };
    match code {
        KeyCode::Char('c') if modifiers.contains(KeyModifiers::CONTROL) => Some(Wish::Quit),
        KeyCode::Char('q' | 'Q') => Some(Wish::Quit),
        KeyCode::Char(' ') | KeyCode::Esc => Some(Wish::Stop),
        KeyCode::Char('x' | 'X') => Some(Wish::Relax),
        _ => None,
    }
}

/// Takes what comes until the next picture is due; true when nothing more comes.
fn hear(told: &Receiver<Told>, seen: &mut Seen) -> bool {
    let end = Instant::now() + PICTURE;
    loop {
        match told.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(told) => seen.take(told),
            Err(RecvTimeoutError::Timeout) => return false,
            Err(RecvTimeoutError::Disconnected) => return true,
        }
    }
}

fn count(source: &dyn Source, counters: &Mutex<Option<Counters>>, over: &AtomicBool) {
    let mut asked: Option<Instant> = None;
    while !over.load(Ordering::Relaxed) {
        if asked.is_none_or(|asked| asked.elapsed() >= COUNTERS) {
            asked = Some(Instant::now());
            // A gripper that is silent shows by its reports.
            if let Ok(Some(now)) = source.counters() {
                *counters.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
            }
        }
        std::thread::sleep(PICTURE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_stop_and_end() {
        let key = |code, modifiers| wish(&Event::Key(KeyEvent::new(code, modifiers)));
        assert_eq!(key(KeyCode::Char(' '), KeyModifiers::NONE), Some(Wish::Stop));
        assert_eq!(key(KeyCode::Esc, KeyModifiers::NONE), Some(Wish::Stop));
        assert_eq!(key(KeyCode::Char('q'), KeyModifiers::NONE), Some(Wish::Quit));
        assert_eq!(key(KeyCode::Char('c'), KeyModifiers::CONTROL), Some(Wish::Quit));
        assert_eq!(key(KeyCode::Char('c'), KeyModifiers::NONE), None);
    }
}
