//! A photon pass of which all is decided but the photons: they are shot, or were saved before.

use std::sync::Arc;

use super::pass_settings::{PassSettings, fluence_builders, seen_shares};
use super::progress::Progress;
use super::seen_cells;
use crate::cache::{
    Caches, CellOrigins, DirectLightCache, FluenceBuilder, FluenceGrid, LazyCells, SeenShares,
};
use crate::math::{Aabb, Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::photon::{
    AimedPhotons, CameraImportance, GatherBall, MapBuilder, PathSample, PhotonDirection,
    PhotonMaps, PhotonSettings, Recording, ShotPart, TracedPhotons,
};
use crate::scene::Scene;
use crate::strategy::{self, Assignment, Choice, Evidence};
use crate::transport::FlightSegment;
use crate::work::Work;

/// Flips bits of the seed for gathers of the second half of the photons. Any number does; this one has no pattern (2^64
/// over the golden ratio).
const SECOND_HALF_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// What is known of the flights of all photons.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flights<'a> {
    /// Their length together, in metres.
    pub length: f64,
    /// Width in metres of the cells of each medium's grid, where they filled it before; `None` where none was.
    pub filled: Option<&'a [Option<f64>]>,
}

/// A photon pass of which all is decided but the photons.
pub(super) struct PlannedPass<'a, S: Spectrum> {
    scene: &'a Scene,
    settings: &'a PassSettings,
    /// How light in media is estimated, and why.
    pub choice: Choice,
    /// Cells of fluence grids.
    fluence: Vec<Option<SparseCells>>,
    /// Shares of those that the camera sees, where light is held toward it near surfaces.
    seen: Vec<Option<SeenShares<'a>>>,
    /// Cells of final gathers.
    gathers: Vec<Option<SparseCells>>,
    /// Empty caches of direct light.
    direct: Arc<[Option<DirectLightCache<S>>]>,
    /// Where final gathers start in their cells, not found yet; none in a pilot.
    origins: Vec<Option<Arc<CellOrigins<S>>>>,
}

/// What the paths of one part left: photons, and grids that are not finished.
pub(super) struct Recorded<'a, S: Spectrum, H: PhotonDirection> {
    /// The paths.
    pub part: PathSample,
    /// Photons.
    pub traced: TracedPhotons<S, H>,
    /// Lengths of flights.
    pub grids: Vec<Option<FluenceBuilder<'a, S>>>,
    /// W for which a flight of power 1 stands.
    pub flight_unit: f64,
}

/// Photon maps and caches of one part.
pub(super) struct LitPart<S: Spectrum, H: PhotonDirection> {
    /// Photons.
    pub maps: PhotonMaps<S, H>,
    /// Caches.
    pub caches: Caches<S>,
    /// Gather radius of full quality in metres.
    pub radius: f64,
}

impl<'a, S: Spectrum> PlannedPass<'a, S> {
    /// Decides how light is estimated, and makes caches that photons do not fill.
    pub fn new(
        scene: &'a Scene,
        settings: &'a PassSettings,
        assignment: &Assignment,
        importance: &CameraImportance,
        flights: Flights<'_>,
    ) -> Self {
        let direct = direct_caches(scene, settings, importance);
        let widths = widths(&direct);
        let evidence = Evidence {
            filled: flights.filled,
            ..Evidence::new(&importance.media, &widths, flights.length)
        };
        let (mut choice, cells) =
            strategy::choose(scene, &settings.conditions(), &evidence, assignment);
        for (medium, cache) in choice.media.iter_mut().zip(&direct) {
            let has_cells = cache.as_ref().is_some_and(|cache| cache.cells().is_some());
            medium.direct_cell_width = medium.direct_cell_width.filter(|_| has_cells);
        }
        let (fluence, gathers): (Vec<_>, Vec<_>) =
            cells.into_iter().map(|cells| (cells.fluence, cells.final_gathers)).unzip();
        let seen = seen_shares(scene, &choice, &fluence);
        let is_pilot = settings.photons.traced.is_some();
        let origins = |(medium, cells): (usize, &Option<SparseCells>)| {
            let cells = cells.as_ref().filter(|_| !is_pilot)?;
            Some(Arc::new(CellOrigins::new(cells.clone(), medium, settings.photons.seed)))
        };
        let origins = gathers.iter().enumerate().map(origins).collect();
        let direct = direct.into();
        Self { scene, settings, choice, fluence, seen, gathers, direct, origins }
    }

    /// Grids without flights, which are relative to `origin`.
    pub fn empty_grids(&self, origin: WorldPoint) -> Vec<Option<FluenceBuilder<'_, S>>> {
        fluence_builders(self.scene, &self.choice, self.fluence.clone(), &self.seen, origin)
    }

    /// The cells that photons do not fill: of direct light, and of optical thickness to the camera, of each medium that
    /// has any.
    pub fn camera_cells(&self) -> Vec<&LazyCells<S>> {
        let direct = self.direct.iter().flatten().filter_map(DirectLightCache::cells);
        direct.chain(self.origins().map(|of| of.thickness().cells())).collect()
    }

    /// Where final gathers start in the cells of each medium that has any.
    pub fn origins(&self) -> impl Iterator<Item = &CellOrigins<S>> {
        self.origins.iter().flatten().map(|of| &**of)
    }

    /// Fills those cells that the camera sees, and finds where their gathers start; counts the work.
    pub fn fill_seen(&self, progress: &dyn Progress) -> Work {
        seen_cells::fill(self.scene, self.settings, &self.direct, &self.origins, progress)
    }

    /// Shoots the photons of `part`, whose flights fill the grids.
    pub fn record<H: PhotonDirection>(
        &self,
        aimed: &mut AimedPhotons<'_>,
        part: &PathSample,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Recorded<'_, S, H> {
        let mut grids = self.empty_grids(aimed.origin());
        let bounds = grids.iter().flatten().map(FluenceBuilder::bounds);
        let recording = Recording {
            volume_photons: self.choice.stores_photons,
            flight_bounds: bounds.reduce(Aabb::union),
            flights: &mut |segments: &[&[FlightSegment<S>]]| {
                grids.iter_mut().flatten().for_each(|grid| grid.add(segments));
            },
        };
        let traced = aimed.trace(recording, part, advance);
        Recorded { part: part.clone(), traced, grids, flight_unit: aimed.flight_unit() }
    }

    /// Makes maps by `builder`, and caches, of what was `recorded`.
    pub fn finish<H: PhotonDirection>(
        &self,
        recorded: Recorded<'_, S, H>,
        builder: &MapBuilder<'_>,
    ) -> LitPart<S, H> {
        let Self { scene, settings, choice, .. } = self;
        let Recorded { part, traced, grids, flight_unit } = recorded;
        // Gathers of halves are independent, as their photons are.
        let flipped = if part.paths.start > 0 { SECOND_HALF_SEED } else { 0 };
        let seed = settings.photons.seed ^ flipped;
        let own =
            PassSettings { photons: PhotonSettings { seed, ..settings.photons }, ..**settings };
        let final_gathers = own.final_gathers(scene, self.gathers.clone(), &self.origins);
        let direct = Arc::clone(&self.direct);
        let phases: Vec<_> = choice.splits.iter().map(|split| split.phase).collect();
        let ShotPart { maps, radius_of_all, .. } =
            builder.build(&phases, &part, traced, gather_ball(scene, choice));
        // Finish the grids.
        let unit = flight_unit * part.represents;
        let finish = |grid: FluenceBuilder<'_, S>| grid.finish(part.levels, unit);
        let fluence: Vec<_> = grids.into_iter().map(|grid| grid.map(finish)).collect();
        // Cells are as narrow as kernels of all photons, and both are widened together.
        let widths = fluence.iter().flatten().map(FluenceGrid::cell_width);
        let radius = widths.fold(radius_of_all, f64::min);
        let maps = if radius < radius_of_all {
            let narrower = maps.volume_radius * (radius / radius_of_all);
            maps.with_radius_at_most(narrower)
        } else {
            maps
        };
        LitPart { maps, caches: Caches { direct, fluence, final_gathers }, radius }
    }
}

/// Where rays gather photons in media, if that is near the camera alone: mirrors and glass may send rays anywhere.
fn gather_ball(scene: &Scene, choice: &Choice) -> Option<GatherBall> {
    let within = choice.beams_within.iter().copied().fold(0.0, f64::max);
    let (center, lens) = scene.camera.lens()?;
    let is_ball = within.is_finite() && !scene.surfaces.has_specular();
    is_ball.then_some(GatherBall { center, radius: lens + within })
}

/// Empty caches of direct light of each medium that has any: they serve any strategy.
pub(super) fn direct_caches<S: Spectrum>(
    scene: &Scene,
    settings: &PassSettings,
    importance: &CameraImportance,
) -> Vec<Option<DirectLightCache<S>>> {
    let (conditions, visible) = (settings.conditions(), &importance.media);
    let cells = strategy::direct_cells(scene, &conditions, visible);
    let cache = |(medium, cells): (usize, Option<SparseCells>)| {
        let cells = cells?;
        let are_shared = strategy::shares_direct_cells(scene, &conditions, visible, medium, &cells);
        Some(DirectLightCache::new(scene, medium, cells, are_shared, settings.cells_seed()))
    };
    cells.into_iter().enumerate().map(cache).collect()
}

/// Width in metres of the cells of each cache.
pub(super) fn widths<S: Spectrum>(caches: &[Option<DirectLightCache<S>>]) -> Vec<Option<f64>> {
    let width = |cache: &Option<DirectLightCache<S>>| Some(cache.as_ref()?.width());
    caches.iter().map(width).collect()
}
