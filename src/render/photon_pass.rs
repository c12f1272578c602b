//! The photon pass: strategy, photons and caches of a render, tied together.

use std::ops::Range;
use std::sync::Arc;

use super::integrator::Integrator;
use super::pass_settings::{PassSettings, fluence_builders};
use super::strategy_pilot::StrategyPilot;
use crate::cache::{Caches, DirectLightCache, FluenceBuilder, FluenceGrid};
use crate::error::Result;
use crate::math::{Aabb, Rgb, Spectrum};
use crate::medium::SparseCells;
use crate::photon::{
    AimedPhotons, CameraImportance, Octahedral, PathSample, PhotonDirection, PhotonMaps,
    PhotonSettings, Recording, ShotPart,
};
use crate::scene::plan::Needs;
use crate::scene::{Scene, StrategyRequest};
use crate::strategy::{self, Assignment, Choice, Evidence};
use crate::transport::FlightSegment;
use crate::work::Work;

/// Flips bits of the seed for gathers of the second half of the photons. Any number does; this one has no pattern (2^64
/// over the golden ratio).
const SECOND_HALF_SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// Seed of the pilot of strategies. Any number does; this one has no pattern (e in hexadecimal).
const PILOT_SEED: u64 = 0xb7e1_5162_8aed_2a6a;

/// Which photons of a picture are shot, and into how many maps.
#[derive(Debug, Clone)]
pub(super) enum ShotPaths {
    /// All, into one map.
    Whole,
    /// So many of them into two maps, of a half each that stands for all.
    Halves(u64),
    /// The `paths` of one pass of a picture with this `seed`, into one map that stands for all.
    Pass {
        /// Seed of the paths.
        seed: u64,
        /// Their indices.
        paths: Range<u64>,
    },
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
    /// Gather radius of full quality in metres.
    pub radius: f64,
}

impl<S: Spectrum, H: PhotonDirection> PhotonPass<S, H> {
    /// Without photons and caches, with a gather radius in metres.
    pub fn empty(radius: f64) -> Self {
        let choice = Choice::without_photons();
        Self { maps: PhotonMaps::empty(radius), caches: Caches::default(), choice, radius }
    }

    /// The smallest gather radius of full quality of `passes`, in metres.
    pub(super) fn finest_radius(passes: &[Self]) -> f64 {
        passes.iter().map(|pass| pass.radius).fold(f64::INFINITY, f64::min)
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
        let (mut passes, work) =
            Self::shoot(scene, settings, assignment, aimed, ShotPaths::Whole, advance);
        Ok((passes.swap_remove(0), work))
    }

    /// As [`new`](Self::new), by photons that were [aimed](aim) with these settings, of any seed. One pass for
    /// each map that is asked for; all share caches of direct light.
    pub(super) fn shoot(
        scene: &Scene,
        settings: &PassSettings,
        assignment: &Assignment,
        aimed: Option<AimedPhotons<'_>>,
        shot: ShotPaths,
        advance: &(dyn Fn(u64) + Sync),
    ) -> (Vec<Self>, Work) {
        let Some(mut aimed) = aimed else {
            let radius = settings.photons.radius.unwrap_or(0.0);
            return (vec![Self::empty(radius)], Work::default());
        };
        let planned = PlannedPass::new(scene, settings, assignment, &aimed);
        let parts = match shot {
            ShotPaths::Whole => vec![aimed.all(&settings.photons)],
            ShotPaths::Halves(count) => aimed.halves(&settings.photons, count).to_vec(),
            ShotPaths::Pass { seed, paths } => {
                vec![PathSample { seed, ..aimed.some(&settings.photons, paths) }]
            }
        };
        let mut work = aimed.importance().work;
        let passes = parts.iter().map(|part| {
            let (pass, shot) = planned.shoot(&mut aimed, part, advance);
            work += shot;
            pass
        });
        (passes.collect(), work)
    }
}

/// A photon pass of which all is decided but the photons.
struct PlannedPass<'a, S: Spectrum> {
    scene: &'a Scene,
    settings: &'a PassSettings,
    choice: Choice,
    /// Cells of fluence grids.
    fluence: Vec<Option<SparseCells>>,
    /// Cells of final gathers.
    gathers: Vec<Option<SparseCells>>,
    /// Empty caches of direct light.
    direct: Arc<[Option<DirectLightCache<S>>]>,
}

impl<'a, S: Spectrum> PlannedPass<'a, S> {
    /// Decides how light is estimated, and makes caches that photons do not fill.
    fn new(
        scene: &'a Scene,
        settings: &'a PassSettings,
        assignment: &Assignment,
        aimed: &AimedPhotons<'_>,
    ) -> Self {
        let direct = direct_caches(scene, settings, aimed.importance());
        let widths = widths(&direct);
        let evidence = Evidence::new(&aimed.importance().media, &widths, aimed.flight_length());
        let (mut choice, cells) =
            strategy::choose(scene, &settings.conditions(), &evidence, assignment);
        for (medium, cache) in choice.media.iter_mut().zip(&direct) {
            let has_cells = cache.as_ref().is_some_and(|cache| cache.cells().is_some());
            medium.direct_cell_width = medium.direct_cell_width.filter(|_| has_cells);
        }
        let (fluence, gathers) =
            cells.into_iter().map(|cells| (cells.fluence, cells.final_gathers)).unzip();
        Self { scene, settings, choice, fluence, gathers, direct: direct.into() }
    }

    /// Shoots the photons of `part` and fills the caches that hold their light.
    fn shoot<H: PhotonDirection>(
        &self,
        aimed: &mut AimedPhotons<'_>,
        part: &PathSample,
        advance: &(dyn Fn(u64) + Sync),
    ) -> (PhotonPass<S, H>, Work) {
        let Self { scene, settings, choice, .. } = self;
        let mut builders = fluence_builders(scene, choice, self.fluence.clone(), aimed.origin());
        // Gathers of halves are independent, as their photons are.
        let flipped = if part.paths.start > 0 { SECOND_HALF_SEED } else { 0 };
        let seed = settings.photons.seed ^ flipped;
        let own =
            PassSettings { photons: PhotonSettings { seed, ..settings.photons }, ..**settings };
        let is_pilot = settings.photons.traced.is_some();
        let final_gathers = own.final_gathers(scene, self.gathers.clone(), is_pilot);
        let direct = Arc::clone(&self.direct);
        let mut caches = Caches { direct, final_gathers, ..Caches::default() };
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
        let ShotPart { maps, work, radius_of_all } = aimed.shoot(recording, &phases, part, advance);
        // Finish the grids.
        let unit = aimed.flight_unit() * part.represents;
        let finish = |builder: FluenceBuilder<'_, S>| builder.finish(part.levels, unit);
        caches.fluence = builders.into_iter().map(|builder| builder.map(finish)).collect();
        // Cells are as narrow as kernels of all photons, and both are widened together.
        let widths = caches.fluence.iter().flatten().map(FluenceGrid::cell_width);
        let radius = widths.fold(radius_of_all, f64::min);
        let maps = if radius < radius_of_all {
            let narrower = maps.volume_radius * (radius / radius_of_all);
            maps.with_radius_at_most(narrower)
        } else {
            maps
        };
        (PhotonPass { maps, caches, choice: choice.clone(), radius }, work)
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
