//! Scenes of closed forms, and the means of their pictures.

use std::path::Path;

use fogbow::image::Film;
use fogbow::render::{Silent, render};
use fogbow::scene::{LoadOptions, RenderSettings, Scene};

/// A scene from its text and settings, in a folder that holds what the text names.
pub(crate) fn scene(folder: &Path, text: &str, rays: u32, photons: u64) -> Scene {
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &LoadOptions::default().rays(rays).photons(photons)).unwrap()
}

/// Mean of the green channel and its standard error.
pub(crate) fn mean(film: &Film) -> (f64, f64) {
    let sum = |name: &str| film.layer(name).unwrap().iter().map(|v| f64::from(*v)).sum::<f64>();
    let count = film.layer("G").unwrap().len() as f64;
    (sum("G") / count, sum("variance").sqrt() / count)
}

/// What the photon map gives with each of the first `count` seeds, as [`mean`] tells.
pub(crate) fn seeds(scene: &Scene, count: u32) -> Vec<f64> {
    let of_seed = |seed| {
        let settings = RenderSettings { seed: u64::from(seed), ..scene.render };
        mean(&render(scene, &settings, &Silent).unwrap().film).0
    };
    (0..count).map(of_seed).collect()
}

/// The mean over the first four seeds.
pub(crate) fn four_seeds(scene: &Scene) -> f64 {
    seeds(scene, 4).iter().sum::<f64>() / 4.0
}
