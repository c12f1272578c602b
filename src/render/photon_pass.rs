//! The photon pass: strategy, photons and caches of a render, tied together.

use std::ops::Range;

use super::integrator::Integrator;
use super::pass_settings::PassSettings;
use super::photon_file::SavedPhotons;
use super::planned_pass::{Flights, LitPart, PlannedPass, Recorded, direct_caches, widths};
use super::strategy_pilot::StrategyPilot;
use crate::cache::Caches;
use crate::error::Result;
use crate::math::{Rgb, Spectrum};
use crate::photon::{
    AimedPhotons, CameraImportance, MapBuilder, Octahedral, PathSample, PhotonDirection,
    PhotonMaps, PhotonSettings,
};
use crate::scene::plan::Needs;
use crate::scene::{Scene, StrategyRequest};
use crate::strategy::{self, Assignment, Choice, Evidence};
use crate::work::Work;

/// Seed of the pilot of strategies. Any number does; this one has no pattern (e in hexadecimal).
const PILOT_SEED: u64 = 0xb7e1_5162_8aed_2a6a;

/// Which photons of a picture are shot, and into how many maps.
#[derive(Debug, Clone)]
pub(super) enum ShotPaths {
    /// All, into one map.
    Whole,
    /// So many of them into two maps, of a half each that stands for all.
    Halves(u64),
    /// Those of one pass of the picture, into one map that stands for all.
    Pass(Range<u64>),
}

impl ShotPaths {
    /// The paths of each map at this one of the times of the scene, whose photons stand for those of all of them.
    pub fn parts(
        &self,
        aimed: &AimedPhotons<'_>,
        settings: &PhotonSettings,
        time: ShotTime,
    ) -> Vec<PathSample> {
        match self {
            Self::Whole if time.count == 1 => vec![aimed.all(settings)],
            Self::Whole => {
                let paths = aimed.all(settings).paths;
                vec![aimed.some(settings, 0..time.share(paths.end - paths.start))]
            }
            Self::Halves(count) => aimed.halves(settings, time.share(*count)).to_vec(),
            Self::Pass(paths) => {
                let share = time.share(paths.end - paths.start);
                vec![aimed.some(settings, paths.start..paths.start + share)]
            }
        }
    }
}

/// One of the times of a scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShotTime {
    /// Which.
    pub index: u64,
    /// Of how many.
    pub count: u64,
}

impl ShotTime {
    /// That of a scene in which nothing moves.
    pub const ONLY: Self = Self { index: 0, count: 1 };

    /// So many of `paths` are its own.
    const fn share(self, paths: u64) -> u64 {
        let (index, count) = (self.index as u128, self.count as u128);
        let [begin, end] = [paths as u128 * index / count, paths as u128 * (index + 1) / count];
        (end - begin) as u64
    }
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
        let shot = (&ShotPaths::Whole, ShotTime::ONLY);
        let (mut passes, work) = Self::shoot(scene, settings, assignment, aimed, shot, advance);
        Ok((passes.swap_remove(0), work))
    }

    /// As [`new`](Self::new), by photons that were [aimed](aim) with these settings, of any seed. One pass for
    /// each map that is asked for; all share caches of direct light.
    pub(super) fn shoot(
        scene: &Scene,
        settings: &PassSettings,
        assignment: &Assignment,
        aimed: Option<AimedPhotons<'_>>,
        (shot, time): (&ShotPaths, ShotTime),
        advance: &(dyn Fn(u64) + Sync),
    ) -> (Vec<Self>, Work) {
        let Some(mut aimed) = aimed else {
            let radius = settings.photons.radius.unwrap_or(0.0);
            return (vec![Self::empty(radius)], Work::default());
        };
        let flights = Flights { length: aimed.flight_length(), filled: None };
        let planned = PlannedPass::new(scene, settings, assignment, aimed.importance(), flights);
        let mut work = aimed.importance().work;
        let parts = shot.parts(&aimed, &settings.photons, time);
        let passes = parts.iter().map(|part| {
            let recorded = planned.record::<H>(&mut aimed, part, advance);
            work += *recorded.traced.work();
            Self::of(&planned, recorded, aimed.builder())
        });
        (passes.collect(), work)
    }

    /// That of photons which were `saved`, by the strategies that they were saved with.
    ///
    /// # Errors
    /// Where they cannot be read, or do not serve the camera of `scene`.
    pub(super) fn read(
        scene: &Scene,
        settings: &PassSettings,
        saved: &SavedPhotons,
    ) -> Result<(Vec<Self>, Work)> {
        let importance = CameraImportance::look(scene, settings.photons.needs);
        let (work, flights) = (importance.work, saved.flights());
        let planned = PlannedPass::new(scene, settings, saved.strategies(), &importance, flights);
        let recorded = saved.read(&planned, settings)?;
        let builder = MapBuilder::new(scene, importance, settings.photons.radius);
        let pass = |recorded| Self::of(&planned, recorded, &builder);
        Ok((recorded.into_iter().map(pass).collect(), work))
    }

    /// That of what was `recorded`.
    fn of(
        planned: &PlannedPass<'_, S>,
        recorded: Recorded<'_, S, H>,
        builder: &MapBuilder<'_>,
    ) -> Self {
        let LitPart { maps, caches, radius } = planned.finish(recorded, builder);
        Self { maps, caches, choice: planned.choice.clone(), radius }
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
