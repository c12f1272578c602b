//! A finished picture.

use std::time::{Duration, Instant};

use serde::Serialize;

use crate::director::CachedSnapshot;
use crate::error::Result;
use crate::image::{Denoiser, Film};
use crate::strategy::Summary;
use crate::transport::MAX_EVENTS;
use crate::work::Work;

/// Why a render ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All rays are shot.
    Complete,
    /// It was asked to stop.
    Stopped,
    /// Its time was over.
    OutOfTime,
}

/// A picture and what it took.
#[derive(Debug)]
pub struct Rendered {
    /// The picture.
    pub film: Film,
    /// What was done, and what a kept look spared: the same whether or not there was one.
    pub work: Work,
    /// Stages in the order in which they ran, each with the time it took.
    pub timings: Vec<(&'static str, Duration)>,
    /// Gather radius of the volume photons, in metres; nothing for the reference.
    pub radius: Option<f64>,
    /// How light in media was estimated, and why; `None` for the reference and previews.
    pub strategy: Option<Summary>,
    /// Whether the picture is finished.
    pub ended: Ended,
    /// Rays that it would still have got.
    pub rays_left: u64,
    /// Why its state could not be kept on disk.
    pub checkpoint_error: Option<String>,
    /// What the director's maps took, where there are any.
    pub director: Option<Directed>,
    /// What the director saw first, for another picture with the same camera, surfaces and lights.
    pub sight: Option<CachedSnapshot>,
}

/// Work for the director's maps, without that of the coarse look at scattered light.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Directed {
    /// What was done.
    pub work: Work,
    /// What was not, thanks to a kept look.
    pub spared: Work,
}

impl Rendered {
    /// Share of its rays that the picture has got, in percent.
    pub fn percent(&self) -> f64 {
        let (done, left) = (self.work.rays as f64, self.rays_left as f64);
        100.0 * done / (done + left).max(1.0)
    }

    /// Takes noise off the picture, as one more stage.
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

    /// Whether all rays have been shot.
    pub fn is_complete(&self) -> bool {
        self.ended == Ended::Complete
    }

    /// What keeps the picture from being all that was asked for, one sentence each: work that was
    /// cut short, samples that were left out.
    pub fn warnings(&self) -> Vec<String> {
        let Work { capped_paths: capped, photon_paths, rays, .. } = self.work;
        let mut warnings: Vec<String> = self.checkpoint_error.iter().cloned().collect();
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
