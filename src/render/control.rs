//! How a running render is held: watched, stopped, ended in time, kept on disk.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::checkpoint::Checkpoints;
use super::clock::Deadline;
use super::{Progress, Silent};

/// How often it is looked whether a pause is over.
const PERIOD: Duration = Duration::from_millis(5);

/// Asks a running render to end, from any thread.
#[derive(Debug, Default)]
pub struct Stop {
    asked: AtomicBool,
    exposing: AtomicBool,
    paused: AtomicBool,
}

impl Stop {
    /// Asks for the end. Rays on their way are finished, and what there is makes the picture.
    pub fn ask(&self) {
        self.asked.store(true, Ordering::Relaxed);
    }

    /// Whether the end has been asked for.
    pub fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Whether rays are being shot or were, so that there is a picture to keep. Before that there is
    /// nothing to wait for.
    pub fn has_picture(&self) -> bool {
        self.exposing.load(Ordering::Acquire)
    }

    /// There is a picture from now on.
    pub(super) fn begin_picture(&self) {
        self.exposing.store(true, Ordering::Release);
    }

    /// Photons that are being shot wait until [`go_on`](Self::go_on) is called: another thread has
    /// something to do that cannot.
    pub fn pause(&self) {
        self.paused.store(true, Ordering::Relaxed);
    }

    /// Ends a [pause](Self::pause).
    pub fn go_on(&self) {
        self.paused.store(false, Ordering::Relaxed);
    }

    /// Waits while paused.
    pub(super) fn wait(&self) {
        while self.paused.load(Ordering::Relaxed) {
            std::thread::sleep(PERIOD);
        }
    }

    /// For the next picture: there is none yet.
    pub fn begin_anew(&self) {
        self.exposing.store(false, Ordering::Release);
    }
}

/// Who is told of a render's progress, and what may end it early. Made of whom to tell alone, it lets
/// the render run to its end.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Is told of stages and of work done in them.
    pub progress: &'a dyn Progress,
    /// Ends the render when asked.
    pub stop: Option<&'a Stop>,
    /// When the picture must be there. What comes before the rays is not cut short.
    pub deadline: Option<Deadline<'a>>,
    /// Where the state is kept from time to time, and what is gone on from.
    pub checkpoints: Option<&'a Checkpoints>,
}

impl<'a, P: Progress> From<&'a P> for Control<'a> {
    fn from(progress: &'a P) -> Self {
        Self { progress, ..Self::silent() }
    }
}

impl<'a> From<&'a dyn Progress> for Control<'a> {
    fn from(progress: &'a dyn Progress) -> Self {
        Self { progress, ..Self::silent() }
    }
}

impl Control<'_> {
    /// Tells nobody, and nothing ends the render early.
    pub const fn silent() -> Self {
        Self { progress: &Silent, stop: None, deadline: None, checkpoints: None }
    }

    /// Whether the end has been asked for.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(Stop::is_asked)
    }

    /// Whether the time is over.
    pub(super) fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| deadline.is_over())
    }
}

/// Halts all workers of a stretch of work, each before its next ray.
#[derive(Debug)]
pub(super) struct Halt<'a> {
    stop: Option<&'a Stop>,
    deadline: Option<Deadline<'a>>,
    /// When the stretch ends.
    until: Option<Instant>,
    halted: AtomicBool,
}

impl<'a> Halt<'a> {
    /// For a stretch of work that ends at `until`, or before where `control` says so.
    pub(super) fn new(control: &Control<'a>, until: Option<Instant>) -> Self {
        let Control { stop, deadline, .. } = *control;
        Self { stop, deadline, until, halted: AtomicBool::new(false) }
    }

    /// Whether it has.
    pub(super) fn has_halted(&self) -> bool {
        self.halted.load(Ordering::Relaxed)
    }

    /// Whether to halt; the clock is read only where `looks`.
    pub(super) fn halts(&self, looks: bool) -> bool {
        if self.halted.load(Ordering::Relaxed) {
            return true;
        }
        let is_over = || {
            self.until.is_some_and(|until| Instant::now() >= until)
                || self.deadline.is_some_and(|deadline| deadline.is_over())
        };
        let halts = (looks && is_over()) || self.stop.is_some_and(Stop::is_asked);
        if halts {
            self.halted.store(true, Ordering::Relaxed);
        }
        halts
    }
}
