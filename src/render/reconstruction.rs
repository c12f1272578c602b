//! Reconstruction of a finished picture, with visibility rays for pixels at edges.

use std::time::Instant;

use rayon::prelude::*;

use super::exposure::{Exposure, RenderRegion};
use super::features::visible_surface;
use super::pixel_sampling::{Workspace, sobol_point};
use super::progress::Stages;
use super::reconstructed_passes::{Edge, Edges, write_passes};
use super::rendered::Ended;
use super::stage_settings::finest_step;
use crate::film::{
    Antialiased, ComponentFilm, PictureLight, PixelComponents, Reconstruction, VisibilityRay,
};
use crate::image::Film;
use crate::math::{Ray, Spectrum, Stage, Stream, World, luminance};
use crate::scene::{RenderSettings, Scene};
use crate::transport::{PathContext, SobolPoint, camera_position, camera_view};
use crate::work::Work;

/// The centre of a pixel, from its corner.
///
/// Unit: pixels. Definition: of a pixel.
const CENTRE: f64 = 0.5;

/// Visibility rays of a pixel at an edge beside those along rays of the picture, and most along rays of each half.
///
/// Unit: count. Limit: on the noise of edges, whose pixels a Sobol sequence of so many covers to a hundredth.
const VISIBILITY_RAYS: u32 = 16;

/// Reconstructs the picture that is `exposed` in `region`, where `settings` say so and its components are known, and returns
/// the work of that. A render that was stopped is left as it is.
pub(super) fn finish<S: Spectrum>(
    scene: &Scene,
    settings: &RenderSettings,
    region: &RenderRegion,
    exposed: &mut Exposure,
    stages: &mut Stages,
) -> Work {
    let components = exposed.components.take();
    let wanted = settings.reconstructs() && exposed.ended != Ended::Stopped;
    let Some(components) = components.filter(|_| wanted) else { return Work::default() };
    let start = Instant::now();
    let step = finest_step(scene, settings);
    let work = reconstruct::<S>(scene, region, step, &mut exposed.film, &components);
    stages.done("reconstruct", start);
    work
}

/// Takes noise off `film` of `region`, of which `components` are known. Visibility rays march with `step`, in metres.
fn reconstruct<S: Spectrum>(
    scene: &Scene,
    region: &RenderRegion,
    step: f64,
    film: &mut Film,
    components: &ComponentFilm,
) -> Work {
    let raw = film.image();
    let reconstruction = Reconstruction::new(components);
    let emission = film.visible_emission().to_vec();
    let all = reconstruction.all_light(&raw, &emission);
    let parts = components.parts.iter().map(|part| reconstruction.light_of(part));
    let parts: Vec<PictureLight<'_>> = parts.collect();
    let visibility = Visibility::new(scene, region, step);
    let empty = || {
        let rng = Stream::new(region.seed, Stage::Visibility, 0, 0);
        Workspace::<S>::new(PathContext::new(rng, region.needs))
    };
    let edges = reconstruction.edges();
    let antialiased = edges.par_iter().map_init(empty, |workspace, &pixel| {
        workspace.ctx.work = Work::default();
        let rays = visibility.through(pixel, &components.pixels[pixel], workspace);
        let of = |light: &PictureLight<'_>| reconstruction.antialiased(light, pixel, &rays);
        let edge = of(&all).map(|all| Edge { all, parts: parts.iter().filter_map(of).collect() });
        (edge, workspace.ctx.work)
    });
    let (edges, work): (Vec<Option<Edge>>, Vec<Work>) = antialiased.unzip();
    let edges: Vec<Edge> = edges.into_iter().flatten().collect();
    let of_all: Vec<Antialiased> = edges.iter().map(|edge| edge.all).collect();
    let shares = reconstruction.residual_shares(&of_all);
    film.set_reconstructed(&reconstruction.image(&raw, &of_all, &shares));
    let edges = Edges { edges: &edges, shares: &shares };
    write_passes(&region.contents.aovs, &reconstruction, &edges, (&all, &parts), film);
    work.into_iter().sum()
}

/// What rays of pixels see.
struct Visibility<'a> {
    scene: &'a Scene,
    region: &'a RenderRegion,
    /// March step in metres.
    step: f64,
}

impl<'a> Visibility<'a> {
    /// Of rays through `region`, which march with `step`, in metres.
    fn new(scene: &'a Scene, region: &'a RenderRegion, step: f64) -> Self {
        Self { scene, region, step }
    }

    /// Rays through the pixel of this index in the window, which has `seen` these: the first ones of each half
    /// of the picture, and others.
    fn through<S: Spectrum>(
        &self,
        pixel: usize,
        seen: &PixelComponents,
        workspace: &mut Workspace<S>,
    ) -> Vec<VisibilityRay> {
        let RenderRegion { size, window, seed, .. } = *self.region;
        let [column, row] = [pixel as u32 % window.width, pixel as u32 / window.width];
        let (x, y) = (window.left + column, window.top + row);
        let index = u64::from(y) * u64::from(size[0]) + u64::from(x);
        let scramble = Stream::new(seed, Stage::Visibility, index, 0).scramble();
        let others = (0..VISIBILITY_RAYS).map(|index| (None, SobolPoint { index, scramble }));
        let of_half = |half: usize| {
            let rays = 0..(seen.halves[half].rays as u32).min(VISIBILITY_RAYS);
            rays.map(move |number| (Some(half), sobol_point(seed, index, Some(half), number)))
        };
        let ray = |(half, point): (Option<usize>, SobolPoint)| {
            let [u, v, a, b] = point.film_and_lens();
            let scene = &self.scene.moments()[point.time(self.region.times)];
            let ray = scene.camera.ray(f64::from(x) + u, f64::from(y) + v, [a, b]);
            let place = [u, v].map(|at| (at - CENTRE) as f32);
            VisibilityRay { half, place, ..self.along(scene, &ray, workspace) }
        };
        others.chain(of_half(0)).chain(of_half(1)).map(ray).collect()
    }

    /// What a ray sees of `scene`.
    fn along<S: Spectrum>(
        &self,
        scene: &Scene,
        ray: &Ray<World>,
        workspace: &mut Workspace<S>,
    ) -> VisibilityRay {
        let Workspace { ctx, profiles, .. } = workspace;
        ctx.work.visibility_rays += 1;
        let hit = camera_view::first_surface(scene, ray, ctx);
        let mut transmittance = S::ONE;
        if self.region.needs.media {
            let span = camera_view::span_before(scene, ray, hit.as_ref());
            profiles.path.trace(&scene.media, ray, span, self.step, 0.5);
            profiles.path.count(&mut ctx.work);
            transmittance = profiles.path.transmittance();
        }
        let emission = transmittance * camera_view::emission::<S>(scene, ray, hit.as_ref(), ctx);
        let parts = scene.groups.told_apart(emission, [S::ZERO, S::ZERO, S::ZERO, emission]);
        let transmittance = transmittance.rgb();
        let hit = hit.filter(|hit| !camera_view::is_holdout(scene, hit));
        let is_specular =
            hit.as_ref().is_some_and(|hit| hit.material.is_specular() || hit.material.is_rough());
        let diffuse = hit.filter(|_| !is_specular);
        VisibilityRay {
            half: None,
            place: [0.0; 2],
            surface: diffuse
                .map(|hit| visible_surface(camera_position(scene), ray, &hit, transmittance)),
            specular: is_specular,
            emission: emission.rgb().as_vec3().into(),
            emission_parts: parts.map(|parts| parts.emission),
            opacity: (1.0 - luminance(transmittance)) as f32,
        }
    }
}
