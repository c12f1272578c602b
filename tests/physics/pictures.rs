//! Scenes of closed forms, and the means of their pictures.

use std::path::Path;

use fogbow::image::Film;
use fogbow::render::{Silent, render};
use fogbow::scene::{LoadOptions, RenderSettings, Scene};

/// Seeds of a mean.
pub(crate) const SEEDS: u64 = 16;

/// What a mean may be off in standard errors.
pub(crate) const ERRORS: f64 = 4.5;

/// What floats of a film round off, relative to 1.
pub(crate) const ROUNDING: f64 = 1e-6;

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

/// The mean over the first `count` seeds.
pub(crate) fn mean_of_seeds(scene: &Scene, count: u32) -> f64 {
    seeds(scene, count).iter().sum::<f64>() / f64::from(count)
}

/// The mean over the first four seeds.
pub(crate) fn four_seeds(scene: &Scene) -> f64 {
    mean_of_seeds(scene, 4)
}

/// Mean of a channel over pixels and seeds, with its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mean {
    pub value: f64,
    pub error: f64,
}

impl Mean {
    /// That of independent values.
    pub(crate) fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let value = values.iter().sum::<f64>() / count;
        let squares = values.iter().map(|each| (each - value).powi(2)).sum::<f64>();
        Self { value, error: (squares / (count * (count - 1.0))).sqrt() }
    }
}

/// Means of red, green and blue over the films of all seeds.
pub(crate) fn means(film: impl Fn(u64) -> Film) -> [Mean; 3] {
    let films: Vec<Film> = (0..SEEDS).map(film).collect();
    ["R", "G", "B"].map(|name| {
        let mean = |film: &Film| {
            let layer = film.layer(name).unwrap();
            layer.iter().map(|v| f64::from(*v)).sum::<f64>() / layer.len() as f64
        };
        Mean::of(&films.iter().map(mean).collect::<Vec<f64>>())
    })
}

/// Pictures agree with a reference in every channel, but for noise and a relative `bias` at most.
pub(crate) fn agree<const CHANNELS: usize>(
    ours: [Mean; CHANNELS],
    reference: [Mean; CHANNELS],
    bias: f64,
    what: &str,
) {
    for (ours, reference) in ours.into_iter().zip(reference) {
        let noise = ERRORS * ours.error.hypot(reference.error);
        let off = (ours.value - reference.value).abs();
        let bound = noise + (bias + ROUNDING) * reference.value;
        assert!(off <= bound, "{what}: {ours:?} not {reference:?}: {off} above {bound}");
    }
}
