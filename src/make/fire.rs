//! A campfire: tongues of flame under their own smoke.

use glam::{DVec2, DVec3};

use super::noise::{Turbulence, octaves, smoothstep};
use super::plume::Plume;
use crate::math::{Stage, Stream};

/// A fire on the ground.
pub(super) struct Fire {
    tongues: Vec<Tongue>,
    flicker: Turbulence,
    shreds: Turbulence,
    smoke: Plume,
    resolution: f64,
}

/// One tongue of flame: a cone that leans toward the middle and sways.
struct Tongue {
    foot: DVec2,
    radius: f64,
    height: f64,
    phase: f64,
}

impl Fire {
    /// The fire that `seed` gives, with detail for `resolution` voxels per unit.
    pub(super) fn new(seed: u64, resolution: f64) -> Self {
        Self {
            tongues: tongues(seed),
            flicker: Turbulence::new(seed, 1),
            shreds: Turbulence::new(seed, 2),
            smoke: Plume::above_fire(seed, resolution),
            resolution,
        }
    }

    /// Density of soot and smoke, and temperature, both in [0, 1], at `p`.
    pub(super) fn density_and_temperature(&self, p: DVec3) -> [f64; 2] {
        let heat = self.heat(p);
        [0.2 * smoothstep(0.25, 0.8, heat) + self.smoke.density(p), heat]
    }

    fn heat(&self, p: DVec3) -> f64 {
        if p.y < 0.0 || p.y > 0.75 || DVec2::new(p.x, p.z).length() > 0.3 {
            return 0.0;
        }
        // The gas accelerates upward: eddies are drawn out, and stir more the higher they are.
        let stir = smoothstep(0.0, 0.35, p.y);
        let licks = self.flicker.advected(p, DVec3::new(5.0, 2.5, 5.0), 0.05 * stir, 3);
        let q = self.flicker.advected(licks, DVec3::new(12.0, 6.0, 12.0), 0.006 * stir, 2);
        let inside = self.tongues.iter().map(|t| t.depth(q)).fold(-1.0, f64::max);
        let detail = octaves(self.resolution / 24.0, 4.0);
        let shreds = self.shreds.ridged(q * DVec3::new(12.0, 4.0, 12.0), detail);
        let torn = inside - (1.0 - shreds) * (0.12 + 0.5 * stir);
        let core = smoothstep(-0.02, 0.85, torn).powf(0.6);
        let cooling = 1.0 - 0.3 * smoothstep(0.05, 0.6, p.y);
        core * cooling * smoothstep(-0.01, 0.05, p.y)
    }
}

impl Tongue {
    /// 1 on the axis, 0 on the surface, negative outside.
    fn depth(&self, p: DVec3) -> f64 {
        let up = p.y / self.height;
        if up >= 1.0 {
            return -1.0;
        }
        let lean = self.foot * (1.0 - 0.45 * smoothstep(0.0, 0.9, up));
        let (sin, cos) = (self.phase + 4.5 * up).sin_cos();
        let axis = lean + DVec2::new(sin, cos) * (0.05 * up);
        // Narrow foot, belly at a quarter of the height, long tip.
        let width = self.radius * (1.0 - up).powf(0.9) * (0.55 + 0.75 * smoothstep(0.0, 0.25, up));
        1.0 - DVec2::new(p.x, p.z).distance(axis) / width.max(1e-6)
    }
}

fn tongues(seed: u64) -> Vec<Tongue> {
    let mut stream = Stream::new(seed, Stage::Content, 0, 0);
    let mut between = |low: f64, high: f64| low + (high - low) * stream.uniform();
    (0..8)
        .map(|i| {
            let out = 0.085 * (f64::from(i) / 8.0).sqrt();
            let angle = f64::from(i) * 2.4 + between(-0.4, 0.4); // the golden angle
            Tongue {
                foot: DVec2::new(angle.cos(), angle.sin()) * out,
                radius: between(0.038, 0.058),
                height: between(0.4, 0.68) - 2.0 * out,
                phase: between(0.0, std::f64::consts::TAU),
            }
        })
        .collect()
}
