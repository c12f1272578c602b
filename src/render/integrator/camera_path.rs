//! The camera path: media, mirrors and glass, and the first diffuse surface.

use crate::film::Sample;
use crate::math::{Spectrum, luminance};
use crate::photon::PhotonDirection;
use crate::render::pixel_sampling::{CameraRay, Profiles, Workspace};
use crate::surface::SurfaceHit;
use crate::transport::specular::MAX_CAMERA_BOUNCES;
use crate::transport::{EnclosingSolids, MAX_EVENTS, PathContext, direct_light, survives_roulette};

use super::pending::{MAX_SPLITS, PendingRay, PendingRays, follow_specular};
use super::setup::{Estimate, Integrator};

/// What one path from the camera, or from where a peak deflected it, brings.
struct PathResult<S> {
    /// Its light, W/(m² sr).
    light: Estimate<S>,
    /// The part of it that surfaces and the environment emit, seen without a mirror between: it hardly
    /// differs from ray to ray.
    visible_emission: S,
    /// Distance to the first surface, in metres; infinite where there is none.
    depth: f64,
    /// Transmittance of the media before that.
    transmittance: f64,
}

impl<S: Spectrum> PathResult<S> {
    /// Nothing found yet.
    const NOTHING: Self = Self {
        light: Estimate::ZERO,
        visible_emission: S::ZERO,
        depth: f64::INFINITY,
        transmittance: 1.0,
    };

    /// Adds light of throughput `weight`.
    fn add(&mut self, weight: S, light: Estimate<S>) {
        self.light.radiance += weight * light.radiance;
        self.light.indirect += weight * light.indirect;
    }

    /// Adds what a surface or the environment emits, `directly` or seen in a mirror.
    fn add_emission(&mut self, emitted: S, directly: bool) {
        self.light.radiance += emitted;
        if directly {
            self.visible_emission += emitted;
        }
    }
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Estimates the radiance that arrives along a camera ray at its origin: the path to the first
    /// diffuse surface, and the rays that forward peaks deflect on its way.
    pub fn radiance(&self, camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>) -> Sample {
        let Workspace { ctx, profiles } = workspace;
        let mut pending = PendingRays::new();
        let start = PendingRay {
            ray: camera_ray.ray,
            throughput: S::ONE,
            punctual_weight: 1.0,
            from_camera: true,
            sees_emitters: true,
            solids: EnclosingSolids::NONE,
            splits: MAX_SPLITS,
        };
        let path = self.trace_camera_path(start, camera_ray, &mut pending, ctx, profiles);
        let others = self.trace_pending(pending, camera_ray, ctx, profiles);
        Sample {
            radiance: (path.light.radiance + others.radiance).rgb(),
            indirect: (path.light.indirect + others.indirect).rgb(),
            visible_emission: path.visible_emission.rgb(),
            alpha: if path.depth.is_finite() { 1.0 } else { 1.0 - path.transmittance },
            depth: path.depth,
            transmittance: path.transmittance,
            features: None,
        }
    }

    /// Traces `segment` through media, mirrors and glass to the first diffuse surface. Rays that
    /// forward peaks deflect or glass splits off are put on `pending`.
    fn trace_camera_path(
        &self,
        mut segment: PendingRay<S>,
        camera_ray: &CameraRay<'_>,
        pending: &mut PendingRays<S>,
        ctx: &mut PathContext,
        profiles: &mut Profiles<S>,
    ) -> PathResult<S> {
        let mut path = PathResult::NOTHING;
        for bounce in 0..MAX_CAMERA_BOUNCES {
            let hit = direct_light::first_surface(self.scene, &segment.ray, ctx);
            let mut transmittance = S::ONE;
            if segment.solids.is_none() && self.needs.media {
                let media = self.through_media(&segment, hit.as_ref(), camera_ray, ctx, profiles);
                path.add(segment.throughput, media.light);
                let deflected = media.deflected.and_then(|mut ray| {
                    ray.throughput *= segment.throughput;
                    survives_roulette(&mut ray.throughput, &mut ctx.rng).then_some(ray)
                });
                pending.extend(deflected);
                transmittance = media.transmittance;
            }
            if bounce == 0 {
                path.transmittance = luminance(transmittance.rgb());
                path.depth = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
            }
            segment.throughput *= transmittance;
            if segment.sees_emitters {
                let emitted = self.seen_emission(&segment, hit.as_ref(), ctx);
                path.add_emission(segment.throughput * emitted, segment.from_camera);
            }
            let Some(hit) = hit else { break };
            if !hit.material.is_specular() {
                let weight = camera_ray.indirect_weight;
                path.add(segment.throughput, self.reflected(&segment.ray, &hit, weight, ctx));
                break;
            }
            let Some(next) = follow_specular(&segment, &hit, pending, ctx) else { break };
            segment = next;
        }
        path
    }

    /// What the surface at `hit` emits back along the ray, or the environment where there is none,
    /// W/(m² sr).
    fn seen_emission(
        &self,
        segment: &PendingRay<S>,
        hit: Option<&SurfaceHit<'_>>,
        ctx: &mut PathContext,
    ) -> S {
        S::from_rgb(match hit {
            Some(hit) => direct_light::emitted(self.scene, &segment.ray, hit),
            None => direct_light::environment(self.scene, &segment.ray, ctx),
        })
    }

    /// Traces `pending` rays and all that are deflected or split off from them.
    fn trace_pending(
        &self,
        mut pending: PendingRays<S>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
        profiles: &mut Profiles<S>,
    ) -> Estimate<S> {
        let (mut light, mut traced) = (Estimate::ZERO, 0);
        while let Some(next) = pending.pop() {
            if traced == MAX_EVENTS {
                ctx.work.capped_rays += 1;
                break;
            }
            traced += 1;
            let path = self.trace_camera_path(next, camera_ray, &mut pending, ctx, profiles);
            light.radiance += path.light.radiance;
            light.indirect += path.light.indirect;
        }
        light
    }
}
