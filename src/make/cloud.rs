//! A cumulus: a heap of bubbles on a flat base.

use glam::DVec3;

use super::noise::{Turbulence, octaves, smoothstep};
use crate::math::{Stage, Stream};

/// Height of the condensation level, where the base is cut flat.
const BASE: f64 = 0.05;

/// A fair-weather cumulus.
pub(super) struct Cloud {
    bubbles: Vec<(DVec3, f64)>,
    drift: Turbulence,
    lumps: Turbulence,
    resolution: f64,
}

impl Cloud {
    /// The cloud that `seed` gives, with detail for `resolution` voxels per unit.
    pub(super) fn new(seed: u64, resolution: f64) -> Self {
        Self {
            bubbles: bubbles(seed),
            drift: Turbulence::new(seed, 1),
            lumps: Turbulence::new(seed, 2),
            resolution,
        }
    }

    /// Water content in [0, 1] at `p`.
    pub(super) fn density(&self, p: DVec3) -> f64 {
        if self.depth(p) < -0.14 {
            return 0.0;
        }
        let p = self.drift.advected(p, DVec3::splat(5.0), 0.018, 1);
        let p = self.drift.advected(p, DVec3::splat(13.0), 0.005, 1);
        // Air rises in bubbles: the tops bulge, the base stays level.
        let growth = smoothstep(BASE, BASE + 0.16, p.y);
        let coarse = self.lumps.billow(p * 7.0, octaves(self.resolution / 7.0, 5.0));
        let fine = self.lumps.fbm(p * 40.0 + 3.0, octaves(self.resolution / 40.0, 2.0));
        let surface = self.depth(p) + (0.2 * coarse - 0.055) * growth + 0.006 * fine;
        let level = BASE + 0.012 * self.drift.fbm(p * 6.0 + 9.0, 3.0);
        let core = smoothstep(0.0, 0.035, surface);
        let floor = smoothstep(level - 0.012, level + 0.025, p.y);
        let wet = 0.55 + 0.45 * smoothstep(BASE, 0.45, p.y);
        core * floor * wet
    }

    /// Distance inside the heap of bubbles, negative outside, rounded where bubbles meet.
    fn depth(&self, p: DVec3) -> f64 {
        const SOFT: f64 = 0.012;
        let sum: f64 = self
            .bubbles
            .iter()
            .map(|&(center, radius)| ((radius - center.distance(p)) / SOFT).min(60.0).exp())
            .sum();
        if sum > 0.0 { SOFT * sum.ln() } else { -1.0 }
    }
}

/// Bubbles in a heap: wide and low ones side by side, smaller ones on their shoulders.
fn bubbles(seed: u64) -> Vec<(DVec3, f64)> {
    let mut stream = Stream::new(seed, Stage::Content, 0, 0);
    let mut between = |low: f64, high: f64| low + (high - low) * stream.uniform();
    let mut bubbles: Vec<(DVec3, f64)> = Vec::new();
    for i in 0..9 {
        let angle = f64::from(i) * 2.4 + between(-0.3, 0.3); // the golden angle
        let out = (f64::from(i) / 9.0).sqrt();
        let radius = between(0.085, 0.105) + 0.07 * (1.0 - out);
        let rise = 0.6 * radius + between(0.0, 0.12) * (1.0 - out);
        let center = DVec3::new(0.3 * out * angle.cos(), BASE + rise, 0.2 * out * angle.sin());
        bubbles.push((center, radius));
    }
    for parent in 0..bubbles.len() {
        let (center, radius) = bubbles[parent];
        for _ in 0..6 {
            let angle = between(0.0, std::f64::consts::TAU);
            let up = between(0.0, 1.0);
            let level = (1.0 - up * up).sqrt();
            let toward = DVec3::new(level * angle.cos(), up, level * angle.sin());
            let size = radius * between(0.38, 0.62);
            bubbles.push((center + toward * radius * between(0.75, 0.95), size));
        }
    }
    bubbles
}
