//! What scattering at a surface gives.

use glam::DVec3;

use super::SurfaceHit;
use crate::math::Rgb;

/// What travels along a path. Shading normals and refraction treat them differently (Veach 1997,
/// chapter 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TransportMode {
    /// A path from the camera carries radiance back to it.
    Radiance,
    /// A photon's path from a light carries power.
    Importance,
}

/// A sampled direction.
#[derive(Debug, Clone, Copy)]
pub struct Scattered {
    /// Unit vector away from the surface.
    pub direction: DVec3,
    /// Value times cosine over density.
    pub weight: Rgb,
    /// Whether the direction was one of finitely many.
    pub specular: bool,
    /// Density over solid angle, 1/sr; 0 where specular.
    pub pdf: f64,
    /// Glass: +1 enters the solid, -1 leaves it; otherwise 0.
    pub crossing: i8,
}

/// The geometric and the shading normal, turned to the side that `incoming` comes from.
pub(super) fn facing(incoming: DVec3, hit: &SurfaceHit<'_>) -> (DVec3, DVec3) {
    if incoming.dot(hit.normal) > 0.0 {
        (-hit.normal, -hit.shading_normal)
    } else {
        (hit.normal, hit.shading_normal)
    }
}

/// Whether light goes between both directions by reflection: nothing leaks through either normal.
pub(super) fn reflects(incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> bool {
    let (ng, ns) = facing(incoming, hit);
    incoming.dot(ns) < 0.0 && outgoing.dot(ns) > 0.0 && outgoing.dot(ng) > 0.0
}
