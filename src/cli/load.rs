//! Scenes for commands: loaded, with what they have to say printed.

use std::path::Path;
use std::time::{Duration, Instant};

use rayon::ThreadPool;

use super::console;
use super::memory;
use super::settings::{RunArgs, SettingArgs};
use crate::error::{Error, Result};
use crate::scene::{LoadOptions, Scene};

/// Loads `path` under the settings given, in a pool of as many threads as asked for; also the time
/// that it took.
pub(super) fn scene(
    path: &Path,
    settings: &SettingArgs,
    level_set_as_fog: bool,
    run: &RunArgs,
) -> Result<(Scene, ThreadPool, Duration)> {
    scene_within(None, path, settings, level_set_as_fog, run)
}

/// As [`scene`], but no grid is read that takes more than `memory` bytes, or than the machine has
/// where none is given.
pub(super) fn scene_within(
    memory: Option<u64>,
    path: &Path,
    settings: &SettingArgs,
    level_set_as_fog: bool,
    run: &RunArgs,
) -> Result<(Scene, ThreadPool, Duration)> {
    let memory = memory.or_else(memory::available);
    let options = LoadOptions { overrides: settings.overrides(), level_set_as_fog, memory };
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

fn thread_pool(threads: Option<u16>) -> Result<ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from)) // 0 is one a core
        .build()
        .map_err(|e| Error::Usage(format!("--threads: {e}; give a smaller number")))
}
