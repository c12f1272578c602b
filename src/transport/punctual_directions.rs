//! Directions near those to punctual lights, for phase functions with sharp forward peaks.

use std::f64::consts::PI;

use glam::DVec3;
use smallvec::SmallVec;

use crate::light::Lights;
use crate::math::{Frame, WorldPoint};

use super::equiangular_lights::MAX_SAMPLED;

/// Angle in radians below which the density levels off: about the width of the forward peak of
/// droplets in fog.
///
/// Unit: rad. Derivation: wavelength over circumference of a droplet of 10 µm in radius, 0.55 µm / 63
/// µm, to one digit.
const PEAK: f64 = 0.01;

/// A distribution of directions at one point that is dense near those to punctual lights: per
/// solid angle about as one over the squared angle. Light that a forward peak scatters once more comes
/// from there, and neither phase functions nor surfaces sample it.
#[derive(Debug)]
pub struct PunctualDirections {
    /// Unit directions to the lights.
    axes: SmallVec<[DVec3; MAX_SAMPLED]>,
}

impl PunctualDirections {
    /// The distribution at `from` for the punctual lights of `lights`.
    pub fn new(lights: &Lights, from: WorldPoint) -> Self {
        let axis = |position: WorldPoint| (position - from).try_normalize();
        Self { axes: lights.lights.iter().filter_map(|l| axis(l.position()?)).collect() }
    }

    /// A unit direction and its density, 1/sr, near a light that `choice` chooses; `None` without
    /// lights, or where the density is not finite.
    pub fn sample(&self, choice: f64, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let index = (choice * self.axes.len() as f64) as usize;
        let axis = *self.axes.get(index)?;
        let angle = PEAK * ((1.0 + PI / PEAK).powf(u[0]) - 1.0);
        let around = 2.0 * PI * u[1];
        let local = DVec3::new(angle.sin() * around.cos(), angle.sin() * around.sin(), angle.cos());
        let direction = Frame::around(axis).to_world(local).normalize();
        let pdf = self.pdf(direction);
        (pdf.is_finite() && pdf > 0.0).then_some((direction, pdf))
    }

    /// Density of [`sample`](Self::sample) for a unit direction, 1/sr; infinite exactly toward a light.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let pdf = |axis: &DVec3| {
            let sine = axis.cross(direction).length();
            let angle = sine.atan2(axis.dot(direction));
            1.0 / ((angle + PEAK) * (1.0 + PI / PEAK).ln() * 2.0 * PI * sine)
        };
        self.axes.iter().map(pdf).sum::<f64>() / self.axes.len().max(1) as f64
    }

    /// Weight, by the balance heuristic (Veach 1997, section 9.2.2), of a direction that was sampled with
    /// the density `pdf`, 1/sr, against [`sample`](Self::sample).
    pub fn mis_weight(&self, direction: DVec3, pdf: f64) -> f64 {
        pdf / (pdf + self.pdf(direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};

    /// Probability that a sample lies within `angle` of a single light.
    fn within(angle: f64) -> f64 {
        (1.0 + angle / PEAK).ln() / (1.0 + PI / PEAK).ln()
    }

    /// Nine bounds of 4.5 standard errors make a false alarm of 6e-5 at this fixed seed.
    #[test]
    fn samples_have_the_closed_distribution() {
        let toward = PunctualDirections { axes: [DVec3::new(0.6, 0.0, 0.8)].into_iter().collect() };
        let mut rng = Stream::new(1, Stage::Test, 0, 0);
        let count = 100_000;
        let angles: Vec<f64> = (0..count)
            .map(|_| {
                let (direction, pdf) = toward.sample(rng.uniform(), rng.uniform2()).unwrap();
                assert_eq!(toward.pdf(direction), pdf);
                let axis = toward.axes[0];
                axis.cross(direction).length().atan2(axis.dot(direction))
            })
            .collect();
        for angle in [1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 3.0] {
            let found = angles.iter().filter(|a| **a < angle).count() as f64 / f64::from(count);
            let expected = within(angle);
            let off = (expected * (1.0 - expected) / f64::from(count)).sqrt();
            assert!((found - expected).abs() < 4.5 * off, "{found} of {expected} within {angle}");
        }
    }

    #[test]
    fn the_density_is_that_of_the_samples() {
        let toward = PunctualDirections { axes: [DVec3::Z].into_iter().collect() };
        let steps = 20_000;
        for [from, to] in [[0.0, 0.01], [0.01, 0.2], [0.2, PI]] {
            let width = (to - from) / f64::from(steps);
            let ring = |i: u32| {
                let angle = from + (f64::from(i) + 0.5) * width;
                toward.pdf(DVec3::new(angle.sin(), 0.0, angle.cos()))
                    * 2.0
                    * PI
                    * angle.sin()
                    * width
            };
            let sum: f64 = (0..steps).map(ring).sum();
            let expected = within(to) - within(from);
            assert!((sum / expected - 1.0).abs() < 1e-4, "{sum} for {expected}");
        }
        let both = PunctualDirections { axes: [DVec3::Z, DVec3::X].into_iter().collect() };
        let beside = PunctualDirections { axes: [DVec3::X].into_iter().collect() };
        let along = DVec3::new(0.3, 0.2, 0.9).normalize();
        let mean = 0.5 * (toward.pdf(along) + beside.pdf(along));
        assert!((both.pdf(along) / mean - 1.0).abs() < 1e-12);
        assert!(PunctualDirections { axes: SmallVec::new() }.sample(0.5, [0.5; 2]).is_none());
    }
}
