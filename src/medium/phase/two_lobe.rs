//! Two Henyey-Greenstein lobes, usually one forward and one backward.

use super::{Deflection, HenyeyGreenstein, Phase, Split, split};

/// A mixture of two Henyey-Greenstein functions (Irvine 1965, "Multiple Scattering by Large
/// Particles").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoLobe {
    first: HenyeyGreenstein,
    second: HenyeyGreenstein,
    weight: f64,
}

impl TwoLobe {
    /// Lobes with mean cosines `g1` and `g2`, the first with the share `weight` of the light.
    ///
    /// # Errors
    /// Says what would be right where a mean cosine is not inside (-1, 1) or `weight` not in
    /// [0, 1].
    pub fn new(g1: f64, g2: f64, weight: f64) -> Result<Self, String> {
        if !(0.0..=1.0).contains(&weight) {
            return Err(format!("weight of the first lobe is {weight}: must lie in [0, 1]"));
        }
        Ok(Self {
            first: HenyeyGreenstein::new(g1).map_err(|e| format!("first lobe: {e}"))?,
            second: HenyeyGreenstein::new(g2).map_err(|e| format!("second lobe: {e}"))?,
            weight,
        })
    }

    /// The mean cosine of the whole.
    pub fn mean_cosine(self) -> f64 {
        self.weight * self.first.mean_cosine() + (1.0 - self.weight) * self.second.mean_cosine()
    }

    pub(super) const fn convolved(self, keep: f64) -> Self {
        Self { first: self.first.convolved(keep), second: self.second.convolved(keep), ..self }
    }

    /// The lobe whose mean cosine is farther from 0, and the other.
    pub(super) fn split(self) -> Split {
        let far = |lobe: HenyeyGreenstein| lobe.mean_cosine().abs();
        let (share, peak, rest) = if far(self.first) > far(self.second) {
            (self.weight, self.first, self.second)
        } else {
            (1.0 - self.weight, self.second, self.first)
        };
        Split { share, peak: Phase::HenyeyGreenstein(peak), rest: Phase::HenyeyGreenstein(rest) }
    }

    pub(super) fn is_isotropic(self) -> bool {
        (self.weight == 0.0 || self.first.mean_cosine() == 0.0)
            && (self.weight == 1.0 || self.second.mean_cosine() == 0.0)
    }

    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        self.weight * self.first.eval(cos_theta) + (1.0 - self.weight) * self.second.eval(cos_theta)
    }

    pub(super) fn sample(self, u: f64) -> Deflection {
        match split(u, self.weight) {
            (true, u) => self.first.sample(u),
            (false, u) => self.second.sample(u),
        }
    }
}
