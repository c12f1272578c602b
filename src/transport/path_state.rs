//! The state of a path, its Russian roulette, and the solids of glass around it.

use crate::math::{Ray, Spectrum, Stream, World, WorldPoint};

/// A path traced from the camera or from a point in a medium.
#[derive(Debug, Clone, Copy)]
pub struct PathState<S> {
    /// The ray to trace next (unit direction).
    pub ray: Ray<World>,
    /// Product of the path's weights: values over densities.
    pub throughput: S,
    /// Radiance that the path has found so far, W/(m² sr).
    pub radiance: S,
    /// Solids of glass around the ray's origin.
    pub solids: EnclosingSolids,
    /// The last scattering that was not specular; `None` at the start and behind mirrors and glass,
    /// where light sampling cannot find what the ray finds.
    pub scattering: Option<Scattering>,
}

impl<S: Spectrum> PathState<S> {
    /// A path of throughput 1 that starts along `ray`, outside of all glass.
    pub const fn new(ray: Ray<World>) -> Self {
        Self {
            ray,
            throughput: S::ONE,
            radiance: S::ZERO,
            solids: EnclosingSolids::NONE,
            scattering: None,
        }
    }
}

/// How a path got its direction: what multiple importance sampling needs to know of it.
#[derive(Debug, Clone, Copy)]
pub struct Scattering {
    /// Where it was scattered.
    pub position: WorldPoint,
    /// Density of the direction, 1/sr.
    pub pdf: f64,
    /// Index of the medium that scattered it; `None` at a surface.
    pub medium: Option<usize>,
}

/// The number of solids of glass that a ray's origin is inside of. Media do not fill glass.
#[derive(Debug, Clone, Copy)]
pub struct EnclosingSolids(i32);

impl EnclosingSolids {
    /// Outside of all glass.
    ///
    /// Unit: count. Definition: no solid.
    pub const NONE: Self = Self(0);

    /// Whether the ray is outside of all glass, where media are.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }

    /// The count behind a surface: `crossing` is +1 where the ray enters a solid, -1 where it
    /// leaves one, else 0. Meshes that are not closed never make it negative.
    pub fn after(self, crossing: i8) -> Self {
        Self((self.0 + i32::from(crossing)).max(0))
    }
}

/// Russian roulette on the throughput: whether the path goes on. It survives with the probability
/// min(1, largest channel), and the throughput is divided by that (Arvo and Kirk 1990, "Particle
/// Transport and Image Synthesis").
pub fn survives_roulette<S: Spectrum>(throughput: &mut S, rng: &mut Stream) -> bool {
    let survival = throughput.max_element().min(1.0);
    if rng.uniform() >= survival {
        return false;
    }
    *throughput /= survival;
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Stage};

    /// The mean throughput after roulette is that before it. Bounds of 4.5 standard errors on three
    /// means make a false alarm of 2e-5 at this fixed seed.
    #[test]
    fn roulette_keeps_the_mean_throughput() {
        let mut rng = Stream::new(1, Stage::Test, 0, 0);
        let count = 100_000;
        for before in [0.05, 0.4, 0.9] {
            let mut sum = 0.0;
            for _ in 0..count {
                let mut throughput = Rgb::new(before, 0.5 * before, 0.0);
                if survives_roulette(&mut throughput, &mut rng) {
                    assert_eq!(throughput, Rgb::new(1.0, 0.5, 0.0));
                    sum += throughput.x;
                }
            }
            let error = (before * (1.0 - before) / f64::from(count)).sqrt();
            let mean = sum / f64::from(count);
            assert!((mean - before).abs() < 4.5 * error, "{mean} not {before}");
        }
        let mut bright = Rgb::splat(3.0);
        assert!(survives_roulette(&mut bright, &mut rng) && bright == Rgb::splat(3.0));
    }

    #[test]
    fn solids_are_counted_and_never_negative() {
        let inside = EnclosingSolids::NONE.after(1).after(1);
        assert!(!inside.after(-1).is_none() && inside.after(-1).after(-1).is_none());
        assert!(!EnclosingSolids::NONE.after(-1).after(1).is_none());
        assert!(EnclosingSolids::NONE.after(0).is_none());
    }
}
