//! The photon pass: paths are aimed, measured by a pilot, traced in parallel, and made into maps.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Result;
use crate::math::{Aabb, Spectrum, World, WorldPoint};
use crate::medium::Phase;
use crate::scene::Scene;
use crate::transport::{FlightSegment, camera_position, is_camera_outside};

use super::build::MapBuilder;
use super::camera_importance::{AIM_SEED, CameraImportance};
use super::deposit_regions::DepositRegions;
use super::emitters::Emitters;
use super::extents::{Extents, endless};
use super::path::{Deposits, PhotonTracer, Units};
use super::pilot::PathPilot;
use super::settings::{BATCH, CHUNK};
use super::traced::{PathSample, ShotPart, TracedPhotons};
use super::{PhotonDirection, PhotonSettings, emission_target, emitter_importance};

/// Takes the flights of a batch of paths, one slice a task.
pub type FlightSink<'a, S> = dyn FnMut(&[&[FlightSegment<S>]]) + Send + 'a;

/// What photons leave behind, beside those on surfaces.
pub struct Recording<'a, S: Spectrum> {
    /// Whether photons are stored in media.
    pub volume_photons: bool,
    /// The box in which flights are recorded; `None` where they are not.
    pub flight_bounds: Option<Aabb<World>>,
    /// Takes the flights in that box. Their powers are in [`AimedPhotons::flight_unit`].
    pub flights: &'a mut FlightSink<'a, S>,
}

/// Photon paths that are aimed and weighed, but not yet traced. How does not depend on the seed of a
/// render, so that a pilot and the render share it.
#[derive(Debug)]
pub struct AimedPhotons<'a> {
    tracer: PhotonTracer<'a>,
    builder: MapBuilder<'a>,
    pilot: PathPilot,
    /// Paths of a whole render.
    count: u64,
}

impl<'a> AimedPhotons<'a> {
    /// Aims photons at what the camera sees, of which `importance` tells, or for any camera at the whole scene, and
    /// traces a pilot of the paths. `records_sky` says whether flights straight from the sky are recorded: where they are not,
    /// its light is sampled.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled: an unbounded medium that emits light.
    pub fn new<S: Spectrum, H: PhotonDirection>(
        scene: &'a Scene,
        settings: &PhotonSettings,
        importance: CameraImportance,
        records_sky: bool,
    ) -> Result<Self> {
        let settings = PhotonSettings { seed: AIM_SEED, ..*settings };
        let extents = Extents::new(scene, &importance, settings.radius);
        let nothing = CameraImportance::default();
        let aim = if settings.any_camera { &nothing } else { &importance };
        let mut tracer = tracer(scene, &settings, aim, &extents, records_sky)?;
        let count = if tracer.emitters.is_empty() { 0 } else { settings.photons };
        emitter_importance::choose_emitters::<S, H>(&mut tracer, aim);
        let pilot = PathPilot::with_weight_window::<S, H>(&mut tracer, count);
        Ok(Self { tracer, builder: MapBuilder { scene, extents, importance }, pilot, count })
    }

    /// The point, in world space, that stored positions and flights are relative to.
    pub const fn origin(&self) -> WorldPoint {
        self.tracer.origin
    }

    /// Estimated length of all flights through media together, in metres.
    pub const fn flight_length(&self) -> f64 {
        self.pilot.flight_length
    }

    /// W for which a flight of power 1 stands.
    pub const fn flight_unit(&self) -> f64 {
        self.tracer.units.surface
    }

    /// What maps of them are built with.
    pub const fn builder(&self) -> &MapBuilder<'a> {
        &self.builder
    }

    /// What the camera sees.
    pub const fn importance(&self) -> &CameraImportance {
        &self.builder.importance
    }

    /// All paths that `settings` ask for, each of which stands for itself.
    pub fn all(&self, settings: &PhotonSettings) -> PathSample {
        let PhotonSettings { seed, levels, traced, .. } = *settings;
        let paths = 0..traced.map_or(self.count, |traced| traced.min(self.count));
        PathSample { seed, paths, represents: 1.0, levels }
    }

    /// So many paths, which may be more than [`all`](Self::all), in two halves. Each half stands for all.
    pub fn halves(&self, settings: &PhotonSettings, count: u64) -> [PathSample; 2] {
        let end = if self.count > 0 { count } else { 0 };
        [0..end / 2, end / 2..end].map(|half| self.standing_for_all(settings, half))
    }

    /// As [`all`](Self::all), those of these indices alone, which stand for all.
    pub fn some(&self, settings: &PhotonSettings, paths: Range<u64>) -> PathSample {
        let last = self.all(settings).paths.end;
        self.standing_for_all(settings, paths.start.min(last)..paths.end.min(last))
    }

    /// The paths of these indices, whose light together is that of all.
    fn standing_for_all(&self, settings: &PhotonSettings, paths: Range<u64>) -> PathSample {
        let all = self.all(settings);
        let count = paths.end - paths.start;
        PathSample { represents: all.paths.end as f64 / count.max(1) as f64, paths, ..all }
    }

    /// Traces the paths of `part`, if anything needs them, which leave what `recording` says, and builds
    /// the maps. `phases` scatter the photons of each medium when they are gathered. `advance` is called
    /// with numbers of paths done.
    pub fn shoot<S: Spectrum, H: PhotonDirection>(
        &mut self,
        recording: Recording<'_, S>,
        phases: &[Phase],
        part: &PathSample,
        advance: &(dyn Fn(u64) + Sync),
    ) -> ShotPart<S, H> {
        let traced = self.trace(recording, part, advance);
        self.builder.build(phases, part, traced, None)
    }

    /// As [`shoot`](Self::shoot), without building the maps.
    pub fn trace<S: Spectrum, H: PhotonDirection>(
        &mut self,
        recording: Recording<'_, S>,
        part: &PathSample,
        advance: &(dyn Fn(u64) + Sync),
    ) -> TracedPhotons<S, H> {
        // What paths leave behind.
        let Recording { volume_photons, flight_bounds, flights } = recording;
        let volume = volume_photons || flight_bounds.is_some();
        let is_needed = volume || self.tracer.settings.needs.surface_photons;
        self.tracer.store_probability =
            if volume_photons { self.pilot.store_probability } else { 0.0 };
        self.tracer.flight_bounds = flight_bounds;
        // Trace them.
        let PathSample { seed, paths, .. } = part;
        let paths = if is_needed { paths.clone() } else { 0..0 };
        self.tracer.settings.seed = *seed;
        let mut deposits = trace::<S, H>(&self.tracer, paths.clone(), flights, advance);
        // Count the work.
        let work = &mut deposits.work;
        work.photon_paths = paths.end - paths.start;
        work.volume_photons = deposits.volume.len() as u64;
        work.surface_photons = deposits.surface.len() as u64;
        TracedPhotons { deposits, origin: self.tracer.origin, units: self.tracer.units }
    }

    /// Paths of a whole render.
    pub const fn count(&self) -> u64 {
        self.count
    }
}

/// What all paths share, for pilots that record all photons and flights.
fn tracer<'a>(
    scene: &'a Scene,
    settings: &PhotonSettings,
    importance: &CameraImportance,
    extents: &Extents,
    records_sky: bool,
) -> Result<PhotonTracer<'a>> {
    let target = emission_target::emission_target(scene, importance, extents)?;
    let reflection_target = target.above_ground();
    let emitters = Emitters::new(scene, target, records_sky)?;
    let regions = DepositRegions::around(&scene.media, extents.margin);
    let inside = scene.media.iter().any(|medium| !is_camera_outside(scene, medium));
    let flight_bounds = if scene.media.is_endless() { endless() } else { extents.media };
    Ok(PhotonTracer {
        scene,
        units: Units::around(emitters.power() / settings.photons.max(1) as f64, extents.size),
        emitters,
        settings: *settings,
        reflection_target,
        deposit_regions: if inside && !settings.any_camera {
            regions.with_camera(camera_position(scene), extents.depth)
        } else {
            regions
        },
        origin: extents.origin,
        store_probability: 1.0,
        flight_bounds: settings.needs.volume_photons.then_some(flight_bounds),
        window: None,
    })
}

/// Traces `paths` in batches; the flights of one are recorded while the next is traced.
fn trace<S: Spectrum, H: PhotonDirection>(
    tracer: &PhotonTracer<'_>,
    paths: Range<u64>,
    flights: &mut FlightSink<'_, S>,
    advance: &(dyn Fn(u64) + Sync),
) -> Deposits<S, H> {
    let mut all = Deposits::none();
    let trace = |batch: &[u64]| -> Vec<Deposits<S, H>> {
        let chunk = |chunk: &u64| {
            let first = paths.start + chunk * CHUNK;
            let range = first..paths.end.min(first + CHUNK);
            advance(range.end - range.start);
            tracer.trace(range)
        };
        // One chunk a task, lest a thread without work waits for one that took many.
        batch.par_iter().with_max_len(1).map(chunk).collect()
    };
    let mut record = |traced: Vec<Deposits<S, H>>| {
        traced.iter().for_each(|deposits| all.append(deposits));
        let segments: Vec<&[FlightSegment<S>]> = traced.iter().map(|d| &d.tracks[..]).collect();
        all.work.tracks += segments.iter().map(|segments| segments.len() as u64).sum::<u64>();
        flights(&segments);
    };
    let chunks: Vec<u64> = (0..(paths.end - paths.start).div_ceil(CHUNK)).collect();
    // Both at once, so that no thread waits for the last tasks of either.
    let mut traced = Vec::new();
    for batch in chunks.chunks(BATCH) {
        (traced, ()) = rayon::join(|| trace(batch), || record(traced));
    }
    record(traced);
    all
}
