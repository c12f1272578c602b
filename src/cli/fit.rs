//! Photons and rays are fitted to limits of memory and time.

use std::sync::Arc;
use std::time::Duration;

use super::header::Method;
use super::memory_limit;
use crate::error::Result;
use crate::render::{self, Clock, Deadline, SavedPhotons};
use crate::scene::Scene;

/// Seconds a pixel that writing takes: an allowance that the deadline leaves for it.
const WRITING: f64 = 1e-6;

/// Seconds a pixel that denoising or reconstruction takes: an allowance that the deadline leaves for it.
const FILTERING: f64 = 1.5e-5;

/// Largest share of the time that is left for photons; rays take the rest.
const PHOTON_SHARE: f64 = 0.4;

/// What a picture is fitted to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit<'a> {
    /// Bytes that the process may take.
    pub(super) memory: Option<u64>,
    /// Time until its files are written.
    pub(super) time: Option<Duration>,
    /// How it is rendered.
    pub(super) method: Method,
    /// Time without pauses.
    pub(super) clock: &'a Arc<Clock>,
    /// When its time began.
    pub(super) start: Duration,
    /// Bytes in memory beside scene and render.
    pub(super) program: u64,
}

impl<'a> Fit<'a> {
    /// Reduces the photons of `scene` to as many as the checkpoint that is resumed had `before`, or to as many as fit the
    /// limits of memory and time. Returns a warning where memory or time are too small for all. Those that were
    /// `saved` are all read.
    pub(super) fn photons(
        &self,
        scene: &mut Scene,
        before: Option<u64>,
        saved: Option<&SavedPhotons>,
    ) -> Result<Option<String>> {
        if let Some(saved) = saved {
            return memory_limit::hold_saved(scene, saved, self.memory, self.program)
                .map(|()| None);
        }
        let requested = scene.render.photons;
        scene.render.photons = before.unwrap_or(requested);
        let warning = memory_limit::fit_photons(scene, self.memory, self.method, self.program)?;
        let (Some(deadline), None, false) = (self.deadline(scene), before, self.method.reference)
        else {
            return Ok(warning);
        };
        if scene.render.error.is_some() {
            // Rounds are fitted to the time.
            return Ok(warning);
        }
        let left = deadline.left().mul_f64(PHOTON_SHARE);
        let all = scene.render.photons;
        let photons = render::photons_within(scene, &scene.render, left)?;
        scene.render.photons = photons;
        let too_short =
            || format!("{photons} photons instead of {requested}, for which --time is too short");
        Ok((photons < all).then(too_short).or(warning))
    }

    /// Time by which rays must end, so that the files are written within `--time`.
    pub(super) fn deadline(&self, scene: &Scene) -> Option<Deadline<'a>> {
        let time = self.time?;
        let is_filtered = scene.render.denoise || scene.render.reconstructs();
        let filtering = if is_filtered { FILTERING } else { 0.0 };
        let after = writing(scene) + seconds_of(scene, filtering);
        let at = self.start.checked_add(time - after.min(time / 4))?;
        Some(Deadline { clock: self.clock, at })
    }
}

/// Time to write the picture of `scene`.
pub(super) fn writing(scene: &Scene) -> Duration {
    seconds_of(scene, WRITING)
}

/// Time of a step that takes the seconds `a_pixel`, for the picture of `scene`.
fn seconds_of(scene: &Scene, a_pixel: f64) -> Duration {
    Duration::from_secs_f64(scene.window().pixels() as f64 * a_pixel)
}
