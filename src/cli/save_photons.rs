//! `fogbow render --photons-to`.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::console;
use super::interrupt::Interrupt;
use super::load;
use super::memory;
use super::progress::Console;
use super::render_args::Args;
use crate::error::{Error, Result};
use crate::file::PendingFile;
use crate::render::{self, Clock, Control, PhotonsReport, SavedPhotons};
use crate::scene::OpenScene;

/// Shoots the photons of the scene and saves them in the file `path`.
///
/// # Errors
/// Where the scene cannot be loaded, or the photons cannot be shot or saved.
pub(super) fn run(args: &Args, path: &Path) -> Result<()> {
    let clock = Clock::start();
    let ends_right = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("fog"));
    if !ends_right {
        let problem = "give a path that ends in .fog";
        return Err(Error::Usage(format!("--photons-to {}: {problem}", path.display())));
    }
    drop(PendingFile::new(path)?);
    let interrupt = Interrupt::listen()?;
    let (scene, pool, preparation) =
        load::scene(&mut OpenScene::of_file(&args.paths.scene), args.options(), &args.run)?;
    args.photons.check_goal(&scene)?;
    let console = Console::new(clock, args.run.quiet);
    let control = Control { progress: &console, ..Control::silent() };
    let any_camera = args.photons.any_camera;
    let shoot = || pool.install(|| render::save_photons(&scene, path, any_camera, control));
    let ended = || {
        interrupt.end("interrupted: no photons are saved, and files are as they were");
    };
    let saved = interrupt.early(ended, shoot)?;
    if !args.run.json {
        console::result(&path.display().to_string());
        return Ok(());
    }
    let name = SavedPhotons::open(path, &scene)?.name();
    let PhotonsReport { strategy, work, timings } = saved;
    let start = ("load", preparation.loading);
    let seconds: Map<String, Value> = std::iter::once(start)
        .chain(timings)
        .map(|(name, time)| (name.to_owned(), json!(time.as_secs_f64())))
        .collect();
    let report = json!({
        "photons_saved": name.to_string(),
        "any_camera": any_camera,
        "scene": scene.hash,
        "photons": scene.render.photons,
        "seed": scene.render.seed,
        "strategy": strategy,
        "seconds": seconds,
        "work": work,
        "peak_memory": memory::peak(),
        "warnings": scene.warnings,
        "notes": scene.notes,
        "outputs": [path],
    });
    console::result(&report.to_string());
    Ok(())
}
