//! The camera path: media, mirrors and glass, and the first diffuse surface.

use crate::film::{CaughtShadow, Components, Sample, Seen, VisibleSurface};
use crate::math::{Spectrum, luminance};
use crate::photon::PhotonDirection;
use crate::render::features::visible_surface;
use crate::render::opacity_depths::visible_depth;
use crate::render::pixel_sampling::{CameraRay, Profiles, Workspace};
use crate::surface::SurfaceHit;
use crate::transport::specular::MAX_CAMERA_BOUNCES;
use crate::transport::{
    EnclosingSolids, MAX_EVENTS, PathContext, camera_view, direct_light, surface_light,
    survives_roulette,
};

use super::pending::{MAX_SPLITS, PendingRay, PendingRays, follow_rough, follow_specular};
use super::setup::{Estimate, Integrator};

/// What one path from the camera, or from where a peak deflected it, brings.
struct PathResult<S> {
    /// Its light, W/(m² sr).
    light: Estimate<S>,
    /// The part of it that surfaces and the environment emit, seen without a mirror between: it hardly
    /// differs from ray to ray.
    visible_emission: S,
    /// Distance to the first surface, or to where media before it hide what is behind them, in metres; infinite where
    /// neither is.
    depth: f64,
    /// Transmittance of the media before that.
    transmittance: f64,
    /// Whether that surface covers what lies behind it.
    is_covered: bool,
    /// What is seen of a shadow catcher.
    caught: CaughtShadow,
    /// The light by component.
    components: ComponentLight<S>,
    /// What a ray from the camera sees first.
    seen: Seen,
}

/// Light by [component](Components), W/(m² sr).
#[derive(Debug, Clone, Copy)]
struct ComponentLight<S> {
    media: S,
    direct: S,
    indirect: S,
}

impl<S: Spectrum> PathResult<S> {
    /// Nothing found yet.
    const NOTHING: Self = Self {
        light: Estimate::ZERO,
        visible_emission: S::ZERO,
        depth: f64::INFINITY,
        transmittance: 1.0,
        is_covered: false,
        caught: CaughtShadow { seen: 0.0, shadowed: 0.0, unshadowed: 0.0 },
        components: ComponentLight { media: S::ZERO, direct: S::ZERO, indirect: S::ZERO },
        seen: Seen { surface: None, specular: false, media_distance: None },
    };

    /// Adds light of `segment`'s throughput.
    fn add(&mut self, segment: &PendingRay<S>, light: Estimate<S>) {
        self.light.radiance += segment.throughput * light.radiance;
        self.light.indirect += segment.throughput * light.indirect;
    }

    /// Adds light of media along `segment`.
    fn add_media(&mut self, segment: &PendingRay<S>, light: Estimate<S>) {
        self.add(segment, light);
        if segment.from_camera || segment.deflected {
            self.components.media += segment.throughput * light.radiance;
        }
    }

    /// Adds light that the surface behind `segment` reflects.
    fn add_reflected(&mut self, segment: &PendingRay<S>, light: Estimate<S>) {
        self.add(segment, light);
        if segment.from_camera {
            self.components.direct += segment.throughput * (light.radiance - light.indirect);
            self.components.indirect += segment.throughput * light.indirect;
        } else if segment.deflected {
            self.components.media += segment.throughput * light.radiance;
        }
    }

    /// Adds what a surface or the environment emits behind `segment`.
    fn add_emission(&mut self, segment: &PendingRay<S>, emitted: S) {
        let emitted = segment.throughput * emitted;
        self.light.radiance += emitted;
        if segment.from_camera {
            self.visible_emission += emitted;
        } else if segment.deflected {
            self.components.media += emitted;
        }
    }
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Estimates the radiance that arrives along a camera ray at its origin: the path to the first
    /// diffuse surface, and the rays that forward peaks deflect on its way.
    pub fn radiance(&self, camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>) -> Sample {
        let Workspace { ctx, profiles, parts, .. } = workspace;
        let mut pending = PendingRays::new();
        let start = PendingRay {
            ray: camera_ray.ray,
            end: self.scene.camera.end(&camera_ray.ray),
            throughput: S::ONE,
            punctual_weight: 1.0,
            from_camera: true,
            deflected: false,
            sees_emitters: true,
            rough: None,
            solids: EnclosingSolids::NONE,
            splits: MAX_SPLITS,
        };
        let mut path = self.trace_camera_path(start, camera_ray, &mut pending, ctx, profiles);
        let near = self.scene.camera.near(&camera_ray.ray);
        path.depth += near;
        path.seen.media_distance = path.seen.media_distance.map(|distance| near + distance);
        let others = self.trace_pending(pending, camera_ray, ctx, profiles);
        let radiance = path.light.radiance + others.light.radiance;
        let media = path.components.media + others.components.media;
        let ComponentLight { direct, indirect, .. } = path.components;
        let components = [media, direct, indirect, path.visible_emission];
        *parts = self.scene.groups.told_apart(radiance, components);
        Sample {
            radiance: radiance.rgb(),
            indirect: (path.light.indirect + others.light.indirect).rgb(),
            visible_emission: path.visible_emission.rgb(),
            components: Components {
                media: media.rgb(),
                direct: direct.rgb(),
                indirect: indirect.rgb(),
            },
            seen: path.seen,
            alpha: if path.is_covered { 1.0 } else { 1.0 - path.transmittance },
            caught: path.caught,
            depth: path.depth,
            transmittance: path.transmittance,
            features: None,
            depths: None,
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
            let from_camera = segment.from_camera;
            let hit = camera_view::surface_along(self.scene, &segment.ray, from_camera, ctx);
            let mut transmittance = S::ONE;
            if segment.solids.is_none() && self.needs.media {
                let media = self.through_media(&segment, hit.as_ref(), camera_ray, ctx, profiles);
                path.add_media(&segment, media.light);
                pending.extend(media.deflected.and_then(|mut ray| {
                    ray.throughput *= segment.throughput;
                    survives_roulette(&mut ray.throughput, &mut ctx.rng).then_some(ray)
                }));
                transmittance = media.transmittance;
                if segment.from_camera && camera_ray.half.is_some() {
                    path.seen.media_distance = profiles.path.sample([0.5; 2]).map(|place| place.t);
                }
            }
            if bounce == 0 {
                path.transmittance = luminance(transmittance.rgb());
                let marched = (from_camera && self.needs.media).then_some(&profiles.path);
                path.depth = visible_depth(marched, hit.as_ref().map(|hit| hit.t));
            }
            segment.throughput *= transmittance;
            if segment.sees_emitters {
                path.add_emission(&segment, self.seen_emission(&segment, hit.as_ref(), ctx));
            }
            let Some(hit) = hit else { break };
            if from_camera && !self.covers(&mut path, &segment, &hit, camera_ray, ctx) {
                break;
            }
            let rough = hit.material.rough(&hit);
            if !hit.material.is_specular() {
                let weight = camera_ray.indirect_weight;
                path.add_reflected(&segment, self.reflected(&segment.ray, &hit, weight, ctx));
                if rough.is_none() {
                    let tells = from_camera && camera_ray.half.is_some();
                    path.seen.surface = tells.then(|| self.visible_surface(&segment, &hit));
                    break;
                }
            }
            path.seen.specular |= from_camera;
            segment.throughput = self.scene.groups.reflected(segment.throughput);
            let next = match rough {
                Some(rough) => follow_rough(&segment, &hit, &rough, ctx),
                None => follow_specular(&segment, &hit, pending, ctx),
            };
            let Some(next) = next else { break };
            segment = next;
        }
        path
    }

    /// Whether the surface at `hit` behind `segment`, a ray of the camera, covers all behind it. Where it does not, `path` ends
    /// there: nothing is seen of a holdout, and of a shadow catcher its shadows.
    fn covers(
        &self,
        path: &mut PathResult<S>,
        segment: &PendingRay<S>,
        hit: &SurfaceHit<'_>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
    ) -> bool {
        path.is_covered = camera_view::covers(self.scene, hit);
        if camera_view::catches_shadows(self.scene, hit) {
            self.catch_shadow(path, segment, hit, camera_ray, ctx);
        }
        path.is_covered
    }

    /// The diffuse surface at `hit` behind `segment`.
    fn visible_surface(&self, segment: &PendingRay<S>, hit: &SurfaceHit<'_>) -> VisibleSurface {
        visible_surface(self.eye, &segment.ray, hit, segment.throughput.rgb())
    }

    /// Ends `path` at the shadow catcher at `hit` behind `segment`, of which indirect light alone is radiance.
    fn catch_shadow(
        &self,
        path: &mut PathResult<S>,
        segment: &PendingRay<S>,
        hit: &SurfaceHit<'_>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
    ) {
        let (ray, throughput) = (&segment.ray, segment.throughput);
        let direct = self.direct_with_and_without_shadow(ray, hit, ctx);
        let [shadowed, unshadowed] = direct.map(|light| luminance((throughput * light).rgb()));
        path.caught = CaughtShadow { seen: path.transmittance, shadowed, unshadowed };
        let indirect = self.indirect_on_surface(ray, hit, camera_ray.indirect_weight, ctx);
        path.add_reflected(segment, Estimate { radiance: indirect, indirect });
        if camera_ray.half.is_some() {
            path.seen.surface = Some(self.visible_surface(segment, hit));
        }
    }

    /// What the surface at `hit` emits back along the ray, or the environment where there is none,
    /// W/(m² sr).
    fn seen_emission(
        &self,
        segment: &PendingRay<S>,
        hit: Option<&SurfaceHit<'_>>,
        ctx: &mut PathContext,
    ) -> S {
        if let Some(from) = &segment.rough {
            return surface_light::emission_after(self.scene, from, &segment.ray, hit, ctx);
        }
        if segment.from_camera {
            return camera_view::emission(self.scene, &segment.ray, hit, ctx);
        }
        match hit {
            Some(hit) => direct_light::emitted(self.scene, &segment.ray, hit),
            None => direct_light::environment(self.scene, &segment.ray, ctx),
        }
    }

    /// Traces `pending` rays and all that are deflected or split off from them.
    fn trace_pending(
        &self,
        mut pending: PendingRays<S>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
        profiles: &mut Profiles<S>,
    ) -> PathResult<S> {
        let (mut all, mut traced) = (PathResult::NOTHING, 0);
        while let Some(next) = pending.pop() {
            if traced == MAX_EVENTS {
                ctx.work.capped_rays += 1;
                break;
            }
            traced += 1;
            let path = self.trace_camera_path(next, camera_ray, &mut pending, ctx, profiles);
            all.light.radiance += path.light.radiance;
            all.light.indirect += path.light.indirect;
            all.components.media += path.components.media;
        }
        all
    }
}
