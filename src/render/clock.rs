//! Time as a render has it: while its process is stopped or the machine sleeps, none goes by.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often a clock is looked at.
const PERIOD: Duration = Duration::from_millis(100);

/// Where a clock has not been looked at for so long, the program was paused.
const PAUSED: Duration = Duration::from_secs(1);

/// Counts time without pauses, from when it was started. A thread of its own looks at it; without
/// that pauses count.
#[derive(Debug)]
pub struct Clock {
    begin: Instant,
    seen: Mutex<Seen>,
}

/// The last look.
#[derive(Debug, Default)]
struct Seen {
    /// Whether there has been one.
    ever: bool,
    /// When it was, since the beginning.
    at: Duration,
    /// The part of that which was no pause.
    worked: Duration,
}

impl Seen {
    /// Time without pauses until `now`.
    fn worked(&self, now: Duration) -> Duration {
        let gap = now.saturating_sub(self.at);
        self.worked + if self.ever && gap > PAUSED { PERIOD } else { gap }
    }

    fn look(&mut self, now: Duration) {
        *self = Self { ever: true, at: now, worked: self.worked(now) };
    }
}

impl Clock {
    /// Begins at 0.
    pub fn start() -> Arc<Self> {
        let clock = Arc::new(Self { begin: Instant::now(), seen: Mutex::default() });
        let watched = Arc::downgrade(&clock);
        let watch = move || {
            while let Some(clock) = watched.upgrade() {
                clock.seen().look(clock.begin.elapsed());
                drop(clock);
                std::thread::sleep(PERIOD);
            }
        };
        // What that costs is told above.
        let _ = std::thread::Builder::new().name("clock".into()).spawn(watch);
        clock
    }

    /// Time that has gone by without pauses.
    pub fn elapsed(&self) -> Duration {
        // The lock first: a look after the time was taken would pass for a pause.
        let seen = self.seen();
        seen.worked(self.begin.elapsed())
    }

    fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A moment on a clock.
#[derive(Debug, Clone, Copy)]
pub struct Deadline<'a> {
    /// The clock.
    pub clock: &'a Clock,
    /// What it shows then.
    pub at: Duration,
}

impl Deadline<'_> {
    /// Time until then; nothing where it is over.
    pub fn left(&self) -> Duration {
        self.at.saturating_sub(self.clock.elapsed())
    }

    /// Whether it is over.
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
        let mut seen = Seen::default();
        assert_eq!(seen.worked(7 * second), 7 * second, "nobody looks");
        (0..=20).for_each(|tenth| seen.look(tenth * PERIOD));
        assert_eq!(seen.worked(2 * second + PERIOD / 2), 2 * second + PERIOD / 2);
        // Stopped for an hour; until the next look time stands still.
        assert_eq!(seen.worked(3600 * second), 2 * second + PERIOD);
        assert_eq!(seen.worked(3601 * second), 2 * second + PERIOD);
        seen.look(3601 * second);
        assert_eq!(seen.worked(3601 * second), 2 * second + PERIOD);
        seen.look(3601 * second + PERIOD);
        assert_eq!(seen.worked(3601 * second + PERIOD), 2 * second + 2 * PERIOD);
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
