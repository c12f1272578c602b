//! What photons should reach.

use std::f64::consts::PI;

use glam::DVec3;

use super::{checked_place, one_minus_cos};
use crate::math::{Frame, WorldPoint, warp};

/// The part of the world that photons are emitted toward: a sphere round media and finite
/// surfaces, and round that a larger one, at the same centre, for the ground about them. Half the
/// photons go to each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    center: WorldPoint,
    radius: f64,
    outer: f64,
}

impl Reach {
    /// The sphere of this radius in metres.
    ///
    /// # Errors
    /// Says what would be right where the centre is not finite or the radius not above 0.
    pub fn new(center: WorldPoint, radius: f64) -> Result<Self, String> {
        Self::with_ground(center, radius, radius)
    }

    /// The sphere of `radius` with a larger one of radius `outer`, both in metres.
    ///
    /// # Errors
    /// Says what would be right where the centre is not finite, `radius` not above 0, or `outer`
    /// smaller or infinite.
    pub fn with_ground(center: WorldPoint, radius: f64, outer: f64) -> Result<Self, String> {
        if !(radius > 0.0 && radius <= outer && outer.is_finite()) {
            return Err(format!(
                "radii to reach are {radius} m and {outer} m: must be finite, above 0, and the \
                 second not the smaller"
            ));
        }
        Ok(Self { center: checked_place("centre of the reach", center)?, radius, outer })
    }

    /// The centre.
    pub const fn center(&self) -> WorldPoint {
        self.center
    }

    /// Radius in metres of the sphere round media and finite surfaces.
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// Radius in metres of the sphere that holds the ground as well.
    pub const fn outer(&self) -> f64 {
        self.outer
    }

    /// Whether the larger sphere is more than the smaller.
    pub(super) fn has_ground(&self) -> bool {
        self.outer > self.radius
    }

    /// 1 - cos of the half angle of the cone from `from` round the sphere of `radius` metres at
    /// the centre, with the axis; nothing where `from` lies inside.
    pub(super) fn cone(&self, from: WorldPoint, radius: f64) -> Option<(DVec3, f64)> {
        let toward = self.center - from;
        let distance = toward.length();
        (distance > radius)
            .then(|| (toward / distance, one_minus_cos((radius / distance).min(1.0).asin())))
    }

    /// A place outside the reach from which light along the unit `direction` comes in, and its
    /// density per area perpendicular to the direction, 1/m².
    ///
    /// Uniform over the disk that the sphere of `radius` covers or, one time in two where there
    /// is ground, log-uniform in the distance from the axis from there to `outer`.
    pub(super) fn start(&self, direction: DVec3, u: [f64; 2]) -> (WorldPoint, f64) {
        let inner_pdf = 1.0 / (PI * self.radius * self.radius);
        let (offset, pdf) = if !self.has_ground() {
            (warp::concentric_disk(u) * self.radius, inner_pdf)
        } else if u[0] < 0.5 {
            (warp::concentric_disk([2.0 * u[0], u[1]]) * self.radius, 0.5 * inner_pdf)
        } else {
            let log_ratio = (self.outer / self.radius).ln();
            let r = self.radius * (log_ratio * (2.0 * u[0] - 1.0)).exp();
            let at = glam::DVec2::from_angle(2.0 * PI * u[1]) * r;
            (at, 0.5 / (2.0 * PI * r * r * log_ratio))
        };
        let frame = Frame::around(direction);
        let across = frame.x * offset.x + frame.y * offset.y;
        (self.center + across - direction * self.outer, pdf)
    }

    /// Area in m² of the disk that light from far away is emitted over.
    pub(super) fn disk_area(&self) -> f64 {
        PI * self.outer * self.outer
    }
}
