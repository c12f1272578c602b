//! Photons on surfaces.

use glam::DVec3;

use crate::math::{Rgb, Spectrum, WorldPoint};

use super::kernel::DiskKernel;
use super::{PhotonAt, PhotonMap};

/// Photons on surfaces, each with a kernel of its own radius: the sample-point estimator of
/// Breiman, Meisel and Purcell 1977, "Variable Kernel Estimates of Multivariate Densities". It
/// conserves each photon's power, unlike an estimate from the k nearest photons.
#[derive(Debug)]
pub struct SurfaceMap<S: Spectrum = Rgb> {
    /// Photons grouped by radius, as a kd-tree is searched within one.
    classes: Vec<Class<S>>,
}

#[derive(Debug)]
struct Class<S: Spectrum> {
    kernel: DiskKernel,
    radius: f64,
    photons: PhotonMap<S>,
}

impl<S: Spectrum> Default for SurfaceMap<S> {
    fn default() -> Self {
        Self { classes: Vec::new() }
    }
}

impl<S: Spectrum> SurfaceMap<S> {
    /// The map of `photons`, relative to `origin`, with their radii in metres: those of one octave
    /// get its geometric mean.
    pub(super) fn new(origin: WorldPoint, photons: &[PhotonAt<S>], radii: &[f32]) -> Self {
        let mut sorted: Vec<(i32, u32)> =
            radii.iter().zip(0..).map(|(r, index)| (r.log2().round() as i32, index)).collect();
        sorted.sort_unstable();
        let class = |members: &[(i32, u32)]| {
            let positioned: Vec<_> =
                members.iter().map(|(_, index)| photons[*index as usize]).collect();
            let octaves = members.iter().map(|(_, i)| f64::from(radii[*i as usize].log2()));
            let radius = (octaves.sum::<f64>() / members.len() as f64).exp2();
            let photons = PhotonMap::new(origin, &positioned);
            Class { kernel: DiskKernel::new(radius), radius, photons }
        };
        Self { classes: sorted.chunk_by(|a, b| a.0 == b.0).map(class).collect() }
    }

    /// Whether it holds no photons.
    pub const fn is_empty(&self) -> bool {
        self.classes.is_empty()
    }

    /// Irradiance at `p` on the side of the unit `normal`, in the photons' unit of power a m², from
    /// those nearby that arrived on that side (Jensen 1996). `gathered` counts them.
    pub fn irradiance(&self, p: WorldPoint, normal: DVec3, gathered: &mut u64) -> S {
        let (mut sum, mut count) = (S::ZERO, 0);
        for Class { kernel, radius, photons } in &self.classes {
            photons.within(p, *radius, |photon, distance2| {
                if photon.direction().dot(normal) < 0.0 {
                    count += 1;
                    sum += photon.power() * kernel.at(distance2);
                }
            });
        }
        *gathered += count;
        sum
    }
}
