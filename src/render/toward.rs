//! Directions that lead nearly at a lamp.

use std::f64::consts::PI;

use glam::DVec3;
use smallvec::SmallVec;

use crate::light::Lights;
use crate::math::{Frame, WorldPoint};

/// Angle in radians about which directions are spread evenly: that of the forward peaks of fog.
const PEAK: f64 = 0.01;

/// Directions from one place, dense round those to lamps, in density about as one over the angle
/// squared: what a forward peak scatters of a lamp's light comes from there, and neither phase
/// functions nor surfaces know of it.
#[derive(Debug)]
pub(super) struct TowardLamps {
    /// Unit directions to the lamps.
    axes: SmallVec<[DVec3; 4]>,
}

impl TowardLamps {
    /// From the place `from` to the lamps of `lights`: those that shine from one place.
    pub fn new(lights: &Lights, from: WorldPoint) -> Self {
        let toward = |place: WorldPoint| (place - from).try_normalize();
        Self { axes: lights.lights.iter().filter_map(|l| toward(l.place()?)).collect() }
    }

    /// A unit direction and its density, 1/sr; nothing where there is no lamp, or no density.
    pub fn sample(&self, lamp: f64, u: [f64; 2]) -> Option<(DVec3, f64)> {
        let index = (lamp * self.axes.len() as f64) as usize;
        let axis = *self.axes.get(index)?;
        let angle = PEAK * ((1.0 + PI / PEAK).powf(u[0]) - 1.0);
        let around = 2.0 * PI * u[1];
        let local = DVec3::new(angle.sin() * around.cos(), angle.sin() * around.sin(), angle.cos());
        let direction = Frame::around(axis).to_world(local).normalize();
        let pdf = self.pdf(direction);
        (pdf.is_finite() && pdf > 0.0).then_some((direction, pdf))
    }

    /// Density of [`sample`](Self::sample) for a unit direction, 1/sr; infinite right at a lamp.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        let pdf = |axis: &DVec3| {
            let sine = axis.cross(direction).length();
            let angle = sine.atan2(axis.dot(direction));
            1.0 / ((angle + PEAK) * (1.0 + PI / PEAK).ln() * 2.0 * PI * sine)
        };
        self.axes.iter().map(pdf).sum::<f64>() / self.axes.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream, warp};

    /// Weighing uniform directions by the density gives one; the standard error is about .004 at
    /// this fixed seed, so that 5 of them are a false alarm of 6e-7.
    #[test]
    fn density_belongs_to_samples() {
        let axes = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8)];
        let toward = TowardLamps { axes: axes.into_iter().collect() };
        let mut rng = Stream::new(1, Stage::Test, 0, 0);
        let count = 200_000;
        let mut sum = 0.0;
        let mut near = [0.0; 2];
        for _ in 0..count {
            let (direction, pdf) = toward.sample(rng.uniform(), rng.uniform2()).unwrap();
            assert!((toward.pdf(direction) / pdf - 1.0).abs() < 1e-9);
            let close = axes.iter().any(|axis| axis.angle_between(direction) < 0.1);
            near[0] += f64::from(u8::from(close));
            // The mean of the density's inverse over samples is the sphere's area.
            sum += 1.0 / pdf;
            let direction = warp::uniform_sphere(rng.uniform2());
            let close = axes.iter().any(|axis| axis.angle_between(direction) < 0.1);
            near[1] += if close { toward.pdf(direction) * 4.0 * PI } else { 0.0 };
        }
        let count = f64::from(count);
        assert!((sum / count / (4.0 * PI) - 1.0).abs() < 0.03, "{}", sum / count);
        assert!((near[0] / near[1] - 1.0).abs() < 0.1, "{near:?}");
        assert!(TowardLamps { axes: SmallVec::new() }.sample(0.5, [0.5; 2]).is_none());
    }
}
