//! How the values of a grid go with the smoke.

use glam::DVec3;

use crate::math::{IndexPoint, WorldPoint};
use crate::vdb::{Grid, Voxel, VoxelBox};

/// Places in smoke that are looked at, about.
const SAMPLES: f64 = 65536.0;
/// Density below this share of the largest is no smoke.
const THIN: f64 = 0.01;
/// Places along each edge of a constant block.
const PER_EDGE: u32 = 4;

/// A place in smoke.
#[derive(Debug, Clone, Copy)]
struct Sample {
    at: WorldPoint,
    density: f64,
    /// Voxels for which it stands.
    weight: f64,
}

/// Places evenly spread over the voxels whose density is at least [`THIN`] of the largest.
#[derive(Debug)]
pub(super) struct Smoke(Vec<Sample>);

/// How a scalar goes with the density over the smoke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Overlap {
    /// Mean of the scalar.
    pub(super) mean: f64,
    /// Its standard deviation.
    pub(super) deviation: f64,
    /// The share of its variance that a linear function of the density explains (R²); 0 where either
    /// is constant.
    pub(super) explained: f64,
}

impl Smoke {
    pub(super) fn sampled(density: &Grid<f32>) -> Self {
        let threshold = THIN * f64::from(density.max_value());
        let is_smoke = |b: &VoxelBox| f64::from(b.value) >= threshold && b.value > 0.0;
        let mut voxels = 0u64;
        density.for_each_nonzero(|b| {
            if is_smoke(&b) && b.min == b.max {
                voxels += 1;
            }
        });
        // Odd, so that no plane of voxels is left out where planes have even numbers of them.
        let stride = (voxels as f64 / SAMPLES) as u64 | 1;
        let mut samples = Vec::new();
        let mut number = 0u64;
        let mut add = |p: DVec3, density_there: f32, weight: f64| {
            let at = density.transform().point_to_world(IndexPoint::from_xyz(p));
            samples.push(Sample { at, density: f64::from(density_there), weight });
        };
        density.for_each_nonzero(|b| {
            if !is_smoke(&b) {
                return;
            }
            if b.min == b.max {
                if number.is_multiple_of(stride) {
                    add(b.min.as_dvec3(), b.value, stride as f64);
                }
                number += 1;
                return;
            }
            let size = (b.max - b.min + 1).as_dvec3();
            let weight = size.element_product() / f64::from(PER_EDGE.pow(3));
            for i in 0..PER_EDGE.pow(3) {
                let [x, y, z] = [i / PER_EDGE.pow(2), i / PER_EDGE % PER_EDGE, i % PER_EDGE];
                let share = (DVec3::new(x.into(), y.into(), z.into()) + 0.5) / f64::from(PER_EDGE);
                add((b.min.as_dvec3() + share * size - 0.5).round(), b.value, weight);
            }
        });
        Self(samples)
    }

    /// How `grid` goes with the smoke; nothing where there is no smoke.
    pub(super) fn overlap(&self, grid: &Grid<f32>) -> Option<Overlap> {
        let values = self.values(grid).filter(|(_, value, _)| value.is_finite());
        let values: Vec<(f64, f64, f64)> = values.collect();
        let weight: f64 = values.iter().map(|(.., w)| w).sum();
        if weight <= 0.0 {
            return None;
        }
        let mean = |of: &dyn Fn(&(f64, f64, f64)) -> f64| {
            values.iter().map(|sample| sample.2 * of(sample)).sum::<f64>() / weight
        };
        let (density, value) = (mean(&|s| s.0), mean(&|s| s.1));
        let variance_of_density = mean(&|s| (s.0 - density).powi(2));
        let variance = mean(&|s| (s.1 - value).powi(2));
        let covariance = mean(&|s| (s.0 - density) * (s.1 - value));
        let both = variance_of_density * variance;
        let explained = if both > 0.0 { covariance.powi(2) / both } else { 0.0 };
        Some(Overlap { mean: value, deviation: variance.sqrt(), explained })
    }

    /// Mean velocity of the smoke, weighted by density, and its mean speed.
    pub(super) fn motion(&self, velocity: &Grid<[f32; 3]>) -> Option<(DVec3, f64)> {
        let (mut mean, mut speed, mut mass) = (DVec3::ZERO, 0.0, 0.0);
        for (density, v, weight) in self.values(velocity) {
            let v = DVec3::from(v);
            if v.is_finite() {
                mean += density * weight * v;
                speed += density * weight * v.length();
                mass += density * weight;
            }
        }
        (mass > 0.0).then(|| (mean / mass, speed / mass))
    }

    /// Density, value of `grid` and weight of each place.
    fn values<V: Voxel>(&self, grid: &Grid<V>) -> impl Iterator<Item = (f64, V::Sample, f64)> {
        let value = |at: WorldPoint| grid.value(grid.transform().point_to_local(at));
        self.0.iter().map(move |s| (s.density, value(s.at), s.weight))
    }
}
