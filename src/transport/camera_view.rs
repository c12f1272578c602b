//! What rays from the camera see: no surface and no light that is hidden from it, and nothing of a holdout.
//!
//! All that asks for it asks here, or, without a context, [`Surfaces::intersect_seen`](crate::surface::Surfaces::intersect_seen).

use crate::math::{Ray, Span, Spectrum, World, WorldPoint};
use crate::scene::Scene;
use crate::surface::{CameraView, SurfaceHit};

use super::{PathContext, PixelFootprint, direct_light};

/// The closest surface that `ray`, one of the camera's, sees.
pub fn first_surface<'s>(
    scene: &'s Scene,
    ray: &Ray<World>,
    ctx: &mut PathContext,
) -> Option<SurfaceHit<'s>> {
    if !ctx.needs.surfaces {
        return None;
    }
    ctx.work.intersections += 1;
    scene.surfaces.intersect_seen(ray, span_before(scene, ray, None))
}

/// The part of `ray`, one of the camera's, in front of the surface that it sees at `hit`, or as far as the camera sees.
pub fn span_before(scene: &Scene, ray: &Ray<World>, hit: Option<&SurfaceHit<'_>>) -> Span {
    Span::new(0.0, hit.map_or_else(|| scene.camera.end(ray), |hit| hit.t))
}

/// As [`span_before`] the first surface that `ray` sees, which is not counted.
pub fn clear_span(scene: &Scene, ray: &Ray<World>) -> Span {
    let hit = scene.surfaces.intersect_seen(ray, span_before(scene, ray, None));
    span_before(scene, ray, hit.as_ref())
}

/// The closest surface along `ray` (unit direction): of those that the camera sees where it is `from_camera`, and one of its
/// rays, else of all.
pub fn surface_along<'s>(
    scene: &'s Scene,
    ray: &Ray<World>,
    from_camera: bool,
    ctx: &mut PathContext,
) -> Option<SurfaceHit<'s>> {
    if from_camera {
        first_surface(scene, ray, ctx)
    } else {
        direct_light::first_surface(scene, ray, ctx)
    }
}

/// Whether no surface that the camera sees stands within `distance` metres along `ray` (unit direction).
pub fn is_clear(scene: &Scene, ray: &Ray<World>, distance: f64, ctx: &mut PathContext) -> bool {
    if !ctx.needs.surfaces {
        return true;
    }
    ctx.work.shadow_rays += 1;
    !scene.surfaces.occluded_seen(ray, Span::new(0.0, distance))
}

/// The ray from `p` to the camera, and the distance along it, in metres, within which a surface hides `p`: what is nearer to
/// the camera than that begins to see hides nothing.
pub fn toward_camera(
    scene: &Scene,
    p: WorldPoint,
    footprint: &PixelFootprint,
) -> (Ray<World>, f64) {
    let ray = Ray::new(p, scene.camera.toward(p));
    let near = scene.camera.near(&Ray::new(p, -ray.direction));
    (ray, footprint.distance(p) - near)
}

/// Radiance, W/(m² sr), that `ray` (unit direction) sees of what the surface at `hit` emits, or of lights infinitely
/// far away where there is none.
pub fn emission<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    hit: Option<&SurfaceHit<'_>>,
    ctx: &mut PathContext,
) -> S {
    match hit {
        Some(hit) if is_holdout(scene, hit) => S::ZERO,
        Some(hit) => direct_light::emitted(scene, ray, hit),
        None if !ctx.needs.environment => S::ZERO,
        None => {
            ctx.work.environment_lookups += 1;
            let is_seen = |light: usize| !scene.lights.hidden.contains(&light);
            direct_light::environment_radiance(scene, ray, is_seen)
        }
    }
}

/// Whether the camera sees a hole in the picture at `hit`.
pub fn is_holdout(scene: &Scene, hit: &SurfaceHit<'_>) -> bool {
    scene.surfaces.view(hit) == CameraView::Holdout
}

/// Whether the surface at `hit` covers all that lies behind it.
pub fn covers(scene: &Scene, hit: &SurfaceHit<'_>) -> bool {
    !is_holdout(scene, hit) && !catches_shadows(scene, hit)
}

/// Whether the camera sees only shadows and indirect light at `hit`.
pub fn catches_shadows(scene: &Scene, hit: &SurfaceHit<'_>) -> bool {
    scene.surfaces.view(hit) == CameraView::ShadowCatcher
}
