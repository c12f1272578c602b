//! Scenes for cases, made in a folder of their own and loaded as users' scenes are.

use std::path::Path;

use tempfile::TempDir;

use crate::error::{Error, Result};
use crate::image::{Film, write_exr_layers};
use crate::scene::{LoadOptions, RenderSettings, Scene};
use crate::vdb::{GridToWrite, write};

/// A folder that lives as long as it is held.
pub(super) fn folder() -> Result<TempDir> {
    tempfile::tempdir()
        .map_err(|e| Error::file(std::env::temp_dir(), format!("no folder can be made: {e}")))
}

/// The scene of this text with grids as `grids.vdb` and a half-lit sky as `sky.exr` beside it.
pub(super) fn scene(text: &str, grids: &[GridToWrite]) -> Result<Scene> {
    let folder = folder()?;
    if text.contains("sky.exr") {
        half_sky(folder.path())?;
    }
    if !grids.is_empty() {
        write(&folder.path().join("grids.vdb"), grids)?;
    }
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text)
        .map_err(|e| Error::file(&path, format!("cannot be written: {e}")))?;
    Scene::load(&path, &LoadOptions::default())
}

/// A sky that shines from the upper half only.
fn half_sky(folder: &Path) -> Result<()> {
    let value = [1.0, 0.0];
    let layers = [("R", &value[..]), ("G", &value[..]), ("B", &value[..])];
    write_exr_layers(&folder.join("sky.exr"), 1, 2, &layers, &[])
}

/// The scene's settings with another seed.
pub(super) fn seeded(scene: &Scene, seed: u64) -> RenderSettings {
    RenderSettings { seed, ..scene.render }
}

/// Sum of a layer over the film.
pub(super) fn sum(film: &Film, layer: &str) -> f64 {
    film.layer(layer).unwrap_or_default().iter().map(|v| f64::from(*v)).sum()
}

/// Mean of the green channel, each row weighed by `weight` of its number.
pub(super) fn weighted_mean(film: &Film, weight: impl Fn(usize) -> f64) -> f64 {
    let green = film.layer("G").unwrap_or_default();
    let (mut sum, mut total) = (0.0, 0.0);
    for (row, line) in green.chunks(film.width()).enumerate() {
        let weight = weight(row);
        sum += weight * line.iter().map(|v| f64::from(*v)).sum::<f64>();
        total += weight * line.len() as f64;
    }
    sum / total
}

/// Mean of the green channel.
pub(super) fn mean(film: &Film) -> f64 {
    weighted_mean(film, |_| 1.0)
}
