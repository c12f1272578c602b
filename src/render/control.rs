//! Control of a running render: progress, stop, pause, deadline, checkpoints and previews.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::checkpoint::Checkpoints;
use super::clock::Deadline;
use super::progress::{Progress, Silent};
use super::rendered::{Ended, Rendered};

/// Time between two checks of whether a pause is over: well below what somebody notices.
const PERIOD: Duration = Duration::from_millis(5);

/// Least ratio of the time between two previews to the time that showing one takes: rays wait a fifth of the time at most.
pub const PREVIEW_RATIO: u32 = 4;

/// A request to a running render to end or to pause, made from any thread.
#[derive(Debug, Default)]
pub struct Stop {
    requested: AtomicBool,
    has_picture: AtomicBool,
    paused: AtomicBool,
}

impl Stop {
    /// Requests the end. Rays on their way are finished, and the samples so far make the picture.
    pub fn ask(&self) {
        self.requested.store(true, Ordering::Relaxed);
    }

    /// Whether the end was requested.
    pub fn is_asked(&self) -> bool {
        self.requested.load(Ordering::Relaxed)
    }

    /// Whether rays are or were shot, so that there is a picture to save. Before that there is nothing
    /// worth waiting for.
    pub fn has_picture(&self) -> bool {
        self.has_picture.load(Ordering::Acquire)
    }

    /// Marks that rays begin.
    pub fn begin_picture(&self) {
        self.has_picture.store(true, Ordering::Release);
    }

    /// Halts the threads that shoot photons until [`go_on`](Self::go_on) is called, so that another
    /// thread gets the processors.
    pub fn pause(&self) {
        self.paused.store(true, Ordering::Relaxed);
    }

    /// Ends a [`pause`](Self::pause).
    pub fn go_on(&self) {
        self.paused.store(false, Ordering::Relaxed);
    }

    /// Blocks the calling thread while paused.
    pub(super) fn wait(&self) {
        while self.paused.load(Ordering::Relaxed) {
            std::thread::sleep(PERIOD);
        }
    }

    /// Prepares for the next picture of a sequence: no ray of it was shot yet.
    pub fn begin_anew(&self) {
        self.has_picture.store(false, Ordering::Release);
    }
}

/// Shows the picture while it gets better.
#[derive(Clone, Copy)]
pub struct Preview<'a> {
    /// Time between two moments to show it; `None` where it is only shown when asked for.
    pub every: Option<Duration>,
    /// Set by any thread that asks for a picture at once.
    pub asked: &'a AtomicBool,
    /// Called at each such moment, and after each round of a render to a stated error, while rays wait: with whether a
    /// picture was asked for, and with what makes it, which is left alone where nobody wants to see it.
    pub show: &'a (dyn Fn(bool, PictureSoFar<'_>) + Sync),
}

/// Makes the picture so far, which is marked as [stopped](super::Ended::Stopped).
pub type PictureSoFar<'a> = &'a dyn Fn() -> Rendered;

/// When the next picture is shown.
pub(super) struct PreviewTimer<'a> {
    preview: Option<Preview<'a>>,
    due: Option<Instant>,
}

impl<'a> PreviewTimer<'a> {
    /// Starts where the rays do.
    pub fn new(preview: Option<Preview<'a>>) -> Self {
        let due = preview.and_then(|preview| Instant::now().checked_add(preview.every?));
        Self { preview, due }
    }

    /// When the next picture is due; `None` where none is that nobody asks for.
    pub const fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Shows the `picture` where one is due or asked for.
    pub fn show(&mut self, picture: PictureSoFar<'_>) {
        let Some(Preview { every, asked, show }) = self.preview else { return };
        let start = Instant::now();
        let asked = asked.swap(false, Ordering::Relaxed);
        if !asked && self.due.is_none_or(|due| start < due) {
            return;
        }
        show(asked, picture);
        let pause = every.map(|every| every.max(start.elapsed() * PREVIEW_RATIO));
        self.due = pause.and_then(|pause| Instant::now().checked_add(pause));
    }
}

/// Receiver of a render's progress, and what may end it early. Converted from a [`Progress`] alone, it
/// lets the render run to its end.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Receives stages and the work done in them.
    pub progress: &'a dyn Progress,
    /// Ends or pauses the render on request.
    pub stop: Option<&'a Stop>,
    /// Time by which rays end. The stages before them are not cut short.
    pub deadline: Option<Deadline<'a>>,
    /// Where checkpoints are written, and the one that is resumed.
    pub checkpoints: Option<&'a Checkpoints>,
    /// Shows the picture while it gets better.
    pub preview: Option<Preview<'a>>,
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
    /// Reports to nobody and never ends a render early.
    pub const fn silent() -> Self {
        Self { progress: &Silent, stop: None, deadline: None, checkpoints: None, preview: None }
    }

    /// Whether the end was requested.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.is_some_and(Stop::is_asked)
    }

    /// Whether the deadline has passed.
    pub(super) fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| deadline.is_over())
    }

    /// Why a pass was halted: `Complete` where only a checkpoint or preview was due.
    pub(super) fn ended(&self) -> Ended {
        if self.is_stopped() {
            Ended::Stopped
        } else if self.is_late() {
            Ended::OutOfTime
        } else {
            Ended::Complete
        }
    }
}

/// Halts all threads of a pass, each before its next ray: on request, at the deadline, or when a checkpoint or preview is
/// due.
#[derive(Debug)]
pub(super) struct Halt<'a> {
    stop: Option<&'a Stop>,
    deadline: Option<Deadline<'a>>,
    /// When the next checkpoint or preview is due.
    until: Option<Instant>,
    /// Whether a preview was asked for.
    asked: Option<&'a AtomicBool>,
    halted: AtomicBool,
}

impl<'a> Halt<'a> {
    /// Halts at `until`, or earlier where `control` ends the render.
    pub(super) fn new(control: &Control<'a>, until: Option<Instant>) -> Self {
        let Control { stop, deadline, preview, .. } = *control;
        let asked = preview.map(|preview| preview.asked);
        Self { stop, deadline, until, asked, halted: AtomicBool::new(false) }
    }

    /// Whether threads were halted.
    pub(super) fn has_halted(&self) -> bool {
        self.halted.load(Ordering::Relaxed)
    }

    /// Whether to halt. The clock, which costs time, is read only where `looks`.
    pub(super) fn halts(&self, looks: bool) -> bool {
        if self.halted.load(Ordering::Relaxed) {
            return true;
        }
        let is_over = || {
            self.until.is_some_and(|until| Instant::now() >= until)
                || self.deadline.is_some_and(|deadline| deadline.is_over())
        };
        let halts = (looks && is_over())
            || self.stop.is_some_and(Stop::is_asked)
            || self.asked.is_some_and(|asked| asked.load(Ordering::Relaxed));
        if halts {
            self.halted.store(true, Ordering::Relaxed);
        }
        halts
    }
}
