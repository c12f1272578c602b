//! Spheres under any affine placement.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{Foot, Object, SurfacePoint, coordinate_error};
use crate::math::{Aabb, Point, Ray, Span, Transform, World, WorldPoint};

/// The image of the unit sphere under an affine map: a sphere or an ellipsoid.
#[derive(Debug, Clone, Copy)]
pub struct Sphere {
    placement: Transform<Object>,
    bounds: Aabb<World>,
    /// Unit principal axes as columns.
    axes: DMat3,
    /// Half lengths along them, in metres.
    half: DVec3,
}

impl Sphere {
    /// The sphere round `center` with `radius`, both in metres of an object's space before
    /// `placement` takes it to the world.
    ///
    /// # Errors
    /// The problem, where a value is not finite or the radius is not positive.
    pub fn new(center: DVec3, radius: f64, placement: &DAffine3) -> Result<Self, String> {
        if !(radius > 0.0 && radius.is_finite() && center.is_finite()) {
            return Err(format!(
                "a sphere round {center} with radius {radius} is none; the radius must be \
                 positive and all numbers finite"
            ));
        }
        let sized = DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::splat(radius));
        let affine = *placement * sized;
        let placement = Transform::new(affine)
            .ok_or("the sphere is placed by a singular or infinite transform")?;
        let m = affine.matrix3;
        // The half width along a world axis is the length of that row of the linear part.
        let rows = m.transpose();
        let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let middle = affine.translation;
        let bounds = Aabb::new(Point::from_xyz(middle - reach), Point::from_xyz(middle + reach));
        let (axes, squares) = eigen(m * rows);
        let half = squares.max(DVec3::ZERO).map(f64::sqrt);
        Ok(Self { placement, bounds, axes, half })
    }

    /// Its centre.
    pub fn center(&self) -> WorldPoint {
        WorldPoint::from_xyz(self.placement.affine().translation)
    }

    /// Its half lengths along its principal axes, in metres; three equal ones are the radius.
    pub fn half_lengths(&self) -> DVec3 {
        self.half
    }

    /// The place at a point of the unit ball.
    pub(super) fn at(&self, ball: DVec3) -> WorldPoint {
        self.placement.point_to_world(Point::from_xyz(ball))
    }

    pub(super) fn bounds(&self) -> Aabb<World> {
        self.bounds
    }

    pub(super) fn volume(&self) -> f64 {
        4.0 / 3.0 * PI * self.placement.volume_scale()
    }

    pub(super) fn contains(&self, p: WorldPoint) -> bool {
        self.placement.point_to_local(p).xyz.length_squared() <= 1.0
    }

    /// The part of the ray inside; empty where it misses.
    pub(super) fn chord(&self, ray: &Ray<World>) -> Span {
        let none = Span::new(0.0, 0.0);
        let local = self.placement.ray_to_local(ray);
        let (o, d) = (local.origin.xyz, local.direction);
        let a = d.length_squared();
        let along = -o.dot(d);
        // The discriminant by the closest approach keeps its digits from afar (Haines et al. 2019,
        // "Precision Improvements for Ray/Sphere Intersection").
        let discriminant = 1.0 - (o + d * (along / a)).length_squared();
        if discriminant.is_nan() || discriminant <= 0.0 {
            return none;
        }
        let q = along + (a * discriminant).sqrt().copysign(along);
        let (t0, t1) = ((o.length_squared() - 1.0) / q, q / a);
        Span::new(t0.min(t1), t0.max(t1))
    }

    pub(super) fn intersect(&self, ray: &Ray<World>, span: Span) -> Option<f64> {
        let chord = self.chord(ray);
        let inside = |t: &f64| *t > span.start && *t < span.end;
        (!chord.is_empty()).then_some([chord.start, chord.end])?.into_iter().find(inside)
    }

    pub(super) fn surface_at(&self, p: WorldPoint) -> SurfacePoint {
        let local = self.placement.point_to_local(p).xyz.normalize_or(DVec3::Y);
        let normal = self.placement.normal_to_world(local);
        SurfacePoint {
            point: self.placement.point_to_world(Point::from_xyz(local)).xyz,
            normal,
            shading_normal: normal,
            uv: DVec2::new(
                local.x.atan2(local.z) / (2.0 * PI) + 0.5,
                local.y.clamp(-1.0, 1.0).asin() / PI + 0.5,
            ),
            error: coordinate_error(&self.bounds),
        }
    }

    pub(super) fn foot(&self, p: DVec3) -> Foot {
        let center = self.center().xyz;
        let local = self.axes.transpose() * (p - center);
        let on = closest_on_ellipsoid(self.half, local);
        let normal = (on / (self.half * self.half)).normalize_or(DVec3::X);
        Foot { point: center + self.axes * on, normal: self.axes * normal }
    }
}

/// The closest point to `p` of the ellipsoid with half lengths `half` along the axes: it solves
/// x_i = half_i² p_i / (s + half_i²) with s the largest root of sum (x_i / half_i)² = 1 (Eberly
/// 2013, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid").
fn closest_on_ellipsoid(half: DVec3, p: DVec3) -> DVec3 {
    let unit = half.max_element(); // works in units of it, against overflow
    let (squares, q) = ((half / unit) * (half / unit), p / unit);
    let shortest = squares.min_element();
    let excess = |s: f64| (half / unit * q / (squares + s)).length_squared() - 1.0;
    // The weighted point never reaches the sphere only on the medial axis: step off it.
    let axis = squares.min_position();
    if q[axis] == 0.0 && excess(-shortest * (1.0 - 1e-12)) <= 0.0 {
        let mut on = DVec3::from(std::array::from_fn::<f64, 3, _>(|i| {
            let gap = squares[i] - shortest;
            if gap > 0.0 { squares[i] * q[i] / gap } else { 0.0 }
        }));
        let rest = 1.0 - (on / (half / unit)).length_squared();
        on[axis] = shortest.sqrt() * rest.max(0.0).sqrt();
        return on * unit;
    }
    let (mut low, mut high) = (-shortest, (half / unit * q).length());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let on = squares * q / (squares + high);
    // Puts it back onto the surface against the last rounding.
    on / (on / (half / unit)).length() * unit
}

/// Eigenvectors (columns) and eigenvalues of a symmetric matrix by Jacobi rotations (Golub and Van
/// Loan 2013, section 8.5).
fn eigen(mut a: DMat3) -> (DMat3, DVec3) {
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..16 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = a.col(q)[p];
            if off == 0.0 {
                continue;
            }
            let theta = (a.col(q)[q] - a.col(p)[p]) / (2.0 * off);
            let tangent = 1f64.copysign(theta) / (theta.abs() + theta.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let mut rotation = DMat3::IDENTITY;
            rotation.col_mut(p)[p] = cosine;
            rotation.col_mut(q)[q] = cosine;
            rotation.col_mut(q)[p] = tangent * cosine;
            rotation.col_mut(p)[q] = -tangent * cosine;
            a = rotation.transpose() * a * rotation;
            vectors *= rotation;
        }
    }
    (vectors, DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z))
}
