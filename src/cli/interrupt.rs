//! Ctrl-C: what there is becomes the picture.

use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;

use super::console;
use crate::error::{Error, Result};
use crate::render::Stop;

/// What a shell adds to the number of the signal that ended a program.
const ENDED_BY: i32 = 128;

/// Listens for Ctrl-C and for being asked to end.
#[derive(Debug, Clone, Default)]
pub(super) struct Interrupt {
    stop: Arc<Stop>,
    signal: Arc<AtomicI32>,
    waiting: Arc<Waiting>,
}

/// How a render stands to signals before its first ray.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Early {
    /// Nobody waits for one.
    #[default]
    Idle,
    /// One is waited for.
    Awaited,
    /// There was one.
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

/// Lets nobody wait any longer, even where the work panicked.
struct Over<'a>(&'a Waiting);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.set(self.0.early(), Early::Idle);
    }
}

impl Interrupt {
    /// Listens from now on. The first signal stops the render, which keeps what there is. Before
    /// there is anything it is told to who [waits](Self::early) for it; where nobody does, and from
    /// the second signal on, it ends the program at once.
    ///
    /// # Errors
    /// Where the system does not let it listen.
    pub(super) fn listen() -> Result<Self> {
        let failed = |e| Error::Failed(format!("Ctrl-C cannot be listened for: {e}"));
        let interrupt = Self::default();
        let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(failed)?;
        let heard = interrupt.clone();
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(move || signals.forever().for_each(|signal| heard.hear(signal)))
            .map_err(failed)?;
        Ok(interrupt)
    }

    /// What the render asks whether to stop.
    pub(super) fn stop(&self) -> &Stop {
        &self.stop
    }

    /// The exit code that tells of the signal.
    pub(super) fn exit_code(&self) -> u8 {
        (ENDED_BY + self.signal.load(Ordering::Relaxed)) as u8
    }

    /// Runs `work` while `shown` waits beside it for a signal that comes before there is a picture,
    /// and is then called. Where `shown` returns, `work` goes on.
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

    /// Whether `work` beside which somebody waits is still at it.
    pub(super) fn is_early(&self) -> bool {
        *self.waiting.early() != Early::Idle && !self.stop.has_picture()
    }

    /// Ends the program, and says why.
    pub(super) fn end(&self, message: &str) -> ! {
        console::message(&format!("error: {message}"));
        signal_hook::low_level::exit(self.exit_code().into());
    }

    fn hear(&self, signal: i32) {
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
