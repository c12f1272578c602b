//! A flight into a cloud: where another strategy is chosen from one frame to the next, the picture does not
//! jump.
//!
//! Seeds are fixed. Means over [`SEEDS`] seeds by either strategy may be 4.5 standard errors apart, of
//! Student's distribution with 14 degrees of freedom a false alarm of 5e-4 a switch, and by the bias that
//! kernels and cells may have.

use std::path::Path;

use fogbow::image::Film;
use fogbow::render::{Silent, render, shot_strategies};
use fogbow::scene::{LoadOptions, RenderSettings, Scene, Strategy, StrategyRequest};

const FRAMES: u32 = 8;

/// Seeds of a mean.
const SEEDS: u64 = 8;

/// What a mean may be off in standard errors.
const ERRORS: f64 = 4.5;

/// What a mean may be off beside that, relative to it.
const BIAS: f64 = 0.01;

/// A frame of the flight.
fn frame(index: u32) -> Scene {
    let cloud = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/cloud.toml");
    let along = f64::from(index) / f64::from(FRAMES - 1);
    let position = [0.0, 90.0 + along * 165.0, 1500.0 - along * 1500.0];
    let options = LoadOptions::default().size([24, 18]).rays(8).photons(60_000);
    let options = options.with("camera.position", format!("{position:?}"));
    Scene::load(&cloud, &options.with("camera.target", "[0.0, 255.0, -1000.0]")).unwrap()
}

fn mean(film: &Film) -> f64 {
    let layers = ["R", "G", "B"].map(|name| film.layer(name).unwrap());
    let sum: f64 = layers.iter().flat_map(|layer| layer.iter()).map(|v| f64::from(*v)).sum();
    sum / layers.iter().map(|layer| layer.len()).sum::<usize>() as f64
}

/// Mean of the picture over the seeds and its standard error.
fn mean_by(scene: &Scene, strategy: Strategy) -> [f64; 2] {
    let settings = |seed| {
        let strategy = StrategyRequest::Asked(strategy);
        RenderSettings { seed, strategy, ..scene.render }
    };
    let picture = |seed| mean(&render(scene, &settings(seed), &Silent).unwrap().film);
    let means: Vec<f64> = (0..SEEDS).map(picture).collect();
    let count = SEEDS as f64;
    let mean = means.iter().sum::<f64>() / count;
    let squares = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
    [mean, (squares / (count * (count - 1.0))).sqrt()]
}

#[test]
fn the_picture_does_not_jump_where_the_strategy_changes() {
    let frames: Vec<Scene> = (0..FRAMES).map(frame).collect();
    let chosen = |scene: &Scene| shot_strategies(scene, &scene.render).unwrap().strategies[0];
    let strategies: Vec<Strategy> = frames.iter().map(chosen).collect();
    let mut switches = 0;
    for (pair, scene) in strategies.windows(2).zip(&frames[1..]) {
        if pair[0] == pair[1] {
            continue;
        }
        switches += 1;
        let [[before, noise], [after, other]] =
            [pair[0], pair[1]].map(|strategy| mean_by(scene, strategy));
        let allowed = ERRORS * f64::hypot(noise, other) + BIAS * after;
        let jump = (after - before).abs();
        assert!(jump < allowed, "from {before} to {after} at {pair:?}: {jump} above {allowed}");
    }
    assert!(switches > 0, "{strategies:?}");
}
