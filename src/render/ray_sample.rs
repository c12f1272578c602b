//! Rays in few pixels, for what all rays of a picture take: their work and time, and those of filling cells of caches.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::control::Control;
use super::exposure::{self, RenderRegion};
use super::features::FeatureTracer;
use super::photon_pass::PhotonPass;
use super::pixel_sampling::{CameraRay, FilmPlace, Workspace};
use super::stage_settings::film_contents;
use crate::director::PixelBudget;
use crate::film::FilmContents;
use crate::image::Window;
use crate::math::{Spectrum, Stage};
use crate::photon::PhotonDirection;
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::transport::Amortized;
use crate::work::Work;

/// Rays that an estimate shoots each time, about.
const RAYS: f64 = 30_000.0;

/// Places along each of those rays at most, at which cells are filled.
const MAX_FILLING_PLACES: u32 = 32;

/// The film of an estimate of rays, with fewer pixels than the picture's.
pub(super) struct RaySample {
    /// Width and height in pixels.
    size: [f64; 2],
    /// Pixels of the picture for each.
    pub ratio: f64,
}

impl RaySample {
    /// For the rays of a picture of `scene` under `settings`.
    pub fn new(scene: &Scene, settings: &RenderSettings) -> Self {
        let [width, height] = scene.film.size.map(f64::from);
        let all = width * height * f64::from(settings.rays);
        let coarser = (all / RAYS).sqrt().max(1.0);
        let size = [width, height].map(|side| (side / coarser).ceil().max(1.0));
        Self { size, ratio: width * height / (size[0] * size[1]) }
    }

    /// Places along each of its rays at which they look up caches as often as those of the picture do, each of which has so
    /// many `places`.
    pub fn filling_places(&self, places: u32) -> u32 {
        ((f64::from(places) * self.ratio) as u32).clamp(places, MAX_FILLING_PLACES.max(places))
    }

    /// Renders it by `photons`, with this `budget` a pixel.
    pub fn expose<S: Spectrum, H: PhotonDirection>(
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
pub(super) struct ExposedSample {
    /// Work of its rays.
    pub tracing: Work,
    /// Work of filling cells of caches, which rays share.
    pub filling: Work,
    /// Seconds of its rays.
    pub tracing_seconds: f64,
    /// Seconds of filling cells.
    pub filling_seconds: f64,
}
