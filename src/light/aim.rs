//! Directions from one place of a light toward what photons should reach.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::emission_target::TargetSphere;
use super::ground::Ground;
use super::{EmissionTarget, mixture, one_minus_cos_between, one_minus_cos_by_sine};
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
    /// Whether it shines along this vector of any length.
    fn shines(&self, along: DVec3) -> bool;
}

/// A mixture of the directions to the near and to the far sphere of a [`EmissionTarget`], where those are
/// narrower than the light's own lobe, and of that lobe where not; and of the same for each of the
/// foci. Where endless ground reaches beyond the far sphere also of those to ground and the lobe.
#[derive(Debug, Clone)]
pub(super) struct Aim<'a, L> {
    reach: &'a EmissionTarget,
    from: WorldPoint,
    lobe: &'a L,
    /// Of both cones.
    axis: DVec3,
    /// In the order of a [`mixture`].
    targets: SmallVec<[Target; 4]>,
    /// 1 - cos of the cone outside which nothing is to be reached.
    limit: f64,
}

#[derive(Debug, Clone, Copy)]
enum Target {
    /// Of this 1 - cos of the half angle.
    Cone(f64),
    /// Ground round the reach's centre, at this distance in metres.
    Ground(Ground, f64),
    Lobe,
}

/// 1 - cos of the cone that holds all directions.
const ALL: f64 = 2.0;

impl<'a, L: Lobe> Aim<'a, L> {
    /// From a place `from` of a light that shines into `lobe`.
    pub(super) fn new(reach: &'a EmissionTarget, from: WorldPoint, lobe: &'a L) -> Self {
        let cone = |radius| reach.cone(from, radius);
        let target = |radius| match cone(radius) {
            Some((_, width)) if width < lobe.one_minus_cos() => Target::Cone(width),
            _ => Target::Lobe,
        };
        let near = target(reach.radius());
        let mut targets = smallvec![near];
        // Two targets of the same kind need no mixture.
        if reach.has_ring() && matches!(near, Target::Cone(_)) {
            let far = target(reach.outer());
            targets.push(far);
            if let (Some(ground), Target::Cone(_)) = (reach.ground(), far) {
                let distance = (reach.center() - from).length();
                targets.extend([Target::Ground(ground, distance), Target::Lobe]);
            }
        }
        let axis = cone(reach.radius()).map_or(DVec3::Z, |(axis, _)| axis);
        let limit = match (reach.ground(), cone(reach.outer())) {
            (None, Some((_, width))) => width,
            _ => ALL,
        };
        Self { reach, from, lobe, axis, targets, limit }
    }

    /// A direction and its density, 1/sr; nothing where the direction misses the reach.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let (focus, first) = self.reach.choose(u[0]);
        let u = [first, u[1]];
        let (direction, by_lobe) = match focus {
            Some(focus) => match self.cone_of(focus) {
                Some((axis, width)) => (toward(axis, width, u), false),
                None => (self.lobe.sample(u), true),
            },
            None => self.unfocused(u),
        };
        let missed = by_lobe && self.off_axis(direction) > self.limit;
        let mut pdf = self.unfocused_pdf(direction);
        if !self.reach.foci().is_empty() {
            let pdfs = self.reach.foci().iter().map(|f| f.weight * self.focus_pdf(f, direction));
            pdf = 0.5 * (pdf + pdfs.sum::<f64>());
        }
        (!missed && pdf > 0.0).then_some((direction, pdf))
    }

    /// A direction to one of the targets, and whether the lobe made it.
    fn unfocused(&self, u: [f64; 2]) -> (DVec3, bool) {
        let (index, first) = mixture::pick(u[0], self.targets.len());
        let u = [first, u[1]];
        match self.targets[index] {
            Target::Cone(width) => (toward(self.axis, width, u), false),
            Target::Ground(ground, distance) => {
                let aside = ground.sample(u).extend(distance);
                (Frame::around(self.axis).to_world(aside).normalize(), false)
            }
            Target::Lobe => (self.lobe.sample(u), true),
        }
    }

    fn unfocused_pdf(&self, direction: DVec3) -> f64 {
        mixture::pdf(&self.targets, |target| self.target_pdf(target, direction))
    }

    /// Whether the cone round a focus, in this direction from the light, is worth aiming at.
    fn has_cone(&self, focus: &TargetSphere, toward: DVec3) -> bool {
        let (radius2, distance2) = (focus.radius * focus.radius, toward.length_squared());
        let width = self.lobe.one_minus_cos().min(1.0);
        // As an inequality of sines: cheap, since it is asked for each focus of each photon.
        radius2 < distance2 * (width * (2.0 - width)) && self.lobe.shines(toward)
    }

    /// The cone round a focus, where it is worth aiming at.
    fn cone_of(&self, focus: &TargetSphere) -> Option<(DVec3, f64)> {
        let toward = focus.center - self.from;
        self.has_cone(focus, toward).then(|| {
            let distance = toward.length();
            (toward / distance, one_minus_cos_by_sine(focus.radius / distance))
        })
    }

    fn focus_pdf(&self, focus: &TargetSphere, direction: DVec3) -> f64 {
        let toward = focus.center - self.from;
        if !self.has_cone(focus, toward) {
            return self.lobe.pdf(direction);
        }
        // Most foci lie aside.
        let along = toward.dot(direction);
        let aside2 = toward.length_squared() - along * along;
        if along < 0.0 || aside2 > 1.01 * focus.radius * focus.radius + 1e-9 * along * along {
            return 0.0;
        }
        match self.cone_of(focus) {
            Some((axis, width)) if one_minus_cos_between(axis, direction) <= width => {
                warp::uniform_cone_pdf(width)
            }
            _ => 0.0,
        }
    }

    fn target_pdf(&self, target: Target, direction: DVec3) -> f64 {
        match target {
            Target::Cone(width) if self.off_axis(direction) <= width => {
                warp::uniform_cone_pdf(width)
            }
            Target::Cone(_) => 0.0,
            Target::Ground(ground, distance) => {
                let cosine = self.axis.dot(direction);
                if cosine <= 0.0 {
                    return 0.0;
                }
                // Where the direction meets the plane across the axis at the reach's centre.
                let r2 = self.axis.cross(direction).length_squared() * (distance / cosine).powi(2);
                ground.pdf(r2) * distance * distance / cosine.powi(3)
            }
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

/// A unit direction in the cone of this width (1 - cos of the half angle) round the unit `axis`.
fn toward(axis: DVec3, width: f64, u: [f64; 2]) -> DVec3 {
    Frame::around(axis).to_world(warp::uniform_cone(u, width)).normalize()
}
