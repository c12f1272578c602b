//! The photon pass: strategy, photons and caches of a render, tied together.

use super::integrator::Integrator;
use super::pass_settings::{PassSettings, fluence_builders};
use super::strategy_pilot::StrategyPilot;
use crate::cache::{Caches, DirectLightCache, FluenceBuilder, FluenceGrid};
use crate::error::Result;
use crate::math::{Aabb, Rgb, Spectrum, WorldPoint};
use crate::medium::SparseCells;
use crate::photon::{
    AimedPhotons, CameraImportance, Octahedral, PhotonDirection, PhotonMaps, PhotonSettings,
    Recording,
};
use crate::scene::plan::Needs;
use crate::scene::{Scene, StrategyRequest};
use crate::strategy::{self, Assignment, Choice, Evidence};
use crate::transport::FlightSegment;
use crate::work::Work;

/// Seed of the pilot of strategies. Any number does; this one has no pattern (pi in hexadecimal).
const PILOT_SEED: u64 = 0x243f_6a88_85a3_08d3;

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

    /// Shoots the photons of `scene` and prepares its caches, by the strategies of `assignment`. `advance` is
    /// called with numbers of paths done. One channel suffices where the scene is grey, photons without
    /// direction where all phase functions are isotropic.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled: an unbounded medium that emits light.
    pub fn new(
        scene: &Scene,
        settings: &PassSettings,
        assignment: &Assignment,
        advance: &(dyn Fn(u64) + Sync),
    ) -> Result<(Self, Work)> {
        let PassSettings { photons, .. } = settings;
        if !photons.needs.photons() {
            return Ok((Self::empty(photons.radius.unwrap_or(0.0)), Work::default()));
        }
        let importance = CameraImportance::look(scene, photons.seed, photons.needs);
        let prepared = PreparedPass::<S>::new::<H>(scene, settings, &importance)?;
        let (pass, mut work) = prepared.shoot::<H>(assignment, advance);
        work += importance.work;
        Ok((pass, work))
    }
}

/// The strategies that suit `scene`: those that are asked for, or those that a pilot finds best. They do
/// not depend on the seed, so that pictures of several seeds have the same.
///
/// # Errors
/// As [`PhotonPass::new`].
pub(super) fn strategies<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &PassSettings,
) -> Result<Assignment> {
    let media = scene.media.iter().len();
    let first = match settings.strategy {
        StrategyRequest::Asked(strategy) => {
            return Ok(Assignment::uniform(strategy, media, "it is asked for"));
        }
        StrategyRequest::Auto => strategy::first_allowed(scene, &settings.conditions()),
    };
    let mut measured = None;
    if settings.photons.needs.photons() {
        let photons = PhotonSettings { seed: PILOT_SEED, ..settings.photons };
        let settings = PassSettings { photons, ..*settings };
        let importance = CameraImportance::look(scene, photons.seed, photons.needs);
        let prepared = PreparedPass::<S>::new::<H>(scene, &settings, &importance)?;
        measured = prepared.measure::<H>();
    }
    let reason = "a pilot sees no light by which others differ";
    Ok(measured.unwrap_or_else(|| Assignment::uniform(first, media, reason)))
}

/// A photon pass before its strategies are decided.
struct PreparedPass<'a, S: Spectrum> {
    scene: &'a Scene,
    settings: &'a PassSettings,
    visible: &'a [WorldPoint],
    aimed: AimedPhotons<'a>,
    /// Caches of direct light, which serve any strategy.
    direct: Vec<Option<DirectLightCache<S>>>,
    /// Width in metres of their cells.
    widths: Vec<Option<f64>>,
}

impl<'a, S: Spectrum> PreparedPass<'a, S> {
    fn new<H: PhotonDirection>(
        scene: &'a Scene,
        settings: &'a PassSettings,
        importance: &'a CameraImportance,
    ) -> Result<Self> {
        let (photons, visible) = (&settings.photons, &importance.media[..]);
        let cells = strategy::direct_cells(scene, &settings.conditions(), visible);
        let cache = |(medium, cells): (usize, Option<SparseCells>)| {
            Some(DirectLightCache::new(scene, medium, cells?, photons.seed))
        };
        let direct: Vec<_> = cells.into_iter().enumerate().map(cache).collect();
        let width = |cache: &Option<DirectLightCache<S>>| Some(cache.as_ref()?.cells().width());
        let widths: Vec<_> = direct.iter().map(width).collect();
        let records_sky = direct.iter().any(Option::is_some);
        let aimed = AimedPhotons::new::<S, H>(scene, photons, importance, records_sky)?;
        Ok(Self { scene, settings, visible, aimed, direct, widths })
    }

    /// The strategies that a pilot finds best.
    fn measure<H: PhotonDirection>(self) -> Option<Assignment> {
        let Self { scene, settings, visible, mut aimed, direct, widths } = self;
        let evidence = Evidence::new(visible, &widths, aimed.flight_length());
        StrategyPilot { scene, settings, evidence }.measure::<S, H>(&mut aimed, direct)
    }

    /// Makes caches, shoots the photons and finishes what they fill.
    fn shoot<H: PhotonDirection>(
        self,
        assignment: &Assignment,
        advance: &(dyn Fn(u64) + Sync),
    ) -> (PhotonPass<S, H>, Work) {
        let Self { scene, settings, visible, aimed, direct, widths } = self;
        let (photons, conditions) = (&settings.photons, settings.conditions());
        let evidence = Evidence::new(visible, &widths, aimed.flight_length());
        let (choice, cells) = strategy::choose(scene, &conditions, &evidence, assignment);
        // Make the other caches.
        let (fluence, gathers): (Vec<_>, Vec<_>) =
            cells.into_iter().map(|cells| (cells.fluence, cells.final_gathers)).unzip();
        let mut builders = fluence_builders(scene, &choice, fluence, aimed.origin());
        let final_gathers = settings.final_gathers(scene, gathers, photons.traced.is_some());
        let mut caches = Caches { direct: direct.into(), final_gathers, ..Caches::default() };
        // Shoot photons, whose flights fill the fluence grids.
        let flight_unit = aimed.flight_unit();
        let phases: Vec<_> = choice.splits.iter().map(|split| split.phase).collect();
        let bounds = builders.iter().flatten().map(FluenceBuilder::bounds);
        let recording = Recording {
            volume_photons: choice.stores_photons,
            flight_bounds: bounds.reduce(Aabb::union),
            flights: &mut |segments: &[&[FlightSegment<S>]]| {
                builders.iter_mut().flatten().for_each(|builder| builder.add(segments));
            },
        };
        let (maps, work) = aimed.shoot::<S, H>(recording, &phases, advance);
        // Finish the grids.
        let finish = |builder: FluenceBuilder<'_, S>| builder.finish(photons.levels, flight_unit);
        caches.fluence = builders.into_iter().map(|builder| builder.map(finish)).collect();
        let widths = caches.fluence.iter().flatten().map(FluenceGrid::cell_width);
        let width = widths.fold(f64::INFINITY, f64::min);
        (PhotonPass { maps: maps.with_radius_at_most(width), caches, choice }, work)
    }
}
