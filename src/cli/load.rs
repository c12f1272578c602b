//! Loads scenes for commands and prints their notes and warnings.

use std::time::{Duration, Instant};

use rayon::ThreadPool;

use super::console;
use super::look::LookArgs;
use super::memory;
use super::settings::{RunArgs, SettingArgs};
use crate::error::{Error, Result};
use crate::render;
use crate::scene::{LoadOptions, OpenScene, Scene};

/// The settings that override a scene's, and the look of a bare VDB file.
pub(super) fn options(settings: &SettingArgs, look: &LookArgs) -> LoadOptions {
    LoadOptions {
        settings: settings.settings.clone(),
        look: look.options(),
        level_set_as_fog: look.level_set_as_fog(),
        camera: look.camera(),
        ..LoadOptions::default()
    }
}

/// Times spent before a picture is rendered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Preparation {
    /// Reading files.
    pub(super) loading: Duration,
    /// Metering the exposure, where the scene sets none.
    pub(super) metering: Option<Duration>,
}

/// Loads a scene in a pool of the requested number of threads; also the pool and the time taken.
pub(super) fn scene(
    open: &mut OpenScene,
    options: LoadOptions,
    run: &RunArgs,
) -> Result<(Scene, ThreadPool, Preparation)> {
    let (scene, pool, preparation) = in_silence(open, options, run)?;
    if !run.quiet {
        scene.notes.iter().for_each(|note| console::message(&format!("note: {note}")));
    }
    console::warn(&scene.warnings);
    Ok((scene, pool, preparation))
}

/// As [`scene`], and nothing is printed.
pub(super) fn in_silence(
    open: &mut OpenScene,
    mut options: LoadOptions,
    run: &RunArgs,
) -> Result<(Scene, ThreadPool, Preparation)> {
    options.memory = options.memory.or_else(memory::available);
    let pool = thread_pool(run.threads)?;
    let start = Instant::now();
    let scene = pool.install(|| open.load(&options))?;
    Ok((scene, pool, Preparation { loading: start.elapsed(), metering: None }))
}

/// As [`scene`], with the exposure metered where the scene sets none.
pub(super) fn scene_to_show(
    open: &mut OpenScene,
    options: LoadOptions,
    run: &RunArgs,
) -> Result<(Scene, ThreadPool, Preparation)> {
    let (mut scene, pool, mut preparation) = scene(open, options, run)?;
    preparation.metering = meter(&mut scene, &pool)?;
    Ok((scene, pool, preparation))
}

/// Meters the exposure of `scene` where it sets none. Returns the time that took.
pub(super) fn meter(scene: &mut Scene, pool: &ThreadPool) -> Result<Option<Duration>> {
    if scene.film.exposure.is_some() {
        return Ok(None);
    }
    let start = Instant::now();
    scene.film.exposure = Some(pool.install(|| render::exposure(scene))?);
    Ok(Some(start.elapsed()))
}

/// A pool of `threads`, by default one a core.
///
/// # Errors
/// Where the system cannot start so many.
pub(super) fn thread_pool(threads: Option<u16>) -> Result<ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, usize::from)) // 0 is one a core
        .build()
        .map_err(|e| Error::Usage(format!("--threads: {e}; give a smaller number")))
}
