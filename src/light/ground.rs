//! Places round a target from which evenly lit ground sends it light.

use std::f64::consts::PI;

use glam::DVec2;

/// Heights within which ground counts: what comes from beyond is a ten thousandth of what comes from
/// all of it.
const ENDLESS: f64 = 1e4;

/// Rounding of the square of a distance that was sampled.
pub(super) const SLACK: f64 = 1.0 + 1e-6;

/// Endless ground that a target stands over. Where it is even and evenly lit, what comes to a place at the
/// height h from each m² at the distance r from the foot is as h / (r² + h²)^(3/2); places are sampled so,
/// and the same density serves across any direction from which light comes to the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ground {
    height: f64,
}

impl Ground {
    /// Ground about `height` metres away.
    pub(super) const fn new(height: f64) -> Self {
        Self { height }
    }

    /// A place relative to the target's foot, in metres.
    pub(super) fn sample(self, u: [f64; 2]) -> DVec2 {
        // The height over the distance from the target.
        let cosine = 1.0 - within() * u[0];
        let r = self.height * (cosine.powi(-2) - 1.0).max(0.0).sqrt();
        DVec2::from_angle(2.0 * PI * u[1]) * r
    }

    /// Density of [`sample`](Self::sample) at the square of a distance, 1/m².
    pub(super) fn pdf(self, r2: f64) -> f64 {
        let h2 = self.height * self.height;
        if r2 > SLACK * ENDLESS * ENDLESS * h2 {
            return 0.0;
        }
        self.height / (2.0 * PI * within() * (r2 + h2).powf(1.5))
    }
}

/// Share of the light of all ground that comes from within [`ENDLESS`] heights.
fn within() -> f64 {
    1.0 - 1.0 / ENDLESS.hypot(1.0)
}
