//! Rays of a camera path that are still to be traced.

use smallvec::SmallVec;

use crate::math::{Ray, Spectrum, World};
use crate::surface::{Ggx, SurfaceHit};
use crate::transport::specular::{SpecularStep, scatter_specular, split_specular};
use crate::transport::{EnclosingSolids, PathContext, Scattering, survives_roulette};

/// Panes of glass at which a camera ray is split: the faces of a solid.
///
/// Unit: count. Limit: on the rays that a camera ray becomes, four.
pub(super) const MAX_SPLITS: u32 = 2;

/// A ray that is still to be traced.
#[derive(Debug, Clone, Copy)]
pub(super) struct PendingRay<S> {
    /// The ray (unit direction).
    pub ray: Ray<World>,
    /// Where it ends at the latest, in metres: where the camera ceases to see, infinite for other rays.
    pub end: f64,
    /// Weight of its light.
    pub throughput: S,
    /// MIS weight of punctual lights where their light is scattered next along the ray.
    pub punctual_weight: f64,
    /// Whether it starts at the camera.
    pub from_camera: bool,
    /// Whether a forward peak deflected it: its light is the medium's.
    pub deflected: bool,
    /// Whether emitters that it hits count.
    pub sees_emitters: bool,
    /// How a rough surface scattered it, which samples emitters, too.
    pub rough: Option<Scattering>,
    /// Solids of glass around its origin.
    pub solids: EnclosingSolids,
    /// How many panes of glass split it further, so that both what is reflected and what is refracted is traced.
    pub splits: u32,
}

/// Rays that are still to be traced.
pub(super) type PendingRays<S> = SmallVec<[PendingRay<S>; 4]>;

/// The segment behind the mirror or glass at `hit`; `None` where it absorbs all. Where glass splits the ray, the
/// brighter part is followed and the other put on `pending`.
pub(super) fn follow_specular<S: Spectrum>(
    segment: &PendingRay<S>,
    hit: &SurfaceHit<'_>,
    pending: &mut PendingRays<S>,
    ctx: &mut PathContext,
) -> Option<PendingRay<S>> {
    ctx.work.specular_bounces += 1;
    let behind = |step: &SpecularStep, splits: u32| PendingRay {
        ray: step.ray,
        end: f64::INFINITY,
        throughput: segment.throughput * S::from_rgb(step.weight),
        punctual_weight: 1.0,
        from_camera: false,
        deflected: segment.deflected,
        sees_emitters: true,
        rough: None,
        solids: segment.solids.after(step.crossing),
        splits,
    };
    if segment.splits == 0 {
        let step = scatter_specular(&segment.ray, hit, &mut ctx.rng)?;
        return Some(behind(&step, 0));
    }
    match split_specular(&segment.ray, hit).as_slice() {
        [] => None,
        [only] => Some(behind(only, segment.splits)),
        [a, b, ..] => {
            let [a, b] = [a, b].map(|step| behind(step, segment.splits - 1));
            let is_brighter = a.throughput.max_element() > b.throughput.max_element();
            let (brighter, other) = if is_brighter { (a, b) } else { (b, a) };
            pending.push(other);
            Some(brighter)
        }
    }
}

/// The segment that the `rough` surface at `hit` reflects; `None` where the path ends.
pub(super) fn follow_rough<S: Spectrum>(
    segment: &PendingRay<S>,
    hit: &SurfaceHit<'_>,
    rough: &Ggx<'_>,
    ctx: &mut PathContext,
) -> Option<PendingRay<S>> {
    ctx.work.specular_bounces += 1;
    let scattered = rough.scatter(segment.ray.direction, hit, ctx.rng.uniform2())?;
    let mut throughput = segment.throughput * S::from_rgb(scattered.weight);
    // The first reflection that is seen is worth its ray.
    if !segment.from_camera && !survives_roulette(&mut throughput, &mut ctx.rng) {
        return None;
    }
    Some(PendingRay {
        ray: hit.leave(scattered.direction),
        end: f64::INFINITY,
        throughput,
        punctual_weight: 1.0,
        from_camera: false,
        sees_emitters: true,
        rough: Some(Scattering { position: hit.point, pdf: scattered.pdf, medium: None }),
        ..*segment
    })
}
