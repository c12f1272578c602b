//! Work, memory and time that a render will take, extrapolated from a small part of it.
//!
//! - Photons: a few of the paths are traced. Their counters scale with the number of paths, and their
//!   time as in [`PhotonRate`].
//! - Rays: the film is rendered twice in few pixels. What filling caches takes the first time, where rays look them up at
//!   as many places as all of the picture's do, is added once. All else of the second time scales with the pixels of the film.
//! - Pilot of strategies: it runs, and takes what it takes.
//! - Rounds of a picture that is rendered to an error: the first is rendered, and its error tells how many follow. Each fills
//!   its own caches.
//! - Director: its maps are made, at a lower resolution where the film is large; their time scales with
//!   their pixels. The budgets that follow tell what share of the rays is shot.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::control::Control;
use super::director_pass::{DirectorMaps, Earlier};
use super::error_session::{ErrorJob, foretell};
use super::exposure::{self, RenderRegion};
use super::features::FeatureTracer;
use super::memory::{Memory, map_pixels, memory_with};
use super::photon_pass::{PhotonPass, strategies};
use super::photon_rate::PhotonRate;
use super::pixel_sampling::{CameraRay, FilmPlace, Numbering, Workspace};
use super::progress::Stages;
use super::rounds::{Extent, Round, total};
use super::stage_settings::{
    film_contents, finest_step, pass_settings, sampled_pass_settings, specialised,
    specialised_for_film,
};
use crate::cache::LazyCells;
use crate::director::PixelBudget;
use crate::error::Result;
use crate::film::{FIRST_RAYS, FilmContents};
use crate::image::Window;
use crate::math::{Spectrum, Stage};
use crate::photon::{self, BeamMap, PhotonDirection, PhotonMemory};
use crate::scene::plan::Needs;
use crate::scene::{Director, RenderSettings, Scene};
use crate::strategy::{Assignment, Summary};
use crate::transport::Amortized;
use crate::work::Work;

/// Rays that an estimate shoots each time, about.
const RAYS: f64 = 30_000.0;

/// Places along each of those rays at most, at which cells are filled.
const MAX_FILLING_PLACES: u32 = 32;

/// Pixels of each of the director's maps, at most, that an estimate makes.
const MAP_PIXELS: f64 = 262_144.0;

/// What a render takes, estimated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Costs {
    /// Rays of a pixel, those that the error asks for where one is the goal.
    pub rays: u32,
    /// Photon paths, likewise.
    pub photons: u64,
    /// How light in media is estimated, and why.
    pub strategy: Summary,
    /// Work, by the counters that the render itself will report; an upper bound where a director
    /// distributes rays.
    pub work: Work,
    /// Memory.
    pub memory: Memory,
    /// Time on this machine, on as many threads as the estimate had.
    pub seconds: StageSeconds,
}

/// Wall-clock time of the stages of a render, in seconds, without loading, metering and writing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Pilot of strategies and director.
    pub director: f64,
    /// Photons, with building their maps.
    pub photons: f64,
    /// Rays; an upper bound where a director gives rays by variance or measured error.
    pub march: f64,
}

impl StageSeconds {
    /// Sum of all stages.
    pub fn total(&self) -> f64 {
        self.director + self.photons + self.march
    }
}

/// Estimates what rendering `scene` under `settings` takes, by rendering a small part of it, in a
/// program that takes `program` bytes before it loads the scene.
///
/// # Errors
/// As [`render`](super::render()).
pub fn costs(scene: &Scene, settings: &RenderSettings, program: u64) -> Result<Costs> {
    specialised_for_film!(Needs::new(scene, settings), estimate(scene, settings, program))
}

fn estimate<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    program: u64,
) -> Result<Costs> {
    let start = Instant::now();
    let assignment = chosen_strategies(scene, settings)?;
    let is_measured = !assignment.measured.is_empty();
    let pilot = if is_measured { start.elapsed().as_secs_f64() } else { 0.0 };
    let rounds = rounds::<S, H>(scene, settings, &assignment)?;
    let whole = total(&rounds);
    let settings = &RenderSettings { photons: whole.photons, rays: whole.rays, ..*settings };
    let start = Instant::now();
    let SampledPhotons { pass: photons, mut work, kept } =
        sample_photons::<S, H>(scene, settings, &assignment)?;
    // The photons of one round are in memory at once.
    let most = rounds.iter().map(|round| round.adds.photons).max().unwrap_or(0);
    let held = scaled(&work, most as f64 / settings.photons.max(1) as f64);
    let rate = PhotonRate::from_sample(scene, settings, &assignment, start.elapsed())?;

    let gold = PixelBudget::fixed(settings.rays, photons.radius, finest_step(scene, settings));
    let gold = PixelBudget { gathers: gathers(settings, &rounds), ..gold };
    let sample = RaySample::new(scene, settings);
    // Cells are filled once, by rays that look them up at as many places as those of the whole picture do.
    let filling = PixelBudget { places: sample.filling_places(gold.places), ..gold };
    let first = sample.expose(scene, settings, &photons, filling, settings.seed);
    work += first.filling;
    let second = sample.expose(scene, settings, &photons, gold, settings.seed.wrapping_add(1));
    work += scaled(&second.tracing, sample.ratio);

    // Each round has photons of its own, and each half of them cells.
    let count = rounds.len() as f64;
    let has_own = settings.in_halves() && photons.caches.own_lazy().next().is_some();
    let fills = if has_own { 2.0 } else { 1.0 };
    let once = count * fills * first.filling_seconds;
    let directed = directed_share(scene, settings, gold)?;
    let seconds = StageSeconds {
        director: pilot + directed.seconds,
        photons: rate.map_or(0.0, |rate| rate.seconds(settings.photons, count)),
        march: directed.share * second.tracing_seconds * sample.ratio + once,
    };
    let measuring = match settings.director {
        Director::Variance => FIRST_RAYS.min(settings.rays),
        Director::Fixed | Director::X | Director::S | Director::Xs | Director::XsPaper => 0,
    };
    let rays = u64::from(settings.rays) + u64::from(measuring);
    work.rays = Window::whole(scene.film.size).pixels() * rays;
    let maps = Needs::new(scene, settings).maps;
    work.map_pixels = if maps { map_pixels(scene, settings) } else { 0 };
    let memory = memory_with(
        scene,
        settings,
        photon_pass_memory((&held, kept), (scene, settings), &photons, assignment.pilot_bytes),
        program,
    );
    let strategy = photons.choice.summary();
    Ok(Costs { rays: whole.rays, photons: whole.photons, strategy, work, memory, seconds })
}

/// The rounds of a render of `scene` under `settings`, by the first of them where an error is its goal; one otherwise, and where
/// that shows no light.
fn rounds<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    strategies: &Assignment,
) -> Result<Vec<Round>> {
    let foretold = match settings.error {
        Some(goal) => foretell::<S, H>(&ErrorJob { scene, settings, goal, strategies })?,
        None => None,
    };
    let RenderSettings { rays, photons, .. } = *settings;
    let whole = Extent { photons, rays };
    Ok(foretold.unwrap_or_else(|| vec![Round { adds: whole, whole, found: None }]))
}

/// Gathers of a pixel in all `rounds`, each of which has some in each half.
fn gathers(settings: &RenderSettings, rounds: &[Round]) -> u32 {
    let numbering = if settings.in_halves() { Numbering::halves([0, 0]) } else { Numbering::Whole };
    let of = |round: &Round| numbering.gathers(&PixelBudget::fixed(round.adds.rays, 0.0, 0.0));
    rounds.iter().map(of).sum()
}

/// The film of an estimate of rays, with fewer pixels than the picture's.
struct RaySample {
    /// Width and height in pixels.
    size: [f64; 2],
    /// Pixels of the picture for each.
    ratio: f64,
}

impl RaySample {
    fn new(scene: &Scene, settings: &RenderSettings) -> Self {
        let [width, height] = scene.film.size.map(f64::from);
        let all = width * height * f64::from(settings.rays);
        let coarser = (all / RAYS).sqrt().max(1.0);
        let size = [width, height].map(|side| (side / coarser).ceil().max(1.0));
        Self { size, ratio: width * height / (size[0] * size[1]) }
    }

    /// Places along each of its rays at which they look up caches as often as those of the picture do, each of which has so
    /// many `places`.
    fn filling_places(&self, places: u32) -> u32 {
        ((f64::from(places) * self.ratio) as u32).clamp(places, MAX_FILLING_PLACES.max(places))
    }

    /// Renders it.
    fn expose<S: Spectrum, H: PhotonDirection>(
        &self,
        scene: &Scene,
        settings: &RenderSettings,
        photons: &PhotonPass<S, H>,
        budget: PixelBudget,
        seed: u64,
    ) -> ExposedSample {
        let start = Instant::now();
        let filled = Mutex::new((Work::default(), Duration::ZERO));
        let needs = Needs::new(scene, settings);
        let integrator = photons.integrator(scene, needs);
        let tracer = FeatureTracer::new(scene, film_contents(scene, settings));
        let ([width, height], size) = (scene.film.size.map(f64::from), self.size);
        let small = size.map(|side| side as u32);
        let region = RenderRegion {
            size: small,
            window: Window::whole(small),
            shown: Window::whole(small),
            seed,
            stage: Stage::Director,
            rays: settings.rays,
            pass: None,
            times: 1,
            needs,
            contents: FilmContents::default(),
        };
        let camera = |FilmPlace { x, y, lens, .. }| {
            scene.camera.ray(x * width / size[0], y * height / size[1], lens)
        };
        let radiance = |camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>| {
            let Amortized { work, cells, .. } = workspace.ctx.amortized;
            let sample = integrator.radiance(camera_ray, workspace);
            let after = &workspace.ctx.amortized;
            let mut filled = filled.lock().unwrap_or_else(PoisonError::into_inner);
            filled.0 += after.work.less(&work);
            filled.1 += after.cells - cells;
            drop(filled);
            tracer.complete(sample, camera_ray, workspace)
        };
        let fixed = |_, _| budget;
        let exposed = exposure::expose(region, camera, fixed, radiance, &[], &Control::silent());
        let seconds = start.elapsed().as_secs_f64();
        let (filling, cells) = filled.into_inner().unwrap_or_else(PoisonError::into_inner);
        let filling_seconds = cells.as_secs_f64() / rayon::current_num_threads() as f64;
        ExposedSample {
            tracing: exposed.work.less(&filling),
            filling,
            tracing_seconds: (seconds - filling_seconds).max(0.0),
            filling_seconds,
        }
    }
}

/// What a sample of rays took.
struct ExposedSample {
    /// Work of its rays.
    tracing: Work,
    /// Work of filling cells of caches, which rays share.
    filling: Work,
    /// Seconds of its rays.
    tracing_seconds: f64,
    /// Seconds of filling cells.
    filling_seconds: f64,
}

/// Estimates the memory that rendering `scene` under `settings` takes, as [`costs`] does, without
/// shooting rays. The photons that it shoots are not counted as work of the picture.
///
/// # Errors
/// As [`costs`].
pub fn memory_needed(scene: &Scene, settings: &RenderSettings, program: u64) -> Result<Memory> {
    let needs = Needs::new(scene, settings);
    let photons = specialised_for_film!(needs, photon_memory(scene, settings))?;
    Ok(memory_with(scene, settings, photons, program))
}

/// The strategies of the picture, which do not tell groups of emitters apart.
fn chosen_strategies(scene: &Scene, settings: &RenderSettings) -> Result<Assignment> {
    let pass = pass_settings(scene, settings);
    specialised!(Needs::new(scene, settings), strategies(scene, &pass))
}

fn photon_memory<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
) -> Result<PhotonMemory> {
    let assignment = chosen_strategies(scene, settings)?;
    let SampledPhotons { pass, work, kept } = sample_photons::<S, H>(scene, settings, &assignment)?;
    Ok(photon_pass_memory((&work, kept), (scene, settings), &pass, assignment.pilot_bytes))
}

/// Photons of a few of the paths.
struct SampledPhotons<S: Spectrum, H: PhotonDirection> {
    /// Their maps.
    pass: PhotonPass<S, H>,
    /// The work that all paths of the picture or its pass are.
    work: Work,
    /// Share of the photons in media that their map keeps.
    kept: f64,
}

fn sample_photons<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    assignment: &Assignment,
) -> Result<SampledPhotons<S, H>> {
    let (shooting, paths) = sampled_pass_settings(scene, settings);
    let (pass, shot) = PhotonPass::<S, H>::new(scene, &shooting, assignment, &|_| ())?;
    let in_map = pass.maps.volume.first().map_or(0, BeamMap::len);
    let kept = in_map as f64 / shot.volume_photons.max(1) as f64;
    let work = scaled(&shot, settings.path_count() as f64 / paths.max(1) as f64);
    Ok(SampledPhotons { pass, work, kept })
}

fn scaled(work: &Work, factor: f64) -> Work {
    work.map(|count| (count as f64 * factor).round() as u64)
}

/// What a director takes, and what it leaves for the rays.
#[derive(Debug, Clone, Copy)]
struct DirectedShare {
    /// Seconds for its maps.
    seconds: f64,
    /// Rays in its budgets over rays of the gold standard, 0 to 1.
    share: f64,
}

/// Estimates what the director of `settings` takes and leaves, where `gold` is the gold standard's
/// budget.
fn directed_share(
    scene: &Scene,
    settings: &RenderSettings,
    gold: PixelBudget,
) -> Result<DirectedShare> {
    if !Needs::new(scene, settings).maps {
        return Ok(DirectedShare { seconds: 0.0, share: 1.0 });
    }
    let all = map_pixels(scene, settings) as f64;
    let mut small = *settings;
    small.directing.resolution *= (MAP_PIXELS / all).sqrt().min(1.0);
    let mut stages = Stages::default();
    let maps = DirectorMaps::for_render(scene, &small, Earlier::default(), &mut stages)?;
    let ratio = all / map_pixels(scene, &small) as f64;
    let budgets = maps.budgets(scene, settings, gold);
    let rays: f64 = budgets.iter().map(|budget| f64::from(budget.rays)).sum();
    let most = budgets.len() as f64 * f64::from(gold.rays.max(1));
    let share = if budgets.is_empty() { 1.0 } else { rays / most };
    Ok(DirectedShare { seconds: stages.seconds() * ratio, share })
}

/// Memory of the photons that `work` counts, of which maps keep this share, with the caches of `photons`. Each time of the
/// scene has its own, and each half of a picture that is reconstructed, but for those of direct light.
fn photon_pass_memory<S: Spectrum, H: PhotonDirection>(
    (work, kept): (&Work, f64),
    (scene, settings): (&Scene, &RenderSettings),
    photons: &PhotonPass<S, H>,
    pilot_bytes: u64,
) -> PhotonMemory {
    let [mut fluence, mut lazy] = photons.caches.memory_bytes();
    let gathers = photons.caches.own_lazy().map(LazyCells::memory_bytes).sum::<usize>() as u64;
    // The sample has no cells of optical thickness to the camera: they are as large as those of gathers.
    lazy += gathers;
    let mut maps = scene.moments().len() as u64;
    [fluence, lazy] = [fluence, lazy].map(|bytes| bytes * maps);
    if settings.in_halves() {
        fluence *= 2;
        lazy += maps * gathers;
        maps *= 2;
    }
    photon::memory::<S, H>(work, (maps, kept), [fluence, lazy], pilot_bytes)
}
