//! Water droplets: fog, mist and cloud.

use super::draine::Draine;
use super::{Deflection, HenyeyGreenstein, Phase, Split, split};

/// The fit to Mie scattering by water droplets of Jendersie and d'Eon 2023, "An Approximate Mie
/// Scattering Function for Fog and Cloud Rendering": a Henyey-Greenstein lobe for the forward
/// peak blended with a Draine lobe (eq. 3), their shapes given by the droplet diameter: eq. 4 to 7
/// from 5 to 50 µm, the supplement's fits below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fog {
    peak: HenyeyGreenstein,
    body: Draine,
    body_weight: f64,
}

impl Fog {
    /// Droplets `diameter` micrometres across.
    ///
    /// # Errors
    /// Says what would be right where `diameter` is not above 0 and at most 50.
    pub fn new(diameter: f64) -> Result<Self, String> {
        if !(diameter > 0.0 && diameter <= 50.0) {
            return Err(format!(
                "droplet diameter is {diameter} µm: must lie above 0 and at most 50 µm \
                 (mist 1 to 5, fog 5 to 20, cloud 10 to 50)"
            ));
        }
        let fit = Fit::new(diameter);
        Ok(Self {
            peak: HenyeyGreenstein::new(fit.g_hg)?,
            body: Draine::new(fit.g_d, fit.alpha),
            body_weight: fit.w_d,
        })
    }

    /// The mean cosine of the whole.
    pub fn mean_cosine(self) -> f64 {
        self.body_weight * self.body.mean_cosine()
            + (1.0 - self.body_weight) * self.peak.mean_cosine()
    }

    pub(super) const fn convolved(self, keep: f64) -> Self {
        Self { peak: self.peak.convolved(keep), body: self.body.convolved(keep), ..self }
    }

    /// The forward peak, and the body without it.
    pub(super) const fn split(self) -> Split {
        let rest = Phase::Fog(Self { body_weight: 1.0, ..self });
        Split { share: 1.0 - self.body_weight, peak: Phase::HenyeyGreenstein(self.peak), rest }
    }

    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        self.body_weight * self.body.eval(cos_theta)
            + (1.0 - self.body_weight) * self.peak.eval(cos_theta)
    }

    pub(super) fn sample(self, u: f64) -> Deflection {
        match split(u, self.body_weight) {
            (true, u) => self.body.sample(u),
            (false, u) => self.peak.sample(u),
        }
    }
}

/// The four numbers that the diameter stands for, named as in the paper.
struct Fit {
    g_hg: f64,
    g_d: f64,
    alpha: f64,
    w_d: f64,
}

impl Fit {
    /// The fit for the diameter `d` in micrometres.
    fn new(d: f64) -> Self {
        let l = d.ln();
        if d <= 0.1 {
            Self {
                g_hg: 13.8 * d * d,
                g_d: 1.1456 * d * (9.29044 * d).sin(),
                alpha: 250.0,
                w_d: 0.252977 - 312.983 * d.powf(4.3),
            }
        } else if d < 1.5 {
            let inner = (l - 0.238604) * (l + 1.00667) / (0.507522 - 0.15677 * l);
            let outer = 1.19692 * inner.cos() + 1.37932 * l + 0.0625835;
            Self {
                g_hg: 0.862 - 0.143 * l * l,
                g_d: 0.379685 * outer.cos() + 0.344213,
                alpha: 250.0,
                w_d: 0.146209 * (3.38707 * l + 2.11193).cos() + 0.316072 + 0.0778917 * l,
            }
        } else if d < 5.0 {
            Self {
                g_hg: 0.0604931 * l.ln() + 0.940256,
                g_d: 0.500411 - 0.081287 / (l.tan() - 2.0 * l + 1.27551),
                alpha: 7.30354 * l + 6.31675,
                w_d: 0.026914 * (l - (5.68947 * (l.ln() - 0.0292149)).cos()) + 0.376475,
            }
        } else {
            Self {
                g_hg: (-0.0990567 / (d - 1.67154)).exp(),
                g_d: (-2.20679 / (d + 3.91029) - 0.428934).exp(),
                alpha: (3.62489 - 8.29288 / (d + 5.52825)).exp(),
                w_d: (-0.599085 / (d - 0.641583) - 0.665888).exp(),
            }
        }
    }
}
