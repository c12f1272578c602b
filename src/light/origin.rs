//! Places on lights that are not infinitely far, and parts of such lights.

use glam::DVec3;

use crate::math::{Cone, Ray, Span, World, WorldPoint};

/// A place that a light shines from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightOrigin {
    /// The place.
    pub position: WorldPoint,
    /// Unit normal of the light's surface there, on the side that shines; none where the light has no
    /// extent.
    pub normal: Option<DVec3>,
}

impl LightOrigin {
    /// The place of a light without an extent.
    pub const fn punctual(position: WorldPoint) -> Self {
        Self { position, normal: None }
    }

    /// The part of `span` of `ray` in front of the surface; all of it where there is none.
    pub fn in_front(&self, ray: &Ray<World>, span: Span) -> Span {
        match self.normal {
            Some(axis) => {
                Cone { apex: self.position, axis, one_minus_cos: 1.0 }.clip(ray).intersect(span)
            }
            None => span,
        }
    }
}

/// A part of a light, for estimates of how much of its light arrives where.
#[derive(Debug, Clone, Copy)]
pub struct LightPart {
    /// Its centre.
    pub origin: LightOrigin,
    /// Root mean square of the distances of its places from the centre, in metres.
    pub spread: f64,
}

impl LightPart {
    /// All of a light without an extent.
    pub const fn punctual(position: WorldPoint) -> Self {
        Self { origin: LightOrigin::punctual(position), spread: 0.0 }
    }
}
