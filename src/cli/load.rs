//! Scenes for commands: loaded, with what they have to say printed.

use std::path::Path;
use std::time::{Duration, Instant};

use rayon::ThreadPool;

use super::console;
use super::memory;
use super::settings::RunArgs;
use crate::error::{Error, Result};
use crate::scene::{LoadOptions, Overrides, Planning, Scene};

/// How volumes are read.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Volumes {
    /// A bare level set is turned into fog.
    pub(super) level_set_as_fog: bool,
    /// The frame of a sequence.
    pub(super) frame: Option<i64>,
    /// Bytes that reading a grid may take; what the machine has where none is given.
    pub(super) memory: Option<u64>,
    /// Whether what the scene does not need is left out.
    pub(super) planning: Planning,
}

/// Loads `path` with `overrides` over its settings, in a pool of as many threads as asked for; also the time
/// that it took.
pub(super) fn scene(
    path: &Path,
    overrides: Overrides,
    volumes: Volumes,
    run: &RunArgs,
) -> Result<(Scene, ThreadPool, Duration)> {
    let Volumes { level_set_as_fog, frame, memory, planning } = volumes;
    let memory = memory.or_else(memory::available);
    let options = LoadOptions { overrides, level_set_as_fog, frame, memory, planning };
    let pool = thread_pool(run.threads)?;
    let start = Instant::now();
    let scene = pool.install(|| Scene::load(path, &options))?;
    let loading = start.elapsed();
    if !run.quiet {
        scene.notes.iter().for_each(|note| console::message(&format!("note: {note}")));
    }
    console::warn(&scene.warnings);
    Ok((scene, pool, loading))
}

/// As many threads as asked for, by default one a core.
///
/// # Errors
/// Where the system has not so many.
pub(super) fn thread_pool(threads: Option<u16>) -> Result<ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from)) // 0 is one a core
        .build()
        .map_err(|e| Error::Usage(format!("--threads: {e}; give a smaller number")))
}
