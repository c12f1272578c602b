//! Speed-ups, gains and curves of candidates from their measured runs.
//!
//! All ratios are paired by round: runs of the same minutes are compared, and intervals are over rounds.

use super::candidate::GOLD;
use super::curve::{Crossing, Curve};
use super::job::REFERENCE;
use super::measured::{CurveResult, Estimate, PointResult, RunResult};
use super::request::Metric;
use super::statistics::{Interval, slope};
use super::target::Target;

/// The candidate of uniform sampling, whose curve gains are measured against.
pub(super) const UNIFORM: &str = "fixed";

/// The error of a study: against one target, by one metric.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorMeasure<'a> {
    pub(super) target: &'a Target,
    pub(super) metric: Metric,
}

impl ErrorMeasure<'_> {
    /// The error of a run; `None` where it was not measured.
    pub(super) fn error(&self, result: &RunResult) -> Option<f64> {
        result.errors.get(&self.target.name).and_then(|errors| self.metric.value(errors))
    }

    /// The target's own error.
    pub(super) fn own(&self) -> f64 {
        self.metric.value(&self.target.own).unwrap_or(0.0)
    }

    /// The measured curve of a candidate in one round. Gold is the last point of the uniform curve,
    /// unless it is the target.
    pub(super) fn curve(&self, points: &[PointResult], candidate: &str, round: u32) -> Curve {
        let gold_too = candidate == UNIFORM && self.target.name == REFERENCE;
        let of = |p: &&PointResult| p.candidate == candidate || (gold_too && p.candidate == GOLD);
        let results = points.iter().filter(of).flat_map(|p| &p.runs);
        let results = results.filter(|result| result.run.round == round);
        Curve::new(results.filter_map(|r| Some((r.run.seconds, self.error(r)?))))
    }

    /// The error of a render without the target's: a squared error less the target's own, another
    /// error as it is. `None` where that is not above 0, or where gold is the target and the metric is
    /// not squared.
    pub(super) fn corrected(&self, result: &RunResult) -> Option<f64> {
        let error = self.error(result)?;
        let is_part = result.run.candidate == self.target.name;
        if !self.metric.is_squared() {
            return (!is_part && error > 0.0).then_some(error);
        }
        let own = if is_part {
            self.target.own_of_other_half(self.own(), result.run.round)
        } else {
            self.own()
        };
        Some(error - own).filter(|error| *error > 0.0)
    }

    /// Whether the target's own error is small enough beside that of `point`.
    pub(super) fn is_trusted(&self, point: &PointResult) -> bool {
        point.errors.get(&self.target.name).is_some_and(|measured| measured.trusted)
    }
}

/// Sets speed-up and gains of every point.
pub(super) fn fill_gains(points: &mut [PointResult], measure: ErrorMeasure<'_>) {
    let gold: Vec<(u32, f64)> = points
        .iter()
        .filter(|point| point.candidate == GOLD)
        .flat_map(|point| &point.runs)
        .map(|result| (result.run.round, result.run.seconds))
        .collect();
    let estimates: Vec<_> = points
        .iter()
        .map(|point| {
            let speed_up = |result: &RunResult| {
                let same = gold.iter().find(|(round, _)| *round == result.run.round)?;
                Some(same.1 / result.run.seconds)
            };
            let ratios: Vec<f64> = point.runs.iter().filter_map(speed_up).collect();
            let at_error = gain(points, point, measure, |curve, seconds, error| {
                scaled(curve.time_to(error), seconds)
            });
            let at_time = gain(points, point, measure, |curve, seconds, error| {
                scaled(curve.error_at(seconds), error)
            });
            (Interval::from_values(&ratios), at_error, at_time)
        })
        .collect();
    for (point, (speed_up, at_error, at_time)) in points.iter_mut().zip(estimates) {
        point.speed_up = speed_up;
        point.gain_at_equal_error = at_error;
        point.gain_at_equal_time = at_time;
    }
}

/// The interval over all rounds of `of`, a function of the uniform curve and of a point's seconds and error.
fn gain(
    points: &[PointResult],
    point: &PointResult,
    measure: ErrorMeasure<'_>,
    of: impl Fn(&Curve, f64, f64) -> Crossing,
) -> Estimate {
    if point.candidate == UNIFORM || point.candidate == GOLD {
        return Estimate::None("it is on the uniform curve".into());
    }
    if !measure.is_trusted(point) {
        return Estimate::None(too_inexact(measure.target));
    }
    let crossing = |result: &RunResult| {
        let curve = measure.curve(points, UNIFORM, result.run.round);
        let error = measure.error(result).unwrap_or(f64::NAN);
        of(&curve, result.run.seconds, error)
    };
    let paired = |r: &&RunResult| has_round(points, UNIFORM, r.run.round);
    over_rounds(&point.runs.iter().filter(paired).map(crossing).collect::<Vec<_>>())
}

/// Whether `candidate` was rendered in this round.
pub(super) fn has_round(points: &[PointResult], candidate: &str, round: u32) -> bool {
    let mut of = points.iter().filter(|point| point.candidate == candidate);
    of.any(|point| point.runs.iter().any(|result| result.run.round == round))
}

/// The interval over the crossings of all rounds; `Estimate::None` where a round would have to be
/// extrapolated.
pub(super) fn over_rounds(rounds: &[Crossing]) -> Estimate {
    let found: Vec<f64> = rounds
        .iter()
        .filter_map(|r| if let Crossing::At(v) = r { Some(*v) } else { None })
        .collect();
    let below = rounds.iter().filter(|r| **r == Crossing::Below).count();
    let never = rounds.len() - found.len() - below;
    if below + never > 0 {
        let parts = [(below, "before the curve begins"), (never, "never reached")];
        let reasons = parts.iter().filter(|(n, _)| *n > 0);
        let reasons = reasons.map(|(n, what)| format!("{what} in {n} of {} seeds", rounds.len()));
        return Estimate::None(reasons.collect::<Vec<_>>().join(", "));
    }
    Interval::from_values(&found).map_or(Estimate::None("not measured".into()), Estimate::Found)
}

/// `crossing` with its value divided by `by`.
pub(super) fn scaled(crossing: Crossing, by: f64) -> Crossing {
    if let Crossing::At(value) = crossing { Crossing::At(value / by) } else { crossing }
}

/// The reason for no estimate where the target's own error is too large.
pub(super) fn too_inexact(target: &Target) -> String {
    format!("no verdict: the own error of the {} is over a third of it", target.name)
}

/// Times to `errors` and the slope of each candidate over all its budgets. Where `errors` is empty, they
/// are the errors of uniform sampling at half and an eighth of its rays.
pub(super) fn curve_results(
    points: &[PointResult],
    measure: ErrorMeasure<'_>,
    errors: &[f64],
) -> Vec<CurveResult> {
    let uniform = points.iter().filter(|p| p.candidate == UNIFORM);
    let of_uniform = uniform.step_by(2).take(2).filter(|p| measure.is_trusted(p));
    let usual = of_uniform.filter_map(|p| Some(p.errors.get(&measure.target.name)?.error.estimate));
    let errors: Vec<f64> = if errors.is_empty() { usual.collect() } else { errors.to_vec() };
    let mut names: Vec<&str> = points.iter().map(|p| p.candidate.as_str()).collect();
    names.dedup();
    let of = |name: &&str| CurveResult {
        candidate: (*name).to_owned(),
        time_to: errors.iter().map(|e| (*e, time_to(points, measure, name, *e))).collect(),
        slope: slope_of(points, measure, name),
    };
    names.iter().filter(|name| **name != GOLD).map(of).collect()
}

fn time_to(points: &[PointResult], measure: ErrorMeasure<'_>, name: &str, error: f64) -> Estimate {
    if !Target::is_trusted(measure.own(), error) {
        return Estimate::None(too_inexact(measure.target));
    }
    let first = points.iter().find(|p| p.candidate == name);
    let rounds = first.iter().flat_map(|p| &p.runs).map(|result| result.run.round);
    let crossing = |round| measure.curve(points, name, round).time_to(error);
    over_rounds(&rounds.map(crossing).collect::<Vec<_>>())
}

/// Slope of the logarithm of MSE over that of the rays shot, from points whose error the target can tell.
fn slope_of(points: &[PointResult], measure: ErrorMeasure<'_>, name: &str) -> Option<f64> {
    let measure = ErrorMeasure { metric: Metric::Mse, ..measure };
    let rays = |result: &RunResult| result.run.work.get("rays").and_then(serde_json::Value::as_f64);
    let results = points.iter().filter(|p| p.candidate == name).flat_map(|p| &p.runs);
    let pairs: Vec<(f64, f64)> = results
        .filter_map(|r| Some((rays(r)?, measure.error(r)?)))
        .filter(|(_, error)| Target::is_trusted(measure.own(), *error))
        .collect();
    slope(&pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_beyond_the_curve_leaves_no_estimate() {
        let estimate =
            over_rounds(&[Crossing::At(2.0), Crossing::Never, Crossing::Below, Crossing::Never]);
        let Estimate::None(why) = estimate else { panic!("{estimate:?}") };
        assert!(why.contains("never reached in 2 of 4"), "{why}");
        assert!(why.contains("begins in 1 of 4"), "{why}");
        let Estimate::Found(found) = over_rounds(&[Crossing::At(2.0), Crossing::At(8.0)]) else {
            panic!("both are on the curve")
        };
        assert!((found.estimate - 4.0).abs() < 1e-12);
        assert!(matches!(over_rounds(&[]), Estimate::None(_)));
    }
}
