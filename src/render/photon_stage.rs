//! The stage of photons with its progress, and what rays do with them.

use std::sync::atomic::{AtomicU64, Ordering};

use super::control::{Control, Stop};
use super::features::FeatureTracer;
use super::integrator::Integrator;
use super::pass_settings::PassSettings;
use super::photon_pass::{PhotonPass, ShotPaths};
use super::pixel_sampling::{CameraRay, Workspace};
use crate::cache::LazyCells;
use crate::error::Result;
use crate::film::Sample;
use crate::math::Spectrum;
use crate::photon::{AimedPhotons, PhotonDirection};
use crate::scene::Scene;
use crate::strategy::Assignment;
use crate::work::Work;

/// Shoots those of the `aimed` photons that `shot` says, `paths` in number, by the strategies of `assignment` and builds
/// the photon maps of them. See [`PhotonPass::shoot`].
pub(super) fn shoot<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &PassSettings,
    assignment: &Assignment,
    aimed: Option<AimedPhotons<'_>>,
    shot: ShotPaths,
    paths: u64,
    control: &Control<'_>,
) -> (Vec<PhotonPass<S, H>>, Work) {
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
    let passes = PhotonPass::shoot(scene, settings, assignment, aimed, shot, &advance);
    progress.finish();
    passes
}

/// All cells that rays fill, those that passes share once, with what a checkpoint knows of them.
///
/// # Errors
/// Where the checkpoint's are others.
pub(super) fn lazy_cells<'a, S: Spectrum, H: PhotonDirection>(
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

/// What a camera ray brings by the photons of its half, with the features that it meets.
pub(super) fn estimate<S: Spectrum, H: PhotonDirection>(
    integrators: &[Integrator<'_, S, H>],
    tracer: &FeatureTracer<'_>,
    camera_ray: &CameraRay<'_>,
    workspace: &mut Workspace<S>,
) -> Sample {
    let half = camera_ray.half.unwrap_or(0) % integrators.len();
    let sample = integrators[half].radiance(camera_ray, workspace);
    tracer.complete(sample, camera_ray, workspace)
}
