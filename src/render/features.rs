//! Features of the first diffuse surfaces and of media, for a denoiser and for passes: albedo and normal. And for passes, where
//! the opacity along a ray lies, and which objects it belongs to.
//!
//! Albedo and normals are those of Open Image Denoise's documentation ("Inputs" of its filter "RT"): of
//! the first surface that scatters diffusely, mirrors and glass followed to it, averaged over the rays
//! of a pixel. Media are let in by how much is seen of them: their albedo counts the share of the ray
//! that they scatter or absorb, that of the surface behind them the share that is left. They have no
//! normal of their own. Nothing is drawn at random on the way, so that there is no noise in them.

use smallvec::{SmallVec, smallvec};

use crate::film::{FilmContents, OpacityDepths, Sample, VisibleSurface};
use crate::image::Features;
use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint, luminance};
use crate::medium::{Albedo, Media, Profile};
use crate::scene::{Aov, Scene};
use crate::surface::SurfaceHit;
use crate::transport::specular::MAX_PROBE_BOUNCES;
use crate::transport::{EnclosingSolids, PathContext, camera_view};

use super::object_coverage::objects_along;
use super::opacity_depths::{motion, opacity_depths, visible_depth};
use super::pixel_sampling::{CameraRay, Workspace};

/// Bounces at glass that are traced both where it reflects and where it refracts; later ones are traced
/// where more of the light goes. Each doubles the rays.
const BRANCHING_BOUNCES: u32 = 2;

/// Weight below which what is seen is left out; it bounds the number of rays.
const MIN_WEIGHT: f64 = 1e-3;

/// Traces what rays see of a scene.
#[derive(Debug)]
pub(super) struct FeatureTracer<'a> {
    scene: &'a Scene,
    /// Whether features are gathered.
    features: bool,
    /// Whether it is gathered where opacity lies.
    depths: bool,
    /// Whether objects are gathered.
    objects: bool,
    /// Whether anything of that follows from a march through media: a medium alone has all of their opacity.
    marches: bool,
    /// The albedo of all media, where it is the same everywhere.
    albedo: Option<Rgb>,
}

/// A ray that is still to be traced.
struct FeatureRay {
    ray: Ray<World>,
    /// Where it ends at the latest, in metres: where the camera ceases to see, infinite for other rays.
    end: f64,
    /// Weight of what it sees.
    weight: Rgb,
    /// Solids of glass around its origin.
    solids: EnclosingSolids,
    /// Mirrors and glass before it.
    bounces: u32,
}

impl<'a> FeatureTracer<'a> {
    /// A tracer for `scene`, of what `contents` need.
    pub(super) fn new(scene: &'a Scene, contents: FilmContents) -> Self {
        let FilmContents { features, aovs, .. } = contents;
        let (depths, objects) = (aovs.passes.has_depths(), aovs.passes.has(Aov::Cryptomatte));
        let marches = features || depths || scene.media.len() > 1;
        Self { scene, features, depths, objects, marches, albedo: common_albedo(&scene.media) }
    }

    /// `sample` with what `camera_ray` sees, as far as that is gathered.
    pub(super) fn complete<S: Spectrum>(
        &self,
        sample: Sample,
        camera_ray: &CameraRay<'_>,
        workspace: &mut Workspace<S>,
    ) -> Sample {
        if !self.features && !self.depths && !self.objects {
            return sample;
        }
        let CameraRay { ray, budget, .. } = camera_ray;
        let (features, depths) = self.along(*ray, budget.step, &sample, workspace);
        Sample { features: self.features.then_some(features), depths, ..sample }
    }

    /// As [`complete`](Self::complete), for a `sample` that does not know yet where media hide what is behind them.
    pub(super) fn complete_reference<S: Spectrum>(
        &self,
        mut sample: Sample,
        camera_ray: &CameraRay<'_>,
        workspace: &mut Workspace<S>,
    ) -> Sample {
        let Workspace { ctx, profiles, .. } = workspace;
        if ctx.needs.media {
            let CameraRay { ray, budget, .. } = camera_ray;
            let [near, end] = [self.scene.camera.near(ray), self.scene.camera.end(ray)];
            let first = sample.depth - near;
            let span = Span::new(0.0, first.min(end));
            profiles.path.trace(&self.scene.media, ray, span, budget.step, 0.5);
            profiles.path.count(&mut ctx.work);
            sample.depth = near + visible_depth(Some(&profiles.path), Some(first));
        }
        self.complete(sample, camera_ray, workspace)
    }

    /// The features along `ray`, one of the camera's, and where its opacity lies; `step` is the march step through media in
    /// metres, `sample` what else is known of it. The workspace gets the objects that it sees.
    fn along<S: Spectrum>(
        &self,
        ray: Ray<World>,
        step: f64,
        sample: &Sample,
        workspace: &mut Workspace<S>,
    ) -> (Features, Option<OpacityDepths>) {
        let (mut albedo, mut normal) = (Rgb::ZERO, glam::DVec3::ZERO);
        let Workspace { ctx, profiles, objects, .. } = workspace;
        let (end, solids) = (self.scene.camera.end(&ray), EnclosingSolids::NONE);
        let mut pending: SmallVec<[FeatureRay; 4]> =
            smallvec![FeatureRay { ray, end, weight: Rgb::ONE, solids, bounces: 0 }];
        let mut depths = None;
        while let Some(mut next) = pending.pop() {
            let from_camera = next.bounces == 0;
            let hit = camera_view::surface_along(self.scene, &next.ray, from_camera, ctx);
            let marches = self.marches && next.solids.is_none() && ctx.needs.media;
            if marches {
                let span = Span::new(0.0, hit.as_ref().map_or(next.end, |hit| hit.t));
                let profile = &mut profiles.path;
                let (media, transmittance) =
                    self.through_media(&next.ray, span, step, ctx, profile);
                albedo += next.weight * media;
                next.weight *= transmittance;
            }
            let profile = marches.then_some(&profiles.path);
            if self.objects && from_camera {
                objects_along(self.scene, &next.ray, profile, hit.as_ref(), sample, objects);
            }
            if self.depths && from_camera {
                let covering = hit.as_ref().filter(|hit| camera_view::covers(self.scene, hit));
                let from_origin = opacity_depths(&next.ray, profile, covering.map(|hit| hit.t));
                depths = from_origin.map(|depths| {
                    let clear = 1.0 - profile.map_or(0.0, Profile::middle_opacity);
                    let motion = motion(self.scene, &depths, covering.map(|hit| (hit, clear)));
                    let depths = OpacityDepths { motion, ..depths };
                    depths.behind(self.scene.camera.near(&next.ray))
                });
            }
            if !self.features {
                break;
            }
            let Some(hit) = hit.filter(|_| next.weight.max_element() > MIN_WEIGHT) else {
                continue;
            };
            if from_camera && camera_view::is_holdout(self.scene, &hit) {
                continue;
            }
            if hit.material.is_specular() {
                pending.extend(branches(&next, &hit));
            } else {
                let seen = visible_surface(next.ray.origin, &next.ray, &hit, next.weight);
                albedo += seen.reflectance;
                normal += seen.normal * luminance(next.weight);
            }
        }
        (Features::new(albedo, normal), depths)
    }

    /// The albedo of the media along `span` of `ray`, weighed by how much of them is seen, and their
    /// transmittance.
    fn through_media<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        span: Span,
        step: f64,
        ctx: &mut PathContext,
        profile: &mut Profile<S>,
    ) -> (Rgb, Rgb) {
        profile.trace(&self.scene.media, ray, span, step, 0.5);
        profile.count(&mut ctx.work);
        let transmittance = profile.transmittance().rgb();
        let albedo = match self.albedo {
            Some(albedo) => albedo * (Rgb::ONE - transmittance),
            None => albedo_along(&self.scene.media, ray, profile),
        };
        (albedo, transmittance)
    }
}

/// The diffuse surface at `hit` of a `ray` of this weight; the camera is at `eye`.
pub(super) fn visible_surface(
    eye: WorldPoint,
    ray: &Ray<World>,
    hit: &SurfaceHit<'_>,
    weight: Rgb,
) -> VisibleSurface {
    let is_back = hit.shading_normal.dot(ray.direction) > 0.0;
    VisibleSurface {
        offset: hit.point - eye,
        normal: if is_back { -hit.shading_normal } else { hit.shading_normal },
        reflectance: hit.material.color(hit) * weight,
    }
}

/// The albedo of all media where it is the same everywhere.
fn common_albedo(media: &Media) -> Option<Rgb> {
    let mut albedos = media.iter().map(|medium| match medium.albedo {
        Albedo::Constant(albedo) => Some(albedo),
        Albedo::Color { .. } | Albedo::Scalar { .. } | Albedo::Ramped(_) => None,
    });
    let first = albedos.next()??;
    albedos.all(|albedo| albedo == Some(first)).then_some(first)
}

/// The albedo of the pieces of `profile`, each looked up in its middle, by how much is seen of them.
fn albedo_along<S: Spectrum>(media: &Media, ray: &Ray<World>, profile: &Profile<S>) -> Rgb {
    let mut sum = Rgb::ZERO;
    for piece in profile.pieces() {
        let before = (-piece.before).exp().rgb();
        if before.max_element() < MIN_WEIGHT {
            break;
        }
        let length = piece.span.length();
        let opacity = (piece.sigma_t * length).map(|tau| -(-tau).exp_m1()).rgb();
        if opacity == Rgb::ZERO {
            continue;
        }
        let middle = ray.at(piece.span.start + 0.5 * length);
        let sigma_t = media.sigma_t_at(middle);
        let sigma_s: Rgb = media.mixture_at(middle).iter().map(|(_, sigma_s)| *sigma_s).sum();
        let albedo = Rgb::select(sigma_t.cmpgt(Rgb::ZERO), sigma_s / sigma_t, Rgb::ZERO);
        sum += before * opacity * albedo;
    }
    sum
}

/// The rays that a mirror or glass at `hit` makes of `incoming`.
fn branches(incoming: &FeatureRay, hit: &SurfaceHit<'_>) -> SmallVec<[FeatureRay; 2]> {
    if incoming.bounces == MAX_PROBE_BOUNCES {
        return SmallVec::new();
    }
    let mut branches = hit.material.branches(incoming.ray.direction, hit);
    if incoming.bounces >= BRANCHING_BOUNCES {
        // The branch with most of the light stands for both.
        branches.sort_by(|a, b| b.0.total_cmp(&a.0));
        branches.truncate(1);
        branches.iter_mut().for_each(|branch| branch.0 = 1.0);
    }
    let outgoing = branches.into_iter().map(|(probability, scattered)| FeatureRay {
        ray: hit.leave(scattered.direction),
        end: f64::INFINITY,
        weight: incoming.weight * scattered.weight * probability,
        solids: incoming.solids.after(scattered.crossing),
        bounces: incoming.bounces + 1,
    });
    outgoing.filter(|ray| ray.weight.max_element() > MIN_WEIGHT).collect()
}
