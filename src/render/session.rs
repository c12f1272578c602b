//! The session: a render from its scene to its picture, stage by stage.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use super::control::{Control, Stop};
use super::director_pass::{DirectorMaps, Earlier};
use super::error_pilot::{ErrorMaps, after_pilot, budgets, measure_importance, photon_demand};
use super::exposure::{Exposure, RenderRegion, Sampled, expose, resolve, sample};
use super::features::FeatureTracer;
use super::integrator::PathTracer;
use super::photon_pass::{PhotonPass, aim, strategies, strategies_by};
use super::pixel_sampling::{CameraRay, Workspace};
use super::progress::Stages;
use super::reconstruction::reconstruct;
use super::rendered::{Ended, Rendered};
use super::stage_settings::{finest_step, pass_settings, render_region, specialised};
use super::variance_pilot::budgets_by_variance;
use crate::cache::LazyCells;
use crate::director::{PhotonDemand, PixelBudget};
use crate::error::Result;
use crate::film::{ComponentFilm, FilmContents, Sample};
use crate::math::{Rgb, Spectrum, Stage};
use crate::photon::{AimedPhotons, PhotonDirection};
use crate::scene::plan::Needs;
use crate::scene::{Director, RenderSettings, Scene};
use crate::strategy::Assignment;
use crate::work::Work;

/// Renders `scene` by photon maps and ray marching, directed as `settings` say. The picture is the
/// same on any number of threads of the rayon pool it is called in, and however often it was
/// interrupted and resumed. `control` is a [`Progress`](super::Progress) or a [`Control`].
///
/// # Errors
/// Where an emitter cannot be sampled, or a checkpoint does not fit the scene.
pub fn render<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Result<Rendered> {
    render_next(scene, settings, Earlier::default(), control)
}

/// The strategies that suit `scene`, which may stand for all frames of a shot: decided once, they cannot
/// make pictures flicker.
///
/// # Errors
/// As [`render()`].
pub fn shot_strategies(scene: &Scene, settings: &RenderSettings) -> Result<Assignment> {
    let pass = pass_settings(scene, settings);
    specialised!(pass.photons.needs, strategies(scene, &pass))
}

/// As [`render()`], for the next frame of a sequence.
///
/// # Errors
/// As [`render()`].
pub fn render_next<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    earlier: Earlier<'_>,
    control: impl Into<Control<'a>>,
) -> Result<Rendered> {
    let control = control.into();
    let mut stages = Stages::default();
    let needs = Needs::new(scene, settings);
    let pass = pass_settings(scene, settings);
    // Strategies.
    let start = Instant::now();
    let mut aimed = specialised!(needs, aim(scene, &pass))?;
    let own;
    let strategies = match earlier.strategies {
        Some(of_shot) => of_shot,
        None => {
            own = specialised!(needs, strategies_by(scene, &pass, aimed.as_mut()));
            &own
        }
    };
    stages.done("strategy", start);
    // Pilot and director.
    let earlier = Earlier { strategies: Some(strategies), ..earlier };
    let mut maps = DirectorMaps::for_render(scene, settings, earlier, &mut stages)?;
    let (director, snapshot) = (maps.director_work(), maps.snapshot.take());
    // Photons, caches, rays and film.
    let demand = photon_demand(settings, strategies);
    let job = Directed { scene, settings, maps: &maps, strategies, demand };
    let rendered = specialised!(needs, render_directed(&job, aimed, &control, stages))?;
    Ok(Rendered { director, snapshot, ..rendered })
}

/// A picture to render after the director.
struct Directed<'a> {
    scene: &'a Scene,
    settings: &'a RenderSettings,
    maps: &'a DirectorMaps,
    strategies: &'a Assignment,
    demand: PhotonDemand,
}

/// Renders the picture that maps direct. `stages` are those that ran before.
fn render_directed<S: Spectrum, H: PhotonDirection>(
    job: &Directed<'_>,
    aimed: Option<AimedPhotons<'_>>,
    control: &Control<'_>,
    mut stages: Stages,
) -> Result<Rendered> {
    let Directed { scene, settings, maps, .. } = *job;
    let mut work = maps.work;
    work += maps.pilot_work;
    work.unseen_voxels = scene.unseen.map_or(0, |unseen| unseen.held());

    // Photons.
    let start = Instant::now();
    let (photons, shot) = shoot_photons::<S, H>(job, aimed, control);
    work += shot;
    stages.done("photons", start);

    let radius = PhotonPass::finest_radius(&photons);
    let gold = PixelBudget::fixed(settings.rays, radius, finest_step(scene, settings));
    let region = render_region(scene, settings, Stage::March);
    let exposed = expose_directed(job, &photons, &region, gold, control, &mut stages)?;
    let rendered = finished::<S>(job, &region, exposed, work, stages, radius);
    Ok(Rendered { strategy: Some(photons[0].choice.summary()), ..rendered })
}

/// Exposes the film of `region` by `photons`, with what the director gives each pixel: by its maps, or by what it measures
/// in the first rays.
fn expose_directed<S: Spectrum, H: PhotonDirection>(
    job: &Directed<'_>,
    photons: &[PhotonPass<S, H>],
    region: &RenderRegion,
    gold: PixelBudget,
    control: &Control<'_>,
    stages: &mut Stages,
) -> Result<Exposure> {
    let Directed { scene, settings, maps, demand, .. } = *job;
    let needs = Needs::new(scene, settings);
    let integrators: Vec<_> = photons.iter().map(|pass| pass.integrator(scene, needs)).collect();
    // Caches: rays fill the cells that they need; a checkpoint brings those that are known.
    let caches = lazy_cells(photons, control)?;
    let tracer = FeatureTracer::new(scene, settings.denoise);
    let camera = |x, y, lens| scene.camera.ray(x, y, lens);
    let estimate = |camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>| {
        let CameraRay { ray, budget, half, .. } = camera_ray;
        let half = half.unwrap_or(0) % integrators.len();
        let sample = integrators[half].radiance(camera_ray, workspace);
        Sample { features: tracer.along(*ray, budget.step, workspace), ..sample }
    };

    // Budgets of pixels.
    let mut begun = Sampled::none(region);
    let gold = if settings.measures_error() { after_pilot(gold, settings) } else { gold };
    let budgets = if settings.measures_error() {
        let pilot = |region: RenderRegion, budget: PixelBudget, control: &Control<'_>| {
            let none = Sampled::none(&region);
            sample(region, camera, |_, _| budget, estimate, none, &caches, control)
        };
        let importance = |components: &ComponentFilm| {
            ErrorMaps::new(components, settings, demand.ray_share).importance()
        };
        measure_importance(region, pilot, importance, gold, control, &mut begun, stages);
        budgets(&begun.film.importance, scene, settings, gold)
    } else if settings.director == Director::Variance {
        let start = Instant::now();
        let (budgets, measuring) = budgets_by_variance(scene, settings, &integrators[0], gold);
        begun.work += measuring;
        stages.done("pilot", start);
        budgets
    } else {
        maps.budgets(scene, settings, gold)
    };

    // Rays.
    let start = Instant::now();
    let width = scene.film.size[0] as usize;
    let budget =
        |x: u32, y: u32| budgets.get(y as usize * width + x as usize).copied().unwrap_or(gold);
    let sampled = sample(*region, camera, budget, estimate, begun, &caches, control);
    let exposed = resolve(region, budget, sampled);
    stages.done("march", start);
    Ok(exposed)
}

/// The picture of `region`, reconstructed where its components are known; `work` was done before it was `exposed`.
fn finished<S: Spectrum>(
    job: &Directed<'_>,
    region: &RenderRegion,
    mut exposed: Exposure,
    mut work: Work,
    mut stages: Stages,
    radius: f64,
) -> Rendered {
    let is_stopped = exposed.ended == Ended::Stopped;
    if let Some(components) =
        exposed.components.take().filter(|_| job.settings.reconstructs() && !is_stopped)
    {
        let start = Instant::now();
        let step = finest_step(job.scene, job.settings);
        work += reconstruct::<S>(job.scene, region, step, &mut exposed.film, &components);
        stages.done("reconstruct", start);
    }
    rendered(exposed, work, stages, Some(radius))
}

/// All cells that rays fill, those that passes share once, with what a checkpoint knows of them.
fn lazy_cells<'a, S: Spectrum, H: PhotonDirection>(
    passes: &'a [PhotonPass<S, H>],
    control: &Control<'_>,
) -> Result<Vec<&'a LazyCells<S>>> {
    let first = passes.first().into_iter().flat_map(|pass| pass.caches.lazy());
    let others = passes.iter().skip(1).flat_map(|pass| pass.caches.own_lazy());
    let cells: Vec<_> = first.chain(others).collect();
    if let Some(checkpoints) = control.checkpoints {
        checkpoints.restore(&cells)?;
    }
    Ok(cells)
}

/// Shoots the `aimed` photons, with what the director's maps ask for, and builds the photon maps: of all, or
/// where the picture is reconstructed of two halves.
fn shoot_photons<S: Spectrum, H: PhotonDirection>(
    job: &Directed<'_>,
    aimed: Option<AimedPhotons<'_>>,
    control: &Control<'_>,
) -> (Vec<PhotonPass<S, H>>, Work) {
    let Directed { scene, settings, maps, strategies, demand } = *job;
    let progress = control.progress;
    let in_halves = settings.in_halves().then_some(demand.paths);
    let settings = maps.pass_settings(scene, settings);
    progress.stage("photons", demand.paths);
    let paths = AtomicU64::new(0);
    let advance = |count: u64| {
        control.stop.into_iter().for_each(Stop::wait);
        progress.advance(count);
        // Building the maps has no units of its own, and can take longer than all paths.
        if paths.fetch_add(count, Ordering::Relaxed) + count == demand.paths {
            progress.stage("photon map", 0);
        }
    };
    let shot = PhotonPass::shoot(scene, &settings, strategies, aimed, in_halves, &advance);
    progress.finish();
    shot
}

/// Renders the unbiased reference of `scene`: null-collision path tracing with next-event estimation.
/// The picture is the same on any number of threads of the rayon pool it is called in; `control` is
/// as in [`render()`].
pub fn render_reference<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Rendered {
    let control = control.into();
    if Needs::new(scene, settings).colors {
        trace_reference::<Rgb>(scene, settings, &control)
    } else {
        trace_reference::<f64>(scene, settings, &control)
    }
}

fn trace_reference<S: Spectrum>(
    scene: &Scene,
    settings: &RenderSettings,
    control: &Control<'_>,
) -> Rendered {
    let mut stages = Stages::default();
    let start = Instant::now();
    let paths = PathTracer::new(scene, settings.max_scatter);
    let tracer = FeatureTracer::new(scene, settings.denoise);
    let budget = PixelBudget::fixed(settings.rays, 0.0, 0.0);
    let exposed = expose(
        RenderRegion {
            contents: FilmContents { features: settings.denoise, components: false },
            ..render_region(scene, settings, Stage::Reference)
        },
        |x, y, lens| scene.camera.ray(x, y, lens),
        |_, _| budget,
        |camera_ray, workspace: &mut Workspace<S>| {
            let CameraRay { ray, budget, .. } = camera_ray;
            let sample = paths.radiance::<S>(*ray, &mut workspace.ctx);
            Sample { features: tracer.along(*ray, budget.step, workspace), ..sample }
        },
        &[],
        control,
    );
    stages.done("reference", start);
    rendered(exposed, Work::default(), stages, None)
}

/// Renders `scene` without photons, for a render that is stopped before they are shot: one ray a pixel,
/// or where `control` ends it fewer and the nearest neighbours of those pixels. It shows emission and
/// light that was scattered or reflected once, and is marked as [stopped](Ended::Stopped).
pub fn preview<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Rendered {
    let (mut stages, start) = (Stages::default(), Instant::now());
    let photons = PhotonPass::<Rgb>::empty(settings.radius.unwrap_or(0.0));
    let budget = PixelBudget::fixed(1, photons.radius, finest_step(scene, settings));
    let integrator = photons.integrator(scene, Needs::new(scene, settings));
    let exposed = expose(
        RenderRegion {
            contents: FilmContents::default(),
            ..render_region(scene, settings, Stage::March)
        },
        |x, y, lens| scene.camera.ray(x, y, lens),
        |_, _| budget,
        |camera_ray, workspace| integrator.radiance(camera_ray, workspace),
        &[],
        &control.into(),
    );
    stages.done("preview", start);
    let preview = rendered(exposed, Work::default(), stages, None);
    Rendered { ended: Ended::Stopped, ..preview }
}

/// The picture of an exposure; `work` was done beside it.
fn rendered(exposed: Exposure, mut work: Work, stages: Stages, radius: Option<f64>) -> Rendered {
    let Exposure { film, work: exposing, ended, rays_left, checkpoint_error, .. } = exposed;
    work += exposing;
    Rendered {
        film,
        work,
        timings: stages.timings,
        radius,
        ended,
        rays_left,
        checkpoint_error,
        strategy: None,
        director: None,
        snapshot: None,
    }
}
