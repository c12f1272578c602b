//! A flight into a cloud: where another strategy is chosen from one frame to the next, the picture does not
//! jump.
//!
//! Seeds are fixed. Means over [`SEEDS`](crate::pictures::SEEDS) seeds by either strategy may be 4.5 standard
//! errors apart, of Student's distribution with 15 degrees of freedom a false alarm of 4e-4 a channel, and by
//! the bias that kernels and cells may have.

use std::path::Path;

use fogbow::render::{Silent, render, shot_strategies};
use fogbow::scene::{LoadOptions, RenderSettings, Scene, Strategy, StrategyRequest};

use crate::pictures::{Mean, agree, means};

const FRAMES: u32 = 8;

/// What a mean may be off beside noise, relative to it.
const BIAS: f64 = 0.01;

/// A frame of the flight.
fn frame(index: u32) -> Scene {
    let cloud = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes/cloud.toml");
    let along = f64::from(index) / f64::from(FRAMES - 1);
    let position = [0.0, 90.0 + along * 165.0, 1500.0 - along * 1500.0];
    let options = LoadOptions::default().size([24, 18]).rays(4).photons(30_000);
    let options = options.with("camera.position", format!("{position:?}"));
    Scene::load(&cloud, &options.with("camera.target", "[0.0, 255.0, -1000.0]")).unwrap()
}

/// Means of the frame by one strategy.
fn means_by(scene: &Scene, strategy: Strategy) -> [Mean; 3] {
    let strategy = StrategyRequest::Asked(strategy);
    means(|seed| {
        let settings = RenderSettings { seed, strategy, ..scene.render };
        render(scene, &settings, &Silent).unwrap().film
    })
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
        let [before, after] = [pair[0], pair[1]].map(|strategy| means_by(scene, strategy));
        agree(before, after, BIAS, &format!("{pair:?}"));
    }
    assert!(switches > 0, "{strategies:?}");
}
