//! Infinite planes.

use glam::{DVec2, DVec3};

use super::{Foot, SurfacePoint, coordinate_error};
use crate::math::{Aabb, Frame, Ray, Span, World, WorldPoint};

/// An infinite plane. Its texture coordinates are metres along two axes of the plane.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    point: DVec3,
    frame: Frame,
}

impl Plane {
    /// The plane through `point` across `normal`, which need not have unit length.
    ///
    /// # Errors
    /// The problem, where a value is not finite or the normal is zero.
    pub fn new(point: WorldPoint, normal: DVec3) -> Result<Self, String> {
        match normal.try_normalize() {
            Some(unit) if point.xyz.is_finite() => {
                Ok(Self { point: point.xyz, frame: Frame::around(unit) })
            }
            _ => Err(format!(
                "a plane through {} with normal {normal} is none; give finite numbers and a \
                 normal that is not zero",
                point.xyz
            )),
        }
    }

    /// Its unit normal.
    pub fn normal(&self) -> DVec3 {
        self.frame.z
    }

    pub(super) fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<f64> {
        let t = (self.point - ray.origin.xyz).dot(self.frame.z) / ray.direction.dot(self.frame.z);
        (t > span.start && t < span.end).then_some(t)
    }

    pub(super) fn surface_at(&self, p: WorldPoint) -> SurfacePoint {
        let point = self.foot(p.xyz).point;
        let local = self.frame.to_local(point - self.point);
        let reached = Aabb::around([self.point, point].map(WorldPoint::from_xyz));
        SurfacePoint {
            point,
            normal: self.frame.z,
            shading_normal: self.frame.z,
            uv: DVec2::new(local.x, local.y),
            error: coordinate_error(&reached),
        }
    }

    pub(super) fn foot(&self, p: DVec3) -> Foot {
        let height = (p - self.point).dot(self.frame.z);
        Foot { point: p - self.frame.z * height, normal: self.frame.z }
    }
}
