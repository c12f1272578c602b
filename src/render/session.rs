//! The session: a render from its scene to its picture, stage by stage.

use std::iter;
use std::time::Instant;

use super::control::Control;
use super::director_pass::{DirectorMaps, Earlier};
use super::error_pilot::{ErrorMaps, after_pilot, budgets, measure_importance, photon_demand};
use super::error_session::{ErrorJob, render_to_error};
use super::exposure::{Exposure, RenderRegion, Sampled, resolve, sample};
use super::photon_file::SavedPhotons;
use super::photon_pass::{PhotonPass, ShotPaths, aim, strategies, strategies_by};
use super::photon_stage::{Lit, lazy_cells, shoot};
use super::pixel_sampling::{CameraRay, FilmPlace, Workspace};
use super::progress::Stages;
use super::reconstruction::finish;
use super::rendered::Rendered;
use super::stage_settings::{
    finest_step, pass_settings, render_region, specialised, specialised_for_film,
};
use super::variance_pilot::budgets_by_variance;
use crate::cache::DirectedRays;
use crate::director::{PhotonDemand, PixelBudget};
use crate::error::{Error, Result};
use crate::film::{ComponentFilm, sample_passes};
use crate::math::{Spectrum, Stage};
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
    render_controlled(scene, settings, earlier, &control.into())
}

/// [`render_next`] without a generic argument: other crates that call it do not compile the renderer again.
fn render_controlled(
    scene: &Scene,
    settings: &RenderSettings,
    earlier: Earlier<'_>,
    control: &Control<'_>,
) -> Result<Rendered> {
    let mut stages = Stages::default();
    let needs = Needs::new(scene, settings);
    let pass = pass_settings(scene, settings);
    // Strategies.
    let start = Instant::now();
    let saved = earlier.photons;
    let mut aimed = match saved {
        Some(_) => None,
        None => specialised!(needs, aim(scene, &pass))?,
    };
    let own;
    let strategies = match saved.map(SavedPhotons::strategies).or(earlier.strategies) {
        Some(decided) => decided,
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
    let job = Directed { scene, settings, maps: &maps, strategies, demand, saved };
    let rendered = match settings.error {
        Some(goal) => {
            let job = ErrorJob { scene, settings, goal, strategies };
            specialised_for_film!(needs, render_to_error(&job, control, stages))?
        }
        None => specialised_for_film!(needs, render_directed(&job, aimed, control, stages))?,
    };
    Ok(Rendered { director, snapshot, ..rendered })
}

/// A picture to render after the director.
struct Directed<'a> {
    scene: &'a Scene,
    settings: &'a RenderSettings,
    maps: &'a DirectorMaps,
    strategies: &'a Assignment,
    demand: PhotonDemand,
    /// Photons that are read in place of shooting them.
    saved: Option<&'a SavedPhotons>,
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
    let (photons, shot) = match job.saved {
        Some(saved) => read_photons::<S, H>(job, saved, control)?,
        None => shoot_photons::<S, H>(job, aimed, control)?,
    };
    work += shot;
    stages.done("photons", start);

    let radius = PhotonPass::finest_radius(&photons);
    let gold = PixelBudget::fixed(settings.rays, radius, finest_step(scene, settings));
    let region = render_region(scene, settings, Stage::March);
    let mut exposed = expose_directed(job, &photons, &region, gold, control, &mut stages)?;
    work += finish::<S>(scene, settings, &region, &mut exposed, &mut stages);
    let rendered = exposed.rendered(work, stages, Some(radius));
    Ok(Rendered { strategy: Some(photons[0].choice.summary()), ..rendered })
}

/// Shoots the `aimed` photons, with what the director's maps ask for, and builds the photon maps: of all, of a pass of the
/// picture, or where that is reconstructed of two halves.
fn shoot_photons<S: Spectrum, H: PhotonDirection>(
    job: &Directed<'_>,
    aimed: Option<AimedPhotons<'_>>,
    control: &Control<'_>,
) -> Result<(Vec<PhotonPass<S, H>>, Work)> {
    let Directed { scene, settings, maps, strategies, demand, .. } = *job;
    let photons = maps.pass_settings(scene, settings);
    let (shot, count) = match settings.pass {
        _ if settings.in_halves() => (ShotPaths::Halves(demand.paths), demand.paths),
        None => (ShotPaths::Whole, demand.paths),
        Some(_) => (ShotPaths::Pass(settings.paths()), settings.path_count()),
    };
    shoot(scene, &photons, strategies, aimed, shot, count, control)
}

/// Reads photons that were `saved`, and builds the photon maps of them: a pass of the picture reads all, too.
fn read_photons<S: Spectrum, H: PhotonDirection>(
    job: &Directed<'_>,
    saved: &SavedPhotons,
    control: &Control<'_>,
) -> Result<(Vec<PhotonPass<S, H>>, Work)> {
    let Directed { scene, settings, maps, .. } = *job;
    if !scene.times.is_empty() {
        let problem = "is blurred by motion, and each of its times has photons of its own: leave out saved ones";
        return Err(Error::file(&scene.path, problem));
    }
    let mut photons = maps.pass_settings(scene, settings);
    photons.photons.any_camera = saved.any_camera();
    control.progress.stage("saved photons", 0);
    let read = PhotonPass::read(scene, &photons, saved);
    control.progress.finish();
    read
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
    let lit = Lit::new(scene, settings, photons);
    // Caches: rays fill the cells that they need; a checkpoint brings those that are known.
    let caches = lazy_cells(scene, photons, control)?;
    let camera = |place: FilmPlace| place.ray(scene);
    let undirected = |camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>| {
        lit.estimate(camera_ray, workspace)
    };

    // Budgets of pixels.
    let mut begun = Sampled::none(region);
    let gold = if settings.measures_error() { after_pilot(gold, &demand) } else { gold };
    let budgets = if settings.measures_error() {
        let pilot = |region: RenderRegion, budget: PixelBudget, control: &Control<'_>| {
            let none = Sampled::none(&region);
            sample(region, camera, |_, _| budget, undirected, none, &caches, control)
        };
        let importance =
            |components: &ComponentFilm| ErrorMaps::new(components, settings, &demand).importance();
        measure_importance(region, pilot, importance, gold, control, &mut begun, stages);
        budgets(&begun.film.importance, scene, settings, gold)
    } else if settings.director == Director::Variance {
        let start = Instant::now();
        let (scene, integrator) = lit.middle();
        let (budgets, measuring) = budgets_by_variance(scene, settings, integrator, gold);
        begun.work += measuring;
        stages.done("pilot", start);
        budgets
    } else {
        maps.budgets(scene, settings, gold)
    };

    // Rays.
    let start = Instant::now();
    let width = scene.film.size[0] as usize;
    let budget = |x: u32, y: u32| {
        let whole = budgets.get(y as usize * width + x as usize).copied().unwrap_or(gold);
        whole.of_pass(settings)
    };
    let directed = directed_rays(region, &budgets, gold.pilot);
    let estimate = |camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>| {
        let camera_ray = CameraRay { directed: directed.as_ref(), ..*camera_ray };
        lit.estimate(&camera_ray, workspace)
    };
    let sampled = sample(*region, camera, budget, estimate, begun, &caches, control);
    let exposed = resolve(region, budget, sampled);
    stages.done("march", start);
    Ok(exposed)
}

/// The rays that a director's `budgets` give the pixels of the film of `region`, of which the first `pilot` measured the error;
/// `None` where there are no budgets.
fn directed_rays(
    region: &RenderRegion,
    budgets: &[PixelBudget],
    pilot: u32,
) -> Option<DirectedRays> {
    if budgets.is_empty() {
        return None;
    }
    let passes = match region.pass {
        Some(pass) => iter::once(0..pass.rays).collect(),
        None => sample_passes(region.rays, pilot),
    };
    let width = region.size[0] as usize;
    let rays = |x: u32, y: u32| budgets[y as usize * width + x as usize].rays;
    let of_cache = |rays: u32| region.numbering([0, 0]).most_of_half(rays);
    let has_mirrors = region.needs.specular;
    Some(DirectedRays::new(region.size, rays, &passes, of_cache, has_mirrors))
}
