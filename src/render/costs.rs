//! About how much work and memory a render will take, from a small look at the scene.

use std::time::Instant;

use serde::Serialize;

use super::exposure::{self, RenderRegion};
use super::features::FeatureTracer;
use super::integrator::Integrator;
use super::photon_pass::PhotonPass;
use super::photon_rate::PhotonRate;
use super::pixel_sampling::{CameraRay, Workspace};
use super::seconds::{self, StageSeconds};
use super::{Control, director_pass, finest_step, specialised};
use crate::director::PixelBudget;
use crate::error::Result;
use crate::image::{Accumulator, FeatureMean, Features, Sample, Window};
use crate::math::{Spectrum, Stage};
use crate::medium::Medium;
use crate::photon::{self, PhotonDirection, PhotonMemory};
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::strategy::Summary;
use crate::work::Work;

/// Rays of the look, about.
const RAYS: f64 = 30_000.0;

/// Bytes a pixel: what its samples leave and the film's layers.
const FILM: u64 = size_of::<Accumulator>() as u64 + 60;

/// Bytes a pixel more where it takes in what its rays see.
const FEATURES: u64 = (size_of::<FeatureMean>() + size_of::<Features>()) as u64;

/// Bytes a pixel of the layers, their copies for the file and the file itself.
const WRITING: u64 = 48 + 48 + 48;

/// Bytes a pixel of the maps: distances, snapshot, X, S, XS.
const MAPS: u64 = 8 + 12 + 4 + 4 + 4;

/// Bytes a pixel of the film: what it may spend.
const BUDGET: u64 = 80;

/// Bytes, at most, that the allocator keeps of what was freed: larger blocks go back at once.
const RETAINED: u64 = 32 << 20;

/// Bytes of threads, small tables and what the file formats keep.
const WORKING: u64 = 4 << 20;

/// About what a render takes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Costs {
    /// How light in media is estimated, and why.
    pub strategy: Summary,
    /// Work, by the counters that the render itself will report; at most so much where a director
    /// hands out rays.
    pub work: Work,
    /// Memory.
    pub memory: Memory,
    /// Time on this machine, on as many threads as the look had.
    pub seconds: StageSeconds,
}

/// Memory in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// What stays once it is there: grids, trees, photon maps and maps as they are used, the film with
    /// what is gathered for it.
    #[serde(flatten)]
    pub kept: MemoryParts,
    /// The film while it is written, with its copies.
    pub writing: u64,
    /// The most that is in use at any time.
    pub peak: u64,
    /// What it consists of.
    pub at_peak: MemoryParts,
}

/// Bytes in use at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MemoryParts {
    /// The program and its libraries.
    pub program: u64,
    /// Voxel grids, and what is read into them.
    pub grids: u64,
    /// Surfaces with their trees, and what is read into them.
    pub surfaces: u64,
    /// Photons and what they leave, with what building that takes.
    pub photons: u64,
    /// The film, or its copies while it is written.
    pub film: u64,
    /// The director's maps.
    pub maps: u64,
}

impl MemoryParts {
    /// All of it.
    pub const fn sum(&self) -> u64 {
        self.program + self.grids + self.surfaces + self.photons + self.film + self.maps
    }
}

/// Estimates what rendering `scene` under `settings` takes, by a small part of it, in a program that
/// takes `program` bytes before it loads the scene.
///
/// # Errors
/// As [`render`](super::render()).
pub fn costs(scene: &Scene, settings: &RenderSettings, program: u64) -> Result<Costs> {
    specialised!(Needs::of(scene, settings), estimate(scene, settings, program))
}

fn estimate<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    program: u64,
) -> Result<Costs> {
    let needs = Needs::of(scene, settings);
    let start = Instant::now();
    let (photons, mut work) = look::<S, H>(scene, settings)?;
    let shooting = PhotonRate::beside(scene, settings, start.elapsed())?;

    let [width, height] = scene.film.size.map(f64::from);
    let all = width * height * f64::from(settings.rays);
    let coarser = (all / RAYS).sqrt().max(1.0);
    let size = [width, height].map(|side| (side / coarser).ceil().max(1.0));
    let step = settings.step.unwrap_or_else(|| finest_step(scene));
    let budget = PixelBudget::fixed(settings.rays, photons.maps.volume_radius, step);
    let integrator = Integrator::new(scene, &photons, needs);
    let seen = FeatureTracer::new(scene, settings.denoise);
    let expose = |seed: u64| {
        let small = size.map(|side| side as u32);
        let sheet = RenderRegion {
            size: small,
            window: Window::whole(small),
            seed,
            stage: Stage::Director,
            rays: settings.rays,
            needs,
            features: false,
        };
        let camera = |x, y, lens| scene.camera.ray(x * width / size[0], y * height / size[1], lens);
        let radiance = |ray: &CameraRay<'_>, workspace: &mut Workspace<S>| {
            let sample = integrator.radiance(ray, workspace);
            Sample { features: seen.along(ray.ray, ray.budget.step, workspace), ..sample }
        };
        let fixed = |_, _| budget;
        exposure::expose(sheet, camera, fixed, radiance, &[], &Control::silent()).work
    };
    let timed = |seed: u64| {
        let start = Instant::now();
        (expose(seed), start.elapsed().as_secs_f64())
    };
    // What lattices keep is computed once; the second look finds most of it.
    let (first, begun) = timed(settings.seed);
    let (again, each) = timed(settings.seed.wrapping_add(1));
    let larger = width * height / (size[0] * size[1]);
    work += scaled(&again, larger);
    work += first.less(&again);
    let directed = seconds::directed(scene, settings, budget)?;
    let seconds = StageSeconds {
        director: directed.seconds,
        photons: shooting.map_or(0.0, |pace| pace.time(settings.photons).as_secs_f64()),
        march: directed.share * each * larger + (begun - each).max(0.0),
    };
    work.rays = (width * height) as u64 * u64::from(settings.rays);
    work.map_pixels = if needs.maps { map_pixels(scene, settings) } else { 0 };
    let strategy = photons.choice.summary();
    let [fluence, lazy] = photons.caches.memory_bytes();
    let photons = photon::memory::<S, H>(&work, fluence, lazy);
    let memory = memory(scene, settings, photons, program + WORKING);
    Ok(Costs { strategy, work, memory, seconds })
}

/// Estimates the memory that rendering `scene` under `settings` takes, as [`costs`], without a look
/// at its rays. Its look at photons is no work of the picture, and not counted.
///
/// # Errors
/// As [`costs`].
pub fn memory_needed(scene: &Scene, settings: &RenderSettings, program: u64) -> Result<Memory> {
    let photons = specialised!(Needs::of(scene, settings), photon_memory(scene, settings))?;
    Ok(memory(scene, settings, photons, program + WORKING))
}

fn photon_memory<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
) -> Result<PhotonMemory> {
    let (photons, work) = look::<S, H>(scene, settings)?;
    let [fluence, lazy] = photons.caches.memory_bytes();
    Ok(photon::memory::<S, H>(&work, fluence, lazy))
}

/// The maps that a few of the photons leave, and the work that all are.
fn look<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
) -> Result<(PhotonPass<S, H>, Work)> {
    let (shooting, paths) = director_pass::look(scene, settings);
    let (photons, shot) = PhotonPass::new(scene, &shooting, &|_| ())?;
    Ok((photons, scaled(&shot, settings.photons as f64 / paths.max(1) as f64)))
}

/// About the memory that rendering `scene` under `settings` takes beside photons, in a program that
/// takes `program` bytes before it loads the scene.
pub fn memory_without_photons(scene: &Scene, settings: &RenderSettings, program: u64) -> Memory {
    let none = PhotonMemory { held: 0, building: 0, pieces: 0 };
    memory(scene, settings, none, program + WORKING)
}

fn scaled(work: &Work, factor: f64) -> Work {
    work.map(|count| (count as f64 * factor).round() as u64)
}

/// Pixels of each of the director's maps.
fn map_pixels(scene: &Scene, settings: &RenderSettings) -> u64 {
    settings.directing.map_size(scene.film.size).map(u64::from).iter().product()
}

fn memory(scene: &Scene, settings: &RenderSettings, photons: PhotonMemory, program: u64) -> Memory {
    let all = Window::whole(scene.film.size);
    let pixels = settings.crop.unwrap_or(all).pixels();
    let media = &scene.media;
    let sizes = media.grid_bytes();
    let grids = sizes.iter().map(|bytes| *bytes as u64).sum::<u64>();
    let surfaces = scene.surfaces.memory_bytes() as u64;
    let film = pixels * (FILM + if settings.denoise { FEATURES } else { 0 });
    let maps = map_pixels(scene, settings) * MAPS + all.pixels() * BUDGET;
    let maps = if Needs::of(scene, settings).maps { maps } else { 0 };
    let writing = pixels * WRITING;
    // Grids are read one after another, the last beside the others; its source and OpenVDB's own
    // copy come and go. So do the lists that a mesh is read into.
    let read = sizes.last().map_or(0, |bytes| 2 * *bytes as u64);
    let reading = read + surfaces;
    let tables: u64 = media.iter().map(Medium::sampler_bytes).sum();
    let building = photons.building + tables;
    let left = |freed: u64| freed.min(RETAINED);
    // What reading left is taken again for photons.
    let freed = left(reading.max(building - photons.held));
    let built = (building + left(photons.pieces)).max(left(reading));
    let scene = MemoryParts { program, grids, surfaces, ..MemoryParts::default() };
    let at_peak = [
        MemoryParts { grids: grids + read, surfaces: 2 * surfaces, ..scene },
        MemoryParts { maps, photons: built, ..scene },
        MemoryParts { maps, photons: photons.held + freed, film, ..scene },
        MemoryParts { film: writing, photons: freed, ..scene },
    ];
    let at_peak = at_peak.into_iter().max_by_key(MemoryParts::sum).unwrap_or(scene);
    let kept = MemoryParts { photons: photons.held, film, maps, ..scene };
    Memory { kept, writing, peak: at_peak.sum(), at_peak }
}
