//! Phase functions: how light that scatters once is spread over directions.
//!
//! Every phase function here depends on the cosine between the directions of propagation before
//! and after scattering alone (1 is straight on), is normalised over the sphere in 1/sr, and is
//! sampled exactly: the density of a sampled direction is the value of the function.

mod cut;
mod draine;
mod fog;
mod henyey_greenstein;
mod isotropic;
mod rayleigh;
mod two_lobe;

use std::f64::consts::TAU;

use glam::DVec3;

use crate::math::{Frame, warp};
pub use cut::{Body, Tip};
pub use fog::Fog;
pub use henyey_greenstein::HenyeyGreenstein;
pub use isotropic::Isotropic;
pub use rayleigh::Rayleigh;
pub use two_lobe::TwoLobe;

/// Deflections by which the concentration of a phase function is found.
const DEFLECTIONS: u32 = 256;

/// A phase function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// The same in all directions.
    Isotropic(Isotropic),
    /// One lobe, forward or backward.
    HenyeyGreenstein(HenyeyGreenstein),
    /// Particles much smaller than the wavelength.
    Rayleigh(Rayleigh),
    /// Two Henyey-Greenstein lobes.
    TwoLobe(TwoLobe),
    /// Water droplets of one diameter.
    Fog(Fog),
    /// What rises above a cut of one lobe.
    Tip(Tip),
    /// What lies below it.
    Body(Body),
}

impl Phase {
    /// The isotropic phase function.
    pub const ISOTROPIC: Self = Self::Isotropic(Isotropic);

    /// Rayleigh's phase function.
    pub const RAYLEIGH: Self = Self::Rayleigh(Rayleigh);

    /// Henyey and Greenstein's with mean cosine `g`.
    ///
    /// # Errors
    /// Says what would be right where `g` is not inside (-1, 1).
    pub fn henyey_greenstein(g: f64) -> Result<Self, String> {
        HenyeyGreenstein::new(g).map(Self::HenyeyGreenstein)
    }

    /// Two Henyey-Greenstein lobes, the first with the share `weight`.
    ///
    /// # Errors
    /// Says what would be right where a mean cosine is not inside (-1, 1) or `weight` not in
    /// [0, 1].
    pub fn two_lobe(g1: f64, g2: f64, weight: f64) -> Result<Self, String> {
        TwoLobe::new(g1, g2, weight).map(Self::TwoLobe)
    }

    /// Fog or cloud of water droplets `diameter` micrometres across.
    ///
    /// # Errors
    /// Says what would be right where `diameter` is not above 0 and at most 50.
    pub fn fog(diameter: f64) -> Result<Self, String> {
        Fog::new(diameter).map(Self::Fog)
    }

    /// Share of light scattered per solid angle, 1/sr, where `cos_theta` is the cosine between
    /// the directions of propagation before and after. Values that rounding pushed outside
    /// [-1, 1] count as the nearest inside.
    pub fn eval(&self, cos_theta: f64) -> f64 {
        let cos_theta = cos_theta.clamp(-1.0, 1.0);
        match self {
            Self::Isotropic(p) => p.eval(),
            Self::HenyeyGreenstein(p) => p.eval(cos_theta),
            Self::Rayleigh(p) => p.eval(cos_theta),
            Self::TwoLobe(p) => p.eval(cos_theta),
            Self::Fog(p) => p.eval(cos_theta),
            Self::Tip(p) => p.eval(cos_theta),
            Self::Body(p) => p.eval(cos_theta),
        }
    }

    /// A direction of propagation after scattering of light that came along the unit vector
    /// `direction`, and its density in 1/sr, which equals [`Self::eval`] up to rounding.
    pub fn sample(&self, direction: DVec3, u: [f64; 2]) -> (DVec3, f64) {
        let deflection = match self {
            Self::Isotropic(p) => p.sample(u[0]),
            Self::HenyeyGreenstein(p) => p.sample(u[0]),
            Self::Rayleigh(p) => p.sample(u[0]),
            Self::TwoLobe(p) => p.sample(u[0]),
            Self::Fog(p) => p.sample(u[0]),
            Self::Tip(p) => p.sample(u[0]),
            Self::Body(p) => p.sample(u[0]),
        };
        (deflection.apply(direction, u[1]), self.eval(deflection.cos()))
    }

    /// The function after a further deflection by Henyey and Greenstein's with mean cosine `keep`
    /// in [0, 1]. The lobes' Legendre coefficients g^l are multiplied by keep^l: exact for
    /// Henyey-Greenstein lobes, near it for Draine's. Smooth functions and parts of a lobe stay as
    /// they are.
    #[must_use]
    pub const fn convolved(&self, keep: f64) -> Self {
        match self {
            Self::Isotropic(p) => Self::Isotropic(*p),
            Self::HenyeyGreenstein(p) => Self::HenyeyGreenstein(p.convolved(keep)),
            Self::Rayleigh(p) => Self::Rayleigh(*p),
            Self::TwoLobe(p) => Self::TwoLobe(p.convolved(keep)),
            Self::Fog(p) => Self::Fog(p.convolved(keep)),
            Self::Tip(_) | Self::Body(_) => *self,
        }
    }

    /// The function as its peak and the rest, where it has a lobe of a
    /// [`concentration`](Self::concentration) above `most` beside another that is smoother. A lobe
    /// by itself is cut across where `smooth` is given, so that the rest has that concentration.
    pub fn split(&self, most: f64, smooth: Option<f64>) -> Option<Split> {
        let split = match self {
            Self::HenyeyGreenstein(p) if self.concentration() > most => p.split(smooth?),
            Self::TwoLobe(p) => p.split(),
            Self::Fog(p) => p.split(),
            _ => return None,
        };
        let parted = split.share > 0.0 && split.share < 1.0;
        let peaked = split.peak.concentration() > most && split.rest.concentration() <= most;
        (parted && peaked).then_some(split)
    }

    /// By how much the variance of light scattered one way exceeds that of isotropic scattering,
    /// where it comes from all sides alike: the mean of (4 pi p)² over the sphere.
    pub fn concentration(&self) -> f64 {
        let values = self.deflections().map(|(_, value)| value / warp::uniform_sphere_pdf());
        values.sum::<f64>() / f64::from(DEFLECTIONS)
    }

    /// Cosines of [`DEFLECTIONS`] of the scattered light, each for an equal part of it, and the
    /// function's values there, 1/sr.
    fn deflections(&self) -> impl Iterator<Item = (f64, f64)> {
        (0..DEFLECTIONS).map(|index| {
            let u = (f64::from(index) + 0.5) / f64::from(DEFLECTIONS);
            let (direction, value) = self.sample(DVec3::Z, [u, 0.5]);
            (direction.z, value)
        })
    }

    /// Means of the Legendre polynomials of degrees 1 to 3 of the cosine over the scattered light:
    /// what a scattering leaves of the moments of radiance of these degrees. All but the first are
    /// found by a few hundred deflections.
    pub fn legendre(&self) -> [f64; 3] {
        let mut sums = [0.0; 2];
        for (cosine, _) in self.deflections() {
            let square = cosine * cosine;
            sums[0] += 1.5 * square - 0.5;
            sums[1] += (2.5 * square - 1.5) * cosine;
        }
        let [second, third] = sums.map(|sum| sum / f64::from(DEFLECTIONS));
        [self.mean_cosine(), second, third]
    }

    /// Mean of the cosine over the scattered light.
    pub fn mean_cosine(&self) -> f64 {
        match self {
            Self::Isotropic(_) | Self::Rayleigh(_) => 0.0,
            Self::HenyeyGreenstein(p) => p.mean_cosine(),
            Self::TwoLobe(p) => p.mean_cosine(),
            Self::Fog(p) => p.mean_cosine(),
            Self::Tip(p) => p.mean_cosine(),
            Self::Body(p) => p.mean_cosine(),
        }
    }

    /// Whether the function is the same in all directions, so that nothing need be known of where
    /// light came from.
    pub fn is_isotropic(&self) -> bool {
        match self {
            Self::Isotropic(_) => true,
            Self::HenyeyGreenstein(p) => p.mean_cosine() == 0.0,
            Self::TwoLobe(p) => p.is_isotropic(),
            Self::Rayleigh(_) | Self::Fog(_) | Self::Tip(_) | Self::Body(_) => false,
        }
    }
}

/// A phase function parted in two: `share` of the light is scattered by one, what is left by the
/// other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Split {
    /// Share of the light that the peak scatters.
    pub share: f64,
    /// The more concentrated part, normalised.
    pub peak: Phase,
    /// The other, normalised.
    pub rest: Phase,
}

/// An angle between the directions before and after scattering. Kept as distance from both ends,
/// since a cosine alone forgets angles under 1e-8.
#[derive(Debug, Clone, Copy)]
struct Deflection {
    one_minus_cos: f64,
    one_plus_cos: f64,
}

impl Deflection {
    fn from_cos(cos_theta: f64) -> Self {
        Self { one_minus_cos: 1.0 - cos_theta, one_plus_cos: 1.0 + cos_theta }
    }

    fn cos(self) -> f64 {
        if self.one_minus_cos < 1.0 { 1.0 - self.one_minus_cos } else { self.one_plus_cos - 1.0 }
    }

    fn reversed(self) -> Self {
        Self { one_minus_cos: self.one_plus_cos, one_plus_cos: self.one_minus_cos }
    }

    fn apply(self, direction: DVec3, u: f64) -> DVec3 {
        let sin = (self.one_minus_cos * self.one_plus_cos).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * u).sin_cos();
        Frame::around(direction)
            .to_world(DVec3::new(sin * cos_phi, sin * sin_phi, self.cos()))
            .normalize()
    }
}

/// Splits one uniform number among two lobes: whether the first, of share `weight`, is taken, and
/// a uniform number in [0, 1) to sample that lobe with.
fn split(u: f64, weight: f64) -> (bool, f64) {
    let below_one = 1.0 - f64::EPSILON;
    if u < weight {
        (true, (u / weight).min(below_one))
    } else {
        (false, ((u - weight) / (1.0 - weight)).min(below_one))
    }
}
