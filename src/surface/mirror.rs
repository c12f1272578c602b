//! Perfect reflection.

use glam::DVec3;

use super::scattered::facing;
use super::{Scattered, SurfaceHit};
use crate::math::Rgb;

pub(super) fn scatter(reflectance: Rgb, incoming: DVec3, hit: &SurfaceHit<'_>) -> Scattered {
    Scattered {
        direction: reflected(incoming, hit),
        weight: reflectance,
        specular: true,
        pdf: 0.0,
        crossing: 0,
    }
}

/// The mirrored direction: about the shading normal, or about the geometric one where that would
/// lead into the surface.
pub(super) fn reflected(incoming: DVec3, hit: &SurfaceHit<'_>) -> DVec3 {
    let (ng, ns) = facing(incoming, hit);
    let smooth = incoming.reflect(ns);
    let direction = if smooth.dot(ng) > 0.0 { smooth } else { incoming.reflect(ng) };
    direction.normalize()
}
