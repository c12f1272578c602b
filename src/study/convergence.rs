//! How errors fall with photons, beside what theory says.

use serde::{Deserialize, Serialize};

use super::candidate::{GOLD, PHOTONS};
use super::gain::ErrorMeasure;
use super::job::REFERENCE;
use super::measured::{PointResult, RunResult};
use super::request::Metric;
use super::split::ErrorSplit;
use super::statistics::slope;
use crate::strategy::Strategy;

/// How light is estimated from N photons.
///
/// With a kernel that is h wide in d dimensions the variance is as 1/(N h^d), the squared bias as
/// h⁴ (Silverman 1986, "Density Estimation for Statistics and Data Analysis", section 4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Lengths of flights in cubic cells, which a ray sums up: d = 1. The edge is as N^(-1/5),
    /// which makes both parts N^(-4/5), the best there is for d = 1.
    Lattice,
    /// Photons spread across the ray: d = 2. Radii are chosen so that a ray always finds as many
    /// photons, as N^(-1/2): the variance of one gather stays and the squared bias is as N^(-2).
    /// What the rays of a pixel see is averaged beyond that.
    Beams,
    /// Photons on surfaces alone: d = 2, and radii with always as many photons in them.
    Surfaces,
    /// Final gathers that end at moments of photons' light on cells. The width of cells and the
    /// tolerance at which gathers end are as N^(-1/5); the noise of the gathers is that of rays.
    FinalGathers,
    /// No photons: they change nothing.
    None,
    /// Not the same for all numbers of photons.
    Mixed,
}

impl Estimator {
    /// In words.
    pub fn about(self) -> &'static str {
        match self {
            Self::Lattice => {
                "light in media is kept on cells whose edge h is made as N^(-1/5): what a ray sums \
                 up has a variance as 1/(N h) and a squared bias as h⁴, both as N^(-4/5)"
            }
            Self::Beams => {
                "rays gather photons within radii r that are made as N^(-1/2), where nothing \
                 bounds them: the variance is as 1/(N r²) and stays, the squared bias as r⁴"
            }
            Self::Surfaces => {
                "photons on surfaces are gathered within radii r made as N^(-1/2): the variance \
                 is as 1/(N r²) and stays, the squared bias as r⁴"
            }
            Self::FinalGathers => {
                "final gathers end at moments of photons' light, kept on cells whose edge is made as \
                 N^(-1/5): their own noise is that of rays, so that no exponent is to be expected"
            }
            Self::None => "photons are not needed",
            Self::Mixed => {
                "light is estimated in another way with few photons than with many (cells must be \
                 thin), so that no single exponent is to be expected"
            }
        }
    }

    /// Dimensions across which a kernel of the width h is spread, and the exponent of h over N that
    /// it is made with.
    fn law(self) -> Option<(f64, f64)> {
        match self {
            Self::Lattice => Some((1.0, -0.2)),
            Self::Beams | Self::Surfaces => Some((2.0, -0.5)),
            Self::FinalGathers | Self::None | Self::Mixed => None,
        }
    }

    /// Exponents of variance and squared bias over N. `width` is that of the kernel's width, as
    /// measured; as it is made where that is not known.
    pub fn exponents(self, width: Option<f64>) -> Option<[f64; 2]> {
        let (dimensions, made) = self.law()?;
        // The radius that a render tells is not that of surfaces.
        let width = width.filter(|_| self != Self::Surfaces).unwrap_or(made);
        Some([-1.0 - dimensions * width, 4.0 * width])
    }

    /// That of a render: by its strategy in media where photons are stored there, else by its counters,
    /// as in results stored without a strategy.
    fn from_result(result: &RunResult) -> Self {
        let count = |name: &str| result.run.work.get(name).and_then(serde_json::Value::as_u64);
        let some = |name: &str| count(name).is_some_and(|n| n > 0);
        let strategy = result.run.strategy.as_ref();
        let strategy = strategy.and_then(|summary| summary.media.first()).map(|m| m.strategy);
        let in_media = some("tracks") || some("volume_photons");
        match strategy.filter(|_| in_media) {
            Some(Strategy::FluenceTowardEye) => return Self::Lattice,
            Some(Strategy::Beams) => return Self::Beams,
            Some(Strategy::Moments | Strategy::SharedGathers) => return Self::FinalGathers,
            Some(Strategy::Traced) => return Self::None,
            None => (),
        }
        match (some("tracks"), some("volume_photons"), some("surface_photons")) {
            (true, ..) => Self::Lattice,
            (false, true, _) => Self::Beams,
            (false, false, true) => Self::Surfaces,
            (false, false, false) => Self::None,
        }
    }
}

/// Exponents by which errors fall with photons: slopes of logarithms over that of the number of
/// photons asked for, by MSE. The noise of the rays is in them and flattens them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// How light is estimated.
    pub estimator: Estimator,
    /// The theory in words.
    pub about: String,
    /// The exponents of variance and squared bias that theory gives for radii, or edges of cells,
    /// that fall as they were measured to.
    pub expected: Option<[f64; 2]>,
    /// Numbers of photons, each with its mean MSE, where the target's own error allows it.
    pub points: Vec<(u64, f64)>,
    /// Measured exponent of the MSE.
    pub mse: Option<f64>,
    /// Measured exponent of its part that is noise.
    pub noise: Option<f64>,
    /// Measured exponent of its part that is bias; nothing where it is not above 0 everywhere.
    pub bias: Option<f64>,
    /// Measured exponent of the gather radius, or the edge of the cells.
    pub radius: Option<f64>,
}

/// What the candidate with fewer photons shows; nothing where it was not measured.
pub(super) fn convergence(
    points: &[PointResult],
    measure: ErrorMeasure<'_>,
) -> Option<Convergence> {
    let measure = ErrorMeasure { metric: Metric::Mse, ..measure };
    // Gold is the end of the curve, unless it is what errors are measured against.
    let with_gold = measure.target.name == REFERENCE;
    let of = |p: &&PointResult| p.candidate == PHOTONS || (with_gold && p.candidate == GOLD);
    if !points.iter().any(|p| p.candidate == PHOTONS) {
        return None;
    }
    let mut told = Vec::new();
    for point in points.iter().filter(of) {
        let errors: Vec<f64> = point.runs.iter().filter_map(|t| measure.error(t)).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        if super::Target::is_trusted(measure.own(), mean) {
            told.push((point, mean));
        }
    }
    let estimators =
        told.iter().filter_map(|(point, _)| point.runs.first()).map(Estimator::from_result);
    let estimator = estimators
        .reduce(|a, b| if a == b { a } else { Estimator::Mixed })
        .unwrap_or(Estimator::None);
    let slope_of = |value: &dyn Fn(&PointResult, f64) -> Option<f64>| {
        let pair = |(point, mse): &(&PointResult, f64)| {
            Some((point.settings.photons as f64, value(point, *mse).filter(|v| *v > 0.0)?))
        };
        slope(&told.iter().map(pair).collect::<Option<Vec<_>>>()?)
    };
    let part =
        |of: fn(ErrorSplit) -> f64| move |point: &PointResult, _: f64| point.mse_split.map(of);
    let radius = slope_of(&|point, _| point.runs.first()?.run.radius);
    Some(Convergence {
        estimator,
        about: estimator.about().into(),
        expected: estimator.exponents(radius),
        mse: slope_of(&|_, mse| Some(mse)),
        noise: slope_of(&part(|split| split.noise)),
        bias: slope_of(&part(|split| split.bias)),
        radius,
        points: told.iter().map(|(point, mse)| (point.settings.photons, *mse)).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_those_of_kernels() {
        assert_eq!(Estimator::Lattice.exponents(None), Some([-0.8, -0.8]));
        assert_eq!(Estimator::Beams.exponents(None), Some([0.0, -2.0]));
        // A radius that is bounded, or asked for, leaves all to the number.
        assert_eq!(Estimator::Beams.exponents(Some(0.0)), Some([-1.0, 0.0]));
        assert_eq!(Estimator::Mixed.exponents(Some(-0.2)), None);
    }
}
