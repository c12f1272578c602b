//! Triangles: a watertight ray test and the closest point.

use glam::DVec3;

use crate::math::{Ray, World};

/// A ray prepared for [`cross`]: sheared so that it runs along its dominant axis (Woop, Benthin and
/// Wald 2013, "Watertight Ray/Triangle Intersection", section 3).
#[derive(Debug, Clone, Copy)]
pub(super) struct ShearedRay {
    origin: DVec3,
    axes: [usize; 3],
    shear: DVec3,
}

/// Where a ray crosses a triangle's plane inside the triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct TriangleCrossing {
    pub(super) t: f64,
    /// Weights of the three corners; they sum to 1.
    pub(super) weights: [f64; 3],
    /// Whether the ray comes from the side that the normal (b - a) x (c - a) points to.
    pub(super) front: bool,
}

impl ShearedRay {
    pub(super) fn new(ray: &Ray<World>) -> Self {
        let d = ray.direction;
        let z = d.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            std::mem::swap(&mut x, &mut y); // keeps the winding
        }
        let shear = DVec3::new(d[x] / d[z], d[y] / d[z], 1.0 / d[z]);
        Self { origin: ray.origin.xyz, axes: [x, y, z], shear }
    }

    fn apply(&self, corner: DVec3) -> DVec3 {
        let p = corner - self.origin;
        let [x, y, z] = self.axes;
        DVec3::new(p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z], self.shear.z * p[z])
    }
}

/// Where `ray` crosses the triangle, at any `t`.
///
/// A ray exactly through an edge or a corner counts as if moved aside by an infinitesimal
/// (e, e²) (Edelsbrunner and Mücke 1990, "Simulation of Simplicity"): it meets exactly one triangle
/// of a fan that surrounds it, so nothing leaks and no crossing counts twice.
pub(super) fn cross(ray: &ShearedRay, corners: [DVec3; 3]) -> Option<TriangleCrossing> {
    let [a, b, c] = corners.map(|corner| ray.apply(corner));
    let edges = [(c, b), (a, c), (b, a)];
    let areas = edges.map(|(p, q)| p.x * q.y - p.y * q.x);
    let positive = |i: usize| {
        let ((p, q), area) = (edges[i], areas[i]);
        let tie = [area, p.y - q.y, q.x - p.x].into_iter().find(|s| *s != 0.0)?;
        Some(tie > 0.0)
    };
    let front = positive(0)?;
    if positive(1)? != front || positive(2)? != front {
        return None;
    }
    let whole = areas[0] + areas[1] + areas[2];
    if whole == 0.0 {
        return None;
    }
    let weights = areas.map(|area| area / whole);
    let t = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
    t.is_finite().then_some(TriangleCrossing { t, weights, front })
}

/// The point of the triangle that is closest to `p` (Ericson 2005, "Real-Time Collision
/// Detection", section 5.1.5).
pub(super) fn closest_point(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let (along, back) = (d4 - d3, d5 - d6);
    if va <= 0.0 && along >= 0.0 && back >= 0.0 {
        return b + (c - b) * (along / (along + back));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}
