//! The photon pass: strategy, photons and caches of a render, tied together.

use crate::cache::{
    Caches, CellContents, DirectLightCache, FinalGatherCache, FluenceBuilder, FluenceGrid,
};
use crate::error::Result;
use crate::math::{Aabb, Rgb, Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::photon::{
    AimedPhotons, CameraImportance, Octahedral, PhotonDirection, PhotonMaps, PhotonSettings,
    Recording,
};
use crate::scene::{FinalGather, Scene};
use crate::strategy::{self, CacheCells, Choice, Conditions};
use crate::transport::{FlightSegment, PixelFootprint};
use crate::work::Work;

/// Settings of a photon pass.
#[derive(Debug, Clone, Copy)]
pub struct PassSettings {
    /// How photons are shot.
    pub photons: PhotonSettings,
    /// Whether final gathers are forced, forbidden or chosen.
    pub final_gather: FinalGather,
    /// Whether the picture is denoised.
    pub denoise: bool,
    /// Rays of each pixel of the picture, at most.
    pub rays: u32,
    /// Pixels of the film, along each side, that one pixel of the picture covers: cells that rays fill
    /// are as much wider.
    pub film_pixels: f64,
}

/// What rays read: photon maps, caches, and the strategy that says which.
#[derive(Debug)]
pub struct PhotonPass<S: Spectrum = Rgb, H: PhotonDirection = Octahedral> {
    /// Photons, immutable.
    pub maps: PhotonMaps<S, H>,
    /// Caches. Rays fill some of their cells.
    pub caches: Caches<S>,
    /// How light in media is estimated, and why.
    pub choice: Choice,
}

impl<S: Spectrum, H: PhotonDirection> PhotonPass<S, H> {
    /// Without photons and caches, with a gather radius in metres.
    pub fn empty(radius: f64) -> Self {
        let choice = Choice::without_photons();
        Self { maps: PhotonMaps::empty(radius), caches: Caches::default(), choice }
    }

    /// Shoots the photons of `scene` and prepares its caches. `advance` is called with numbers of
    /// paths done. One channel suffices where the scene is grey, photons without direction where all
    /// phase functions are isotropic.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled: an unbounded medium that emits light.
    pub fn new(
        scene: &Scene,
        settings: &PassSettings,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<(Self, Work)> {
        let PassSettings { photons, .. } = settings;
        if !photons.needs.photons() {
            return Ok((Self::empty(photons.radius.unwrap_or(0.0)), Work::default()));
        }
        // Look through the camera.
        let importance = CameraImportance::look(scene, photons.seed, photons.needs);
        let visible = &importance.media;
        // Choose the strategy.
        let conditions = settings.conditions();
        let direct = strategy::direct_cells(scene, &conditions, visible);
        let aimed = AimedPhotons::new::<S, H>(scene, photons, &importance, !direct.is_empty())?;
        let length = aimed.flight_length();
        let (choice, cells) = strategy::choose(scene, &conditions, visible, direct, length);
        // Make the caches.
        let CacheCells { direct, fluence, final_gathers } = cells;
        let mut builders = fluence_builders(scene, &choice, fluence, aimed.origin());
        let direct = direct_caches(scene, direct, photons.seed);
        let final_gathers = gather_caches(scene, final_gathers, settings);
        // Shoot photons, whose flights fill the fluence grids.
        let flight_unit = aimed.flight_unit();
        let phases: Vec<_> = choice.splits.iter().map(|split| split.phase).collect();
        let recording = Recording {
            volume_photons: choice.stores_photons,
            flight_bounds: builders.iter().map(FluenceBuilder::bounds).reduce(Aabb::union),
            flights: &mut |segments: &[&[FlightSegment<S>]]| {
                builders.iter_mut().for_each(|builder| builder.add(segments));
            },
        };
        let (maps, mut work) = aimed.shoot::<S, H>(recording, &phases, advance);
        // Finish the grids.
        let finish = |builder: FluenceBuilder<'_, S>| builder.finish(photons.levels, flight_unit);
        let fluence: Vec<FluenceGrid<S>> = builders.into_iter().map(finish).collect();
        let width = fluence.iter().map(FluenceGrid::cell_width).fold(f64::INFINITY, f64::min);
        work += importance.work;
        let caches = Caches { direct, fluence, final_gathers };
        Ok((Self { maps: maps.with_radius_at_most(width), caches, choice }, work))
    }
}

impl PassSettings {
    /// As `self`, for a pilot that traces `paths` of the photon paths.
    #[must_use]
    pub const fn pilot(self, paths: u64) -> Self {
        let photons = PhotonSettings { traced: Some(paths), ..self.photons };
        Self { photons, ..self }
    }

    fn conditions(&self) -> Conditions {
        let Self { photons, final_gather, denoise, rays, film_pixels } = *self;
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

/// Empty fluence grids on these cells, for what the strategy reads from them.
fn fluence_builders<'a, S: Spectrum>(
    scene: &'a Scene,
    choice: &'a Choice,
    cells: Vec<SparseCells>,
    origin: WorldPoint,
) -> Vec<FluenceBuilder<'a, S>> {
    let builder = |(medium, cells): (usize, SparseCells)| {
        let contents = match &choice.termination {
            None => CellContents::TowardEye(&choice.blurred[medium], &scene.camera),
            Some(termination) if termination.degree(medium) > 1 => CellContents::Moments,
            Some(_) => CellContents::FirstMoments,
        };
        FluenceBuilder::new(cells, origin, contents)
    };
    cells.into_iter().enumerate().map(builder).collect()
}

fn direct_caches<S: Spectrum>(
    scene: &Scene,
    cells: Vec<SparseCells>,
    seed: u64,
) -> Vec<DirectLightCache<S>> {
    let cache = |(medium, cells)| DirectLightCache::new(scene, medium, cells, seed);
    cells.into_iter().enumerate().map(cache).collect()
}

fn gather_caches<S: Spectrum>(
    scene: &Scene,
    cells: Vec<SparseCells>,
    settings: &PassSettings,
) -> Vec<FinalGatherCache<S>> {
    let PhotonSettings { seed, traced, .. } = settings.photons;
    let cache = |(medium, cells)| {
        let footprint = PixelFootprint::new(scene, settings.film_pixels);
        FinalGatherCache::new(medium, cells, footprint, seed, traced.is_some())
    };
    cells.into_iter().enumerate().map(cache).collect()
}
