//! Time, by the clock and by the processors.
//!
//! Other programs on the machine stretch what the clock tells. What the threads of this process ran is
//! hardly touched by them, and how long its threads were kept waiting for a processor the system tells
//! too.

use std::ops::{Add, Sub};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// Seconds: a moment of this process, or what lies between two.
#[derive(Debug, Clone, Copy, Default)]
pub struct Spent {
    /// By the clock.
    pub elapsed: f64,
    /// That threads ran, all together.
    pub ran: f64,
    /// That threads were ready and others had the processor, all together.
    pub waited: f64,
}

impl Spent {
    /// Now, since the process began; the clock since `start`.
    pub fn now(start: Instant) -> Self {
        let cpu = clock_gettime(ClockId::ProcessCPUTime);
        Self {
            elapsed: start.elapsed().as_secs_f64(),
            ran: cpu.tv_sec as f64 + 1e-9 * cpu.tv_nsec as f64,
            waited: waited().unwrap_or(0.0),
        }
    }

    /// What `work` takes.
    pub fn on<T>(work: impl FnOnce() -> T) -> (T, Self) {
        let start = Instant::now();
        let before = Self::now(start);
        let done = work();
        (done, Self::now(start) - before)
    }

    /// How many threads ran or would have, had there been processors enough.
    pub fn busy(&self) -> f64 {
        (self.ran + self.waited) / self.elapsed
    }

    /// What the clock would tell if no thread ever waited for a processor.
    pub fn unhindered(&self) -> f64 {
        self.ran / self.busy()
    }
}

impl Add for Spent {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            elapsed: self.elapsed + other.elapsed,
            ran: self.ran + other.ran,
            waited: self.waited + other.waited,
        }
    }
}

impl Sub for Spent {
    type Output = Self;

    fn sub(self, earlier: Self) -> Self {
        Self {
            elapsed: self.elapsed - earlier.elapsed,
            ran: self.ran - earlier.ran,
            // A thread that has ended takes what it waited with it.
            waited: (self.waited - earlier.waited).max(0.0),
        }
    }
}

/// Seconds that the threads of this process have waited for a processor; nothing where the system
/// does not tell.
fn waited() -> Option<f64> {
    let mut nanoseconds = 0_u64;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        nanoseconds += text.split_whitespace().nth(1)?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(nanoseconds).as_secs_f64())
}

/// The middle one of `values`.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}
