//! The stage of photons with its progress, at each of the times of a scene, and what rays do with them.

use std::sync::atomic::{AtomicU64, Ordering};

use super::control::{Control, Stop};
use super::features::FeatureTracer;
use super::integrator::Integrator;
use super::pass_settings::PassSettings;
use super::photon_pass::{PhotonPass, ShotPaths, ShotTime, aim};
use super::pixel_sampling::{CameraRay, Workspace};
use super::stage_settings::film_contents;
use crate::cache::LazyCells;
use crate::error::Result;
use crate::film::Sample;
use crate::math::Spectrum;
use crate::photon::{AimedPhotons, PhotonDirection, PhotonSettings};
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::strategy::Assignment;
use crate::work::Work;

/// Flips bits of the seed of photons and cells for each of the times of a scene but the first. Any odd number does; this one has no
/// pattern (the square root of 2 in hexadecimal).
const TIME_SEED: u64 = 0x6a09_e667_f3bc_c909;

/// Shoots the photons that `shot` says, `paths` in number, by the strategies of `assignment` and builds the photon maps of them:
/// those of the first of the scene's times first. They are those that were `aimed`, or where the scene has several times aimed
/// anew at each. See [`PhotonPass::shoot`].
///
/// # Errors
/// Where an emitter cannot be sampled.
pub(super) fn shoot<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &PassSettings,
    assignment: &Assignment,
    aimed: Option<AimedPhotons<'_>>,
    shot: ShotPaths,
    paths: u64,
    control: &Control<'_>,
) -> Result<(Vec<PhotonPass<S, H>>, Work)> {
    let progress = control.progress;
    progress.stage("photons", paths);
    let done = AtomicU64::new(0);
    let advance = |count: u64| {
        control.stop.into_iter().for_each(Stop::wait);
        progress.advance(count);
        // Building the maps has no units of its own, and can take longer than all paths.
        if done.fetch_add(count, Ordering::Relaxed) + count == paths {
            progress.stage("photon map", 0);
        }
    };
    let count = scene.times.len() as u64;
    let (mut passes, mut work) = (Vec::new(), Work::default());
    if count == 0 {
        let only = (&shot, ShotTime::ONLY);
        (passes, work) = PhotonPass::shoot(scene, settings, assignment, aimed, only, &advance);
    }
    for (index, scene) in (0..count).zip(&scene.times) {
        let seed = settings.photons.seed ^ TIME_SEED.wrapping_mul(index);
        let photons = PhotonSettings { seed, ..settings.photons };
        let gather_share = settings.gather_share / count as f64;
        let settings = PassSettings { photons, gather_share, ..*settings };
        let aimed = aim::<S, H>(scene, &settings)?;
        let of_time = (&shot, ShotTime { index, count });
        let (shot, done) =
            PhotonPass::shoot(scene, &settings, assignment, aimed, of_time, &advance);
        passes.extend(shot);
        work += done;
    }
    progress.finish();
    Ok((passes, work))
}

/// All cells that rays fill, those that passes of one time of the scene share once, with what a checkpoint knows of them.
///
/// # Errors
/// Where the checkpoint's are others.
pub(super) fn lazy_cells<'a, S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    passes: &'a [PhotonPass<S, H>],
    control: &Control<'_>,
) -> Result<Vec<&'a LazyCells<S>>> {
    let mut cells = Vec::new();
    for passes in of_times(scene, passes) {
        cells.extend(passes.first().into_iter().flat_map(|pass| pass.caches.lazy()));
        cells.extend(passes.iter().skip(1).flat_map(|pass| pass.caches.own_lazy()));
    }
    if let Some(checkpoints) = control.checkpoints {
        checkpoints.restore(&cells)?;
    }
    Ok(cells)
}

/// Those of `passes` that belong to each of the times of `scene`.
fn of_times<'a, S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    passes: &'a [PhotonPass<S, H>],
) -> impl Iterator<Item = &'a [PhotonPass<S, H>]> {
    passes.chunks((passes.len() / scene.moments().len()).max(1))
}

/// A scene lit by photons, at each of its times.
pub(super) struct Lit<'a, S: Spectrum, H: PhotonDirection> {
    moments: Vec<Moment<'a, S, H>>,
}

/// A scene lit by photons, at one of its times.
struct Moment<'a, S: Spectrum, H: PhotonDirection> {
    scene: &'a Scene,
    /// Of each half of the photons.
    integrators: Vec<Integrator<'a, S, H>>,
    tracer: FeatureTracer<'a>,
}

impl<'a, S: Spectrum, H: PhotonDirection> Lit<'a, S, H> {
    /// That of `scene` by these `passes`, those of its first time first.
    pub fn new(
        scene: &'a Scene,
        settings: &RenderSettings,
        passes: &'a [PhotonPass<S, H>],
    ) -> Self {
        let (needs, contents) = (Needs::new(scene, settings), film_contents(scene, settings));
        let moment = |(scene, passes): (&'a Scene, &'a [PhotonPass<S, H>])| Moment {
            scene,
            integrators: passes.iter().map(|pass| pass.integrator(scene, needs)).collect(),
            tracer: FeatureTracer::new(scene, contents),
        };
        Self { moments: scene.moments().iter().zip(of_times(scene, passes)).map(moment).collect() }
    }

    /// The scene in the middle of its times, and its integrator by the first photons.
    pub fn middle(&self) -> (&'a Scene, &Integrator<'a, S, H>) {
        let middle = &self.moments[self.moments.len() / 2];
        (middle.scene, &middle.integrators[0])
    }

    /// What a camera ray brings by the photons of its time and half, with the features that it meets.
    pub fn estimate(&self, camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>) -> Sample {
        let Moment { integrators, tracer, .. } = &self.moments[camera_ray.time];
        let half = camera_ray.half.unwrap_or(0) % integrators.len();
        let sample = integrators[half].radiance(camera_ray, workspace);
        tracer.complete(sample, camera_ray, workspace)
    }
}
