//! Settings of a photon pass, and the fluence grids that its strategies ask for.

use std::sync::Arc;

use crate::cache::{CellContents, CellOrigins, FinalGatherCache, FluenceBuilder, SeenShares};
use crate::math::{Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::photon::PhotonSettings;
use crate::scene::{FinalGather, PicturePass, Scene, StrategyRequest};
use crate::strategy::{Choice, Conditions, MediumStrategy, Strategy};
use crate::transport::PixelFootprint;

/// Settings of a photon pass.
#[derive(Debug, Clone, Copy)]
pub struct PassSettings {
    /// How photons are shot.
    pub photons: PhotonSettings,
    /// The pass of the picture that is rendered; `None` for all of it, and in pilots.
    pub pass: Option<PicturePass>,
    /// Who decides on the strategies of media.
    pub strategy: StrategyRequest,
    /// Whether the pilot of strategies measures also where one strategy alone is possible.
    pub measures_one: bool,
    /// Whether final gathers may be chosen.
    pub final_gather: FinalGather,
    /// Rays of each pixel of the picture, at most.
    pub rays: u32,
    /// Pixels of the film, along each side, that one pixel of the picture covers: cells that rays fill
    /// are as much wider.
    pub film_pixels: f64,
    /// Share of the rays of a pixel that are expected to read cells, which have as much less of the gathers: where rays
    /// choose among times of the scene.
    pub gather_share: f64,
}

impl PassSettings {
    /// As `self`, for a pilot that traces `paths` of the photon paths.
    #[must_use]
    pub const fn pilot(self, paths: u64) -> Self {
        let photons = PhotonSettings { traced: Some(paths), ..self.photons };
        Self { photons, ..self }
    }

    /// Empty caches of final gathers on the cells of each medium that has any, with its `origins` of the same. Where
    /// there are none, as in a pilot, each ray does its part of a cell's gathers.
    pub(super) fn final_gathers<S: Spectrum>(
        &self,
        scene: &Scene,
        cells: Vec<Option<SparseCells>>,
        origins: &[Option<Arc<CellOrigins<S>>>],
    ) -> Vec<Option<FinalGatherCache<S>>> {
        let seeds = [self.cells_seed(), self.photons.seed];
        let cache = |(medium, cells): (usize, Option<SparseCells>)| {
            let footprint = PixelFootprint::new(scene, self.film_pixels);
            let origins = origins.get(medium).cloned().flatten();
            let cache = FinalGatherCache::new(medium, cells?, footprint, seeds, origins);
            Some(cache.with_share(self.gather_share))
        };
        cells.into_iter().enumerate().map(cache).collect()
    }

    /// Seed of what rays find for cells: passes of a picture share none of it.
    pub(super) fn cells_seed(&self) -> u64 {
        let seed = self.photons.seed;
        self.pass.map_or(seed, |pass| pass.seed(seed))
    }

    pub(super) fn conditions(&self) -> Conditions {
        let Self { photons, final_gather, rays, film_pixels, .. } = *self;
        Conditions {
            photons: photons.photons,
            max_scatter: photons.max_scatter,
            final_gather,
            radius: photons.radius,
            rays,
            film_pixels,
            volume_photons: photons.needs.volume_photons,
            any_camera: photons.any_camera,
        }
    }
}

/// Shares that the camera sees of the `cells` of each medium that hold light toward it.
pub(super) fn seen_shares<'a>(
    scene: &'a Scene,
    choice: &Choice,
    cells: &[Option<SparseCells>],
) -> Vec<Option<SeenShares<'a>>> {
    let seen = |(medium, cells): (&MediumStrategy, &Option<SparseCells>)| {
        let toward_eye = medium.strategy == Strategy::FluenceTowardEye;
        SeenShares::new(scene, cells.as_ref().filter(|_| toward_eye)?)
    };
    choice.media.iter().zip(cells).map(seen).collect()
}

/// Empty fluence grids on the cells of each medium that has any, for what its strategy reads from them.
/// Flights are given relative to `origin`. Of cells near surfaces only what is `seen` holds light toward the camera.
pub(super) fn fluence_builders<'a, S: Spectrum>(
    scene: &'a Scene,
    choice: &'a Choice,
    cells: Vec<Option<SparseCells>>,
    seen: &'a [Option<SeenShares<'a>>],
    origin: WorldPoint,
) -> Vec<Option<FluenceBuilder<'a, S>>> {
    let builder = |(medium, cells): (usize, Option<SparseCells>)| {
        let contents = match choice.media[medium].strategy {
            Strategy::FluenceTowardEye => CellContents::TowardEye(
                &choice.blurred[medium],
                &scene.camera,
                seen.get(medium).and_then(Option::as_ref),
            ),
            _ if choice.termination.degree(medium) > 1 => CellContents::Moments,
            _ => CellContents::FirstMoments,
        };
        Some(FluenceBuilder::new(cells?, origin, contents))
    };
    cells.into_iter().enumerate().map(builder).collect()
}
