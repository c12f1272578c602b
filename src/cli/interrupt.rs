//! Ctrl-C: what there is becomes the picture.

use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};

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
}

impl Interrupt {
    /// Listens from now on. The first signal stops the render, which keeps what there is; before
    /// there is anything, and from the second signal on, it ends the program at once.
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

    fn hear(&self, signal: i32) {
        self.signal.store(signal, Ordering::Relaxed);
        if !self.stop.has_picture() {
            console::message(
                "error: interrupted before the first ray: there is no picture, and files are as \
                 they were",
            );
        } else if !self.stop.is_asked() {
            self.stop.ask();
            return;
        }
        signal_hook::low_level::exit(ENDED_BY + signal);
    }
}
