//! Work, memory and time that a render will take, extrapolated from a small part of it.
//!
//! - Photons: a few of the paths are traced. Their counters scale with the number of paths, and their
//!   time as in [`PhotonRate`].
//! - Rays: the film is rendered twice in few pixels. What filling caches takes the first time, where rays look them up at
//!   as many places as all of the picture's do, is added once. All else of the second time scales with the pixels of the film.
//! - Pilot of strategies: it runs, and takes what it takes.
//! - Rounds of a picture that is rendered to an error: the first is rendered, and takes what it takes. Its error tells how many
//!   follow, each of which fills its own caches.
//! - Director: its maps are made, at a lower resolution where the film is large; their time scales with
//!   their pixels. The budgets that follow tell what share of the rays is shot.

use std::time::Instant;

use serde::Serialize;

use super::director_pass::{DirectorMaps, Earlier};
use super::error_pilot::demanded_share;
use super::error_session::{ErrorJob, Foretold, foretell};
use super::memory::{Memory, map_pixels, memory_with};
use super::photon_pass::{PhotonPass, strategies};
use super::photon_rate::PhotonRate;
use super::pixel_sampling::Numbering;
use super::progress::Stages;
use super::ray_sample::RaySample;
use super::rounds::{Extent, Round, total};
use super::stage_settings::{
    finest_step, pass_settings, sampled_pass_settings, specialised, specialised_for_film,
};
use crate::cache::LazyCells;
use crate::director::PixelBudget;
use crate::error::Result;
use crate::film::FIRST_RAYS;
use crate::image::Window;
use crate::math::Spectrum;
use crate::photon::{self, BeamMap, MapLayout, PhotonDirection, PhotonMemory};
use crate::scene::plan::Needs;
use crate::scene::{Director, RenderSettings, Scene};
use crate::strategy::{Assignment, Summary};
use crate::work::Work;

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
    let whole = total(&rounds.all);
    let settings = &RenderSettings { photons: whole.photons, rays: whole.rays, ..*settings };
    let start = Instant::now();
    let SampledPhotons { pass: photons, work: of_photons, kept } =
        sample_photons::<S, H>(scene, settings, &assignment)?;
    // The photons of one round are in memory at once.
    let most = rounds.all.iter().map(|round| round.adds.photons).max().unwrap_or(0);
    let held = scaled(&of_photons, most as f64 / settings.photons.max(1) as f64);
    let mut work = rounds.work;
    let mut seconds = StageSeconds { director: pilot, ..rounds.seconds };
    if let Some(coming) = rounds.coming() {
        let left = total(coming);
        work += scaled(&of_photons, left.photons as f64 / settings.photons.max(1) as f64);
        let rate = PhotonRate::from_sample(scene, settings, &assignment, start.elapsed())?;
        let passes = coming.len() as f64;
        seconds.photons += rate.map_or(0.0, |rate| rate.seconds(left.photons, passes));
        let settings = RenderSettings { rays: left.rays, ..*settings };
        let rays = RayCosts::new(scene, &settings, coming, &photons)?;
        work += rays.work;
        seconds.director += rays.directing;
        seconds.march += rays.march;
    }
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
    let shot = (whole.photons as f64 * demanded_share(settings, &assignment)).round() as u64;
    Ok(Costs { rays: whole.rays, photons: shot, strategy, work, memory, seconds })
}

/// The rounds of a render.
struct Rounds {
    all: Vec<Round>,
    /// How many of them were rendered.
    rendered: usize,
    /// What those did.
    work: Work,
    /// What those took.
    seconds: StageSeconds,
}

impl Rounds {
    /// Those that were not rendered, if there are any.
    fn coming(&self) -> Option<&[Round]> {
        Some(&self.all[self.rendered..]).filter(|coming| !coming.is_empty())
    }
}

/// The rounds of a render of `scene` under `settings`, by the first of them where an error is its goal; one otherwise, and where
/// that shows no light.
fn rounds<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    strategies: &Assignment,
) -> Result<Rounds> {
    if let Some(goal) = settings.error {
        let job = ErrorJob { scene, settings, goal, strategies };
        if let Some(Foretold { rounds, work, stages }) = foretell::<S, H>(&job)? {
            let [photons, march] = ["photons", "march"].map(|name| stages.seconds_of(name));
            let seconds = StageSeconds { director: 0.0, photons, march };
            return Ok(Rounds { all: rounds, rendered: 1, work, seconds });
        }
    }
    let RenderSettings { rays, photons, .. } = *settings;
    let whole = Extent { photons, rays };
    let all = vec![Round { adds: whole, whole, found: None }];
    Ok(Rounds { all, rendered: 0, work: Work::default(), seconds: StageSeconds::default() })
}

/// What the rays of a picture take.
struct RayCosts {
    work: Work,
    /// Seconds of a director's maps.
    directing: f64,
    /// Seconds of the rays.
    march: f64,
}

impl RayCosts {
    /// That of the rays of `settings` in so many `rounds`, by `photons` of a sample.
    fn new<S: Spectrum, H: PhotonDirection>(
        scene: &Scene,
        settings: &RenderSettings,
        rounds: &[Round],
        photons: &PhotonPass<S, H>,
    ) -> Result<Self> {
        let gold = PixelBudget::fixed(settings.rays, photons.radius, finest_step(scene, settings));
        let gold = PixelBudget { gathers: gathers(settings, rounds), ..gold };
        let sample = RaySample::new(scene, settings);
        // Cells are filled once, by rays that look them up at as many places as those of the whole picture do.
        let filling = PixelBudget { places: sample.filling_places(gold.places), ..gold };
        let first = sample.expose(scene, settings, photons, filling, settings.seed);
        let second = sample.expose(scene, settings, photons, gold, settings.seed.wrapping_add(1));
        // Each round has photons of its own, and each half of them cells.
        let has_own = settings.in_halves() && photons.caches.own_lazy().next().is_some();
        let fills = if has_own { 2.0 } else { 1.0 };
        let once = rounds.len() as f64 * fills * first.filling_seconds;
        let directed = directed_share(scene, settings, gold)?;
        Ok(Self {
            work: [first.filling, scaled(&second.tracing, sample.ratio)].into_iter().sum(),
            directing: directed.seconds,
            march: directed.share * second.tracing_seconds * sample.ratio + once,
        })
    }
}

/// Gathers of a pixel in all `rounds`, each of which has some in each half.
fn gathers(settings: &RenderSettings, rounds: &[Round]) -> u32 {
    let numbering = if settings.in_halves() { Numbering::halves([0, 0]) } else { Numbering::Whole };
    let of = |round: &Round| numbering.gathers(&PixelBudget::fixed(round.adds.rays, 0.0, 0.0));
    rounds.iter().map(of).sum()
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
    let all = settings.path_count() as f64 * demanded_share(settings, assignment);
    let work = scaled(&shot, all / paths.max(1) as f64);
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
/// scene has its own, and each half of a picture that is in halves, but for those of direct light.
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
    photon::memory::<S, H>(work, MapLayout { maps, kept }, [fluence, lazy], pilot_bytes)
}
