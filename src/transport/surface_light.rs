//! Direct light on surfaces, and what rough ones reflect of emitters.
//!
//! A path that meets a rough surface goes on by what its facets reflect. Lights that it then hits are sampled by
//! themselves, too, with the balance heuristic (Veach 1997, section 9.2.2).

use glam::DVec3;

use crate::light::{Light, LightSample};
use crate::math::{Ray, Spectrum, World};
use crate::medium::Media;
use crate::scene::Scene;
use crate::surface::{Ggx, SurfaceHit, TransportMode};

use super::direct_light::{LightNumbers, emitters_behind, sample_lights, unoccluded};
use super::{PathContext, Scattering};

/// Direct light that the surface at `hit` reflects back along the unit `incoming`, through `media` (those of the
/// scene, or none), W/(m² sr); of what is [rough](crate::surface::Material::rough) the part of light sampling, which
/// [`emission_after`] completes. Of the uniform numbers `u` two choose a position on each light, or a direction, one which
/// of both, and one among many lights.
pub fn direct_on_surface<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    incoming: DVec3,
    hit: &SurfaceHit<'_>,
    u: [f64; 4],
    ctx: &mut PathContext,
) -> S {
    match hit.material.rough(hit) {
        Some(rough) => direct_on_rough(scene, media, incoming, hit, &rough, u, ctx),
        None => direct_on_diffuse(scene, media, incoming, hit, u, ctx),
    }
}

fn direct_on_rough<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    incoming: DVec3,
    hit: &SurfaceHit<'_>,
    rough: &Ggx<'_>,
    [x, y, _, among]: [f64; 4],
    ctx: &mut PathContext,
) -> S {
    let u = LightNumbers::varied(among, [x, y]);
    sample_lights(scene, hit.point, u, ctx, |_, light, choice, ctx| {
        let direction = light.direction;
        let light_pdf = choice * light.pdf;
        let other_pdf = if light.delta { 0.0 } else { rough.pdf(incoming, direction, hit) };
        let base = hit.material.diffuse_value(incoming, direction, hit) / light_pdf;
        let reflected = rough.eval(incoming, direction, hit) / (light_pdf + other_pdf);
        let weight = (base + reflected) * direction.dot(hit.shading_normal).abs();
        unoccluded(scene, media, hit, light, weight, ctx)
    })
}

/// Radiance of the emitters at the first surface `hit` by `ray`, or infinitely far where there is none, which a rough
/// surface scattered as `from` says, W/(m² sr): the part that light sampling leaves.
pub fn emission_after<S: Spectrum>(
    scene: &Scene,
    from: &Scattering,
    ray: &Ray<World>,
    hit: Option<&SurfaceHit<'_>>,
    ctx: &mut PathContext,
) -> S {
    ctx.work.environment_lookups += u64::from(hit.is_none() && ctx.needs.environment);
    let lights = &scene.lights;
    emitters_behind(scene, ray, hit, |index, at| {
        let choice = lights.pick_probability(from.position, index);
        from.pdf / (from.pdf + choice * lights.lights[index].pdf(from.position, ray.direction, at))
    })
}

/// An environment is sampled by itself or by the surface, half of the time each, with the balance heuristic for one
/// sample (Veach 1997, section 9.2.4), other lights by themselves.
fn direct_on_diffuse<S: Spectrum>(
    scene: &Scene,
    media: &Media,
    incoming: DVec3,
    hit: &SurfaceHit<'_>,
    u: [f64; 4],
    ctx: &mut PathContext,
) -> S {
    let material = hit.material;
    let reflected = |direction: DVec3| {
        material.eval(incoming, direction, hit, TransportMode::Radiance)
            * direction.dot(hit.shading_normal).abs()
    };
    let [x, y, way, among] = u;
    let u = LightNumbers::varied(among, [x, y]);
    sample_lights(scene, hit.point, u, ctx, |index, light, choice, ctx| {
        let light_pdf = choice * light.pdf;
        let kind = &scene.lights.lights[index];
        let Light::Environment(sky) = kind else {
            let weight = reflected(light.direction) / light_pdf;
            return unoccluded(scene, media, hit, light, weight, ctx);
        };
        if way < 0.5 {
            let surface_pdf = material.pdf(incoming, light.direction, hit);
            let weight = reflected(light.direction) / (0.5 * (light_pdf + surface_pdf));
            return unoccluded(scene, media, hit, light, weight, ctx);
        }
        let u = [x, y, ctx.rng.uniform()];
        let scattered = material.scatter(incoming, hit, u, TransportMode::Radiance);
        let Some(scattered) = scattered else { return S::ZERO };
        let direction = scattered.direction;
        let sampled = LightSample { direction, radiance: sky.radiance(direction), ..*light };
        let light_pdf = choice * kind.pdf(hit.point, direction, None);
        let weight = scattered.weight * scattered.pdf / (0.5 * (light_pdf + scattered.pdf));
        unoccluded(scene, media, hit, &sampled, weight, ctx)
    })
}
