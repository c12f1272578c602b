//! Triangle meshes.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};

use super::tree::Tree;
use super::triangle::{self, ShearedRay};
use super::{Crossing, Foot, SurfacePoint, coordinate_error};
use crate::math::{Aabb, Ray, Span, World, WorldPoint};

/// Largest coordinate of a placed mesh, in metres: squares and products of four stay finite.
const LARGEST: f64 = 1e60;

/// The parts of a mesh in an object's own space.
#[derive(Debug, Clone, Default)]
pub struct MeshData {
    /// Corners, in metres before the placement.
    pub positions: Vec<DVec3>,
    /// Three indices into the vertices for each triangle, counterclockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Normals of the vertices, of any length (0: none there), or empty.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the vertices, or empty.
    pub uvs: Vec<Vec2>,
    /// Material slot of each triangle, or empty: all 0.
    pub slots: Vec<u32>,
    /// Parts that have names: the first triangle of each, in their order, or empty.
    pub parts: MeshParts,
}

/// Parts of a mesh, which copies of it share: the first triangle of each, in their order, and its name.
pub type MeshParts = Arc<[(u32, String)]>;

/// A triangle mesh in the world, with a BVH of its own.
#[derive(Debug, Clone)]
pub struct Mesh {
    data: MeshData,
    tree: Tree,
}

impl Mesh {
    /// The mesh of `data` placed in the world. A mirroring placement keeps the outside outside.
    ///
    /// # Errors
    /// The problem, where there are no triangles, an index has no vertex, a list has the wrong
    /// length, or a coordinate is not finite.
    pub fn new(mut data: MeshData, placement: &DAffine3) -> Result<Self, String> {
        check(&data)?;
        let normal_map = placement.matrix3.inverse().transpose();
        if !(placement.is_finite() && normal_map.is_finite()) {
            return Err("the mesh is placed by a singular or infinite transform".into());
        }
        for position in &mut data.positions {
            *position = placement.transform_point3(*position);
            if position.abs().max_element() > LARGEST {
                return Err(format!("a vertex lies at {position}, beyond {LARGEST:e} m"));
            }
        }
        for normal in &mut data.normals {
            *normal = (normal_map * normal.as_dvec3()).normalize_or_zero().as_vec3();
        }
        if placement.matrix3.determinant() < 0.0 {
            data.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let corners = |t: &[u32; 3]| t.map(|i| WorldPoint::from_xyz(data.positions[i as usize]));
        let boxes: Vec<_> = data.triangles.iter().map(|t| Aabb::around(corners(t))).collect();
        Ok(Self { tree: Tree::new(&boxes), data })
    }

    /// The mesh at the time `t`, where it is this at 0 and `next` at 1: vertices move in straight lines.
    ///
    /// # Errors
    /// The problem, where `next` has other triangles.
    pub fn toward(&self, next: &Self, t: f64) -> Result<Self, String> {
        if self.data.triangles != next.data.triangles
            || self.data.positions.len() != next.data.positions.len()
            || self.data.normals.len() != next.data.normals.len()
        {
            return Err(format!(
                "has {} triangles and {} vertices, and the mesh at the frame {} and {}, or they are joined otherwise; \
                 give the same mesh with its vertices moved",
                next.triangle_count(),
                next.data.positions.len(),
                self.triangle_count(),
                self.data.positions.len()
            ));
        }
        let mut data = self.data.clone();
        for (here, there) in data.positions.iter_mut().zip(&next.data.positions) {
            *here = here.lerp(*there, t);
        }
        for (here, there) in data.normals.iter_mut().zip(&next.data.normals) {
            *here = here.lerp(*there, t as f32);
        }
        Self::new(data, &DAffine3::IDENTITY)
    }

    /// How many triangles it has.
    pub fn triangle_count(&self) -> usize {
        self.data.triangles.len()
    }

    /// About the bytes it takes in memory, its tree included: two nodes a triangle.
    pub fn memory_bytes(&self) -> usize {
        let MeshData { positions, triangles, normals, uvs, slots, parts } = &self.data;
        let tree = size_of::<u32>() + 2 * size_of::<obvhs::bvh2::node::Bvh2Node>();
        size_of_val(&positions[..])
            + size_of_val(&triangles[..])
            + size_of_val(&normals[..])
            + size_of_val(&uvs[..])
            + size_of_val(&slots[..])
            + parts.iter().map(|part| size_of_val(part) + part.1.len()).sum::<usize>()
            + triangles.len() * tree
    }

    /// The corners of a triangle, in metres.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.data.triangles[triangle as usize].map(|i| self.data.positions[i as usize])
    }

    /// The material slot of a triangle.
    pub fn slot(&self, triangle: u32) -> u32 {
        self.data.slots.get(triangle as usize).copied().unwrap_or(0)
    }

    /// Its parts that have names, by their first triangles.
    pub fn parts(&self) -> &[(u32, String)] {
        &self.data.parts
    }

    /// How many material slots its triangles name.
    pub fn slot_count(&self) -> usize {
        self.data.slots.iter().max().map_or(1, |s| *s as usize + 1)
    }

    /// The box round it.
    pub fn bounds(&self) -> Aabb<World> {
        self.tree.bounds()
    }

    /// Whether it bounds a volume: once vertices at equal places are one, each edge belongs to
    /// exactly two triangles. Triangles that have two corners in one place do not count.
    pub fn is_closed(&self) -> bool {
        let edges = self.edges();
        !edges.is_empty() && edges.values().all(|e| e[0] + e[1] == 2)
    }

    /// Whether, being closed, its triangles are wound alike: neighbours run along their common
    /// edge in opposite directions.
    pub fn is_oriented(&self) -> bool {
        self.edges().values().all(|e| e[0] == e[1])
    }

    /// The volume it encloses if it is closed and oriented, in m³; parts that overlap count twice.
    pub(super) fn enclosed_volume(&self) -> f64 {
        let origin = self.bounds().center().xyz;
        let tetrahedron = |t| {
            let [a, b, c] = self.corners(t).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        };
        (0..self.triangle_count() as u32).map(tetrahedron).sum::<f64>().abs()
    }

    /// How often each edge is used, upward and downward in vertex order.
    fn edges(&self) -> HashMap<[u32; 2], [u32; 2]> {
        let mut first = HashMap::with_capacity(self.data.positions.len());
        let merged: Vec<u32> = (0u32..)
            .zip(&self.data.positions)
            .map(|(i, p)| {
                *first.entry((*p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(i)
            })
            .collect();
        let mut edges = HashMap::with_capacity(self.data.triangles.len() * 3 / 2);
        for triangle in &self.data.triangles {
            let [a, b, c] = triangle.map(|i| merged[i as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            for (p, q) in [(a, b), (b, c), (c, a)] {
                edges.entry([p.min(q), p.max(q)]).or_insert([0, 0])[usize::from(p > q)] += 1;
            }
        }
        edges
    }

    pub(super) fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<Crossing> {
        let sheared = ShearedRay::new(ray);
        let test = |triangle, span: Span| {
            let hit = triangle::cross(&sheared, self.corners(triangle))?;
            (hit.t > span.start && hit.t < span.end)
                .then_some(Crossing { t: hit.t, primitive: triangle })
        };
        self.tree.closest(ray, span, test).map(|(_, crossing)| crossing)
    }

    pub(super) fn occluded(&self, ray: &Ray<World>, span: Span) -> bool {
        let sheared = ShearedRay::new(ray);
        self.tree.any(ray, span, |triangle| {
            triangle::cross(&sheared, self.corners(triangle))
                .is_some_and(|hit| hit.t > span.start && hit.t < span.end)
        })
    }

    /// Calls `visit` with (t, whether the ray comes from the front) of every crossing along the
    /// whole line of `ray`, behind its origin too, in no order.
    pub(super) fn each_crossing(&self, ray: &Ray<World>, mut visit: impl FnMut(f64, bool)) {
        let line = Span::new(f64::NEG_INFINITY, f64::INFINITY);
        let sheared = ShearedRay::new(ray);
        self.tree.each(ray, line, |triangle| {
            if let Some(hit) = triangle::cross(&sheared, self.corners(triangle)) {
                visit(hit.t, hit.front);
            }
        });
    }

    pub(super) fn surface_at(&self, ray: &Ray<World>, crossing: Crossing) -> SurfacePoint {
        let corners = self.corners(crossing.primitive);
        let weights = triangle::cross(&ShearedRay::new(ray), corners)
            .map_or([1.0 / 3.0; 3], |hit| hit.weights);
        let indices = self.data.triangles[crossing.primitive as usize].map(|i| i as usize);
        let normal = face_normal(corners);
        let mixed = |values: [DVec3; 3]| {
            values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
        };
        let shading_normal = if self.data.normals.is_empty() {
            normal
        } else {
            let smooth = mixed(indices.map(|i| self.data.normals[i].as_dvec3()));
            let unit = smooth.normalize_or(normal);
            if unit.dot(normal) < 0.0 { -unit } else { unit }
        };
        let uv = if self.data.uvs.is_empty() {
            DVec2::new(weights[1], weights[2])
        } else {
            mixed(indices.map(|i| self.data.uvs[i].as_dvec2().extend(0.0))).truncate()
        };
        SurfacePoint {
            point: mixed(corners),
            normal,
            shading_normal,
            uv,
            error: coordinate_error(&Aabb::around(corners.map(WorldPoint::from_xyz))),
        }
    }

    pub(super) fn foot(&self, p: DVec3, reach: f64) -> Option<Foot> {
        let mut best: Option<(f64, u32, DVec3)> = None;
        self.tree.near(p, reach, |triangle| {
            let point = triangle::closest_point(p, self.corners(triangle));
            let distance = point.distance(p);
            let closer = best.is_none_or(|(d, i, _)| (distance, triangle) < (d, i));
            (distance <= reach && closer).then(|| {
                best = Some((distance, triangle, point));
                distance
            })
        });
        best.map(|(_, triangle, point)| Foot { point, normal: face_normal(self.corners(triangle)) })
    }
}

fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let unit = |v: DVec3| v.normalize_or_zero();
    unit(unit(b - a).cross(unit(c - a)))
}

fn check(data: &MeshData) -> Result<(), String> {
    let vertices = data.positions.len();
    if data.triangles.is_empty() {
        return Err("holds no triangles; a mesh needs at least one".into());
    }
    if u32::try_from(data.triangles.len().max(vertices)).is_err() {
        return Err(format!("holds more than {} triangles or vertices", u32::MAX));
    }
    if let Some(i) = data.positions.iter().position(|p| !p.is_finite()) {
        return Err(format!(
            "vertex {i} lies at {}; coordinates must be finite numbers",
            data.positions[i]
        ));
    }
    let out_of_range = |t: &[u32; 3]| t.iter().any(|i| *i as usize >= vertices);
    if let Some(i) = data.triangles.iter().position(out_of_range) {
        return Err(format!(
            "triangle {i} has vertex indices {:?}, but there are {vertices} vertices",
            data.triangles[i]
        ));
    }
    let lists = [
        ("normals", data.normals.len(), vertices),
        ("texture coordinates", data.uvs.len(), vertices),
        ("material slots", data.slots.len(), data.triangles.len()),
    ];
    for (name, found, right) in lists {
        if found != 0 && found != right {
            return Err(format!("holds {found} {name} where {right} belong"));
        }
    }
    if let Some(i) = data.normals.iter().position(|n| !n.is_finite()) {
        return Err(format!("the normal of vertex {i} is {}, not finite", data.normals[i]));
    }
    if let Some(i) = data.uvs.iter().position(|n| !n.is_finite()) {
        return Err(format!("the texture coordinates of vertex {i} are not finite"));
    }
    Ok(())
}
