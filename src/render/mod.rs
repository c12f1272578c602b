//! Pass 2: rays are marched through the media, and the picture is put together.
//!
//! Only this room knows both the budget of a pixel and the estimators; below it plain numbers are
//! passed. The unbiased reference renders the same scene onto the same film.

mod checkpoint;
mod checkpoint_file;
mod clock;
mod control;
mod cost_model;
mod costs;
mod director_pass;
mod exposure;
mod features;
mod integrator;
mod metering;
mod photon_pass;
mod photon_rate;
mod pixel_sampling;
mod preview;
mod progress;
mod rendered;
mod seconds;

/// Calls a function that is generic over the channels of light and the heading of photons in media
/// for what is needed: chosen here, once, and not asked about in any loop.
macro_rules! specialised {
    ($needs:expr, $f:ident($($argument:expr),* $(,)?)) => {
        match ($needs.colors, $needs.directions) {
            (true, true) => $f::<crate::math::Rgb, crate::photon::Octahedral>($($argument),*),
            (true, false) => $f::<crate::math::Rgb, crate::photon::NoDirection>($($argument),*),
            (false, true) => $f::<f64, crate::photon::Octahedral>($($argument),*),
            (false, false) => $f::<f64, crate::photon::NoDirection>($($argument),*),
        }
    };
}
use specialised;

pub use checkpoint::Checkpoints;
pub use clock::{Clock, Deadline};
pub use control::{Control, Stop};
pub use costs::{Costs, Memory, MemoryParts, costs, memory_needed, memory_without_photons};
pub use director_pass::{Extent, Maps, maps};
pub use metering::exposure;
pub use photon_pass::{PassSettings, PhotonPass};
pub use photon_rate::photons_within;
pub use preview::preview;
pub use progress::{Progress, Silent, Stages};
pub use rendered::{Directed, Ended, Rendered};
pub use seconds::StageSeconds;

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::director::{CachedSnapshot, PixelBudget};
use crate::error::Result;
use crate::image::{Sample, Window};
use crate::math::{Rgb, Spectrum, Stage};
use crate::photon::PhotonDirection;
use crate::scene::plan::Needs;
use crate::scene::{Director, RenderSettings, Scene};
use crate::work::Work;

use exposure::{Exposure, RenderRegion};
use features::FeatureTracer;
use pixel_sampling::Workspace;

/// Renders `scene` with a photon map and a march, directed as `settings` say: the same picture on
/// any number of threads of the rayon pool it is called in, and however often it was cut short and
/// taken up again. `control` is whom to tell of progress, or a [`Control`].
///
/// # Errors
/// Where an emitter cannot be sampled, or a checkpoint does not fit the scene.
pub fn render<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Result<Rendered> {
    render_next(scene, settings, None, control)
}

/// As [`render()`], after a picture that left `kept`: where that suits the scene, nothing is
/// intersected for the director's first look. The picture and the work that it tells are the same.
///
/// # Errors
/// As [`render()`].
pub fn render_next<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    kept: Option<CachedSnapshot>,
    control: impl Into<Control<'a>>,
) -> Result<Rendered> {
    let control = control.into();
    let mut stages = Stages::default();
    let needs = Needs::of(scene, settings);
    let mut maps = Maps::default();
    if needs.maps {
        maps = director_pass::maps(scene, settings, kept, Extent::Needed, &mut stages)?;
    }
    if matches!(settings.director, Director::Fixed | Director::Variance) {
        maps.xs.clear(); // made for nothing, where everything is asked for
    }
    let (director, sight) = (maps.director().filter(|_| needs.maps), maps.sight.take());
    let rendered = specialised!(needs, picture(scene, settings, &maps, &control, stages))?;
    Ok(Rendered { director, sight, ..rendered })
}

/// The picture that `maps` direct, after the stages that made those.
fn picture<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    maps: &Maps,
    control: &Control<'_>,
    mut stages: Stages,
) -> Result<Rendered> {
    let (needs, progress) = (Needs::of(scene, settings), control.progress);
    let mut work = maps.work;
    work += maps.pilot_work;
    work.unseen_voxels = scene.unseen.map_or(0, |unseen| unseen.held());
    let start = Instant::now();
    let shooting = maps.shooting(scene, settings);
    progress.stage("photons", shooting.photons.photons);
    let paths = AtomicU64::new(0);
    let advance = |count: u64| {
        control.stop.into_iter().for_each(Stop::wait);
        progress.advance(count);
        // Building the maps can take longer than the last paths, and as long as all of them.
        if paths.fetch_add(count, Ordering::Relaxed) + count == shooting.photons.photons {
            progress.stage("photon map", 0);
        }
    };
    let (photons, shot) = PhotonPass::<S, H>::new(scene, &shooting, &advance)?;
    progress.finish();
    work += shot;
    stages.done("photons", start);

    let start = Instant::now();
    let step = settings.step.unwrap_or_else(|| finest_step(scene));
    let mut gold = PixelBudget::fixed(settings.rays, photons.maps.volume_radius, step);
    if settings.director == Director::Variance {
        gold = gold.until(settings.directing.tolerance, settings.directing.floor);
    }
    let budgets = maps.budgets(scene, settings, gold);
    let width = scene.film.size[0] as usize;
    let integrator = integrator::Integrator::new(scene, &photons, needs);
    let seen = FeatureTracer::new(scene, settings.denoise);
    if let Some(checkpoints) = control.checkpoints {
        checkpoints.restore(&photons.caches.lazy())?;
    }
    let exposed = exposure::expose(
        sheet(scene, settings, Stage::March),
        |x, y, lens| scene.camera.ray(x, y, lens),
        |x, y| {
            let index = y as usize * width + x as usize;
            budgets.get(index).copied().unwrap_or(gold)
        },
        |ray, workspace| {
            let sample = integrator.radiance(ray, workspace);
            Sample { features: seen.along(ray.ray, ray.budget.step, workspace), ..sample }
        },
        &photons.caches.lazy(),
        control,
    );
    stages.done("march", start);
    let strategy = Some(photons.choice.summary());
    let rendered = rendered(exposed, work, stages, Some(photons.maps.volume_radius));
    Ok(Rendered { strategy, ..rendered })
}

/// Renders `scene` without bias by null-collision path tracing with next-event estimation: the
/// same picture on any number of threads of the rayon pool it is called in, as [`render()`].
pub fn render_reference<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Rendered {
    let control = control.into();
    if Needs::of(scene, settings).colors {
        traced::<Rgb>(scene, settings, &control)
    } else {
        traced::<f64>(scene, settings, &control)
    }
}

fn traced<S: Spectrum>(
    scene: &Scene,
    settings: &RenderSettings,
    control: &Control<'_>,
) -> Rendered {
    let mut stages = Stages::default();
    let start = Instant::now();
    let tracer = integrator::PathTracer::new(scene, settings.max_scatter);
    let seen = FeatureTracer::new(scene, settings.denoise);
    let budget = PixelBudget::fixed(settings.rays, 0.0, 0.0);
    let exposed = exposure::expose(
        sheet(scene, settings, Stage::Reference),
        |x, y, lens| scene.camera.ray(x, y, lens),
        |_, _| budget,
        |ray, workspace: &mut Workspace<S>| {
            let sample = tracer.radiance::<S>(ray.ray, &mut workspace.ctx);
            Sample { features: seen.along(ray.ray, ray.budget.step, workspace), ..sample }
        },
        &[],
        control,
    );
    stages.done("reference", start);
    rendered(exposed, Work::default(), stages, None)
}

/// What is exposed for `stage`.
fn sheet(scene: &Scene, settings: &RenderSettings, stage: Stage) -> RenderRegion {
    let size = scene.film.size;
    RenderRegion {
        size,
        window: settings.crop.unwrap_or(Window::whole(size)),
        seed: settings.seed,
        stage,
        rays: settings.rays,
        needs: Needs::of(scene, settings),
        features: settings.denoise,
    }
}

/// The picture of an exposure, before which `work` was done.
fn rendered(exposed: Exposure, mut work: Work, stages: Stages, radius: Option<f64>) -> Rendered {
    let Exposure { film, work: exposing, ended, rays_left, checkpoint_error } = exposed;
    work += exposing;
    let timings = stages.timings;
    Rendered {
        film,
        work,
        timings,
        radius,
        strategy: None,
        ended,
        rays_left,
        checkpoint_error,
        director: None,
        sight: None,
    }
}

/// The step where none is given, in metres: the shortest voxel edge of all media, at which cells
/// are integrated exactly; 0 where there is no grid.
fn finest_step(scene: &Scene) -> f64 {
    scene.media.detail().unwrap_or(0.0)
}
