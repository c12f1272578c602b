//! Draine's lobe, a part of the fog function.

use std::f64::consts::PI;

use super::Deflection;
use super::henyey_greenstein::{deflection, lobe_distance_squared};

/// The phase function of Draine 2003, "Scattering by Interstellar Dust Grains. I", eq. 4: that of
/// Henyey and Greenstein times 1 + alpha cos², normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Draine {
    g: f64,
    alpha: f64,
}

impl Draine {
    /// The function with shape `g` inside (-1, 1) and `alpha` >= 0.
    pub(super) const fn new(g: f64, alpha: f64) -> Self {
        Self { g, alpha }
    }

    pub(super) const fn convolved(self, keep: f64) -> Self {
        Self { g: self.g * keep, ..self }
    }

    /// Mean of 1 + alpha cos² under the Henyey-Greenstein function.
    fn normalisation(self) -> f64 {
        1.0 + self.alpha * (1.0 + 2.0 * self.g * self.g) / 3.0
    }

    pub(super) fn mean_cosine(self) -> f64 {
        let third_moment = self.g * (3.0 + 2.0 * self.g * self.g) / 5.0;
        (self.g + self.alpha * third_moment) / self.normalisation()
    }

    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        let s = lobe_distance_squared(self.g, cos_theta);
        (1.0 - self.g * self.g) * (1.0 + self.alpha * cos_theta * cos_theta)
            / (4.0 * PI * self.normalisation() * s * s.sqrt())
    }

    /// Share of the light deflected to cosines below that of parameter `m` (see [`deflection`]),
    /// and its derivative.
    ///
    /// With b = 1 + g and q = b - 2 g m the integral of cos^k (1 + g² - 2 g cos)^(-3/2) from -1
    /// is 2 m / (q b) for k = 0 and, by parts, cos² times that plus
    /// (4 m² - 16 b m³ / 3 + 4 g m⁴) / b for k = 2. Nothing is divided by g, so that the sum is
    /// as good at g = 0, where the usual closed form is 0 / 0.
    fn cumulative(self, m: f64) -> (f64, f64) {
        let Self { g, alpha } = self;
        let b = 1.0 + g;
        let q = b - 2.0 * g * m;
        let cos_theta = 2.0 * m * (b - g * m) - 1.0;
        let bump = 1.0 + alpha * cos_theta * cos_theta;
        let rest = m * m * (4.0 - m * (16.0 * b / 3.0 - 4.0 * g * m));
        let norm = self.normalisation();
        (
            (1.0 - g) * (2.0 * m * bump / q + alpha * rest) / (2.0 * norm),
            (1.0 - g * g) * bump / (norm * q * q),
        )
    }

    /// Inverts the cumulative distribution by Newton's method held inside a shrinking bracket.
    /// The quartic's closed form (Jendersie and d'Eon 2023, supplement) loses its digits for
    /// small g, which the fits for small droplets give.
    pub(super) fn sample(self, u: f64) -> Deflection {
        let (mut low, mut high) = (0.0, 1.0);
        let mut m = u;
        for _ in 0..MAX_STEPS {
            let (share, slope) = self.cumulative(m);
            let excess = share - u;
            if excess > 0.0 {
                high = m;
            } else {
                low = m;
            }
            let newton = m - excess / slope;
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            let step = (next - m).abs();
            m = next;
            if step <= f64::EPSILON {
                break;
            }
        }
        deflection(self.g, m, 1.0 - m)
    }
}

/// More than bisection alone needs for every bit of the result.
const MAX_STEPS: usize = 60;
