//! Time of a render without the pauses of its process.
//!
//! A deadline must not run out while a render is stopped (Ctrl-Z, SIGSTOP, a batch system that
//! suspends jobs). No system clock leaves that time out: the monotonic clock runs on, and a CPU clock
//! does not tell how long somebody has waited. So a thread of the process ticks: it stops with the
//! process, and a long gap between two ticks was a pause.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Time between two ticks. A pause may count as work by up to so much.
const PERIOD: Duration = Duration::from_millis(100);

/// Least gap between two ticks that counts as a pause: ten periods, which a machine under load hardly
/// delays a tick by.
const PAUSE: Duration = Duration::from_secs(1);

/// Measures time without pauses, from [`start`](Self::start) on. Its thread ends with the last handle;
/// where no thread can be started, pauses count.
#[derive(Debug)]
pub struct Clock {
    begin: Instant,
    last: Mutex<Tick>,
}

/// The state of a clock at its last tick.
#[derive(Debug, Default)]
struct Tick {
    /// Whether there has been a tick.
    has_ticked: bool,
    /// Time since the beginning, pauses included.
    at: Duration,
    /// Time since the beginning without pauses.
    worked: Duration,
}

impl Tick {
    /// Time without pauses until `now`, which counts from the beginning.
    fn worked_until(&self, now: Duration) -> Duration {
        let gap = now.saturating_sub(self.at);
        self.worked + if self.has_ticked && gap > PAUSE { PERIOD } else { gap }
    }

    fn tick(&mut self, now: Duration) {
        *self = Self { has_ticked: true, at: now, worked: self.worked_until(now) };
    }
}

impl Clock {
    /// Starts a clock at 0.
    pub fn start() -> Arc<Self> {
        let clock = Arc::new(Self { begin: Instant::now(), last: Mutex::default() });
        let ticking = Arc::downgrade(&clock);
        let ticks = move || {
            while let Some(clock) = ticking.upgrade() {
                clock.last().tick(clock.begin.elapsed());
                drop(clock);
                std::thread::sleep(PERIOD);
            }
        };
        // Without the thread the clock still runs, as its type says.
        let _ = std::thread::Builder::new().name("clock".into()).spawn(ticks);
        clock
    }

    /// Time since the start without pauses.
    pub fn elapsed(&self) -> Duration {
        // The lock comes first, so that no tick falls between reading the time and using it.
        let last = self.last();
        last.worked_until(self.begin.elapsed())
    }

    fn last(&self) -> MutexGuard<'_, Tick> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A time on a clock by which something must be done.
#[derive(Debug, Clone, Copy)]
pub struct Deadline<'a> {
    /// The clock.
    pub clock: &'a Clock,
    /// Its [`elapsed`](Clock::elapsed) time at the deadline.
    pub at: Duration,
}

impl Deadline<'_> {
    /// Time until the deadline; 0 after it.
    pub fn left(&self) -> Duration {
        self.at.saturating_sub(self.clock.elapsed())
    }

    /// Whether the deadline has passed.
    pub fn is_over(&self) -> bool {
        self.left().is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_are_not_counted() {
        let second = Duration::from_secs(1);
        let mut last = Tick::default();
        assert_eq!(last.worked_until(7 * second), 7 * second, "no tick yet");
        (0..=20).for_each(|tenth| last.tick(tenth * PERIOD));
        assert_eq!(last.worked_until(2 * second + PERIOD / 2), 2 * second + PERIOD / 2);
        // Stopped for an hour; until the next tick time stands still.
        assert_eq!(last.worked_until(3600 * second), 2 * second + PERIOD);
        assert_eq!(last.worked_until(3601 * second), 2 * second + PERIOD);
        last.tick(3601 * second);
        assert_eq!(last.worked_until(3601 * second), 2 * second + PERIOD);
        last.tick(3601 * second + PERIOD);
        assert_eq!(last.worked_until(3601 * second + PERIOD), 2 * second + 2 * PERIOD);
    }

    #[test]
    fn a_clock_runs() {
        let clock = Clock::start();
        let deadline = Deadline { clock: &clock, at: Duration::from_millis(30) };
        while !deadline.is_over() {
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(clock.elapsed() >= Duration::from_millis(30));
    }
}
