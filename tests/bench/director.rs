//! What the director costs beside the render that it directs: `cargo bench --bench director`, or
//! with names of scenes in `volumes/` behind `--`.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::{Duration, Instant};

use fogbow::render::{Extent, Silent, Stages, maps, render};
use fogbow::scene::{Director, LoadOptions, RenderSettings, Scene};

/// Pixels along the longer side, and rays of the most important pixel, as in Anson et al. 2006.
const SIDE: u32 = 512;
const RAYS: u32 = 16;

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes");
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let mut scenes: Vec<_> = std::fs::read_dir(&folder)
        .expect("volumes/ is there")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .filter(|path| {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            named.is_empty() || named.contains(&name)
        })
        .collect();
    scenes.sort();
    println!("seconds, and the director's share of the gold standard's time");
    println!("{:<14}{:>9}{:>10}{:>8}{:>8}", "scene", "saliency", "director", "gold", "share");
    for path in scenes {
        match load(&path) {
            Ok(scene) => row(&path, &scene),
            Err(error) => println!("{}: skipped: {error}", path.display()),
        }
    }
}

/// The scene with [`SIDE`] pixels along the longer side of its film.
fn load(path: &Path) -> fogbow::Result<Scene> {
    let [width, height] = Scene::load(path, &LoadOptions::default())?.film.size;
    let longer = width.max(height);
    let size = [width, height].map(|side| (side * SIDE / longer).max(1));
    Scene::load(path, &LoadOptions::default().size(size).rays(RAYS))
}

fn row(path: &Path, scene: &Scene) {
    let settings = RenderSettings { director: Director::Xs, ..scene.render };
    let mut stages = Stages::default();
    let director = timed(|| {
        maps(scene, &settings, None, Extent::Needed, &mut stages).expect("maps");
    });
    let saliency = stages.timings.iter().find(|(name, _)| *name == "saliency");
    let gold = timed(|| {
        let settings = RenderSettings { director: Director::Fixed, ..scene.render };
        render(scene, &settings, &Silent).expect("a picture");
    });
    println!(
        "{:<14}{:>9.3}{:>10.3}{:>8.2}{:>7.1}%",
        path.file_stem().unwrap_or_default().to_string_lossy(),
        saliency.map_or(0.0, |(_, time)| time.as_secs_f64()),
        director.as_secs_f64(),
        gold.as_secs_f64(),
        100.0 * director.as_secs_f64() / gold.as_secs_f64()
    );
}

fn timed(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}
