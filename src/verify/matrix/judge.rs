//! What every cell of the matrix must satisfy.

use super::setup::Setup;
use crate::error::Result;
use crate::render::Rendered;
use crate::verify::{Check, Parts, scenes};

/// Tentative collisions that a photon path may take in the mean. The hard cap of a path on its events
/// is 1e5; more than this would mean that majorants are loose by orders of magnitude.
const COLLISIONS_PER_PATH: f64 = 1e5;

/// Volume photons that a path may leave in memory in the mean, beside those of a small map.
const KEPT_PER_PATH: f64 = 64.0;
/// Photons of a small map.
const SMALL_MAP: f64 = 1.1e6;

/// Bounds of the mean radiance, and how the cap on a path's events may lower it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Least mean, where no path was capped.
    pub low: f64,
    /// Largest mean.
    pub high: f64,
}

impl Bounds {
    /// What holds for any picture of a medium in a furnace of radiance 1: a little of noise over it.
    pub const ENERGY: Self = Self { low: 0.0, high: 1.3 };
    /// A white medium in such a furnace.
    pub const WHITE: Self = Self { low: 0.7, high: 1.3 };
}

/// Renders the scene of a cell and holds it against its bounds.
pub(super) fn judge(parts: &Parts, setup: &Setup, bounds: Bounds) -> Result<Vec<Check>> {
    let scene = setup.scene()?;
    let rendered = (parts.render)(&scene, &scene.render)?;
    Ok(checks(&rendered, bounds))
}

/// The checks of one picture.
pub(super) fn checks(rendered: &Rendered, bounds: Bounds) -> Vec<Check> {
    let (film, work) = (&rendered.film, &rendered.work);
    let values = || film.layers().flat_map(|(_, layer)| layer.iter().copied());
    let wrong = values().filter(|v| !v.is_finite()).count() as f64 + film.repaired() as f64;
    let colors = || ["R", "G", "B"].into_iter().filter_map(|c| film.layer(c)).flatten();
    let least = colors().fold(f64::INFINITY, |least, v| least.min(f64::from(*v)));
    let paths = work.photon_paths.max(1) as f64;
    // What the cap takes out is at most the energy of the paths that it ended.
    let capped = work.capped_paths as f64 / paths;
    let mean = scenes::mean(film);
    let within = |what: &str, found: f64, most: f64| Check::within(what, found, 0.0, most);
    vec![
        Check::within("mean radiance", mean, (bounds.low - capped).max(0.0), bounds.high),
        within("values that are not finite", wrong, 0.0),
        within("dropped samples", work.dropped_samples as f64, 0.0),
        Check::within("least radiance", least, 0.0, f64::from(f32::MAX)),
        within("collisions per photon path", work.collisions as f64 / paths, COLLISIONS_PER_PATH),
        within(
            "volume photons kept",
            work.volume_photons as f64,
            SMALL_MAP + KEPT_PER_PATH * paths,
        ),
        within("share of photon paths capped", capped, 1.0),
    ]
}
