//! Pass 2: rays are marched through the media, and the picture is put together.
//!
//! Only this room knows both the budget of a pixel and the estimators; below it plain numbers are
//! passed. The unbiased reference renders the same scene onto the same film.

mod expose;
mod lamps;
mod march;
mod progress;
mod reference;

pub use expose::Budget;
pub use progress::{Progress, Silent};

use std::time::{Duration, Instant};

use crate::error::Result;
use crate::image::Film;
use crate::math::Stage;
use crate::photon::{self, Shooting};
use crate::scene::{RenderSettings, Scene};
use crate::work::Work;

/// A finished picture and what it took.
#[derive(Debug)]
pub struct Rendered {
    /// The picture.
    pub film: Film,
    /// What was done.
    pub work: Work,
    /// Stages in the order in which they ran, each with the time it took.
    pub timings: Vec<(&'static str, Duration)>,
    /// Gather radius of the volume photons, in metres; nothing for the reference.
    pub radius: Option<f64>,
}

/// Renders `scene` with a photon map and a march: the same picture on any number of threads of
/// the rayon pool it is called in.
///
/// # Errors
/// Where a light cannot be sampled.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    progress: &dyn Progress,
) -> Result<Rendered> {
    let mut timings = Vec::new();
    let shooting = Shooting {
        photons: settings.photons,
        seed: settings.seed,
        max_scatter: settings.max_scatter,
        radius: settings.radius,
    };
    let start = Instant::now();
    progress.stage("photons", settings.photons);
    let (maps, mut work) = photon::shoot(scene, &shooting, &|n| progress.advance(n))?;
    progress.finish();
    timings.push(("photons", start.elapsed()));

    let start = Instant::now();
    let budget = Budget {
        rays: settings.rays,
        radius: maps.volume_radius,
        step: settings.step.unwrap_or_else(|| finest_step(scene)),
    };
    let marcher = march::Marcher::new(scene, &maps, settings.max_scatter);
    let (film, marching) = expose::expose(
        scene,
        settings.seed,
        Stage::March,
        |_, _| budget,
        |ray, budget, state| marcher.radiance(ray, budget, state),
        progress,
    );
    work += marching;
    timings.push(("march", start.elapsed()));
    Ok(Rendered { film, work, timings, radius: Some(maps.volume_radius) })
}

/// Renders `scene` without bias by null-collision path tracing with next-event estimation: the
/// same picture on any number of threads of the rayon pool it is called in.
pub fn render_reference(
    scene: &Scene,
    settings: &RenderSettings,
    progress: &dyn Progress,
) -> Rendered {
    let start = Instant::now();
    let tracer = reference::PathTracer::new(scene, settings.max_scatter);
    let budget = Budget { rays: settings.rays, radius: 0.0, step: 0.0 };
    let (film, work) = expose::expose(
        scene,
        settings.seed,
        Stage::Reference,
        |_, _| budget,
        |ray, _, state| tracer.radiance(ray, &mut state.draws),
        progress,
    );
    Rendered { film, work, timings: vec![("reference", start.elapsed())], radius: None }
}

/// The step where none is given, in metres: the shortest voxel edge of all media, at which cells
/// are integrated exactly; 0 where there is no grid.
fn finest_step(scene: &Scene) -> f64 {
    scene.media.detail().unwrap_or(0.0)
}
