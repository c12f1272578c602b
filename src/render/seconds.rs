//! How long the stages of a render take, as estimated from small ones on this machine.
//!
//! Photons: two looks at few of the paths tell what a path takes and what any number of them takes.
//! Rays: the film is exposed twice with few pixels; the second time, which finds the caches filled,
//! scales with the pixels of the film, and what the first took longer is added. The director: its
//! maps are made, of few pixels where the film is large, and their time scales with the pixels; what
//! they hand out is the share of the rays that is shot.

use serde::Serialize;

use super::Stages;
use super::director_pass::{self, Extent};
use crate::director::PixelBudget;
use crate::error::Result;
use crate::scene::plan::Needs;
use crate::scene::{Director, RenderSettings, Scene};

/// Pixels of the director's maps, at most, that are made for an estimate.
const PIXELS: f64 = 262_144.0;

/// About how long the stages of a render take, in seconds of a clock. Loading, metering and writing
/// are none of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// The director's maps.
    pub director: f64,
    /// Photons, and the maps of them.
    pub photons: f64,
    /// Rays; at most so long where a director stops when a pixel is good enough.
    pub march: f64,
}

impl StageSeconds {
    /// All stages.
    pub fn total(&self) -> f64 {
        self.director + self.photons + self.march
    }
}

/// What a director takes and leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct DirectedShare {
    /// Seconds for its maps.
    pub(super) seconds: f64,
    /// Share of the rays that it hands out, 0 to 1.
    pub(super) share: f64,
}

/// What the director of `settings` takes, and what share of the rays it hands out where every pixel
/// could have `gold`.
pub(super) fn directed(
    scene: &Scene,
    settings: &RenderSettings,
    gold: PixelBudget,
) -> Result<DirectedShare> {
    if !Needs::of(scene, settings).maps {
        return Ok(DirectedShare { seconds: 0.0, share: 1.0 });
    }
    let directing = settings.directing;
    let pixels = |size: [u32; 2]| f64::from(size[0]) * f64::from(size[1]);
    let all = pixels(directing.map_size(scene.film.size));
    let mut small = *settings;
    small.directing.resolution *= (PIXELS / all).sqrt().min(1.0);
    let mut stages = Stages::default();
    let mut maps = director_pass::maps(scene, &small, None, Extent::Needed, &mut stages)?;
    let seconds: f64 = stages.timings.iter().map(|(_, time)| time.as_secs_f64()).sum();
    let larger = all / pixels(maps.size);
    if matches!(settings.director, Director::Fixed | Director::Variance) {
        maps.xs.clear(); // made for nothing, where everything is asked for
    }
    let budgets = maps.budgets(scene, settings, gold);
    let handed: f64 = budgets.iter().map(|one| f64::from(one.rays)).sum();
    let asked = budgets.len() as f64 * f64::from(gold.rays.max(1));
    let share = if budgets.is_empty() { 1.0 } else { handed / asked };
    Ok(DirectedShare { seconds: seconds * larger, share })
}
