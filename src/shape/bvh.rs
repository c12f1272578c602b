//! The BVH over shapes.

use glam::DVec3;

use super::tree::Tree;
use super::{Crossing, Foot, Nearest, Shape, ShapeHit};
use crate::math::{Aabb, Ray, Span, World, WorldPoint};

/// Many shapes, searched by ray and by place. Each mesh has a tree of its own below the one over
/// the shapes; infinite planes stand beside it.
#[derive(Debug, Clone)]
pub struct Bvh {
    shapes: Vec<Shape>,
    tree: Tree,
    /// Shapes in the tree, by its index.
    finite: Vec<u32>,
    /// Shapes without bounds.
    infinite: Vec<u32>,
}

impl Bvh {
    /// The BVH over `shapes`; hits name them by their index here.
    pub fn new(shapes: Vec<Shape>) -> Self {
        let (mut boxes, mut finite, mut infinite) = (Vec::new(), Vec::new(), Vec::new());
        for (index, shape) in (0u32..).zip(&shapes) {
            match shape.bounds() {
                Some(bounds) => {
                    boxes.push(bounds);
                    finite.push(index);
                }
                None => infinite.push(index),
            }
        }
        Self { tree: Tree::new(&boxes), shapes, finite, infinite }
    }

    /// The shapes, by index.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The box round the finite shapes, empty where there are none.
    pub fn bounds(&self) -> Aabb<World> {
        self.tree.bounds()
    }

    /// The closest crossing with `t` inside the open `span`. The direction need not have unit
    /// length.
    pub fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<ShapeHit> {
        let mut best: Option<(u32, Crossing)> = self
            .tree
            .closest(ray, span, |i, span| self.finite_shape(i).intersect(ray, span))
            .map(|(i, crossing)| (self.finite[i as usize], crossing));
        for &index in &self.infinite {
            let span = Span::new(span.start, best.map_or(span.end, |(_, c)| c.t));
            if let Some(crossing) = self.shapes[index as usize].intersect(ray, span) {
                best = Some((index, crossing));
            }
        }
        let (shape, crossing) = best?;
        let surface = self.shapes[shape as usize].surface_at(ray, crossing);
        Some(ShapeHit {
            t: crossing.t,
            point: WorldPoint::from_xyz(surface.point),
            normal: surface.normal,
            shading_normal: surface.shading_normal,
            uv: surface.uv,
            error: surface.error,
            shape,
            primitive: crossing.primitive,
        })
    }

    /// Whether anything is crossed inside the open `span`.
    pub fn occluded(&self, ray: &Ray<World>, span: Span) -> bool {
        self.infinite.iter().any(|&i| self.shapes[i as usize].occluded(ray, span))
            || self.tree.any(ray, span, |i| self.finite_shape(i).occluded(ray, span))
    }

    /// The closest point of any surface within `max_distance` metres of `point`.
    pub fn nearest(&self, point: WorldPoint, max_distance: f64) -> Option<Nearest> {
        let p = point.xyz;
        let mut reach = max_distance;
        let mut best: Option<Foot> = None;
        let mut consider = |shape: &Shape| {
            let foot = shape.foot(p, reach)?;
            reach = foot.point.distance(p);
            best = Some(foot);
            Some(reach)
        };
        for &index in &self.infinite {
            consider(&self.shapes[index as usize]);
        }
        self.tree.near(p, max_distance, |i| consider(self.finite_shape(i)));
        best.map(|foot| toward(p, foot))
    }

    /// The place nearest to `point` on each infinite shape, with the shape's index.
    pub fn infinite_feet(&self, point: WorldPoint) -> impl Iterator<Item = (u32, WorldPoint)> {
        let foot = move |&index: &u32| {
            let foot = self.shapes[index as usize].foot(point.xyz, f64::INFINITY)?;
            Some((index, WorldPoint::from_xyz(foot.point)))
        };
        self.infinite.iter().filter_map(foot)
    }

    fn finite_shape(&self, index: u32) -> &Shape {
        &self.shapes[self.finite[index as usize] as usize]
    }
}

/// The direction from a foot to `p` loses its digits where they coincide; the geometric normal
/// stands in for it there.
fn toward(p: DVec3, foot: Foot) -> Nearest {
    let offset = p - foot.point;
    let distance = offset.length();
    let noise = 1e3 * f64::EPSILON * p.abs().max_element();
    let normal_toward_point = if distance > noise {
        offset / distance
    } else if offset.dot(foot.normal) < 0.0 {
        -foot.normal
    } else {
        foot.normal
    };
    Nearest { distance, normal_toward_point }
}
