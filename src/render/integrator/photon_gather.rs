//! Density estimates: indirect light from the photon maps, in media and on surfaces.

use std::f64::consts::PI;
use std::time::Instant;

use crate::math::{Ray, Rgb, Span, Spectrum, World};
use crate::medium::{Media, Profile};
use crate::photon::{PhotonDirection, Response};
use crate::render::pixel_sampling::CameraRay;
use crate::scene::plan::Needs;
use crate::strategy::Strategy;
use crate::surface::SurfaceHit;
use crate::transport::{Decision, PathContext, surface_light};

use super::pending::PendingRay;
use super::ray_estimators::RayEstimators;
use super::setup::{Estimate, Integrator, Scatterers};

/// Distance beyond a surface, in gather radii, at which a beam gather ends at most. A ray that meets
/// the surface at a slant would need an unbounded distance.
const MAX_BEYOND: f64 = 4.0;

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Light of the volume photons that media scatter along `segment` to its origin, W/(m² sr): the beam
    /// radiance estimate (Jarosz, Zwicker and Jensen 2008) of
    /// [`PhotonMaps::along`](crate::photon::PhotonMaps::along) where light of media is gathered so, times
    /// the weight of indirect light.
    pub(super) fn volume_photons_along(
        &self,
        segment: &PendingRay<S>,
        by: &RayEstimators,
        hit: Option<&SurfaceHit<'_>>,
        profile: &Profile<S>,
        camera_ray: &CameraRay<'_>,
        ctx: &mut PathContext,
    ) -> S {
        if self.maps.volume[0].is_empty() || profile.pieces().is_empty() {
            return S::ZERO;
        }
        let start = Instant::now();
        let ray = &segment.ray;
        let radius = camera_ray.budget.radius;
        // Where the ray meets a surface at a slant, the kernel's disk at its end lies partly behind
        // the surface; photons in front of it, beyond the end, replace those.
        let end = hit.map_or(segment.end, |h| h.t);
        let beyond = hit.map_or(0.0, |h| {
            let cosine = ray.direction.dot(h.normal).abs().min(1.0);
            radius * ((1.0 - cosine * cosine).sqrt() / cosine).min(MAX_BEYOND)
        });
        let work = &mut ctx.work;
        work.gathers += 1;
        let before = work.gathered;
        let span = Span::new(0.0, (end + beyond).min(by.beams_end()));
        let respond = |t: f64| {
            let t = t.min(end);
            let (transmittance, sigma_t) = profile.at(t)?;
            let attenuated = transmittance * sigma_t;
            let scatterer = |(medium, albedo): (usize, S)| {
                let split = &self.choice.splits[medium];
                (&split.phase, albedo * attenuated * split.share)
            };
            let albedos = self.albedos(ray.at(t)).into_iter();
            let is_gathered =
                |(medium, _): &(usize, S)| by.strategy_at(*medium, t) == Strategy::Beams;
            let scatterers: Scatterers<'_, S> =
                albedos.filter(is_gathered).map(scatterer).collect();
            Some(Response { sigma_t: sigma_t.max_element(), scatterers })
        };
        work.directed_gathers += u64::from(H::KNOWN);
        let light = self.maps.along(ray, span, radius, &mut work.gathered, respond);
        work.grid_lookups += (work.gathered - before) * self.media.albedo_lookups;
        ctx.amortized.gathers += start.elapsed();
        light * camera_ray.indirect_weight
    }

    /// Light that the surface at `hit` reflects along `ray` back to its origin: direct light by all of its reflection, and
    /// `indirect_weight` times the surface photons' irradiance by its diffuse part.
    pub(super) fn reflected(
        &self,
        ray: &Ray<World>,
        hit: &SurfaceHit<'_>,
        indirect_weight: f64,
        ctx: &mut PathContext,
    ) -> Estimate<S> {
        let draws = ctx.stratified.draws(Decision::SurfaceLights, 1);
        let (media, u) = (&self.scene.media, draws.numbers(0, &mut ctx.rng));
        let direct: S =
            surface_light::direct_on_surface(self.scene, media, ray.direction, hit, u, ctx);
        let indirect = self.indirect_on_surface(ray, hit, indirect_weight, ctx);
        let [radiance, indirect] =
            [direct + indirect, indirect].map(|light| self.scene.groups.reflected(light));
        Estimate { radiance, indirect }
    }

    /// Direct light that the surface at `hit` reflects along `ray` back to its origin, W/(m² sr), and what that would be
    /// were nothing between it and the lights: by the same samples of these, so that both are the same where nothing is.
    pub(super) fn direct_with_and_without_shadow(
        &self,
        ray: &Ray<World>,
        hit: &SurfaceHit<'_>,
        ctx: &mut PathContext,
    ) -> [S; 2] {
        let draws = ctx.stratified.draws(Decision::SurfaceLights, 1);
        let u = draws.numbers(0, &mut ctx.rng);
        let (scene, incoming) = (self.scene, ray.direction);
        let needs = Needs { surfaces: false, media: false, ..ctx.needs };
        let mut open = PathContext::new(ctx.rng.clone(), needs);
        let nothing = Media::default();
        let unshadowed =
            surface_light::direct_on_surface(scene, &nothing, incoming, hit, u, &mut open);
        ctx.work += open.work;
        let shadowed = surface_light::direct_on_surface(scene, &scene.media, incoming, hit, u, ctx);
        [shadowed, unshadowed]
    }

    /// Light of the surface photons that the surface at `hit` reflects by its diffuse part along `ray` back to its origin,
    /// times `indirect_weight`, W/(m² sr).
    pub(super) fn indirect_on_surface(
        &self,
        ray: &Ray<World>,
        hit: &SurfaceHit<'_>,
        indirect_weight: f64,
        ctx: &mut PathContext,
    ) -> S {
        if self.maps.surface.is_empty() || indirect_weight == 0.0 || hit.material.is_followed() {
            return S::ZERO;
        }
        let facing = if ray.direction.dot(hit.normal) < 0.0 { hit.normal } else { -hit.normal };
        ctx.work.surface_gathers += 1;
        let start = Instant::now();
        let irradiance = self.maps.irradiance(hit.point, facing, &mut ctx.work.gathered);
        ctx.amortized.gathers += start.elapsed();
        let reflects = hit.material.diffuse_value(ray.direction, facing, hit) != Rgb::ZERO;
        let albedo =
            if reflects { hit.material.diffuse_albedo(ray.direction, hit) } else { Rgb::ZERO };
        let reflectance = albedo / PI;
        S::from_rgb(reflectance) * indirect_weight * irradiance
    }
}
