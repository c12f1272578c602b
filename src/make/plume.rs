//! A rising plume of smoke.

use glam::{DVec2, DVec3};

use super::noise::{Turbulence, octaves, smoothstep};

/// A plume above a round source.
///
/// All is computed in the plume's own space, where lengths are counted in its local radius: the
/// radius grows in proportion to the height above a virtual origin, and so do the eddies.
pub(super) struct Plume {
    /// Where it starts, in units of the longest side.
    base: DVec3,
    /// Radius at the base.
    source: f64,
    /// Growth of the radius per height.
    spread: f64,
    /// Height above the base at which it has dissolved.
    height: f64,
    /// Distance over which it turns from smooth to turbulent, in radii.
    calm: f64,
    /// Distance over which it thickens at its base, in radii.
    onset: f64,
    /// Voxels per unit.
    resolution: f64,
    meander: Turbulence,
    eddies: Turbulence,
    wisps: Turbulence,
}

impl Plume {
    /// The plume of a smoke source on the ground.
    pub(super) fn on_ground(seed: u64, resolution: f64) -> Self {
        Self {
            base: DVec3::ZERO,
            source: 0.035,
            spread: 0.12,
            height: 1.0,
            calm: 5.0,
            onset: 0.3,
            resolution,
            meander: Turbulence::new(seed, 0),
            eddies: Turbulence::new(seed, 1),
            wisps: Turbulence::new(seed, 2),
        }
    }

    /// The smoke over a fire.
    pub(super) fn above_fire(seed: u64, resolution: f64) -> Self {
        Self {
            base: DVec3::new(0.0, 0.3, 0.0),
            source: 0.06,
            spread: 0.13,
            height: 0.7,
            calm: 2.0,
            onset: 3.0,
            ..Self::on_ground(seed.wrapping_add(1), resolution)
        }
    }

    /// Density in [0, 1] at `p`.
    pub(super) fn density(&self, p: DVec3) -> f64 {
        let h = p.y - self.base.y;
        if h <= 0.0 || h >= self.height {
            return 0.0;
        }
        let radius = self.source + self.spread * h;
        // Height in local radii: the integral of dh / radius.
        let s = (radius / self.source).ln() / self.spread;
        let wild = smoothstep(0.0, self.calm, s);
        let sway = self.sway(s) * wild * radius;
        let across = DVec2::new(p.x - self.base.x - sway.x, p.z - self.base.z - sway.y) / radius;
        if across.length_squared() > 7.0 {
            return 0.0;
        }
        let q = self.advected(DVec3::new(across.x, s, across.y), wild);
        let detail = octaves(0.7 * radius * self.resolution, 5.0);
        let lumps = self.wisps.billow(q * 0.9, detail);
        let edge = 1.0 - DVec2::new(q.x, q.z).length() + (1.5 * lumps - 0.5) * wild;
        let body = smoothstep(0.0, 0.45, edge);
        if body <= 0.0 {
            return 0.0;
        }
        let threads = self.wisps.ridged(q * DVec3::new(1.1, 0.6, 1.1) + 31.0, detail);
        let texture = 1.0 + (smoothstep(0.25, 0.8, threads) * 1.25 - 0.9) * wild;
        let thinning = (self.source / radius).powf(0.8);
        let ragged = h / self.height + 0.12 * self.meander.fbm(q * 0.5 + 7.0, 2.0);
        let ends = smoothstep(0.0, self.onset, s) * smoothstep(0.98, 0.6, ragged);
        let box_side = smoothstep(0.272, 0.24, p.x.abs().max(p.z.abs()));
        body * texture * thinning * ends * box_side * smoothstep(1.0, 0.97, h / self.height)
    }

    /// How far the axis has wandered at height `s`, in radii.
    fn sway(&self, s: f64) -> DVec2 {
        let wander = |line: f64| self.meander.fbm(DVec3::new(line, 0.16 * s, 0.4), 2.0);
        DVec2::new(wander(0.3), wander(9.6)) * 1.1
    }

    /// Where the smoke at `q` came from: traced back through eddies, the large ones first.
    fn advected(&self, q: DVec3, wild: f64) -> DVec3 {
        [(0.35, 0.6, 3), (0.9, 0.26, 3), (2.2, 0.07, 2)].into_iter().fold(
            q,
            |q, (frequency, reach, steps)| {
                self.eddies.advected(q, DVec3::splat(frequency), reach * wild, steps)
            },
        )
    }
}
