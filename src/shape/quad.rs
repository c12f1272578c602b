//! Flat parallelograms.

use glam::{DVec2, DVec3};

use super::{Foot, SurfacePoint, coordinate_error, triangle};
use crate::math::{Aabb, Ray, Span, World, WorldPoint};

/// A flat parallelogram, visible from both sides, with its normal along u x v.
#[derive(Debug, Clone, Copy)]
pub struct Quad {
    center: DVec3,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
}

impl Quad {
    /// The parallelogram with corners `center` ± `u` ± `v`, in metres.
    ///
    /// # Errors
    /// The problem, where a value is not finite or `u` and `v` span no area.
    pub fn new(center: WorldPoint, u: DVec3, v: DVec3) -> Result<Self, String> {
        let normal = u.normalize_or_zero().cross(v.normalize_or_zero()).normalize_or_zero();
        if normal == DVec3::ZERO || !(center.xyz.is_finite() && u.is_finite() && v.is_finite()) {
            return Err(format!(
                "a quad with half edges {u} and {v} spans no area; give two finite vectors that \
                 are not parallel"
            ));
        }
        Ok(Self { center: center.xyz, u, v, normal })
    }

    /// Its centre.
    pub fn center(&self) -> WorldPoint {
        WorldPoint::from_xyz(self.center)
    }

    /// Its two half edges, in metres.
    pub fn half_edges(&self) -> [DVec3; 2] {
        [self.u, self.v]
    }

    /// Its unit normal.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Its area, in m².
    pub fn area(&self) -> f64 {
        4.0 * self.u.cross(self.v).length()
    }

    fn corners(&self) -> [DVec3; 4] {
        let (c, u, v) = (self.center, self.u, self.v);
        [c - u - v, c + u - v, c + u + v, c - u + v]
    }

    pub(super) fn bounds(&self) -> Aabb<World> {
        Aabb::around(self.corners().map(WorldPoint::from_xyz))
    }

    /// Coordinates of a vector from the centre in units of u and v.
    fn coordinates(&self, offset: DVec3) -> DVec2 {
        let n = self.u.cross(self.v);
        let scale = 1.0 / n.length_squared();
        DVec2::new(offset.cross(self.v).dot(n), self.u.cross(offset).dot(n)) * scale
    }

    pub(super) fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<f64> {
        let t = (self.center - ray.origin.xyz).dot(self.normal) / ray.direction.dot(self.normal);
        if !(t > span.start && t < span.end) {
            return None;
        }
        let st = self.coordinates(ray.at(t).xyz - self.center);
        (st.abs().max_element() <= 1.0).then_some(t)
    }

    pub(super) fn surface_at(&self, p: WorldPoint) -> SurfacePoint {
        let st = self.coordinates(p.xyz - self.center);
        SurfacePoint {
            point: self.center + self.u * st.x + self.v * st.y,
            normal: self.normal,
            shading_normal: self.normal,
            uv: (st + 1.0) * 0.5,
            error: coordinate_error(&self.bounds()),
        }
    }

    pub(super) fn foot(&self, p: DVec3) -> Foot {
        let point = closest_on_quad(p, self.corners());
        Foot { point, normal: self.normal }
    }
}

/// The closest point of a flat quadrilateral with its corners in order.
pub(super) fn closest_on_quad(p: DVec3, [a, b, c, d]: [DVec3; 4]) -> DVec3 {
    let (q, r) = (triangle::closest_point(p, [a, b, c]), triangle::closest_point(p, [a, c, d]));
    if q.distance_squared(p) <= r.distance_squared(p) { q } else { r }
}
