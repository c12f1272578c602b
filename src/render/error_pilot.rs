//! The pilot of directors that measure error: the first rays of each pixel, which the picture keeps.

use std::time::Instant;

use super::checkpoint::Checkpoints;
use super::control::Control;
use super::exposure::{RenderRegion, Sampled, sample};
use super::photon_pass::{PhotonPass, ShotPaths, ShotTime, aim};
use super::progress::Stages;
use super::rendered::Ended;
use super::stage_settings::{finest_step, pass_settings, render_region};
use crate::director::{
    MeasuredError, PhotonDemand, PixelBudget, Saliency, error_x_map, visible_differences, xs_map,
};
use crate::error::Result;
use crate::film::{ComponentFilm, FilmContents, Importance, PixelComponents, Reconstruction};
use crate::image::{Image, Window};
use crate::math::{Spectrum, Stage};
use crate::photon::PhotonDirection;
use crate::scene::{Directing, RenderSettings, Scene};
use crate::strategy::Assignment;
use crate::work::Work;

/// Maps of a director that measures error, of the size of the film, row by row from the top.
#[derive(Debug)]
pub(super) struct ErrorMaps {
    /// The pilot's picture, reconstructed.
    pub pilot: Image,
    /// Rays that the error asks for over those of the gold standard, 0 to 1.
    pub x: Vec<f32>,
    /// Saliency of the pilot's picture, where it has a weight.
    pub saliency: Option<Saliency>,
    /// Importance of each pixel.
    pub xs: Vec<f32>,
}

impl ErrorMaps {
    /// Those of a picture of which the pilot has these `components`, with as much noise of rays as the `demand` for photons leaves
    /// to them.
    pub(super) fn new(
        components: &ComponentFilm,
        settings: &RenderSettings,
        demand: &PhotonDemand,
    ) -> Self {
        let reconstruction = Reconstruction::new(components);
        let [width, height] = components.size();
        let radiance = |pixel: &PixelComponents| {
            let [a, b] = &pixel.halves;
            ((a.radiance + b.radiance) / pixel.rays().max(1.0)).to_array()
        };
        let rendered = components.pixels.iter().map(radiance).collect();
        let pilot = reconstruction.image(&Image::new(width, height, rendered), &[], &[]);
        let noise = reconstruction.noise();
        let visible = visible_differences(&pilot, &noise.reconstructed);
        let rays = demand.pilot;
        let error = MeasuredError {
            width,
            reconstructed: &noise.reconstructed,
            rendered: &noise.rendered,
            squared_bias: &noise.squared_bias,
            shared: noise.shared.each_ref().map(Vec::as_slice),
            photon_part: demand.photon_part(f64::from(rays) / f64::from(settings.rays)),
            visible: &visible,
            rays,
            ray_power: demand.ray_power,
        };
        let x = error_x_map(&error, settings.rays, demand.ray_share);
        let Directing { weights, operator, .. } = settings.effective_directing();
        let saliency = (weights[1] > 0.0).then(|| Saliency::from_image(&pilot));
        let s = saliency.as_ref().map_or(&[][..], |saliency| &saliency.map);
        let xs = xs_map(&x, s, weights, operator);
        Self { pilot, x, saliency, xs }
    }

    /// Importance of each pixel.
    pub(super) fn importance(&self) -> Vec<Importance> {
        let saliency = |pixel| self.saliency.as_ref().map_or(1.0, |s: &Saliency| s.map[pixel]);
        let pixels = self.xs.iter().enumerate();
        pixels.map(|(pixel, &xs)| Importance { xs, saliency: saliency(pixel) }).collect()
    }
}

/// The photons of a picture under `settings` and the rays of the pilot that measures its error, by what the pilot of strategies
/// measured of the `assignment`. As many photons as `settings` name where nothing was measured, or where error is not
/// what directs.
pub(super) fn photon_demand(settings: &RenderSettings, assignment: &Assignment) -> PhotonDemand {
    let Assignment { strategies, measured, .. } = assignment;
    let chosen = measured.iter().find(|measured| measured.strategies == *strategies);
    let RenderSettings { photons, rays, .. } = *settings;
    let chosen = chosen.filter(|_| settings.measures_error());
    chosen.map_or_else(
        || PhotonDemand::all(photons, rays),
        |measured| PhotonDemand::new(measured, photons, rays),
    )
}

/// Photons that a picture is rendered with by the strategies of `assignment`, over those that its `settings` name.
pub(super) fn demanded_share(settings: &RenderSettings, assignment: &Assignment) -> f64 {
    photon_demand(settings, assignment).paths as f64 / settings.photons.max(1) as f64
}

/// The maps of `scene`, of a pilot that is rendered for them alone, by the strategies of `assignment`. Returns its work as
/// well.
///
/// # Errors
/// Where an emitter cannot be sampled.
pub(super) fn error_maps<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    assignment: &Assignment,
) -> Result<(ErrorMaps, Work)> {
    let pass = pass_settings(scene, settings);
    let aimed = aim::<S, H>(scene, &pass)?;
    let demand = photon_demand(settings, assignment);
    let shot = (&ShotPaths::Halves(demand.paths), ShotTime::ONLY);
    let (photons, mut work) =
        PhotonPass::<S, H>::shoot(scene, &pass, assignment, aimed, shot, &|_| ());
    let integrators: Vec<_> =
        photons.iter().map(|half| half.integrator(scene, pass.photons.needs)).collect();
    let radius = PhotonPass::finest_radius(&photons);
    let gold = PixelBudget::fixed(settings.rays, radius, finest_step(scene, settings));
    let budget = after_pilot(gold, &demand).of_pilot();
    let region = RenderRegion {
        window: Window::whole(scene.film.size),
        times: 1,
        contents: FilmContents { components: true, ..FilmContents::default() },
        ..render_region(scene, settings, Stage::March)
    };
    let sampled = sample(
        region,
        |place| place.ray(scene),
        |_, _| budget,
        |camera_ray, workspace| {
            let half = camera_ray.half.unwrap_or(0) % integrators.len();
            integrators[half].radiance(camera_ray, workspace)
        },
        Sampled::none(&region),
        &[],
        &Control::silent(),
    );
    work += sampled.work;
    Ok((ErrorMaps::new(&sampled.film.component_film(), settings, &demand), work))
}

/// Importance of each pixel of the film of `region`, measured in the pilot, of which `sample` takes the samples and
/// `importance` tells it. The pilot is that of the whole film, so that all crops have the same importance; `begun` gets its
/// samples in `region`. `gold` is the gold standard's budget, [with a pilot](after_pilot). Nothing is measured where a checkpoint knows it, nor where the pilot is cut short.
pub(super) fn measure_importance(
    region: &RenderRegion,
    sample: impl Fn(RenderRegion, PixelBudget, &Control<'_>) -> Sampled,
    importance: impl Fn(&ComponentFilm) -> Vec<Importance>,
    gold: PixelBudget,
    control: &Control<'_>,
    begun: &mut Sampled,
    stages: &mut Stages,
) {
    begun.film.importance = control.checkpoints.map_or_else(Vec::new, Checkpoints::importance);
    if !begun.film.importance.is_empty() {
        return;
    }
    let start = Instant::now();
    let window = Window::whole(region.size);
    let is_whole = window == region.window;
    let control = if is_whole { *control } else { Control { checkpoints: None, ..*control } };
    let sampled = sample(RenderRegion { window, ..*region }, gold.of_pilot(), &control);
    stages.done("pilot", start);
    let start = Instant::now();
    let components = sampled.film.component_film();
    let is_complete = sampled.ended == Ended::Complete;
    *begun = Sampled { film: sampled.film.cut(region.window, region.contents), ..sampled };
    if is_complete {
        begun.film.importance = importance(&components);
        begun.work.map_pixels += begun.film.importance.len() as u64;
    }
    stages.done("director", start);
}

/// The budget of each pixel of this `importance`, where `gold` is the gold standard's, [with a pilot](after_pilot).
pub(super) fn budgets(
    importance: &[Importance],
    scene: &Scene,
    settings: &RenderSettings,
    gold: PixelBudget,
) -> Vec<PixelBudget> {
    let (directing, voxel) = (settings.effective_directing(), scene.media.detail());
    let budget = |Importance { xs, saliency }: &Importance| PixelBudget {
        saliency: f64::from(*saliency),
        ..gold.for_importance(*xs, &directing, voxel)
    };
    importance.iter().map(budget).collect()
}

/// The budget of gold in a picture of which the first rays of each pixel are a pilot's.
pub(super) const fn after_pilot(gold: PixelBudget, demand: &PhotonDemand) -> PixelBudget {
    PixelBudget { pilot: demand.pilot, ..gold }
}
