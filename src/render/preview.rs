//! What can be shown of a scene before there are photons.

use std::time::Instant;

use super::exposure::{RenderRegion, expose};
use super::integrator::Integrator;
use super::photon_pass::PhotonPass;
use super::rendered::Ended;
use super::{Control, Rendered, Stages, finest_step, rendered, sheet};
use crate::director::PixelBudget;
use crate::math::{Rgb, Stage};
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::work::Work;

/// A first look at `scene`, for a render that ends before its photons are shot: one ray a pixel, or
/// where `control` ends it fewer and the nearest neighbours of those pixels. It shows what glows and
/// light that was scattered or reflected once, and calls itself [stopped](Ended::Stopped).
pub fn preview<'a>(
    scene: &Scene,
    settings: &RenderSettings,
    control: impl Into<Control<'a>>,
) -> Rendered {
    let (mut stages, start) = (Stages::default(), Instant::now());
    let photons = PhotonPass::<Rgb>::empty(settings.radius.unwrap_or(0.0));
    let step = settings.step.unwrap_or_else(|| finest_step(scene));
    let budget = PixelBudget::fixed(1, photons.maps.volume_radius, step);
    let integrator = Integrator::new(scene, &photons, Needs::of(scene, settings));
    let exposed = expose(
        RenderRegion { features: false, ..sheet(scene, settings, Stage::March) },
        |x, y, lens| scene.camera.ray(x, y, lens),
        |_, _| budget,
        |ray, workspace| integrator.radiance(ray, workspace),
        &[],
        &control.into(),
    );
    stages.done("preview", start);
    let preview = rendered(exposed, Work::default(), stages, None);
    Rendered { ended: Ended::Stopped, ..preview }
}
