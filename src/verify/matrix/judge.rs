//! What every cell of the matrix must satisfy.

use super::setup::Setup;
use crate::error::Result;
use crate::render::Rendered;
use crate::verify::{Check, Parts, scenes};
use crate::work::Work;

/// Tentative collisions that a photon path may take in the mean: as many as the cap on its
/// scatterings. More would mean that majorants are loose.
const COLLISIONS_PER_PATH: f64 = 1e5;

/// Volume photons that a path may leave in memory in the mean, beside those of a small map.
const KEPT_PER_PATH: f64 = 64.0;

/// Photons of a small map.
const SMALL_MAP: f64 = 1.1e6;

/// Bounds of the mean radiance, and of the work.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Least mean, where no path was capped.
    pub low: f64,
    /// Largest mean.
    pub high: f64,
    /// Most tentative collisions a photon path.
    pub collisions: f64,
}

impl Bounds {
    /// What holds for any picture of a medium in a furnace of radiance 1: a little of noise over it.
    pub const ENERGY: Self = Self::mean(0.0, 1.3);
    /// A white medium in such a furnace.
    pub const WHITE: Self = Self::mean(0.7, 1.3);

    /// Of the mean, with the work that any scene may take.
    pub const fn mean(low: f64, high: f64) -> Self {
        Self { low, high, collisions: COLLISIONS_PER_PATH }
    }
}

/// Renders the scene of a cell and holds it against its bounds.
pub(super) fn judge(parts: &Parts, setup: &Setup, bounds: Bounds) -> Result<Vec<Check>> {
    let scene = setup.scene()?;
    let rendered = (parts.render)(&scene, &scene.render)?;
    Ok(checks(&rendered, bounds))
}

/// The checks of one picture.
pub(super) fn checks(rendered: &Rendered, bounds: Bounds) -> Vec<Check> {
    // What the cap on scatterings takes out is at most the light of the paths that it ended.
    let Work { capped_paths, capped_rays, .. } = rendered.work;
    let capped = (capped_paths + capped_rays) as f64 / paths(&rendered.work);
    let mean = scenes::mean(&rendered.film);
    let low = bounds.low - capped;
    let mut all = vec![if low > 0.0 {
        Check::within("mean radiance", mean, low, bounds.high)
    } else {
        Check::at_most("mean radiance", mean, bounds.high)
    }];
    all.extend(soundness(rendered, bounds.collisions));
    all
}

/// The checks of one picture but for what is seen on it.
pub(super) fn soundness(rendered: &Rendered, collisions: f64) -> [Check; 5] {
    let (film, work) = (&rendered.film, &rendered.work);
    let values = || film.all_layers().flat_map(|(_, layer)| layer.iter().copied());
    let wrong = values().filter(|v| !v.is_finite()).count() as f64 + film.repaired() as f64;
    let colors = || ["R", "G", "B"].into_iter().filter_map(|c| film.layer(c)).flatten();
    let negative = colors().filter(|v| **v < 0.0).count() as f64;
    let collisions_per_path = work.collisions as f64 / paths(work);
    let kept = SMALL_MAP + KEPT_PER_PATH * work.photon_paths as f64;
    [
        Check::at_most("values that are not finite", wrong, 0.0),
        Check::at_most("negative values", negative, 0.0),
        Check::at_most("dropped samples", work.dropped_samples as f64, 0.0),
        Check::at_most("collisions per path", collisions_per_path, collisions),
        Check::at_most("volume photons kept", work.volume_photons as f64, kept),
    ]
}

/// Paths of photons, or of rays where no photon is shot.
fn paths(work: &Work) -> f64 {
    let paths = if work.photon_paths > 0 { work.photon_paths } else { work.rays };
    paths.max(1) as f64
}
