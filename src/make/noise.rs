//! Noise for procedural volumes: fractal sums of gradient noise and divergence-free flow.

use glam::{DMat3, DVec3};
use noise::{NoiseFn, Perlin};

use crate::math::{Stage, Stream};

/// Turns each octave against the one before, so that the lattices' zeros never line up.
const TURN: DMat3 = DMat3::from_cols(
    DVec3::new(0.0, 0.8, 0.6),
    DVec3::new(-0.8, 0.36, -0.48),
    DVec3::new(-0.6, -0.48, 0.64),
);

/// Sums of Perlin noise with a wavelength of 1 in the first octave.
pub(super) struct Turbulence {
    first: Perlin,
    second: Perlin,
}

impl Turbulence {
    /// The turbulence that `seed` gives to the part number `part` of a volume.
    pub(super) fn new(seed: u64, part: u64) -> Self {
        let mut stream = Stream::new(seed, Stage::Content, part, 0);
        let mut perlin = || Perlin::new((stream.uniform() * f64::from(u32::MAX)) as u32);
        Self { first: perlin(), second: perlin() }
    }

    /// One octave of gradient noise in [-1, 1].
    pub(super) fn perlin(&self, p: DVec3) -> f64 {
        self.first.get(p.to_array())
    }

    /// Fractal Brownian motion in [-1, 1], mostly within half of that.
    pub(super) fn fbm(&self, p: DVec3, octaves: f64) -> f64 {
        self.sum(p, octaves, |n| n)
    }

    /// Round lumps between sharp creases, in [0, 1]: the sum of |noise|.
    pub(super) fn billow(&self, p: DVec3, octaves: f64) -> f64 {
        self.sum(p, octaves, f64::abs)
    }

    /// Thin sheets of 1 between wide hollows, in [0, 1]: the sum of (1 - |noise|)².
    pub(super) fn ridged(&self, p: DVec3, octaves: f64) -> f64 {
        self.sum(p, octaves, |n| (1.0 - n.abs()) * (1.0 - n.abs()))
    }

    /// A flow without sources, of speed about 1: the cross product of the gradients of two noises
    /// has no divergence (DeWolf 2005, "Divergence-free noise").
    fn flow(&self, p: DVec3) -> DVec3 {
        self.gradient(&self.first, p).cross(self.gradient(&self.second, p))
    }

    /// Where what is at `p` came from: traced back by `reach` through eddies of the given
    /// frequencies. More steps keep strong flow from folding over itself.
    pub(super) fn advected(&self, p: DVec3, frequency: DVec3, reach: f64, steps: u32) -> DVec3 {
        (0..steps).fold(p, |q, _| q - self.flow(q * frequency) * (reach / f64::from(steps)))
    }

    fn gradient(&self, noise: &Perlin, p: DVec3) -> DVec3 {
        const H: f64 = 1e-2;
        let at = |offset: DVec3| noise.get((p + offset).to_array());
        DVec3::new(at(DVec3::X * H), at(DVec3::Y * H), at(DVec3::Z * H)) / H
            - DVec3::splat(at(DVec3::ZERO) / H)
    }

    /// Octaves of halving wavelength and weight; the last counts by the fraction of `octaves`, so
    /// that detail fades in with resolution and does not pop.
    fn sum(&self, mut p: DVec3, octaves: f64, shape: impl Fn(f64) -> f64) -> f64 {
        let (mut total, mut weights, mut weight) = (0.0, 0.0, 1.0);
        let mut left = octaves.max(1.0);
        while left > 0.0 {
            let w = weight * left.min(1.0);
            total += w * shape(self.perlin(p));
            weights += w;
            weight *= 0.5;
            left -= 1.0;
            p = TURN * p * 2.0 + DVec3::new(17.3, 5.9, 11.7);
        }
        total / weights
    }
}

/// How many octaves fit between a first wavelength, in voxels, and the finest that voxels can
/// carry, at most `limit`.
pub(super) fn octaves(wavelength: f64, limit: f64) -> f64 {
    const FINEST: f64 = 3.0; // voxels per wavelength
    (1.0 + (wavelength / FINEST).max(1.0).log2()).min(limit)
}

/// 0 up to `from`, 1 from `to` on, smooth between them; falls where `from > to`.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
