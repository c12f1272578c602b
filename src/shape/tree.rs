//! A bounding volume hierarchy over boxes, blind to what is in them.
//!
//! obvhs works in f32. The boxes are therefore moved and scaled into [-1, 1]³ and padded by more
//! than every rounding of a traversal, and a ray starts where it enters the whole: what f32 loses
//! then costs a few extra primitive tests, never a hit, at any place and any scale.

use std::fmt;
use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::RayHit;

use super::Crossing;
use crate::math::{Aabb, Point, Ray, Span, World};

/// How far each box is grown, in units of half the longest side of the whole. A ray inside the
/// whole has coordinates up to 1 and parameters up to 2·sqrt(3), so that its position in f32 is off
/// by at most about 1e-6.
const PAD: f64 = 4e-6;

/// How far the whole is grown before rays are clipped to it, in the same unit.
const MARGIN: f64 = 1e-3;

#[derive(Clone)]
pub(super) struct Tree {
    bvh: Option<Bvh2>,
    bounds: Aabb<World>,
    center: DVec3,
    scale: f64,
}

impl fmt::Debug for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Tree").field("bounds", &self.bounds).finish_non_exhaustive()
    }
}

impl Tree {
    pub(super) fn new(boxes: &[Aabb<World>]) -> Self {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(*b));
        if boxes.is_empty() {
            return Self { bvh: None, bounds, center: DVec3::ZERO, scale: 1.0 };
        }
        let center = bounds.center().xyz;
        let half = 0.5 * bounds.size().max_element();
        let scale = if half > 0.0 { half } else { 1.0 };
        let local: Vec<_> = boxes
            .iter()
            .map(|b| {
                let corner =
                    |p: Point<World>, pad: f64| ((p.xyz - center) / scale + pad).as_vec3a();
                obvhs::aabb::Aabb::new(corner(b.min, -PAD), corner(b.max, PAD))
            })
            .collect();
        let bvh = build_bvh2(&local, BvhBuildParams::medium_build(), &mut Duration::default());
        Self { bvh: Some(bvh), bounds, center, scale }
    }

    pub(super) fn bounds(&self) -> Aabb<World> {
        self.bounds
    }

    /// The closest of the crossings that `test` finds in a primitive; of equal ones that of the
    /// lowest index.
    pub(super) fn closest(
        &self,
        ray: &Ray<World>,
        span: Span,
        mut test: impl FnMut(u32, Span) -> Option<Crossing>,
    ) -> Option<(u32, Crossing)> {
        let (bvh, local) = (self.bvh.as_ref()?, self.localise(ray, span)?);
        let mut best: Option<(u32, Crossing)> = None;
        bvh.ray_traverse(local.ray, &mut RayHit::none(), |_, slot| {
            let index = bvh.primitive_indices[slot];
            let end = best.map_or(span.end, |(_, c)| c.t.next_up());
            match test(index, Span::new(span.start, end)) {
                Some(c) if best.is_none_or(|(i, b)| (c.t, index) < (b.t, i)) => {
                    best = Some((index, c));
                    local.shorten(c.t)
                }
                _ => f32::INFINITY,
            }
        });
        best
    }

    /// Whether `test` holds for any primitive that the ray may meet.
    pub(super) fn any(
        &self,
        ray: &Ray<World>,
        span: Span,
        mut test: impl FnMut(u32) -> bool,
    ) -> bool {
        let (Some(bvh), Some(local)) = (&self.bvh, self.localise(ray, span)) else {
            return false;
        };
        !bvh.ray_traverse_miss(local.ray, |_, slot| {
            if test(bvh.primitive_indices[slot]) { f32::NEG_INFINITY } else { f32::INFINITY }
        })
    }

    /// Calls `visit` with every primitive that the ray may meet, in no order.
    pub(super) fn each(&self, ray: &Ray<World>, span: Span, mut visit: impl FnMut(u32)) {
        if let (Some(bvh), Some(local)) = (&self.bvh, self.localise(ray, span)) {
            bvh.ray_traverse_anyhit(local.ray, |_, slot| visit(bvh.primitive_indices[slot]));
        }
    }

    /// Calls `visit` with every primitive that may lie within `reach` of `p`, near ones first; it
    /// answers with a shorter reach where it found something.
    pub(super) fn near(&self, p: DVec3, reach: f64, mut visit: impl FnMut(u32) -> Option<f64>) {
        let Some(bvh) = &self.bvh else { return };
        let outside = (self.bounds.min.xyz - p).max(p - self.bounds.max.xyz).max(DVec3::ZERO);
        if outside.length() > reach {
            return;
        }
        let local = ((p - self.center) / self.scale).as_vec3a();
        let slack = 1e-6 * (1.0 + local.abs().max_element());
        let to_local = |reach: f64| (reach / self.scale) as f32 * (1.0 + 1e-6) + slack;
        let mut search = Search {
            bvh,
            p: local,
            reach: to_local(reach),
            visit: |index| visit(index).map(to_local),
        };
        search.descend(0);
    }

    fn localise(&self, ray: &Ray<World>, span: Span) -> Option<LocalRay> {
        let inside = self.bounds.grown(MARGIN * self.scale).clip(ray).intersect(span);
        let direction = ray.direction / self.scale;
        let speed = direction.length();
        if inside.is_empty() || !(speed > 0.0 && speed.is_finite()) {
            return None;
        }
        let origin = (ray.at(inside.start).xyz - self.center) / self.scale;
        let mut local = LocalRay {
            ray: obvhs::ray::Ray::new_inf(origin.as_vec3a(), (direction / speed).as_vec3a()),
            start: inside.start,
            speed,
        };
        local.ray.tmax = local.shorten(inside.end);
        Some(local)
    }
}

/// A ray in the tree's frame, with unit direction, from where it enters.
struct LocalRay {
    ray: obvhs::ray::Ray,
    start: f64,
    speed: f64,
}

impl LocalRay {
    /// The local parameter of `t`, rounded up past every error.
    fn shorten(&self, t: f64) -> f32 {
        ((t - self.start) * self.speed + 2.0 * PAD) as f32
    }
}

/// A descent toward the primitives near a point.
struct Search<'a, V> {
    bvh: &'a Bvh2,
    p: Vec3A,
    reach: f32,
    visit: V,
}

impl<V: FnMut(u32) -> Option<f32>> Search<'_, V> {
    fn descend(&mut self, node: usize) {
        let node = &self.bvh.nodes[node];
        if node.is_leaf() {
            for slot in node.first_index..node.first_index + node.prim_count {
                if let Some(reach) = (self.visit)(self.bvh.primitive_indices[slot as usize]) {
                    self.reach = self.reach.min(reach);
                }
            }
            return;
        }
        let first = node.first_index as usize;
        let mut children = [first, first + 1].map(|child| (self.distance(child), child));
        if children[1].0 < children[0].0 {
            children.swap(0, 1);
        }
        for (distance, child) in children {
            if distance <= self.reach {
                self.descend(child);
            }
        }
    }

    fn distance(&self, node: usize) -> f32 {
        let b = self.bvh.nodes[node].aabb();
        (b.min - self.p).max(self.p - b.max).max(Vec3A::ZERO).length()
    }
}
