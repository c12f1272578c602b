//! From measured runs to answers.
//!
//! Everything is paired by round: what ran in the same minutes is compared, and the interval is
//! over rounds.

use super::candidate::GOLD;
use super::curve::{Curve, Reach};
use super::job::REFERENCE;
use super::measured::{Answer, CurveResult, PointResult, RunResult};
use super::request::Metric;
use super::statistics::{Interval, slope};
use super::target::Target;

/// The candidate that others are measured beside.
pub(super) const UNIFORM: &str = "fixed";

/// What all answers are about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Question<'a> {
    pub(super) target: &'a Target,
    pub(super) metric: Metric,
}

impl Question<'_> {
    pub(super) fn error(&self, result: &RunResult) -> Option<f64> {
        result.errors.get(&self.target.name).and_then(|errors| self.metric.value(errors))
    }

    pub(super) fn own(&self) -> f64 {
        self.metric.value(&self.target.own).unwrap_or(0.0)
    }

    /// The measured curve of a candidate in one round. Gold is the end of the uniform one, unless
    /// it is what errors are measured against.
    pub(super) fn curve(&self, points: &[PointResult], candidate: &str, round: u32) -> Curve {
        let gold_too = candidate == UNIFORM && self.target.name == REFERENCE;
        let of = |p: &&PointResult| p.candidate == candidate || (gold_too && p.candidate == GOLD);
        let results = points.iter().filter(of).flat_map(|p| &p.runs);
        let results = results.filter(|result| result.run.round == round);
        Curve::new(results.filter_map(|r| Some((r.run.seconds, self.error(r)?))))
    }

    /// The error of a render itself: where it is a squared one, less that of what it was measured
    /// against. Nothing where noise leaves nothing of it, or for gold by another metric.
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

    pub(super) fn is_trusted(&self, point: &PointResult) -> bool {
        point.errors.get(&self.target.name).is_some_and(|measured| measured.trusted)
    }
}

/// Fills in speed-up and gains of every point.
pub(super) fn answer_points(points: &mut [PointResult], question: Question<'_>) {
    let gold: Vec<(u32, f64)> = points
        .iter()
        .filter(|point| point.candidate == GOLD)
        .flat_map(|point| &point.runs)
        .map(|result| (result.run.round, result.run.seconds))
        .collect();
    let answers: Vec<_> = points
        .iter()
        .map(|point| {
            let faster = |result: &RunResult| {
                let same = gold.iter().find(|(round, _)| *round == result.run.round)?;
                Some(same.1 / result.run.seconds)
            };
            let ratios: Vec<f64> = point.runs.iter().filter_map(faster).collect();
            let at_error = gain(points, point, question, |curve, seconds, error| {
                scaled(curve.time_to(error), seconds)
            });
            let at_time = gain(points, point, question, |curve, seconds, error| {
                scaled(curve.error_at(seconds), error)
            });
            (Interval::from_values(&ratios), at_error, at_time)
        })
        .collect();
    for (point, (speed_up, at_error, at_time)) in points.iter_mut().zip(answers) {
        point.speed_up = speed_up;
        point.gain_at_equal_error = at_error;
        point.gain_at_equal_time = at_time;
    }
}

/// What `of` makes of the uniform curve and a point's seconds and error, over all rounds.
fn gain(
    points: &[PointResult],
    point: &PointResult,
    question: Question<'_>,
    of: impl Fn(&Curve, f64, f64) -> Reach,
) -> Answer {
    if point.candidate == UNIFORM || point.candidate == GOLD {
        return Answer::None("it is on the uniform curve".into());
    }
    if !question.is_trusted(point) {
        return Answer::None(too_inexact(question.target));
    }
    let reach = |result: &RunResult| {
        let curve = question.curve(points, UNIFORM, result.run.round);
        let error = question.error(result).unwrap_or(f64::NAN);
        of(&curve, result.run.seconds, error)
    };
    let paired = |r: &&RunResult| has_round(points, UNIFORM, r.run.round);
    over_rounds(&point.runs.iter().filter(paired).map(reach).collect::<Vec<_>>())
}

/// Whether `candidate` was rendered in this round.
pub(super) fn has_round(points: &[PointResult], candidate: &str, round: u32) -> bool {
    let mut of = points.iter().filter(|point| point.candidate == candidate);
    of.any(|point| point.runs.iter().any(|result| result.run.round == round))
}

/// One answer out of what each round says: nothing is told where a round would have to be
/// extrapolated.
pub(super) fn over_rounds(rounds: &[Reach]) -> Answer {
    let found: Vec<f64> =
        rounds.iter().filter_map(|r| if let Reach::At(v) = r { Some(*v) } else { None }).collect();
    let below = rounds.iter().filter(|r| **r == Reach::Below).count();
    let never = rounds.len() - found.len() - below;
    if below + never > 0 {
        let parts = [(below, "before the curve begins"), (never, "never reached")];
        let told = parts.iter().filter(|(n, _)| *n > 0);
        let told = told.map(|(n, what)| format!("{what} in {n} of {} seeds", rounds.len()));
        return Answer::None(told.collect::<Vec<_>>().join(", "));
    }
    Interval::from_values(&found).map_or(Answer::None("not measured".into()), Answer::Found)
}

pub(super) fn scaled(reach: Reach, by: f64) -> Reach {
    if let Reach::At(value) = reach { Reach::At(value / by) } else { reach }
}

pub(super) fn too_inexact(target: &Target) -> String {
    format!("no verdict: the own error of the {} is over a third of it", target.name)
}

/// What holds for each candidate as a whole; `errors` as asked for, those of the uniform candidate
/// at half and an eighth of its rays where none are.
pub(super) fn answer_curves(
    points: &[PointResult],
    question: Question<'_>,
    errors: &[f64],
) -> Vec<CurveResult> {
    let uniform = points.iter().filter(|p| p.candidate == UNIFORM);
    let of_uniform = uniform.step_by(2).take(2).filter(|p| question.is_trusted(p));
    let usual =
        of_uniform.filter_map(|p| Some(p.errors.get(&question.target.name)?.error.estimate));
    let errors: Vec<f64> = if errors.is_empty() { usual.collect() } else { errors.to_vec() };
    let mut names: Vec<&str> = points.iter().map(|p| p.candidate.as_str()).collect();
    names.dedup();
    let of = |name: &&str| CurveResult {
        candidate: (*name).to_owned(),
        time_to: errors.iter().map(|e| (*e, time_to(points, question, name, *e))).collect(),
        slope: slope_of(points, question, name),
    };
    names.iter().filter(|name| **name != GOLD).map(of).collect()
}

fn time_to(points: &[PointResult], question: Question<'_>, name: &str, error: f64) -> Answer {
    if !Target::is_trusted(question.own(), error) {
        return Answer::None(too_inexact(question.target));
    }
    let first = points.iter().find(|p| p.candidate == name);
    let rounds = first.iter().flat_map(|p| &p.runs).map(|result| result.run.round);
    let reach = |round| question.curve(points, name, round).time_to(error);
    over_rounds(&rounds.map(reach).collect::<Vec<_>>())
}

/// Of MSE against rays shot, where the target allows it.
fn slope_of(points: &[PointResult], question: Question<'_>, name: &str) -> Option<f64> {
    let question = Question { metric: Metric::Mse, ..question };
    let rays = |result: &RunResult| result.run.work.get("rays").and_then(serde_json::Value::as_f64);
    let results = points.iter().filter(|p| p.candidate == name).flat_map(|p| &p.runs);
    let pairs: Vec<(f64, f64)> = results
        .filter_map(|r| Some((rays(r)?, question.error(r)?)))
        .filter(|(_, error)| Target::is_trusted(question.own(), *error))
        .collect();
    slope(&pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_beyond_the_curve_leaves_no_answer() {
        let told = over_rounds(&[Reach::At(2.0), Reach::Never, Reach::Below, Reach::Never]);
        let Answer::None(why) = told else { panic!("{told:?}") };
        assert!(why.contains("never reached in 2 of 4"), "{why}");
        assert!(why.contains("begins in 1 of 4"), "{why}");
        let Answer::Found(found) = over_rounds(&[Reach::At(2.0), Reach::At(8.0)]) else {
            panic!("both are on the curve")
        };
        assert!((found.estimate - 4.0).abs() < 1e-12);
        assert!(matches!(over_rounds(&[]), Answer::None(_)));
    }
}
