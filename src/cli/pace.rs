//! The time that is left of a stage, estimated from its recent pace.

use std::collections::VecDeque;
use std::time::Duration;

/// Share of the finished work whose pace is taken for the rest: caches that fill, and what is done for the
/// first ray of a pixel alone, make the beginning slower.
const RECENT: f64 = 0.4;

/// Largest number of moments that are remembered.
const MOMENTS: usize = 512;

/// The pace of a stage: work against time at some moments.
#[derive(Debug)]
pub(super) struct Pace {
    total: u64,
    done: u64,
    begin: Duration,
    /// Time that the stage has taken.
    worked: Duration,
    /// The part of it for work that is done once.
    apart: Duration,
    /// Time, without what is apart, and work of some moments before.
    moments: VecDeque<(Duration, u64)>,
}

impl Pace {
    /// A stage of `total` units of work that begins at the time `now` of a clock without pauses.
    pub(super) fn new(total: u64, now: Duration) -> Self {
        let moments = VecDeque::from([(Duration::ZERO, 0)]);
        let zero = Duration::ZERO;
        Self { total, done: 0, begin: now, worked: zero, apart: zero, moments }
    }

    /// Records that `done` units are done at the time `now`. The time `apart` went into work that is done
    /// once, and is left out of the pace.
    pub(super) fn look(&mut self, now: Duration, done: u64, apart: Duration) {
        self.worked = now.saturating_sub(self.begin);
        self.apart = apart.min(self.worked);
        if done == self.done {
            return;
        }
        self.done = done.min(self.total);
        if self.moments.len() == MOMENTS {
            // Every other one goes: they are as dense as the whole time needs.
            let mut index = 0;
            self.moments.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
        self.moments.push_back((self.worked - self.apart, self.done));
    }

    /// Redefines the units: `done` are done out of `total`.
    pub(super) fn weigh(&mut self, done: u64, total: u64) {
        let factor = done as f64 / self.done.max(1) as f64;
        self.moments.iter_mut().for_each(|(_, units)| *units = (*units as f64 * factor) as u64);
        (self.done, self.total) = (done, total);
    }

    /// Share of the work that is done, 0 to 1.
    pub(super) fn share(&self) -> f64 {
        self.done as f64 / self.total.max(1) as f64
    }

    /// Time that the stage has taken.
    pub(super) fn worked(&self) -> Duration {
        self.worked
    }

    /// Estimated time until the end; `None` before any work is done.
    pub(super) fn left(&self) -> Option<Duration> {
        let &(now, done) = self.moments.back().filter(|(_, done)| *done > 0)?;
        let recent = (done as f64 * (1.0 - RECENT)) as u64;
        let mut earlier = self.moments.iter().rev().skip_while(|(_, done)| *done > recent);
        let &(then, before) = earlier.next()?;
        let each = now.saturating_sub(then).as_secs_f64() / (done - before).max(1) as f64;
        let since = (self.worked - self.apart).saturating_sub(now);
        let left = each * (self.total - done) as f64 - since.as_secs_f64();
        Some(Duration::from_secs_f64(left.max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a stage whose unit `i` of `total` takes `cost(i)` seconds; checks what it tells from a
    /// tenth of the work on.
    fn run(total: u64, cost: impl Fn(u64) -> f64, within: f64) {
        let all: f64 = (0..total).map(&cost).sum();
        let begin = 77.0;
        let mut pace = Pace::new(total, Duration::from_secs_f64(begin));
        let (mut clock, mut worked) = (begin, 0.0);
        for i in 0..total {
            let mut unit = cost(i);
            worked += unit;
            while unit > 0.0 {
                let slice = unit.min(0.1);
                (clock, unit) = (clock + slice, unit - slice);
                pace.look(Duration::from_secs_f64(clock), i, Duration::ZERO);
            }
            pace.look(Duration::from_secs_f64(clock), i + 1, Duration::ZERO);
            if 10 * (i + 1) >= total {
                let (told, right) = (pace.left().unwrap().as_secs_f64(), all - worked);
                let off = (told - right).abs();
                assert!(off <= within * right + 0.5, "{told} s told, {right} s left at {i}");
            }
        }
    }

    #[test]
    fn an_even_pace_is_told_rightly() {
        run(1000, |_| 0.05, 0.05);
        run(40, |_| 3.0, 0.05);
    }

    #[test]
    fn a_slow_beginning_is_forgotten() {
        run(1600, |i| if i < 90 { 0.2 } else { 0.05 }, 0.2);
    }

    #[test]
    fn what_is_done_once_is_left_out() {
        let (mut pace, mut clock, mut apart) = (Pace::new(100, Duration::ZERO), 0.0, 0.0);
        for unit in 0..10 {
            let once = 4.0 * 0.7_f64.powi(unit);
            (clock, apart) = (clock + 1.0 + once, apart + once);
            let [now, apart] = [clock, apart].map(Duration::from_secs_f64);
            pace.look(now, unit as u64 + 1, apart);
        }
        let told = pace.left().unwrap().as_secs_f64();
        assert!((told - 90.0).abs() < 1e-6, "{told}");
        assert_eq!(pace.worked(), Duration::from_secs_f64(clock));
    }

    #[test]
    fn work_can_be_counted_anew() {
        let mut pace = Pace::new(100, Duration::ZERO);
        for second in 1..=10 {
            pace.look(Duration::from_secs(second), second, Duration::ZERO);
        }
        pace.weigh(40, 100);
        assert_eq!(pace.left(), Some(Duration::from_secs(15)));
        assert_eq!(pace.share(), 0.4);
    }

    #[test]
    fn nothing_is_told_before_anything_is_done() {
        let mut pace = Pace::new(10, Duration::ZERO);
        pace.look(Duration::from_secs(1), 0, Duration::ZERO);
        assert_eq!(pace.left(), None);
        assert_eq!(Pace::new(0, Duration::ZERO).left(), None);
    }
}
