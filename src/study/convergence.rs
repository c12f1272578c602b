//! How errors fall with photons, beside what theory says.

use serde::{Deserialize, Serialize};

use super::answer::Question;
use super::candidate::{GOLD, PHOTONS};
use super::plan::REFERENCE;
use super::request::Metric;
use super::results::{PointResult, TrialResult};
use super::split::Split;
use super::statistics::slope;
use crate::scene::RenderSettings;

/// How light in the scene is estimated from photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theory {
    /// Lengths of flights in cubic cells, whose edge h follows the number N of flights as
    /// N^(-1/5). The variance of what a ray sums up is as 1/(N h), the squared bias as h⁴, both of
    /// them as N^(-4/5).
    Lattice,
    /// Photons spread across the ray, within radii r in which a ray finds always as many: r is as
    /// N^(-1/2), the variance 1/(N r²) stays, and only the squared bias r⁴ falls, as N^(-2). What
    /// many rays of a pixel see is averaged beyond that.
    Beams,
    /// The same edge or radius whatever the number of photons, as asked for: the variance is as
    /// 1/N and the bias stays.
    FixedRadius,
    /// Photons on surfaces alone, gathered within radii in which there are always as many: as for
    /// [`Beams`](Self::Beams).
    Surfaces,
    /// No photons: they change nothing.
    None,
}

impl Theory {
    /// In words, with the exponents.
    pub fn about(self) -> &'static str {
        match self {
            Self::Lattice => {
                "light in media is kept on cells whose edge is as N^(-1/5): variance 1/(N h) and \
                 squared bias h⁴ are both as N^(-4/5)"
            }
            Self::Beams => {
                "rays gather photons within radii as N^(-1/2), always as many: the variance of \
                 one gather stays, the squared bias is as N^(-2)"
            }
            Self::FixedRadius => {
                "the radius is as asked for: the variance is as N^(-1), the bias stays"
            }
            Self::Surfaces => {
                "photons on surfaces are gathered within radii as N^(-1/2), always as many: the \
                 variance stays, the squared bias is as N^(-2)"
            }
            Self::None => "no photons are needed",
        }
    }

    /// Exponents of variance and squared bias over the number of photons.
    pub fn exponents(self) -> [f64; 2] {
        match self {
            Self::Lattice => [-0.8, -0.8],
            Self::Beams | Self::Surfaces => [0.0, -2.0],
            Self::FixedRadius => [-1.0, 0.0],
            Self::None => [0.0, 0.0],
        }
    }

    /// What the counters of a render say it is; `radius` is the one asked for.
    fn of(result: &TrialResult, radius: Option<f64>) -> Self {
        let count = |name: &str| result.trial.work.get(name).and_then(serde_json::Value::as_u64);
        let some = |name: &str| count(name).is_some_and(|n| n > 0);
        match (some("tracks"), some("volume_photons"), some("surface_photons")) {
            (false, false, false) => Self::None,
            _ if radius.is_some() => Self::FixedRadius,
            (true, ..) => Self::Lattice,
            (false, true, _) => Self::Beams,
            (false, false, true) => Self::Surfaces,
        }
    }
}

/// Exponents by which errors fall with photons: slopes of logarithms over that of the number of
/// photons asked for, by MSE. The noise of the rays is in them and flattens them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// How light is estimated.
    pub theory: Theory,
    /// The same in words.
    pub about: String,
    /// The exponents of variance and squared bias that theory gives.
    pub expected: [f64; 2],
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
    question: Question<'_>,
    gold: &RenderSettings,
) -> Option<Convergence> {
    let question = Question { metric: Metric::Mse, ..question };
    // Gold is the end of the curve, unless it is what errors are measured against.
    let with_gold = question.target.name == REFERENCE;
    let of = |p: &&PointResult| p.candidate == PHOTONS || (with_gold && p.candidate == GOLD);
    let points: Vec<&PointResult> = points.iter().filter(of).collect();
    let first = points.iter().find(|p| p.candidate == PHOTONS)?.trials.first()?;
    let theory = Theory::of(first, gold.radius);
    let mut told = Vec::new();
    for point in &points {
        let errors: Vec<f64> = point.trials.iter().filter_map(|t| question.error(t)).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        if super::Target::is_trusted(question.own(), mean) {
            told.push((point, mean));
        }
    }
    let slope_of = |value: &dyn Fn(&PointResult, f64) -> Option<f64>| {
        let pair = |(point, mse): &(&&PointResult, f64)| {
            Some((point.settings.photons as f64, value(point, *mse).filter(|v| *v > 0.0)?))
        };
        slope(&told.iter().map(pair).collect::<Option<Vec<_>>>()?)
    };
    let part = |of: fn(Split) -> f64| move |point: &PointResult, _: f64| point.mse_split.map(of);
    let radius = |point: &PointResult, _: f64| point.trials.first()?.trial.radius;
    Some(Convergence {
        theory,
        about: theory.about().into(),
        expected: theory.exponents(),
        mse: slope_of(&|_, mse| Some(mse)),
        noise: slope_of(&part(|split| split.noise)),
        bias: slope_of(&part(|split| split.bias)),
        radius: slope_of(&radius),
        points: told.iter().map(|(point, mse)| (point.settings.photons, *mse)).collect(),
    })
}
