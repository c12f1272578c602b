//! A lobe cut across: its tip, and the body below.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use super::{Deflection, HenyeyGreenstein, Phase, Split};

/// Halvings by which the place of the cut is found.
const HALVINGS: u32 = 50;

/// A Henyey-Greenstein lobe p, and where it is cut. In terms of the distance
/// s = sqrt(1 + g² - 2 g cos) it is (1 - g²) / (4 pi s³).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cut {
    lobe: HenyeyGreenstein,
    /// |g|.
    g: f64,
    /// The distance s at the cut.
    distance: f64,
    /// Height of the lobe there, 1/sr.
    height: f64,
    /// Share of the light in what lies above.
    share: f64,
}

impl Cut {
    /// The cut at `distance` between 1 - |g| and 1 + |g|.
    fn at(lobe: HenyeyGreenstein, distance: f64) -> Self {
        let g = lobe.mean_cosine().abs();
        let height = (1.0 - g) * (1.0 + g) / (4.0 * PI * distance.powi(3));
        let cut = Self { lobe, g, distance, height, share: 0.0 };
        Self { share: cut.within() - TAU * height * cut.opening(), ..cut }
    }

    /// The cut below which light is spread with no more than this
    /// [`concentration`](Phase::concentration).
    fn for_concentration(lobe: HenyeyGreenstein, most: f64) -> Self {
        let g = lobe.mean_cosine().abs();
        let (mut low, mut high) = (1.0 - g, 1.0 + g);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let cut = Self::at(lobe, middle);
            if cut.body_concentration() > most { low = middle } else { high = middle }
        }
        Self::at(lobe, high)
    }

    /// 1 - cos at the cut.
    fn opening(&self) -> f64 {
        let nearest = 1.0 - self.g;
        (self.distance - nearest) * (self.distance + nearest) / (2.0 * self.g)
    }

    /// Share of the lobe's light within the cone of the cut.
    fn within(&self) -> f64 {
        let nearest = 1.0 - self.g;
        (1.0 + self.g) * (self.distance - nearest) / (2.0 * self.g * self.distance)
    }

    /// Integral of cos p over the cone of the cut, less the body's part of it.
    fn moment(&self) -> f64 {
        let Self { g, distance, height, .. } = *self;
        let (nearest, opening) = (1.0 - g, self.opening());
        let lobe = (1.0 + g * g) * (distance - nearest) / (nearest * distance);
        let lobe = (1.0 - g * g) / (4.0 * g * g) * (lobe - (distance - nearest));
        lobe - PI * height * opening * (2.0 - opening)
    }

    /// Mean of (4 pi p)² over the sphere of what lies below the cut, normalised.
    fn body_concentration(&self) -> f64 {
        let Self { g, distance, height, share, .. } = *self;
        let beside = (1.0 - g * g) * (1.0 - g * g) * FRAC_1_PI / (32.0 * g)
            * (distance.powi(-4) - (1.0 + g).powi(-4));
        let square = TAU * height * height * self.opening() + beside;
        4.0 * PI * square / ((1.0 - share) * (1.0 - share))
    }

    /// The deflection at the distance s, to the side where the lobe is.
    fn deflection(&self, s: f64) -> Deflection {
        let nearest = 1.0 - self.g;
        let one_minus_cos = ((s - nearest) * (s + nearest) / (2.0 * self.g)).clamp(0.0, 2.0);
        self.facing(Deflection { one_minus_cos, one_plus_cos: 2.0 - one_minus_cos })
    }

    fn facing(&self, deflection: Deflection) -> Deflection {
        if self.lobe.mean_cosine() < 0.0 { deflection.reversed() } else { deflection }
    }
}

/// What of a Henyey-Greenstein lobe rises above a cut, normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tip(Cut);

impl Tip {
    pub(super) fn mean_cosine(self) -> f64 {
        (self.0.moment() / self.0.share).copysign(self.0.lobe.mean_cosine())
    }

    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        (self.0.lobe.eval(cos_theta) - self.0.height).max(0.0) / self.0.share
    }

    /// Light between the axis and the distance s comes to
    /// a (1 / (1 - g) - 1 / s) - b (s² - (1 - g)²) with a = (1 - g²) / (2 g) and b = pi height / g:
    /// a cubic equation for s, of which the middle root is meant.
    pub(super) fn sample(self, u: f64) -> Deflection {
        let Cut { g, distance, height, share, .. } = self.0;
        let nearest = 1.0 - g;
        let (a, b) = (nearest * (1.0 + g) / (2.0 * g), PI * height / g);
        let c = a / nearest + b * nearest * nearest - (1.0 - u) * share;
        let scale = (c / (3.0 * b)).sqrt();
        let angle = (-a / (2.0 * b * scale.powi(3))).clamp(-1.0, 1.0).acos();
        let root = 2.0 * scale * (angle / 3.0 - TAU / 3.0).cos();
        self.0.deflection(root.clamp(nearest, distance))
    }
}

/// What of a Henyey-Greenstein lobe lies below a cut, normalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body(Cut);

impl Body {
    pub(super) fn mean_cosine(self) -> f64 {
        let mean = (self.0.g - self.0.moment()) / (1.0 - self.0.share);
        mean.copysign(self.0.lobe.mean_cosine())
    }

    pub(super) fn eval(self, cos_theta: f64) -> f64 {
        self.0.lobe.eval(cos_theta).min(self.0.height) / (1.0 - self.0.share)
    }

    pub(super) fn sample(self, u: f64) -> Deflection {
        let cut = self.0;
        let below = u * (1.0 - cut.share);
        let beside = 1.0 - cut.within();
        if below < beside {
            // The lobe's own inverse, with the axis turned to the front.
            let s = 1.0 / (1.0 / (1.0 + cut.g) + below * 2.0 * cut.g / (1.0 - cut.g * cut.g));
            return cut.deflection(s.max(cut.distance));
        }
        let left = (below - beside) / (1.0 - cut.share - beside);
        let one_minus_cos = cut.opening() * (1.0 - left).clamp(0.0, 1.0);
        cut.facing(Deflection { one_minus_cos, one_plus_cos: 2.0 - one_minus_cos })
    }
}

impl HenyeyGreenstein {
    /// The lobe's tip, and its body, which is cut so that its
    /// [`concentration`](Phase::concentration) is at most `most`: below that of the whole.
    pub(super) fn split(self, most: f64) -> Split {
        let cut = Cut::for_concentration(self, most);
        Split { share: cut.share, peak: Phase::Tip(Tip(cut)), rest: Phase::Body(Body(cut)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_as_concentrated_as_asked() {
        for (g, most) in [(0.9, 10.0), (-0.95, 20.0), (0.9999, 5.0)] {
            let lobe = HenyeyGreenstein::new(g).unwrap();
            let cut = Cut::for_concentration(lobe, most);
            assert!((cut.body_concentration() / most - 1.0).abs() < 1e-9, "{g}");
            let rest = Phase::Body(Body(cut));
            assert!((rest.concentration() / most - 1.0).abs() < 0.01, "{g}");
        }
    }
}
