//! Boxes under any affine placement.

use glam::{DAffine3, DVec2, DVec3};

use super::quad::closest_on_quad;
use super::{Crossing, Foot, Object, SurfacePoint, coordinate_error};
use crate::math::{Aabb, Point, Ray, Span, Transform, World, WorldPoint};

/// The image of the cube [-1, 1]³ under an affine map; its faces count -x +x -y +y -z +z.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    placement: Transform<Object>,
    bounds: Aabb<World>,
}

const CUBE: Aabb<Object> = Aabb::new(Point::new(-1.0, -1.0, -1.0), Point::new(1.0, 1.0, 1.0));

impl Cuboid {
    /// The box from `min` to `max` of an object's space, in metres before `placement` takes it to
    /// the world.
    ///
    /// # Errors
    /// The problem, where a value is not finite or a side has no length.
    pub fn new(min: DVec3, max: DVec3, placement: &DAffine3) -> Result<Self, String> {
        if !min.cmplt(max).all() {
            return Err(format!(
                "a box from {min} to {max} has no volume; each coordinate of the first corner \
                 must be below that of the second"
            ));
        }
        let half = (max - min) * 0.5;
        let centered = DAffine3::from_translation(min + half) * DAffine3::from_scale(half);
        let placement = Transform::new(*placement * centered)
            .ok_or("the box is placed by a singular or infinite transform")?;
        Ok(Self { placement, bounds: placement.box_to_world(&CUBE) })
    }

    /// The map from the cube [-1, 1]³ to the world.
    pub fn placement(&self) -> &Transform<Object> {
        &self.placement
    }

    /// The place at a point of the unit cube.
    pub(super) fn at(&self, u: DVec3) -> WorldPoint {
        self.placement.point_to_world(Point::from_xyz(2.0 * u - 1.0))
    }

    pub(super) fn bounds(&self) -> Aabb<World> {
        self.bounds
    }

    pub(super) fn volume(&self) -> f64 {
        8.0 * self.placement.volume_scale()
    }

    pub(super) fn contains(&self, p: WorldPoint) -> bool {
        CUBE.contains(self.placement.point_to_local(p))
    }

    /// The part of the ray inside; empty where it misses.
    pub(super) fn chord(&self, ray: &Ray<World>) -> Span {
        CUBE.clip(&self.placement.ray_to_local(ray))
    }

    pub(super) fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<Crossing> {
        let chord = self.chord(ray);
        let inside = |t: &f64| *t > span.start && *t < span.end;
        let t =
            (!chord.is_empty()).then_some([chord.start, chord.end])?.into_iter().find(inside)?;
        let local = self.placement.point_to_local(ray.at(t)).xyz;
        let axis = local.abs().max_position();
        Some(Crossing { t, primitive: 2 * axis as u32 + u32::from(local[axis] > 0.0) })
    }

    pub(super) fn surface_at(&self, p: WorldPoint, face: u32) -> SurfacePoint {
        let mut local = self.placement.point_to_local(p).xyz.clamp(DVec3::NEG_ONE, DVec3::ONE);
        let axis = face as usize / 2;
        local[axis] = outward(face);
        let normal = self.face_normal(face);
        SurfacePoint {
            point: self.placement.point_to_world(Point::from_xyz(local)).xyz,
            normal,
            shading_normal: normal,
            uv: (DVec2::new(local[(axis + 1) % 3], local[(axis + 2) % 3]) + 1.0) * 0.5,
            error: coordinate_error(&self.bounds),
        }
    }

    pub(super) fn foot(&self, p: DVec3) -> Foot {
        let feet = (0..6).map(|face| Foot {
            point: closest_on_quad(p, self.face_corners(face)),
            normal: self.face_normal(face),
        });
        let distance = |f: &Foot| f.point.distance_squared(p);
        feet.reduce(|a, b| if distance(&b) < distance(&a) { b } else { a })
            .expect("a box has six faces")
    }

    fn face_normal(&self, face: u32) -> DVec3 {
        self.placement.normal_to_world(DVec3::AXES[face as usize / 2] * outward(face))
    }

    fn face_corners(&self, face: u32) -> [DVec3; 4] {
        let axis = face as usize / 2;
        let (a, b) = (DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]);
        let n = DVec3::AXES[axis] * outward(face);
        [n - a - b, n + a - b, n + a + b, n - a + b]
            .map(|c| self.placement.point_to_world(Point::from_xyz(c)).xyz)
    }
}

fn outward(face: u32) -> f64 {
    if face % 2 == 1 { 1.0 } else { -1.0 }
}
