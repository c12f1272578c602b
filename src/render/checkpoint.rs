//! The state of a render, kept on disk: where a render that was killed is taken up again.
//!
//! A file is made of a magic number and a version, a head in JSON (what it is a checkpoint of, work
//! so far, how much follows), what each pixel has gathered and what its rays see where that is asked
//! for, the cells of lattices that are known, and the BLAKE3 hash of all that. Photons are not kept: they are shot again, the same ones.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Map, Value};

use crate::cache::LazyCells;
use crate::error::{Error, Result};
use crate::image::{Accumulator, FeatureMean};
use crate::math::Spectrum;
use crate::work::Work;

use super::Progress;
use super::checkpoint_file;
use crate::film::TiledFilm;

/// Of the time, at most one part in so many goes into checkpoints.
const SHARE: u32 = 20;

/// What is known of a lattice.
#[derive(Debug, PartialEq)]
pub(super) struct CacheState {
    /// Cells of the lattice.
    pub cells: usize,
    /// Index and value of those that are known.
    pub known: Vec<(u32, [u32; 3])>,
}

/// The state of an exposure between two rays.
#[derive(Debug, PartialEq)]
pub(super) struct CheckpointState {
    /// Work so far.
    pub work: Work,
    /// What each pixel has, in the order of [`TiledFilm::samples`].
    pub samples: Vec<Accumulator>,
    /// What their rays see, in the order of [`TiledFilm::features`]; empty where that was not asked for.
    pub features: Vec<FeatureMean>,
    /// What lattices know, one entry each.
    pub lattices: Vec<CacheState>,
}

/// Where the state of a render is kept, and what one that was cut short left there.
#[derive(Debug)]
pub struct Checkpoints {
    path: PathBuf,
    key: Map<String, Value>,
    every: Duration,
    left: Mutex<Option<CheckpointState>>,
    resumes: bool,
}

impl Checkpoints {
    /// Keeps the state in the file `path`, once `every` has passed since the last time, more seldom
    /// where it takes long. `key` says what picture it is of: all that the bytes depend on.
    pub fn new(path: &Path, key: Map<String, Value>, every: Duration) -> Self {
        Self { path: path.into(), key, every, left: Mutex::new(None), resumes: false }
    }

    /// As [`new`](Self::new), and goes on from what the file holds, where there is one.
    ///
    /// # Errors
    /// Where the file cannot be read, is damaged or of another picture.
    pub fn resume(path: &Path, key: Map<String, Value>, every: Duration) -> Result<Self> {
        let fresh = Self::new(path, key, every);
        if !path.exists() {
            return Ok(fresh);
        }
        let moment = checkpoint_file::read(path, &fresh.key)?;
        Ok(Self { left: Mutex::new(Some(moment)), resumes: true, ..fresh })
    }

    /// What the file `path` is a checkpoint of; nothing where it is not there.
    ///
    /// # Errors
    /// Where it cannot be read or is damaged.
    pub fn key_of(path: &Path) -> Result<Option<Map<String, Value>>> {
        if path.exists() { checkpoint_file::key(path).map(Some) } else { Ok(None) }
    }

    /// Whether it goes on from what an earlier run left.
    pub fn resumes(&self) -> bool {
        self.resumes
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Camera rays shot by the runs before this one, until they are taken up again.
    pub fn rays(&self) -> u64 {
        self.lock().as_ref().map_or(0, |moment| moment.work.rays)
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

    /// Tells `lattices` what was known of them, uncounted: the work for it has been counted.
    ///
    /// # Errors
    /// Where they are not the lattices of the render that left it.
    pub(super) fn restore<S: Spectrum>(&self, lattices: &[&LazyCells<S>]) -> Result<()> {
        let mut left = self.lock();
        let Some(moment) = left.as_mut() else { return Ok(()) };
        let fits = moment.lattices.len() == lattices.len()
            && moment.lattices.iter().zip(lattices).all(|(k, lattice)| k.cells == lattice.count());
        if !fits {
            return Err(Error::file(
                &self.path,
                "has lattices of another size than this machine makes; delete it to start anew",
            ));
        }
        for (CacheState { known, .. }, lattice) in moment.lattices.drain(..).zip(lattices) {
            known.iter().for_each(|(cell, value)| lattice.restore(*cell as usize, *value));
        }
        Ok(())
    }

    /// What an earlier run left, once.
    pub(super) fn take(&self) -> Option<CheckpointState> {
        self.lock().take()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<CheckpointState>> {
        self.left.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Keeps the state of one exposure from time to time.
#[derive(Debug)]
pub(super) struct CheckpointWriter<'a> {
    checkpoints: Option<&'a Checkpoints>,
    due: Option<Instant>,
    problem: Option<String>,
}

impl<'a> CheckpointWriter<'a> {
    /// Keeps it in `checkpoints`, if there are any.
    pub(super) fn new(checkpoints: Option<&'a Checkpoints>) -> Self {
        let due = checkpoints.and_then(|c| Instant::now().checked_add(c.every));
        Self { checkpoints, due, problem: None }
    }

    /// When the state is to be kept next.
    pub(super) fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Keeps it. Where that fails the earlier file stays, `progress` is told, and it is not tried
    /// again: the render goes on.
    pub(super) fn keep<S: Spectrum>(
        &mut self,
        work: &Work,
        plate: &TiledFilm,
        lattices: &[&LazyCells<S>],
        progress: &dyn Progress,
    ) {
        let Some(checkpoints) = self.checkpoints.filter(|_| self.problem.is_none()) else { return };
        let start = Instant::now();
        let written =
            checkpoint_file::write(&checkpoints.path, &checkpoints.key, work, plate, lattices);
        if let Err(error) = written {
            let problem = format!("no checkpoint is kept: {error}");
            progress.warn(&problem);
            self.problem = Some(problem);
            self.due = None;
            return;
        }
        let pause = checkpoints.every.max(start.elapsed() * SHARE);
        self.due = Instant::now().checked_add(pause);
    }

    /// Why it is kept no longer.
    pub(super) fn problem(self) -> Option<String> {
        self.problem
    }
}
