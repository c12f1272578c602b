//! The photon pass: strategy, photons and caches of a render, tied together.

use super::integrator::Integrator;
use super::pass_settings::{PassSettings, fluence_builders};
use super::strategy_pilot::StrategyPilot;
use crate::cache::{Caches, DirectLightCache, FluenceBuilder, FluenceGrid};
use crate::error::Result;
use crate::math::{Aabb, Rgb, Spectrum};
use crate::medium::SparseCells;
use crate::photon::{
    AimedPhotons, CameraImportance, Octahedral, PhotonDirection, PhotonMaps, PhotonSettings,
    Recording, ShotPart,
};
use crate::scene::plan::Needs;
use crate::scene::{Scene, StrategyRequest};
use crate::strategy::{self, Assignment, Choice, Evidence};
use crate::transport::FlightSegment;
use crate::work::Work;

/// Seed of the pilot of strategies. Any number does; this one has no pattern (e in hexadecimal).
const PILOT_SEED: u64 = 0xb7e1_5162_8aed_2a6a;

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

    /// The integrator of `scene` by what this holds, as far as `needs` say that it is needed.
    pub(super) fn integrator<'a>(&'a self, scene: &'a Scene, needs: Needs) -> Integrator<'a, S, H> {
        Integrator::new(scene, &self.maps, &self.caches, &self.choice, needs)
    }

    /// Aims and shoots the photons of `scene` and prepares its caches, by the strategies of `assignment`.
    /// `advance` is called with numbers of paths done. One channel suffices where the scene is grey,
    /// photons without direction where all phase functions are isotropic.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled: an unbounded medium that emits light.
    pub fn new(
        scene: &Scene,
        settings: &PassSettings,
        assignment: &Assignment,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<(Self, Work)> {
        let aimed = aim::<S, H>(scene, settings)?;
        Ok(Self::shoot(scene, settings, assignment, aimed, advance))
    }

    /// As [`new`](Self::new), by photons that were [aimed](aim) with these settings, of any seed.
    pub(super) fn shoot(
        scene: &Scene,
        settings: &PassSettings,
        assignment: &Assignment,
        aimed: Option<AimedPhotons<'_>>,
        advance: &(dyn Fn(u64) + Sync),
    ) -> (Self, Work) {
        let PassSettings { photons, .. } = settings;
        let Some(mut aimed) = aimed else {
            return (Self::empty(photons.radius.unwrap_or(0.0)), Work::default());
        };
        // Decide how light is estimated, and make caches.
        let direct = direct_caches(scene, settings, aimed.importance());
        let widths = widths(&direct);
        let evidence = Evidence::new(&aimed.importance().media, &widths, aimed.flight_length());
        let (mut choice, cells) =
            strategy::choose(scene, &settings.conditions(), &evidence, assignment);
        for (medium, cache) in choice.media.iter_mut().zip(&direct) {
            let has_cells = cache.as_ref().is_some_and(|cache| cache.cells().is_some());
            medium.direct_cell_width = medium.direct_cell_width.filter(|_| has_cells);
        }
        let (fluence, gathers): (Vec<_>, Vec<_>) =
            cells.into_iter().map(|cells| (cells.fluence, cells.final_gathers)).unzip();
        let mut builders = fluence_builders(scene, &choice, fluence, aimed.origin());
        let final_gathers = settings.final_gathers(scene, gathers, photons.traced.is_some());
        let mut caches = Caches { direct: direct.into(), final_gathers, ..Caches::default() };
        // Shoot photons, whose flights fill the fluence grids.
        let phases: Vec<_> = choice.splits.iter().map(|split| split.phase).collect();
        let bounds = builders.iter().flatten().map(FluenceBuilder::bounds);
        let recording = Recording {
            volume_photons: choice.stores_photons,
            flight_bounds: bounds.reduce(Aabb::union),
            flights: &mut |segments: &[&[FlightSegment<S>]]| {
                builders.iter_mut().flatten().for_each(|builder| builder.add(segments));
            },
        };
        let part = aimed.all(photons);
        let ShotPart { maps, mut work, .. } = aimed.shoot(recording, &phases, &part, advance);
        work += aimed.importance().work;
        // Finish the grids.
        let flight_unit = aimed.flight_unit();
        let finish = |builder: FluenceBuilder<'_, S>| builder.finish(photons.levels, flight_unit);
        caches.fluence = builders.into_iter().map(|builder| builder.map(finish)).collect();
        let widths = caches.fluence.iter().flatten().map(FluenceGrid::cell_width);
        let width = widths.fold(f64::INFINITY, f64::min);
        (Self { maps: maps.with_radius_at_most(width), caches, choice }, work)
    }
}

/// Aims the photons of `scene` at what its camera sees; `None` where no photons are needed.
///
/// # Errors
/// As [`PhotonPass::new`].
pub(super) fn aim<'a, S: Spectrum, H: PhotonDirection>(
    scene: &'a Scene,
    settings: &PassSettings,
) -> Result<Option<AimedPhotons<'a>>> {
    let PassSettings { photons, .. } = settings;
    if !photons.needs.photons() {
        return Ok(None);
    }
    let importance = CameraImportance::look(scene, photons.needs);
    let cells = strategy::direct_cells(scene, &settings.conditions(), &importance.media);
    let records_sky = cells.iter().any(Option::is_some);
    AimedPhotons::new::<S, H>(scene, photons, importance, records_sky).map(Some)
}

/// The strategies that suit `scene`: those that are asked for, or those that a pilot of the `aimed` photons
/// finds best. They do not depend on the seed, so that pictures of several seeds have the same.
pub(super) fn strategies_by<'a, S: Spectrum, H: PhotonDirection>(
    scene: &'a Scene,
    settings: &PassSettings,
    aimed: Option<&mut AimedPhotons<'a>>,
) -> Assignment {
    let media = scene.media.iter().len();
    if let StrategyRequest::Asked(strategy) = settings.strategy {
        return Assignment::uniform(strategy, media, "it is asked for");
    }
    let photons = PhotonSettings { seed: PILOT_SEED, ..settings.photons };
    let settings = PassSettings { photons, ..*settings };
    let measured = aimed.and_then(|aimed| {
        let direct = direct_caches(scene, &settings, aimed.importance());
        let visible = aimed.importance().media.clone();
        let widths = widths(&direct);
        let evidence = Evidence::new(&visible, &widths, aimed.flight_length());
        let pilot = StrategyPilot { scene, settings: &settings, evidence };
        pilot.measure::<S, H>(aimed, direct)
    });
    measured.unwrap_or_else(|| {
        let first = strategy::first_allowed(scene, &settings.conditions());
        Assignment::uniform(first, media, "a pilot sees no light by which others differ")
    })
}

/// As [`strategies_by`], by photons that are aimed for that alone.
///
/// # Errors
/// As [`PhotonPass::new`].
pub(super) fn strategies<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &PassSettings,
) -> Result<Assignment> {
    let mut aimed = match settings.strategy {
        StrategyRequest::Asked(_) => None,
        StrategyRequest::Auto => aim::<S, H>(scene, settings)?,
    };
    Ok(strategies_by::<S, H>(scene, settings, aimed.as_mut()))
}

/// Empty caches of direct light of each medium that has any: they serve any strategy.
fn direct_caches<S: Spectrum>(
    scene: &Scene,
    settings: &PassSettings,
    importance: &CameraImportance,
) -> Vec<Option<DirectLightCache<S>>> {
    let (conditions, visible) = (settings.conditions(), &importance.media);
    let cells = strategy::direct_cells(scene, &conditions, visible);
    let cache = |(medium, cells): (usize, Option<SparseCells>)| {
        let cells = cells?;
        let are_shared = strategy::shares_direct_cells(scene, &conditions, visible, medium, &cells);
        Some(DirectLightCache::new(scene, medium, cells, are_shared, settings.photons.seed))
    };
    cells.into_iter().enumerate().map(cache).collect()
}

/// Width in metres of the cells of each cache.
fn widths<S: Spectrum>(caches: &[Option<DirectLightCache<S>>]) -> Vec<Option<f64>> {
    let width = |cache: &Option<DirectLightCache<S>>| Some(cache.as_ref()?.width());
    caches.iter().map(width).collect()
}
