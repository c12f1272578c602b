//! What camera rays see, told without light, for a denoiser.
//!
//! Albedo and normals are those of Open Image Denoise's documentation ("Inputs" of its filter "RT"): of
//! the first surface that scatters diffusely, mirrors and glass followed to it, averaged over the rays
//! of a pixel. Media are let in by how much is seen of them: their albedo counts the share of the ray
//! that they scatter or absorb, that of the surface behind them the share that is left. They have no
//! normal of their own. Nothing is drawn at random on the way, so that there is no noise in them.

use smallvec::{SmallVec, smallvec};

use crate::image::Features;
use crate::math::{Ray, Rgb, Span, Spectrum, World, luminance};
use crate::medium::{Albedo, Media, Profile};
use crate::scene::Scene;
use crate::surface::SurfaceHit;
use crate::transport::direct_light;

use super::exposure::State;

/// Mirrors and panes of glass that a ray follows at most.
const MAX_SPECULAR: u32 = 8;

/// The first so many panes of glass are followed both where they reflect and where they refract, those
/// behind them where more of the light goes.
const SPLIT: u32 = 2;

/// What is seen through less than this is left out.
const LEAST: f64 = 1e-3;

/// Sees a scene as a denoiser is to be shown it.
#[derive(Debug)]
pub(super) struct FeatureTracer<'a> {
    scene: &'a Scene,
    asked: bool,
    /// The albedo of all media, where it is the same everywhere.
    albedo: Option<Rgb>,
}

/// A ray of sight that is still to be followed.
struct Snapshot {
    ray: Ray<World>,
    /// Share of what it sees that is seen from the camera.
    weight: Rgb,
    /// How many solids of glass it is inside of; media do not fill them.
    inside: i32,
    /// Mirrors and glass that it has met.
    bounces: u32,
}

impl<'a> FeatureTracer<'a> {
    /// Looks at `scene`, if that is `asked`.
    pub(super) fn new(scene: &'a Scene, asked: bool) -> Self {
        Self { scene, asked, albedo: common_albedo(&scene.media) }
    }

    /// What `ray` (unit direction) sees, where that is asked for; `step` is the march step through
    /// media in metres.
    pub(super) fn along<S: Spectrum>(
        &self,
        ray: Ray<World>,
        step: f64,
        state: &mut State<S>,
    ) -> Option<Features> {
        if !self.asked {
            return None;
        }
        let (mut albedo, mut normal) = (Rgb::ZERO, glam::DVec3::ZERO);
        let mut sights: SmallVec<[Snapshot; 4]> =
            smallvec![Snapshot { ray, weight: Rgb::ONE, inside: 0, bounces: 0 }];
        while let Some(mut sight) = sights.pop() {
            let hit = direct_light::first_surface(self.scene, &sight.ray, &mut state.ctx);
            if sight.inside == 0 && state.ctx.needs.media {
                let end = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
                let (media, transmittance) = self.through_media(&sight.ray, end, step, state);
                albedo += sight.weight * media;
                sight.weight *= transmittance;
            }
            let Some(hit) = hit.filter(|_| sight.weight.max_element() > LEAST) else { continue };
            if hit.material.is_specular() {
                sights.extend(branches(&sight, &hit));
            } else {
                let facing = hit.shading_normal.dot(sight.ray.direction) > 0.0;
                let towards = if facing { -hit.shading_normal } else { hit.shading_normal };
                albedo += sight.weight * hit.material.diffuse_albedo(&hit);
                normal += towards * luminance(sight.weight);
            }
        }
        Some(Features::new(albedo, normal))
    }

    /// The albedo of the media along `ray` as far as `end`, by how much is seen of them, and their
    /// transmittance.
    fn through_media<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        end: f64,
        step: f64,
        state: &mut State<S>,
    ) -> (Rgb, Rgb) {
        let mut profile = std::mem::take(&mut state.profile);
        profile.trace(&self.scene.media, ray, Span::new(0.0, end), step, 0.5);
        profile.count(&mut state.ctx.work);
        let transmittance = profile.transmittance().rgb();
        let albedo = match self.albedo {
            Some(albedo) => albedo * (Rgb::ONE - transmittance),
            None => albedo_along(&self.scene.media, ray, &profile),
        };
        state.profile = profile;
        (albedo, transmittance)
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
        if before.max_element() < LEAST {
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

/// Where `sight` goes on from the mirror or glass that it hits.
fn branches(sight: &Snapshot, hit: &SurfaceHit<'_>) -> SmallVec<[Snapshot; 2]> {
    if sight.bounces == MAX_SPECULAR {
        return SmallVec::new();
    }
    let mut branches = hit.material.branches(sight.ray.direction, hit);
    if sight.bounces >= SPLIT {
        // The larger share stands for all.
        branches.sort_by(|a, b| b.0.total_cmp(&a.0));
        branches.truncate(1);
        branches.iter_mut().for_each(|branch| branch.0 = 1.0);
    }
    let onward = branches.into_iter().map(|(share, scattered)| Snapshot {
        ray: hit.leave(scattered.direction),
        weight: sight.weight * scattered.weight * share,
        inside: (sight.inside + i32::from(scattered.crossing)).max(0),
        bounces: sight.bounces + 1,
    });
    onward.filter(|sight| sight.weight.max_element() > LEAST).collect()
}
