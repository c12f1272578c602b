//! Checkpoints: the state of a render on disk, from which one that was killed resumes.
//!
//! Photons are not stored. They are shot again, and are the same.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use crate::cache::LazyCells;
use crate::error::{Error, Result};
use crate::math::Spectrum;
use crate::work::Work;

use super::checkpoint_file::{self, CacheState, CheckpointState};
use super::progress::Progress;
use super::rounds::Round;
use crate::film::{Importance, TiledFilm};

/// Least ratio of the time between checkpoints to the time that one takes: writing them takes at most 5 %.
const MIN_INTERVAL_RATIO: u32 = 20;

/// The checkpoint file of a render, and the state of an earlier run that is resumed.
#[derive(Debug)]
pub struct Checkpoints {
    path: PathBuf,
    key: Map<String, Value>,
    every: Duration,
    resumed: Mutex<Option<CheckpointState>>,
    resumes: bool,
    /// Rounds that were begun, where the render has rounds.
    rounds: Mutex<Vec<Round>>,
}

impl Checkpoints {
    /// Writes checkpoints to the file `path`, one after each interval `every`, or more seldom where
    /// writing takes long. `key` identifies the picture: it holds all that its bytes depend on.
    pub fn new(path: &Path, key: Map<String, Value>, every: Duration) -> Self {
        Self {
            path: path.into(),
            key,
            every,
            resumed: Mutex::new(None),
            resumes: false,
            rounds: Mutex::default(),
        }
    }

    /// As [`new`](Self::new), and resumes the render of which the file is a checkpoint, where there is
    /// one.
    ///
    /// # Errors
    /// Where the file cannot be read, is damaged or of another picture.
    pub fn resume(path: &Path, key: Map<String, Value>, every: Duration) -> Result<Self> {
        let fresh = Self::new(path, key, every);
        if !path.exists() {
            return Ok(fresh);
        }
        let state = checkpoint_file::read(path, &fresh.key)?;
        let rounds = Mutex::new(state.rounds.clone());
        Ok(Self { resumed: Mutex::new(Some(state)), resumes: true, rounds, ..fresh })
    }

    /// The key of the checkpoint `path`; `None` where there is no such file.
    ///
    /// # Errors
    /// Where it cannot be read or is damaged.
    pub fn key_of(path: &Path) -> Result<Option<Map<String, Value>>> {
        if path.exists() { checkpoint_file::key(path).map(Some) } else { Ok(None) }
    }

    /// Whether an earlier run is resumed.
    pub fn resumes(&self) -> bool {
        self.resumes
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Camera rays of the runs before this one; 0 once the render has taken them over.
    pub fn rays(&self) -> u64 {
        self.lock().as_ref().map_or(0, |state| state.work.rays)
    }

    /// Removes the file: the picture is finished.
    ///
    /// # Errors
    /// Where it is there and cannot be removed.
    pub fn remove(&self) -> Result<()> {
        if !self.path.is_file() {
            return Ok(());
        }
        std::fs::remove_file(&self.path)
            .map_err(|e| Error::file(&self.path, format!("cannot be removed: {e}")))
    }

    /// Restores the filled cells of `caches`. No work is counted for them: the checkpoint's holds it.
    ///
    /// # Errors
    /// Where they differ in size from the caches of the earlier run.
    pub(super) fn restore<S: Spectrum>(&self, caches: &[&LazyCells<S>]) -> Result<()> {
        let mut resumed = self.lock();
        let Some(state) = resumed.as_mut() else { return Ok(()) };
        let fits = state.caches.len() == caches.len()
            && state.caches.iter().zip(caches).all(|(stored, cache)| stored.head.fits(cache));
        if !fits {
            return Err(Error::file(
                &self.path,
                "has caches of another size than this machine makes; delete it to start anew",
            ));
        }
        for (CacheState { known, bits, .. }, cache) in state.caches.drain(..).zip(caches) {
            let bits = bits.chunks_exact(S::NUMBERS);
            known.iter().zip(bits).for_each(|(cell, bits)| cache.restore(*cell, bits));
        }
        Ok(())
    }

    /// Importance of the pixels that a director of the earlier run has measured; empty where it has not.
    pub(super) fn importance(&self) -> Vec<Importance> {
        self.lock().as_ref().map_or_else(Vec::new, |state| state.film.importance.clone())
    }

    /// The rounds that were begun, of which the last is in progress.
    pub(super) fn rounds(&self) -> Vec<Round> {
        self.lock_rounds().clone()
    }

    /// Keeps the `rounds` that were begun for the checkpoints to come.
    pub(super) fn begin_round(&self, rounds: &[Round]) {
        *self.lock_rounds() = rounds.to_vec();
    }

    /// Takes the state of the earlier run, for the render to start from.
    pub(super) fn take(&self) -> Option<CheckpointState> {
        self.lock().take()
    }

    fn lock(&self) -> MutexGuard<'_, Option<CheckpointState>> {
        self.resumed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn lock_rounds(&self) -> MutexGuard<'_, Vec<Round>> {
        self.rounds.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writes the checkpoints of one render.
#[derive(Debug)]
pub(super) struct CheckpointWriter<'a> {
    checkpoints: Option<&'a Checkpoints>,
    due: Option<Instant>,
    problem: Option<String>,
}

impl<'a> CheckpointWriter<'a> {
    /// Writes to the file of `checkpoints`, or nothing without them.
    pub(super) fn new(checkpoints: Option<&'a Checkpoints>) -> Self {
        let due = checkpoints.and_then(|c| Instant::now().checked_add(c.every));
        Self { checkpoints, due, problem: None }
    }

    /// When the next checkpoint is due; `None` where no more are written.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Whether the next checkpoint is due.
    pub(super) fn is_due(&self) -> bool {
        self.due.is_some_and(|due| Instant::now() >= due)
    }

    /// Writes a checkpoint. Where that fails the earlier file stays, `progress` is warned, no other is
    /// tried, and the render goes on.
    pub(super) fn write<S: Spectrum>(
        &mut self,
        work: &Work,
        film: &TiledFilm,
        caches: &[&LazyCells<S>],
        progress: &dyn Progress,
    ) {
        let Some(checkpoints) = self.checkpoints.filter(|_| self.problem.is_none()) else { return };
        let start = Instant::now();
        let Checkpoints { path, key, .. } = checkpoints;
        let written = checkpoint_file::write(path, key, work, &checkpoints.rounds(), film, caches);
        if let Err(error) = written {
            let problem = format!("no checkpoint is kept: {error}");
            progress.warn(&problem);
            self.problem = Some(problem);
            self.due = None;
            return;
        }
        let interval = checkpoints.every.max(start.elapsed() * MIN_INTERVAL_RATIO);
        self.due = Instant::now().checked_add(interval);
    }

    /// Why no more checkpoints were written.
    pub(super) fn problem(self) -> Option<String> {
        self.problem
    }
}
