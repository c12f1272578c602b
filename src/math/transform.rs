//! Affine maps between a local space and the world.

use glam::{DAffine3, DVec3};

use super::{Aabb, Point, Ray, World, WorldPoint};

/// An invertible affine map from a local space (a grid's index space, an object's own space) to
/// the world, with its inverse.
#[derive(Debug, Clone, Copy)]
pub struct Transform<S> {
    to_world: DAffine3,
    to_local: DAffine3,
    space: std::marker::PhantomData<S>,
}

impl<S: Copy> Transform<S> {
    /// The map that changes nothing.
    pub const IDENTITY: Self = Self {
        to_world: DAffine3::IDENTITY,
        to_local: DAffine3::IDENTITY,
        space: std::marker::PhantomData,
    };

    /// The map `to_world`, or nothing where it is singular or not finite.
    pub fn new(to_world: DAffine3) -> Option<Self> {
        let to_local = to_world.inverse();
        (to_world.is_finite() && to_local.is_finite()).then_some(Self {
            to_world,
            to_local,
            space: std::marker::PhantomData,
        })
    }

    /// The affine map itself.
    pub fn affine(&self) -> DAffine3 {
        self.to_world
    }

    /// This map followed by `placement` in the world.
    pub fn placed(&self, placement: &DAffine3) -> Option<Self> {
        Self::new(*placement * self.to_world)
    }

    /// A local point in the world.
    pub fn point_to_world(&self, p: Point<S>) -> WorldPoint {
        WorldPoint::from_xyz(self.to_world.transform_point3(p.xyz))
    }

    /// A world point in the local space.
    pub fn point_to_local(&self, p: WorldPoint) -> Point<S> {
        Point::from_xyz(self.to_local.transform_point3(p.xyz))
    }

    /// A world ray in the local space; `t` keeps its meaning.
    pub fn ray_to_local(&self, ray: &Ray<World>) -> Ray<S> {
        Ray::new(self.point_to_local(ray.origin), self.to_local.transform_vector3(ray.direction))
    }

    /// A local direction in the world, not normalised.
    pub fn vector_to_world(&self, v: DVec3) -> DVec3 {
        self.to_world.transform_vector3(v)
    }

    /// A local surface normal in the world, of unit length.
    pub fn normal_to_world(&self, n: DVec3) -> DVec3 {
        (self.to_local.matrix3.transpose() * n).normalize_or_zero()
    }

    /// The world box round a local box.
    pub fn box_to_world(&self, b: &Aabb<S>) -> Aabb<World> {
        if b.is_empty() {
            return Aabb::EMPTY;
        }
        Aabb::around(b.corners().map(|c| self.point_to_world(c)))
    }

    /// World volume of one unit of local volume, in m³.
    pub fn volume_scale(&self) -> f64 {
        self.to_world.matrix3.determinant().abs()
    }

    /// World lengths of the three local unit vectors, in metres: a grid's voxel size.
    pub fn unit_lengths(&self) -> DVec3 {
        let m = self.to_world.matrix3;
        DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
    }
}
