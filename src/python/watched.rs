//! Work on a thread of its own, which Python watches: it reports progress and hears Ctrl-C.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::render::{Progress, Stop};

/// Time between two looks at the work: what somebody who pressed Ctrl-C does not notice.
const PERIOD: Duration = Duration::from_millis(50);

/// What a thread unwinds with whose work was cancelled.
struct Cancelled;

/// How a piece of work ended: its result, or what its thread unwound with.
type Ended<T> = Result<T, Box<dyn Any + Send>>;

/// Progress of work that Python watches. Once it is cancelled, threads that report to it unwind.
#[derive(Debug, Default)]
pub(super) struct Watched {
    stage: Mutex<Stage>,
    done: AtomicU64,
    stop: Stop,
    is_cancelled: AtomicBool,
}

/// A stage, and how much work it is.
#[derive(Debug, Default, Clone, PartialEq)]
struct Stage {
    name: String,
    total: u64,
}

impl Watched {
    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
        self.stop.ask();
    }

    /// Unwinds where the work was cancelled. No panic is printed.
    fn end_where_cancelled(&self) {
        if self.is_cancelled.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Cancelled));
        }
    }

    /// Runs `work` without Python's lock, and calls `progress` with stage, units done and their total. What a signal or
    /// that call raises cancels the work and is returned.
    pub(super) fn run<T: Send>(
        &self,
        py: Python<'_>,
        progress: Option<Bound<'_, PyAny>>,
        work: impl FnOnce(&Self, &Stop) -> T + Send,
    ) -> PyResult<T> {
        let (sender, receiver) = sync_channel(1);
        let ended: (Ended<T>, Option<PyErr>) = thread::scope(|scope| {
            scope.spawn(move || {
                let ended = catch_unwind(AssertUnwindSafe(|| work(self, &self.stop)));
                // Where nobody waits for it any more, it is of no use.
                let _ = sender.send(ended);
            });
            self.watch(py, receiver, progress.as_ref())
        });
        match ended {
            (_, Some(raised)) => Err(raised),
            (Ok(result), None) => Ok(result),
            (Err(panic), None) => resume_unwind(panic),
        }
    }

    /// Waits for the end of the work, and returns what was raised meanwhile as well.
    fn watch<T: Send>(
        &self,
        py: Python<'_>,
        mut receiver: Receiver<Ended<T>>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> (Ended<T>, Option<PyErr>) {
        let (mut raised, mut told) = (None, None);
        loop {
            let (back, received) = py.detach(move || {
                let received = receiver.recv_timeout(PERIOD);
                (receiver, received)
            });
            receiver = back;
            if raised.is_none() {
                let heard = py.check_signals().and_then(|()| self.tell(progress, &mut told));
                raised = heard.err();
                raised.iter().for_each(|_| self.cancel());
            }
            match received {
                Ok(ended) => return (ended, raised),
                Err(RecvTimeoutError::Disconnected) => return (Err(Box::new(Cancelled)), raised),
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    }

    /// Calls `progress` where there is something new since what was `told` last.
    fn tell(
        &self,
        progress: Option<&Bound<'_, PyAny>>,
        told: &mut Option<(Stage, u64)>,
    ) -> PyResult<()> {
        let (stage, done) = (self.stage().clone(), self.done.load(Ordering::Relaxed));
        let Some(progress) = progress.filter(|_| !stage.name.is_empty()) else { return Ok(()) };
        let next = Some((stage.clone(), done));
        if *told != next {
            progress.call1((&stage.name, done, stage.total))?;
            *told = next;
        }
        Ok(())
    }
}

impl Progress for Watched {
    fn stage(&self, name: &str, total: u64) {
        self.end_where_cancelled();
        *self.stage() = Stage { name: name.into(), total };
        self.done.store(0, Ordering::Relaxed);
    }

    fn advance(&self, units: u64) {
        self.end_where_cancelled();
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    fn weigh(&self, done: u64, total: u64) {
        self.stage().total = total;
        self.done.store(done, Ordering::Relaxed);
    }

    fn finish(&self) {
        self.done.store(self.stage().total, Ordering::Relaxed);
    }
}
