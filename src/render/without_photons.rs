//! Renders without photons: the unbiased reference, and previews.

use std::time::Instant;

use super::control::Control;
use super::exposure::{RenderRegion, expose};
use super::features::FeatureTracer;
use super::integrator::PathTracer;
use super::photon_pass::PhotonPass;
use super::pixel_sampling::Workspace;
use super::progress::Stages;
use super::rendered::{Ended, Rendered};
use super::stage_settings::{film_contents, finest_step, render_region};
use crate::director::PixelBudget;
use crate::film::FilmContents;
use crate::math::{GroupedRgb, Rgb, Spectrum, Stage};
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::work::Work;

/// Renders the unbiased reference of `scene`: null-collision path tracing with next-event estimation.
/// The picture is the same on any number of threads of the rayon pool it is called in; `control` is
/// as in [`render()`](super::render()).
pub fn render_reference<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Rendered {
    reference_controlled(scene, settings, &control.into())
}

/// [`render_reference`] without a generic argument: other crates that call it do not compile the path tracer again.
fn reference_controlled(
    scene: &Scene,
    settings: &RenderSettings,
    control: &Control<'_>,
) -> Rendered {
    let Needs { parts, colors, .. } = Needs::new(scene, settings);
    match (parts, colors) {
        (true, _) => trace_reference::<GroupedRgb>(scene, settings, control),
        (false, true) => trace_reference::<Rgb>(scene, settings, control),
        (false, false) => trace_reference::<f64>(scene, settings, control),
    }
}

fn trace_reference<S: Spectrum>(
    scene: &Scene,
    settings: &RenderSettings,
    control: &Control<'_>,
) -> Rendered {
    let mut stages = Stages::default();
    let start = Instant::now();
    let contents = film_contents(scene, settings).undivided();
    let of_time =
        |scene| (PathTracer::new(scene, settings.max_scatter), FeatureTracer::new(scene, contents));
    let times: Vec<_> = scene.moments().iter().map(of_time).collect();
    let budget = PixelBudget::fixed(settings.rays, 0.0, 0.0).of_pass(settings);
    let region = render_region(scene, settings, Stage::Reference);
    let exposed = expose(
        RenderRegion { window: region.shown, contents, ..region },
        |place| place.ray(scene),
        |_, _| budget,
        |camera_ray, workspace: &mut Workspace<S>| {
            let (paths, tracer) = &times[camera_ray.time];
            let sample = paths.radiance(camera_ray.ray, workspace);
            tracer.complete_reference(sample, camera_ray, workspace)
        },
        &[],
        control,
    );
    stages.done("reference", start);
    exposed.rendered(Work::default(), stages, None)
}

/// Renders `scene` without photons, for a render that is stopped before they are shot: one ray a pixel,
/// or where `control` ends it fewer and the nearest neighbours of those pixels. It shows emission and
/// light that was scattered or reflected once, and is marked as [stopped](Ended::Stopped).
pub fn preview<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Rendered {
    preview_controlled(scene, settings, &control.into())
}

/// [`preview`] without a generic argument: other crates that call it do not compile the integrator again.
fn preview_controlled(scene: &Scene, settings: &RenderSettings, control: &Control<'_>) -> Rendered {
    let (mut stages, start) = (Stages::default(), Instant::now());
    let photons = PhotonPass::<Rgb>::empty(settings.radius.unwrap_or(0.0));
    let budget = PixelBudget::fixed(1, photons.radius, finest_step(scene, settings));
    let integrator = photons.integrator(scene, Needs::new(scene, settings));
    let region = render_region(scene, settings, Stage::March);
    let contents = FilmContents::default();
    let exposed = expose(
        RenderRegion { window: region.shown, times: 1, contents, ..region },
        |place| place.ray(scene),
        |_, _| budget,
        |camera_ray, workspace| integrator.radiance(camera_ray, workspace),
        &[],
        control,
    );
    stages.done("preview", start);
    let preview = exposed.rendered(Work::default(), stages, None);
    Rendered { ended: Ended::Stopped, ..preview }
}
