//! Settings of a photon pass, and what the grids of its strategies hold.

use crate::cache::CellContents;
use crate::photon::PhotonSettings;
use crate::scene::{FinalGather, Scene, StrategyRequest};
use crate::strategy::{Choice, Conditions, Strategy};

/// Settings of a photon pass.
#[derive(Debug, Clone, Copy)]
pub struct PassSettings {
    /// How photons are shot.
    pub photons: PhotonSettings,
    /// Who decides on the strategies of media.
    pub strategy: StrategyRequest,
    /// March step of a pilot's rays, in metres.
    pub step: f64,
    /// Whether final gathers may be chosen.
    pub final_gather: FinalGather,
    /// Whether the picture is denoised.
    pub denoise: bool,
    /// Rays of each pixel of the picture, at most.
    pub rays: u32,
    /// Pixels of the film, along each side, that one pixel of the picture covers: cells that rays fill
    /// are as much wider.
    pub film_pixels: f64,
}

impl PassSettings {
    /// As `self`, for a pilot that traces `paths` of the photon paths.
    #[must_use]
    pub const fn pilot(self, paths: u64) -> Self {
        let photons = PhotonSettings { traced: Some(paths), ..self.photons };
        Self { photons, ..self }
    }

    pub(super) fn conditions(&self) -> Conditions {
        let Self { photons, final_gather, denoise, rays, film_pixels, .. } = *self;
        Conditions {
            photons: photons.photons,
            max_scatter: photons.max_scatter,
            final_gather,
            denoise,
            radius: photons.radius,
            rays,
            film_pixels,
            volume_photons: photons.needs.volume_photons,
        }
    }
}

/// What the fluence grid of a medium holds by its strategy.
pub(super) fn contents<'a>(
    scene: &'a Scene,
    choice: &'a Choice,
    medium: usize,
) -> CellContents<'a> {
    if choice.media[medium].strategy == Strategy::FluenceTowardEye {
        CellContents::TowardEye(&choice.blurred[medium], &scene.camera)
    } else if choice.termination.degree(medium) > 1 {
        CellContents::Moments
    } else {
        CellContents::FirstMoments
    }
}
