//! Geometry in the world: shapes, meshes and their loaders, the BVH, closed regions.

mod bvh;
mod cuboid;
mod gltf;
mod load;
mod mesh;
mod obj;
mod parsed;
mod plane;
mod ply;
mod ply_write;
mod quad;
mod region;
mod sphere;
mod tree;
mod triangle;

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::math::{Aabb, Ray, Span, World, WorldPoint};

pub use bvh::Bvh;
pub use cuboid::Cuboid;
pub use load::{LoadedMesh, MESH_READER, load_mesh};
pub use mesh::{Mesh, MeshData};
pub use parsed::{MeshMaterial, TextureSource};
pub use plane::Plane;
pub use ply_write::write_ply;
pub use quad::Quad;
pub use region::{ClosedMesh, Region};
pub use sphere::Sphere;

/// An object's own space, before it is placed in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Object {}

/// A surface in the world, its placement baked in.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A sphere, or an ellipsoid where its placement stretches.
    Sphere(Sphere),
    /// A flat parallelogram.
    Quad(Quad),
    /// A box, or a parallelepiped where its placement shears.
    Box(Cuboid),
    /// An infinite plane.
    Plane(Plane),
    /// Triangles.
    Mesh(Arc<Mesh>),
}

/// The closest crossing of a ray with a shape.
#[derive(Debug, Clone, Copy)]
pub struct ShapeHit {
    /// Ray parameter, in multiples of the ray's direction.
    pub t: f64,
    /// The place, put back onto the surface.
    pub point: WorldPoint,
    /// Unit geometric normal, outward or as the surface is wound; not turned toward the ray.
    pub normal: DVec3,
    /// Unit normal for shading, interpolated where a mesh has normals, on the side of `normal`.
    pub shading_normal: DVec3,
    /// Texture coordinates.
    pub uv: DVec2,
    /// Bound of the error of each coordinate of `point`, in metres.
    pub error: f64,
    /// Index of the shape.
    pub shape: u32,
    /// Index of the triangle of a mesh or of the face of a box, otherwise 0.
    pub primitive: u32,
}

/// The point of a surface that is closest to a place.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// How far it is, in metres.
    pub distance: f64,
    /// Unit vector from the surface toward the place; the geometric normal where the place lies on
    /// the surface.
    pub normal_toward_point: DVec3,
}

/// A crossing before its surface is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Crossing {
    t: f64,
    primitive: u32,
}

/// The surface at a crossing.
#[derive(Debug, Clone, Copy)]
struct SurfacePoint {
    point: DVec3,
    normal: DVec3,
    shading_normal: DVec3,
    uv: DVec2,
    error: f64,
}

/// A point of a surface beside its geometric normal.
#[derive(Debug, Clone, Copy)]
struct Foot {
    point: DVec3,
    normal: DVec3,
}

impl Shape {
    /// The mesh that it is, if it is one.
    pub const fn mesh(&self) -> Option<&Arc<Mesh>> {
        match self {
            Self::Mesh(mesh) => Some(mesh),
            Self::Sphere(_) | Self::Quad(_) | Self::Box(_) | Self::Plane(_) => None,
        }
    }

    /// The box round the shape, or nothing where it is infinite.
    pub fn bounds(&self) -> Option<Aabb<World>> {
        match self {
            Self::Sphere(s) => Some(s.bounds()),
            Self::Quad(q) => Some(q.bounds()),
            Self::Box(b) => Some(b.bounds()),
            Self::Plane(_) => None,
            Self::Mesh(m) => Some(m.bounds()),
        }
    }

    fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<Crossing> {
        let simple = |t| Crossing { t, primitive: 0 };
        match self {
            Self::Sphere(s) => s.intersect(ray, span).map(simple),
            Self::Quad(q) => q.intersect(ray, span).map(simple),
            Self::Box(b) => b.intersect(ray, span),
            Self::Plane(p) => p.intersect(ray, span).map(simple),
            Self::Mesh(m) => m.intersect(ray, span),
        }
    }

    fn occluded(&self, ray: &Ray<World>, span: Span) -> bool {
        match self {
            Self::Mesh(m) => m.occluded(ray, span),
            Self::Sphere(_) | Self::Quad(_) | Self::Box(_) | Self::Plane(_) => {
                self.intersect(ray, span).is_some()
            }
        }
    }

    fn surface_at(&self, ray: &Ray<World>, crossing: Crossing) -> SurfacePoint {
        match self {
            Self::Sphere(s) => s.surface_at(ray.at(crossing.t)),
            Self::Quad(q) => q.surface_at(ray.at(crossing.t)),
            Self::Box(b) => b.surface_at(ray.at(crossing.t), crossing.primitive),
            Self::Plane(p) => p.surface_at(ray.at(crossing.t)),
            Self::Mesh(m) => m.surface_at(ray, crossing),
        }
    }

    /// The closest point of the surface within `reach` of `p`.
    fn foot(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let foot = match self {
            Self::Sphere(s) => s.foot(p),
            Self::Quad(q) => q.foot(p),
            Self::Box(b) => b.foot(p),
            Self::Plane(s) => s.foot(p),
            Self::Mesh(m) => return m.foot(p, reach),
        };
        (foot.point.distance(p) <= reach).then_some(foot)
    }
}

/// Bound of the error of a coordinate that was computed from coordinates of a box: those of its
/// corners and the differences between them, some twenty roundings each.
fn coordinate_error(bounds: &Aabb<World>) -> f64 {
    let largest = bounds.min.xyz.abs().max(bounds.max.xyz.abs()).max_element();
    32.0 * f64::EPSILON * (largest + bounds.size().max_element())
}

/// Where a ray begins that leaves a surface at `point` along `direction`: moved along `normal`, to
/// the side of `direction`, just past the error of `point`, so that it does not meet the surface it
/// leaves (Pharr, Jakob and Humphreys 2023, section 6.8.6).
pub fn offset_origin(point: WorldPoint, error: f64, normal: DVec3, direction: DVec3) -> WorldPoint {
    let distance = error * normal.abs().element_sum();
    let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
    let moved = point.xyz + side * distance;
    let round = |x: f64, toward: f64| match toward {
        s if s > 0.0 => x.next_up(),
        s if s < 0.0 => x.next_down(),
        _ => x,
    };
    WorldPoint::new(round(moved.x, side.x), round(moved.y, side.y), round(moved.z, side.z))
}
