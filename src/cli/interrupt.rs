//! Signals: Ctrl-C and SIGTERM end a render, and the samples so far become its picture; SIGUSR1 asks to see them.

use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::iterator::Signals;

use super::console;
use crate::error::{Error, Result};
use crate::render::Stop;

/// What a shell adds to the number of the signal that ended a program.
const ENDED_BY: i32 = 128;

/// Listens for SIGINT (Ctrl-C), SIGTERM and SIGUSR1.
#[derive(Debug, Clone, Default)]
pub(super) struct Interrupt {
    stop: Arc<Stop>,
    preview: Arc<AtomicBool>,
    signal: Arc<AtomicI32>,
    waiting: Arc<Waiting>,
}

/// State of a render before its first ray, towards signals.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Early {
    /// No thread waits for a signal.
    #[default]
    Idle,
    /// A thread waits for one.
    Awaited,
    /// A signal came.
    Heard,
}

#[derive(Debug, Default)]
struct Waiting {
    early: Mutex<Early>,
    changed: Condvar,
}

impl Waiting {
    fn early(&self) -> MutexGuard<'_, Early> {
        self.early.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, mut early: MutexGuard<'_, Early>, to: Early) {
        *early = to;
        self.changed.notify_all();
    }
}

/// Ends the waiting when dropped, even where the work panicked.
struct Over<'a>(&'a Waiting);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.set(self.0.early(), Early::Idle);
    }
}

impl Interrupt {
    /// Starts to listen. The first signal stops the render, which saves its picture. Before the first ray it
    /// wakes the thread that [waits](Self::early) for it. Where none does, and from the second signal on, it
    /// ends the program at once.
    ///
    /// # Errors
    /// Where the system does not let it listen.
    pub(super) fn listen() -> Result<Self> {
        let failed = |e| Error::Failed(format!("Ctrl-C cannot be listened for: {e}"));
        let interrupt = Self::default();
        let mut signals = Signals::new([SIGINT, SIGTERM, SIGUSR1]).map_err(failed)?;
        let heard = interrupt.clone();
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(move || signals.forever().for_each(|signal| heard.hear(signal)))
            .map_err(failed)?;
        Ok(interrupt)
    }

    /// Leaves the first signal from now on to work that watches [`stop`](Self::stop), as it is with rays.
    pub(super) fn defer(&self) {
        self.stop.begin_picture();
    }

    /// The stop request that the render watches.
    pub(super) fn stop(&self) -> &Stop {
        &self.stop
    }

    /// Set where a preview is asked for.
    pub(super) fn preview(&self) -> &AtomicBool {
        &self.preview
    }

    /// The exit code for the signal.
    pub(super) fn exit_code(&self) -> u8 {
        (ENDED_BY + self.signal.load(Ordering::Relaxed)) as u8
    }

    /// Runs `work`. Where a signal comes before the first ray, `shown` is called beside it on another
    /// thread. Where `shown` returns, `work` goes on.
    pub(super) fn early<T>(&self, shown: impl FnOnce() + Send, work: impl FnOnce() -> T) -> T {
        self.waiting.set(self.waiting.early(), Early::Awaited);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let awaited = |early: &mut Early| *early == Early::Awaited;
                let early = self.waiting.changed.wait_while(self.waiting.early(), awaited);
                let early = *early.unwrap_or_else(PoisonError::into_inner);
                if early == Early::Heard {
                    shown();
                }
            });
            let _over = Over(&self.waiting);
            work()
        })
    }

    /// Whether the work of [`early`](Self::early) still runs and has shot no ray.
    pub(super) fn is_early(&self) -> bool {
        *self.waiting.early() != Early::Idle && !self.stop.has_picture()
    }

    /// Ends the program with an error message.
    pub(super) fn end(&self, message: &str) -> ! {
        console::message(&format!("error: {message}"));
        signal_hook::low_level::exit(self.exit_code().into());
    }

    fn hear(&self, signal: i32) {
        if signal == SIGUSR1 {
            self.preview.store(true, Ordering::Relaxed);
            return;
        }
        let is_first = self.signal.swap(signal, Ordering::Relaxed) == 0;
        if !is_first {
            signal_hook::low_level::exit(ENDED_BY + signal);
        }
        if self.stop.has_picture() {
            self.stop.ask();
            return;
        }
        let early = self.waiting.early();
        if *early == Early::Awaited {
            self.waiting.set(early, Early::Heard);
            return;
        }
        self.end(
            "interrupted before the first ray: there is no picture, and files are as they were",
        );
    }
}
