//! One test of any sampler of directions against its density: Pearson's chi-square over cells of
//! the sphere (the idea of Mitsuba's `chi2.py`).

use std::f64::consts::TAU;

use fogbow::math::{Frame, Stage, Stream};
use glam::DVec3;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// How often a right sampler fails the test. With a fixed seed it then fails always or never.
pub(crate) const FALSE_ALARM: f64 = 1e-4;

/// Cells over the cap within `one_minus_cos` of `axis`, and one more for everything else.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chi2 {
    /// Middle of the cap.
    pub(crate) axis: DVec3,
    /// 1 - cos of the cap's half angle; 2 for the whole sphere.
    pub(crate) one_minus_cos: f64,
    /// Rings end at the cap's 1 - cos times (i / rings) to this power: above 1 for lobes that are
    /// narrow round the axis.
    pub(crate) crowding: i32,
    /// Directions drawn.
    pub(crate) samples: u64,
    /// Whether the density is the same all round the axis: one spoke then tells of all.
    pub(crate) is_symmetric: bool,
}

impl Default for Chi2 {
    fn default() -> Self {
        Self {
            axis: DVec3::Y,
            one_minus_cos: 2.0,
            crowding: 1,
            samples: 100_000,
            is_symmetric: false,
        }
    }
}

const RINGS: usize = 20;
const SPOKES: usize = 24;
/// Points a side of the midpoint rule that integrates the density over a cell.
const POINTS: usize = 64;

impl Chi2 {
    /// Fails unless directions from `sample` are spread as `pdf` (1/sr) says. Draws that give
    /// nothing count as everything else, outside the cap.
    pub(crate) fn check(
        &self,
        name: &str,
        sample: impl Fn(&mut Stream) -> Option<DVec3>,
        pdf: impl Fn(DVec3) -> f64,
    ) {
        let frame = Frame::around(self.axis);
        let counts = self.counts(&frame, sample);
        let expected = self.expected(&frame, pdf);
        let (mut statistic, mut cells) = (0.0, 0u32);
        let mut pool = (0.0, 0.0);
        for (count, mean) in counts.iter().zip(&expected) {
            // Pearson's statistic wants cells that are not too empty.
            pool = (pool.0 + count, pool.1 + mean);
            if pool.1 >= 10.0 {
                statistic += (pool.0 - pool.1) * (pool.0 - pool.1) / pool.1;
                cells += 1;
                pool = (0.0, 0.0);
            }
        }
        assert!(
            pool.0 <= pool.1 + 8.0 * pool.1.max(1.0).sqrt(),
            "{name}: {} directions where {} were expected",
            pool.0,
            pool.1
        );
        let freedom = f64::from(cells.max(2) - 1);
        let p = ChiSquared::new(freedom).expect("degrees of freedom are positive").sf(statistic);
        assert!(p > FALSE_ALARM, "{name}: chi-square {statistic:.1} of {freedom}, p {p:.2e}");
    }

    fn counts(&self, frame: &Frame, sample: impl Fn(&mut Stream) -> Option<DVec3>) -> Vec<f64> {
        let mut counts = vec![0.0; RINGS * SPOKES + 1];
        let mut stream = Stream::new(1, Stage::Test, 0, 0);
        for _ in 0..self.samples {
            let direction = sample(&mut stream);
            counts[direction.map_or(RINGS * SPOKES, |d| self.cell(frame, d))] += 1.0;
        }
        counts
    }

    fn cell(&self, frame: &Frame, direction: DVec3) -> usize {
        assert!((direction.length() - 1.0).abs() < 1e-9, "{direction} is not a unit vector");
        let place = 0.5 * (direction - frame.z).length_squared() / self.one_minus_cos;
        if place > 1.0 + 1e-9 {
            return RINGS * SPOKES;
        }
        let local = frame.to_local(direction);
        let ring = place.powf(1.0 / f64::from(self.crowding)) * RINGS as f64;
        let spoke = (local.y.atan2(local.x) / TAU).rem_euclid(1.0) * SPOKES as f64;
        (ring as usize).min(RINGS - 1) * SPOKES + (spoke as usize).min(SPOKES - 1)
    }

    fn expected(&self, frame: &Frame, pdf: impl Fn(DVec3) -> f64) -> Vec<f64> {
        let across = if self.is_symmetric { 1 } else { POINTS };
        let integral = |ring: usize, spoke: usize| {
            let mut sum = 0.0;
            for i in 0..POINTS {
                let x = (ring as f64 + (i as f64 + 0.5) / POINTS as f64) / RINGS as f64;
                let drop = self.one_minus_cos * x.powi(self.crowding);
                let stretch =
                    self.one_minus_cos * f64::from(self.crowding) * x.powi(self.crowding - 1)
                        / (RINGS * POINTS) as f64;
                let sin = (drop * (2.0 - drop)).max(0.0).sqrt();
                for j in 0..across {
                    let turn = spoke as f64 + (j as f64 + 0.5) / across as f64;
                    let phi = TAU * turn / SPOKES as f64;
                    let local = DVec3::new(sin * phi.cos(), sin * phi.sin(), 1.0 - drop);
                    sum += pdf(frame.to_world(local).normalize()) * stretch;
                }
            }
            sum * TAU / (SPOKES * across) as f64 * self.samples as f64
        };
        let spokes = if self.is_symmetric { 1 } else { SPOKES };
        let mut cells: Vec<f64> = (0..RINGS)
            .flat_map(|ring| {
                let ring: Vec<f64> = (0..spokes).map(|spoke| integral(ring, spoke)).collect();
                ring.into_iter().cycle().take(SPOKES)
            })
            .collect();
        let inside: f64 = cells.iter().sum();
        cells.push((self.samples as f64 - inside).max(0.0));
        cells
    }
}
