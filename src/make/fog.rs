//! Fog that lies on the ground in drifting banks.

use glam::{DVec2, DVec3};

use super::noise::{Turbulence, octaves, smoothstep};

/// Height of the layer's box, in units of the longest side.
pub(super) const HEIGHT: f64 = 0.16;

/// A layer of fog over a square of ground.
pub(super) struct Fog {
    banks: Turbulence,
    drift: Turbulence,
    resolution: f64,
}

impl Fog {
    /// The fog that `seed` gives, with detail for `resolution` voxels per unit.
    pub(super) fn new(seed: u64, resolution: f64) -> Self {
        Self { banks: Turbulence::new(seed, 0), drift: Turbulence::new(seed, 1), resolution }
    }

    /// Density in [0, 1] at `p`.
    pub(super) fn density(&self, p: DVec3) -> f64 {
        if p.y < 0.0 {
            return 0.0;
        }
        // A light wind along x draws the banks out.
        let q = p * DVec3::new(3.2, 9.0, 6.0);
        let q = self.drift.advected(q, DVec3::splat(0.5), 0.6, 2);
        let q = self.drift.advected(q, DVec3::splat(1.3), 0.25, 2);
        let detail = octaves(self.resolution / 6.0, 5.0);
        let ground = DVec3::new(q.x, 0.0, q.z);
        let banks = smoothstep(-0.35, 0.45, self.banks.fbm(ground * 0.8, 3.0));
        let patches = smoothstep(-0.4, 0.5, self.banks.fbm(q * 1.1 + 5.0, detail));
        let depth = HEIGHT * (0.1 + 0.28 * banks);
        let falling = (-p.y / depth).exp() - (-HEIGHT / depth).exp();
        let out = DVec2::new(p.x, p.z).length() + 0.12 * self.banks.fbm(q * 0.7 + 2.0, 3.0);
        let rim = smoothstep(0.49, 0.3, out);
        falling * rim * (0.12 + 0.88 * banks) * (0.3 + 0.7 * patches)
    }
}
