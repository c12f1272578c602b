//! The result of a render: the picture, the work and the time that it took.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::stated_error::StatedError;
use crate::director::CachedSnapshot;
use crate::error::Result;
use crate::image::{Denoiser, Film};
use crate::scene::ErrorGoal;
use crate::strategy::Summary;
use crate::transport::MAX_EVENTS;
use crate::work::Work;

/// Why a render ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All rays were shot.
    Complete,
    /// A [`Stop`](super::Stop) asked for the end.
    Stopped,
    /// The [`Deadline`](super::Deadline) passed.
    OutOfTime,
}

/// A rendered picture, with its work and time.
#[derive(Debug)]
pub struct Rendered {
    /// The picture.
    pub film: Film,
    /// Work done, including what a cached snapshot saved: the same with and without one.
    pub work: Work,
    /// Name and wall-clock time of each stage, in the order in which they ran.
    pub timings: Vec<(&'static str, Duration)>,
    /// Finest gather radius of volume photons, in metres; `None` for the reference.
    pub radius: Option<f64>,
    /// Why the render ended.
    pub ended: Ended,
    /// Rays that were left to shoot.
    pub rays_left: u64,
    /// Why no checkpoint could be written, one sentence.
    pub checkpoint_error: Option<String>,
    /// How light in media was estimated, and why; `None` for the reference and previews.
    pub strategy: Option<Summary>,
    /// The error that it has, where that was the goal.
    pub error: Option<ReachedError>,
    /// Work for the director's maps, where there are any.
    pub director: Option<DirectorWork>,
    /// The director's snapshot, for the next picture with the same camera, surfaces and lights.
    pub snapshot: Option<CachedSnapshot>,
}

/// The error of a picture that was rendered until it is small enough, and what that took.
#[derive(Debug, Clone, Copy)]
pub struct ReachedError {
    /// What was asked for.
    pub goal: ErrorGoal,
    /// What it is; `None` where no light was found, or not every pixel has its first rays.
    pub stated: Option<StatedError>,
    /// Photon paths.
    pub photons: u64,
    /// Rays of a pixel.
    pub rays: u32,
}

impl ReachedError {
    /// A note of the error and what it took; `None` where it is not known.
    pub fn note(&self) -> Option<String> {
        let Self { goal, stated, photons, rays } = self;
        let [percent, sure] = (*stated)?.percent();
        let of = match goal {
            ErrorGoal::Relative(_) => "of the radiance",
            ErrorGoal::Visible => "of the least visible difference",
        };
        Some(format!(
            "note: the error in the worst hundredth of the picture is {percent:.2} ± {sure:.2} % {of}, after {rays} \
             rays a pixel and {photons} photons"
        ))
    }

    /// A warning where the goal is not reached.
    fn warning(&self) -> Option<String> {
        let Self { goal, stated, photons, rays } = self;
        let spent = format!("{rays} rays a pixel and {photons} photons");
        match stated {
            Some(stated) if stated.reaches(*goal) => None,
            Some(stated) => Some(match goal {
                ErrorGoal::Relative(goal) => {
                    format!("the error after {spent} is {:.2} times {goal}", stated.value / goal)
                }
                ErrorGoal::Visible => {
                    format!("the error after {spent} is {:.2} times what is visible", stated.value)
                }
            }),
            None => Some(format!(
                "the error is not known after {spent}: no light was found, or not every pixel has its first rays"
            )),
        }
    }
}

/// Work for the director's maps, without the pilot's.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct DirectorWork {
    /// Work done.
    pub work: Work,
    /// Work that a cached snapshot saved.
    pub spared: Work,
}

impl Rendered {
    /// Share of the picture's rays that were shot, in percent.
    pub fn percent(&self) -> f64 {
        let (done, left) = (self.work.rays as f64, self.rays_left as f64);
        100.0 * done / (done + left).max(1.0)
    }

    /// Denoises the picture, as one more stage.
    ///
    /// # Errors
    /// As [`Denoiser::denoised`].
    pub fn denoise(&mut self, denoiser: &Denoiser) -> Result<()> {
        let start = Instant::now();
        let image = denoiser.denoised(&self.film)?;
        self.film.set_denoised(&image, &denoiser.to_string());
        self.timings.push(("denoise", start.elapsed()));
        Ok(())
    }

    /// Whether all rays were shot.
    pub fn is_complete(&self) -> bool {
        self.ended == Ended::Complete
    }

    /// Warnings about the picture, one sentence each: paths that were cut short, photons that were
    /// never gathered, samples that were dropped.
    pub fn warnings(&self) -> Vec<String> {
        let Work { capped_paths: capped, photon_paths, rays, .. } = self.work;
        let mut warnings: Vec<String> = self.checkpoint_error.iter().cloned().collect();
        warnings.extend(self.error.as_ref().and_then(ReachedError::warning));
        if capped > 0 {
            let (paths, kind) =
                if photon_paths > 0 { (photon_paths, "photon") } else { (rays, "camera") };
            let percent = 100.0 * capped as f64 / paths.max(1) as f64;
            warnings.push(format!(
                "{capped} of {paths} {kind} paths ({percent:.2} %) were ended after {MAX_EVENTS} \
                 scatterings: up to so much of the light is missing; a lower sigma_t or albedo \
                 scatters less often"
            ));
        }
        let Work { capped_rays, dropped_samples, .. } = self.work;
        if capped_rays > 0 {
            warnings.push(format!(
                "{capped_rays} rays were ended after {MAX_EVENTS} scatterings: a little light is \
                 missing; a lower sigma_t or albedo scatters less often"
            ));
        }
        let Work { gathers, gathered, volume_photons, .. } = self.work;
        if gathers > 0 && gathered == 0 && volume_photons > 0 {
            warnings.push(format!(
                "none of {volume_photons} photons lies where the camera looks: light scattered \
                 more than once is missing; give more photons or a wider radius"
            ));
        }
        let dropped = dropped_samples + self.film.repaired();
        if dropped > 0 {
            warnings.push(format!(
                "{dropped} values were too large or not finite and left out; please report the scene"
            ));
        }
        warnings
    }
}
