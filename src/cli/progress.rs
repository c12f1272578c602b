//! Progress on stderr: bars with remaining time on a terminal, plain lines elsewhere. Others may watch it.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::console;
use super::pace::Pace;
use super::units;
use crate::render::{Clock, Progress, ReachedError};

/// Time between two updates of what is shown.
const PERIOD: Duration = Duration::from_millis(100);

/// A stage that takes less gets one line, when it is over.
const SHORT: Duration = Duration::from_secs(2);

/// The stage whose units take equally long from the first on, so that its remaining time is shown before
/// its first part is done. The first rays are slower than the rest.
const EVEN: &str = "photons";

/// It is shown where at least the first time is left, once the stage has run for the second.
const LONG: [Duration; 2] = [Duration::from_secs(60), Duration::from_secs(5)];

/// Parts of the work after each of which a line is printed.
const LINES: f64 = 10.0;

/// How stages are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    Bars,
    Lines,
    Hidden,
}

/// The stage that is shown.
#[derive(Debug)]
struct Stage {
    name: String,
    pace: Pace,
    style: Style,
    /// Where there are bars.
    bar: Option<ProgressBar>,
    /// Parts of the work that a line was printed for, once there was one.
    printed: Option<u64>,
}

/// State of a stage, which a thread of its own shows.
#[derive(Debug)]
struct Shown {
    clock: Arc<Clock>,
    style: Style,
    done: AtomicU64,
    /// Nanoseconds of work that is done once.
    once: AtomicU64,
    stage: Mutex<Option<Stage>>,
    /// The error after the last round of a render to a stated error.
    reached: Mutex<Option<ReachedError>>,
}

/// Shows the stages of a render on stderr, each in one line of at most the terminal's width.
#[derive(Debug)]
pub(super) struct Console {
    shown: Arc<Shown>,
}

/// Tells others how far a render is.
#[derive(Debug, Clone)]
pub(super) struct Watch(Arc<Shown>);

/// How far a stage is.
#[derive(Debug, Clone)]
pub(super) struct StageProgress {
    pub(super) name: String,
    /// Share of the work that is done, 0 to 1.
    pub(super) share: f64,
    /// Time that it has taken.
    pub(super) worked: Duration,
    /// Estimated time until its end.
    pub(super) left: Option<Duration>,
}

impl Watch {
    /// The stage that runs; `None` between two.
    pub(super) fn stage(&self) -> Option<StageProgress> {
        let mut stage = self.0.stage();
        let Stage { name, pace, .. } = stage.as_mut()?;
        self.0.update(pace);
        let (share, worked, left) = (pace.share(), pace.worked(), pace.left());
        Some(StageProgress { name: name.clone(), share, worked, left })
    }

    /// The error of the picture so far, where that is known.
    pub(super) fn reached(&self) -> Option<ReachedError> {
        *self.0.reached()
    }
}

impl Console {
    /// Nothing where it is `quiet`, bars where stderr is a terminal, otherwise lines, with the time of `clock`.
    pub(super) fn new(clock: Arc<Clock>, quiet: bool) -> Self {
        let style = match (quiet, std::io::stderr().is_terminal()) {
            (true, _) => Style::Hidden,
            (false, true) => Style::Bars,
            (false, false) => Style::Lines,
        };
        let shown = Arc::new(Shown {
            clock,
            style,
            done: AtomicU64::new(0),
            once: AtomicU64::new(0),
            stage: Mutex::new(None),
            reached: Mutex::new(None),
        });
        let seen = Arc::downgrade(&shown);
        let watch = move || {
            while let Some(shown) = seen.upgrade() {
                shown.look();
                drop(shown);
                std::thread::sleep(PERIOD);
            }
        };
        // Without the thread only the remaining time is missing.
        let _ = std::thread::Builder::new().name("progress".into()).spawn(watch);
        Self { shown }
    }

    /// For others to look at.
    pub(super) fn watch(&self) -> Watch {
        Watch(self.shown.clone())
    }
}

impl Shown {
    fn stage(&self) -> MutexGuard<'_, Option<Stage>> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn reached(&self) -> MutexGuard<'_, Option<ReachedError>> {
        self.reached.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads clock and work, and shows them.
    fn look(&self) {
        if let Some(stage) = self.stage().as_mut() {
            self.update(&mut stage.pace);
            stage.show(self.done.load(Ordering::Relaxed));
        }
    }

    /// Updates `pace`.
    fn update(&self, pace: &mut Pace) {
        let once = Duration::from_nanos(self.once.load(Ordering::Relaxed));
        pace.look(self.clock.elapsed(), self.done.load(Ordering::Relaxed), once);
    }
}

impl Stage {
    fn show(&mut self, done: u64) {
        let worked = self.pace.worked();
        let left = self.pace.left();
        if let Some(bar) = &self.bar {
            bar.set_position(done);
            let shown = left
                .map_or_else(|| units::brief(worked), |left| format!("ETA {}", units::brief(left)));
            bar.set_prefix(shown);
            return;
        }
        if self.style == Style::Hidden {
            return;
        }
        let part = (self.pace.share() * LINES) as u64;
        let Some(left) = left else { return };
        let is_even = self.name == EVEN && self.printed.is_none();
        let is_long = is_even && left >= LONG[0] && worked >= LONG[1];
        let is_further = part > self.printed.unwrap_or(0) && worked >= SHORT;
        if (is_long || is_further) && part < LINES as u64 {
            self.printed = Some(part);
            console::message(&format!(
                "{}: {:.0} % after {:.1} s, ETA {}",
                self.name,
                100.0 * self.pace.share(),
                worked.as_secs_f64(),
                units::brief(left)
            ));
        }
    }
}

impl Progress for Console {
    fn stage(&self, name: &str, total: u64) {
        self.finish();
        let style = || {
            let template = "{msg:>10} [{wide_bar}] {percent:>3} % {prefix}";
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
        };
        let bar = || ProgressBar::new(total).with_message(name.to_owned()).with_style(style());
        self.shown.done.store(0, Ordering::Relaxed);
        self.shown.once.store(0, Ordering::Relaxed);
        *self.shown.stage() = Some(Stage {
            name: name.to_owned(),
            pace: Pace::new(total, self.shown.clock.elapsed()),
            style: self.shown.style,
            bar: (self.shown.style == Style::Bars).then(bar),
            printed: None,
        });
    }

    fn advance(&self, units: u64) {
        self.shown.done.fetch_add(units, Ordering::Relaxed);
    }

    fn once(&self, time: Duration) {
        self.shown.once.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
    }

    fn weigh(&self, done: u64, total: u64) {
        if let Some(stage) = self.shown.stage().as_mut() {
            self.shown.done.store(done, Ordering::Relaxed);
            stage.pace.weigh(done, total);
            if let Some(bar) = &stage.bar {
                bar.set_length(total);
            }
        }
    }

    fn finish(&self) {
        let Some(mut stage) = self.shown.stage().take() else { return };
        let done = self.shown.done.load(Ordering::Relaxed);
        self.shown.update(&mut stage.pace);
        if let Some(bar) = stage.bar.take() {
            bar.set_position(done);
            bar.set_prefix(units::brief(stage.pace.worked()));
            bar.abandon();
        } else if stage.style == Style::Lines {
            let took = stage.pace.worked().as_secs_f64();
            console::message(&format!("{}: {took:.2} s", stage.name));
        }
    }

    fn warn(&self, text: &str) {
        if self.shown.style != Style::Hidden {
            console::message(&format!("warning: {text}"));
        }
    }

    fn reached(&self, error: &ReachedError) {
        *self.shown.reached() = Some(*error);
    }
}
