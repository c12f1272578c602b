//! Where photons from lights are aimed.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::ground::{Ground, SLACK};
use super::{checked_place, mixture, one_minus_cos_by_sine};
use crate::math::{Frame, WorldPoint, warp};

/// The part of the world that photons are emitted toward: a sphere round what the camera sees of media,
/// and round that a larger one with the same centre. Half of the photons go to each; an infinite ground
/// plane takes part of the latter's. Where there are foci, half of all go to those (emission by
/// importance, Peter and Pietrek 1998, "Importance Driven Construction of Photon Maps", with balls in
/// place of an importance map). All densities are mixtures, so that any place gets photons.
#[derive(Debug, Clone, PartialEq)]
pub struct EmissionTarget {
    center: WorldPoint,
    radius: f64,
    outer: f64,
    /// The infinite ground plane, where there is one.
    ground: Option<Ground>,
    foci: Vec<TargetSphere>,
    /// Running sum of the foci's weights, ending at 1.
    cdf: Vec<f64>,
}

/// A focus of an [`EmissionTarget`]: a ball in its smaller sphere that gets more photons, or the image
/// of one in a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetSphere {
    /// Its centre.
    pub center: WorldPoint,
    /// Its radius, in metres.
    pub radius: f64,
    /// Its share of the photons, relative to other foci.
    pub weight: f64,
}

/// Part of a [`EmissionTarget`], seen along the direction of light from far away.
#[derive(Debug, Clone, Copy)]
enum Target {
    /// The disk that the smaller sphere covers.
    Near,
    /// The ring between that and the disk of the larger sphere.
    Ring,
    /// Infinite ground.
    Ground(Ground),
}

impl EmissionTarget {
    /// The sphere of this radius in metres.
    ///
    /// # Errors
    /// Where the centre is not finite or the radius not above 0.
    pub fn new(center: WorldPoint, radius: f64) -> Result<Self, String> {
        Self::with_ring(center, radius, radius)
    }

    /// The sphere of `radius` with a larger one of radius `outer`, both in metres.
    ///
    /// # Errors
    /// Where the centre is not finite, `radius` not above 0, or `outer` smaller or infinite.
    pub fn with_ring(center: WorldPoint, radius: f64, outer: f64) -> Result<Self, String> {
        if !(radius > 0.0 && radius <= outer && outer.is_finite()) {
            return Err(format!(
                "radii to reach are {radius} m and {outer} m: must be finite, above 0, and the \
                 second not the smaller"
            ));
        }
        let center = checked_place("centre of the reach", center)?;
        Ok(Self { center, radius, outer, ground: None, foci: Vec::new(), cdf: Vec::new() })
    }

    /// As `self`, over infinite ground from which the centre is about `height` metres away; `None` is
    /// no ground.
    #[must_use]
    pub fn over_ground(self, height: Option<f64>) -> Self {
        let ground = height.map(|height| Ground::new(height.max(self.radius)));
        Self { ground, ..self }
    }

    /// As `self`, with half of all photons for `foci`; those without weight or radius are left out.
    #[must_use]
    pub fn focused_on(mut self, foci: Vec<TargetSphere>) -> Self {
        self.foci = foci;
        self.foci.retain(|f| f.weight > 0.0 && f.radius > 0.0);
        let total: f64 = self.foci.iter().map(|f| f.weight).sum();
        self.cdf.clear();
        let mut sum = 0.0;
        for focus in &mut self.foci {
            focus.weight /= total;
            sum += focus.weight;
            self.cdf.push(sum);
        }
        self
    }

    /// The foci; their weights sum to 1.
    pub(super) fn foci(&self) -> &[TargetSphere] {
        &self.foci
    }

    /// A focus chosen by `u` in [0, 1), and `u` remapped to [0, 1).
    fn pick(&self, u: f64) -> (&TargetSphere, f64) {
        let index = self.cdf.partition_point(|&sum| sum <= u).min(self.foci.len() - 1);
        let focus = &self.foci[index];
        let below = self.cdf[index] - focus.weight;
        (focus, ((u - below) / focus.weight).clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// A focus or `None`, each with probability 1/2 where there are foci, chosen by `u` in [0, 1), and
    /// `u` remapped to [0, 1).
    pub(super) fn choose(&self, u: f64) -> (Option<&TargetSphere>, f64) {
        if self.foci.is_empty() {
            return (None, u);
        }
        if u >= 0.5 {
            return (None, 2.0 * u - 1.0);
        }
        let (focus, u) = self.pick(2.0 * u);
        (Some(focus), u)
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

    /// As `self` without the ground, for light that comes from there.
    #[must_use]
    pub fn above_ground(&self) -> Self {
        Self { ground: None, ..self.clone() }
    }

    /// The infinite ground.
    pub(super) const fn ground(&self) -> Option<Ground> {
        self.ground
    }

    /// Whether the larger sphere is larger than the smaller.
    pub(super) fn has_ring(&self) -> bool {
        self.outer > self.radius
    }

    /// Axis of the cone from `from` round the sphere of `radius` metres at the centre, and 1 - cos of
    /// its half angle; `None` where `from` lies inside.
    pub(super) fn cone(&self, from: WorldPoint, radius: f64) -> Option<(DVec3, f64)> {
        let toward = self.center - from;
        let distance = toward.length();
        (distance > radius).then(|| (toward / distance, one_minus_cos_by_sine(radius / distance)))
    }

    /// Origin, outside of the target, of a photon along the unit `direction`, and its density per area
    /// perpendicular to the direction, 1/m².
    ///
    /// Uniform over the disk that the sphere of `radius` covers or, one time in two where there
    /// is more, log-uniform in the distance from the axis from there to `outer`, or by half of those
    /// as the light of evenly lit ground comes to the centre; one time in two where there are foci,
    /// uniform over the disk that one of them covers.
    pub(super) fn start(&self, direction: DVec3, u: [f64; 2]) -> (WorldPoint, f64) {
        let (focus, first) = self.choose(u[0]);
        let u = [first, u[1]];
        let frame = Frame::around(direction);
        let offset = match focus {
            Some(focus) => {
                let center = frame.to_local(focus.center - self.center);
                center.truncate() + warp::concentric_disk(u) * focus.radius
            }
            None => self.offset(u),
        };
        let mut pdf = self.offset_pdf(offset);
        if !self.foci.is_empty() {
            let focused = self.foci.iter().map(|focus| {
                let to = frame.to_local(focus.center - self.center).truncate() - offset;
                let area = focus.radius * focus.radius;
                if to.length_squared() <= area { focus.weight / (PI * area) } else { 0.0 }
            });
            pdf = 0.5 * (pdf + focused.sum::<f64>());
        }
        let across = frame.x * offset.x + frame.y * offset.y;
        (self.center + across - direction * self.outer, pdf)
    }

    /// The parts that light from far away is aimed at, in the order of a [`mixture`].
    fn targets(&self) -> SmallVec<[Target; 3]> {
        let ring = self.has_ring().then_some(Target::Ring);
        let ground = self.ground.map(Target::Ground);
        std::iter::once(Target::Near).chain(ring).chain(ground).collect()
    }

    /// A point on the disks of both spheres or on the ground, in metres from their centre.
    fn offset(&self, u: [f64; 2]) -> DVec2 {
        let targets = self.targets();
        let (index, first) = mixture::pick(u[0], targets.len());
        let u = [first, u[1]];
        match targets[index] {
            Target::Near => warp::concentric_disk(u) * self.radius,
            Target::Ring => {
                let log_ratio = (self.outer / self.radius).ln();
                DVec2::from_angle(2.0 * PI * u[1]) * self.radius * (log_ratio * u[0]).exp()
            }
            Target::Ground(ground) => ground.sample(u),
        }
    }

    /// Density of [`offset`](Self::offset), 1/m².
    fn offset_pdf(&self, offset: DVec2) -> f64 {
        let r2 = offset.length_squared();
        let (inner, outer) = (self.radius * self.radius, self.outer * self.outer);
        mixture::pdf(&self.targets(), |target| match target {
            Target::Near if r2 <= inner => 1.0 / (PI * inner),
            Target::Ring if r2 > inner && r2 <= outer * SLACK => {
                1.0 / (PI * r2 * (outer / inner).ln())
            }
            Target::Near | Target::Ring => 0.0,
            Target::Ground(ground) => ground.pdf(r2),
        })
    }

    /// Area in m² of the disk that light from far away is emitted over.
    pub(super) fn disk_area(&self) -> f64 {
        PI * self.outer * self.outer
    }
}
