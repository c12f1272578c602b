//! Directions from one place of a light toward what photons should reach.

use glam::DVec3;

use super::{Reach, one_minus_cos_between};
use crate::math::{Frame, WorldPoint, warp};

/// A light's own distribution of directions from one place.
pub(super) trait Lobe {
    /// A unit direction.
    fn sample(&self, u: [f64; 2]) -> DVec3;
    /// Its density, 1/sr.
    fn pdf(&self, direction: DVec3) -> f64;
    /// 1 - cos of the half angle of a cone about as wide as the lobe: only cones narrower than
    /// that are worth aiming at.
    fn one_minus_cos(&self) -> f64;
}

/// A mixture of the directions to the near and to the far sphere of a [`Reach`], where those are
/// narrower than the light's own lobe, and of that lobe where not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim<'a, L> {
    lobe: &'a L,
    /// Axis of both cones.
    axis: DVec3,
    near: Target,
    /// Where there is ground: takes half of the photons.
    far: Option<Target>,
    /// 1 - cos of the cone outside which nothing is to be reached.
    limit: f64,
}

#[derive(Debug, Clone, Copy)]
enum Target {
    Cone(f64),
    Lobe,
}

/// 1 - cos of the cone that holds all directions.
const ALL: f64 = 2.0;

impl<'a, L: Lobe> Aim<'a, L> {
    /// From a place `from` of a light that shines into `lobe`.
    pub(super) fn new(reach: &Reach, from: WorldPoint, lobe: &'a L) -> Self {
        let cone = |radius| reach.cone(from, radius);
        let target = |radius| match cone(radius) {
            Some((_, width)) if width < lobe.one_minus_cos() => Target::Cone(width),
            _ => Target::Lobe,
        };
        let near = target(reach.radius());
        // Two targets of the same kind need no mixture.
        let far =
            (reach.has_ground() && matches!(near, Target::Cone(_))).then(|| target(reach.outer()));
        let axis = cone(reach.radius()).map_or(DVec3::Z, |(axis, _)| axis);
        Self { lobe, axis, near, far, limit: cone(reach.outer()).map_or(ALL, |(_, width)| width) }
    }

    /// A direction and its density, 1/sr; nothing where the direction misses the reach.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let (target, u) = match self.far {
            Some(far) if u[0] >= 0.5 => (far, [2.0 * u[0] - 1.0, u[1]]),
            Some(_) => (self.near, [2.0 * u[0], u[1]]),
            None => (self.near, u),
        };
        let direction = match target {
            Target::Cone(width) => {
                Frame::around(self.axis).to_world(warp::uniform_cone(u, width)).normalize()
            }
            Target::Lobe => self.lobe.sample(u),
        };
        let missed = matches!(target, Target::Lobe) && self.off_axis(direction) > self.limit;
        let pdf = match self.far {
            // Without a mixture the density need not look where the direction went.
            None => match self.near {
                Target::Cone(width) => warp::uniform_cone_pdf(width),
                Target::Lobe => self.lobe.pdf(direction),
            },
            Some(far) => {
                0.5 * (self.target_pdf(self.near, direction) + self.target_pdf(far, direction))
            }
        };
        (!missed && pdf > 0.0).then_some((direction, pdf))
    }

    fn target_pdf(&self, target: Target, direction: DVec3) -> f64 {
        match target {
            Target::Cone(width) if self.off_axis(direction) <= width => {
                warp::uniform_cone_pdf(width)
            }
            Target::Cone(_) => 0.0,
            Target::Lobe => self.lobe.pdf(direction),
        }
    }

    fn off_axis(&self, direction: DVec3) -> f64 {
        one_minus_cos_between(self.axis, direction)
    }

    /// About the share of the light's power that the reach can receive.
    pub(super) fn share(&self) -> f64 {
        (self.limit / self.lobe.one_minus_cos()).min(1.0)
    }
}
