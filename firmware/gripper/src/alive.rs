//! Whether the tasks below the control task still run.
//!
//! Only the control task feeds the watchdog. A task below it that is stuck, in a loop or in a wait, would go unseen: the fingers hold, and
//! nobody can ask for anything any more. So each of them says regularly that it runs, and the control task restarts the program if one
//! does not, which its last words tell.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_time::{Duration, Instant, Timer};

/// How often a task says that it runs.
const BEAT: Duration = Duration::from_millis(250);
/// Silence after which a task is stuck, ms: several times what erasing a sector of flash takes.
const STUCK_MS: i32 = 10_000;

/// A task that is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Task {
    /// Restores what is kept, answers the host, writes to flash.
    Link = 0,
    /// Writes to the host.
    Send = 1,
}

impl Task {
    const ALL: [Self; 2] = [Self::Link, Self::Send];

    /// What the program says when it restarts because of this.
    pub(crate) fn last_words(self) -> &'static str {
        match self {
            Self::Link => "the task that answers the host was stuck",
            Self::Send => "the task that writes to the host was stuck",
        }
    }
}

/// When each task was last seen to run, ms since the start; wraps after 49 days.
#[derive(Debug)]
pub(crate) struct Alive([AtomicU32; Task::ALL.len()]);

impl Alive {
    /// All of them run as the program starts.
    pub(crate) const fn new() -> Self {
        Self([const { AtomicU32::new(0) }; Task::ALL.len()])
    }

    /// Says that a task runs, for as long as it does.
    pub(crate) async fn beat(&self, task: Task) -> ! {
        loop {
            self.saw(task, Instant::now().as_millis());
            Timer::after(BEAT).await;
        }
    }

    fn saw(&self, task: Task, now_ms: u64) {
        if let Some(seen) = self.0.get(task as usize) {
            seen.store(now_ms as u32, Ordering::Relaxed);
        }
    }

    /// A task that is stuck, if one is; the time since the start, ms.
    pub(crate) fn stuck(&self, now_ms: u64) -> Option<Task> {
        let silent = |seen: &AtomicU32| (now_ms as u32).wrapping_sub(seen.load(Ordering::Relaxed)) as i32;
        let is_stuck = |(_, seen): &(Task, &AtomicU32)| silent(seen) > STUCK_MS;
        Task::ALL.into_iter().zip(&self.0).find(is_stuck).map(|(task, _)| task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also where the counted time wraps.
    #[test]
    fn the_task_that_is_stuck_is_named() {
        for start in [0, u64::from(u32::MAX) - 5_000] {
            let alive = Alive::new();
            Task::ALL.into_iter().for_each(|task| alive.saw(task, start));
            for now in (start..start + 20_000).step_by(250) {
                alive.saw(Task::Send, now);
                let expected = (now - start > 10_000).then_some(Task::Link);
                assert_eq!(alive.stuck(now), expected, "{} ms", now - start);
            }
            alive.saw(Task::Link, start + 20_000);
            assert_eq!(alive.stuck(start + 20_000), None);
        }
    }
}
