//! What each part of the director brings: one way of rendering with it, one without.

use serde::{Deserialize, Serialize};

use super::answer::{Question, UNIFORM, has_round, over_rounds, scaled, too_inexact};
use super::curve::{Curve, Reach};
use super::measured::{Answer, PointResult, RunResult};

/// Parts, each with the candidate that has it and the one that has not.
const PARTS: [(&str, &str, &str); 12] = [
    ("X, by transmittance", "x-transmittance", UNIFORM),
    ("S", "s", UNIFORM),
    ("X and S, their sum", "xs-transmittance", UNIFORM),
    ("X and S, their product", "xs-product", UNIFORM),
    ("product instead of sum", "xs-product", "xs-scattering"),
    ("scattering-awareness, in X", "x-scattering", "x-transmittance"),
    ("scattering-awareness, in XS", "xs-scattering", "xs-transmittance"),
    ("directed rays alone", "xs-rays", UNIFORM),
    ("directed radius alone", "xs-radius", UNIFORM),
    ("directed step alone", "xs-step", UNIFORM),
    ("radius and step beside rays", "xs-scattering", "xs-rays"),
    ("all as in the paper", "xs-paper", UNIFORM),
];

/// What a part brings over doing without it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// The part.
    pub part: String,
    /// The candidate that has it.
    pub with: String,
    /// The candidate that is the same without.
    pub without: String,
    /// Error without it over error with it in the same run time, the geometric mean over all
    /// budgets at which the one without was measured: above 1 it wins.
    pub error_gain: Answer,
    /// Run time without it over run time with it at the same error, likewise.
    pub time_gain: Answer,
}

impl Effect {
    /// Whether the part wins at equal time, loses, or leaves it open, as far as the interval tells.
    pub fn outcome(&self) -> &'static str {
        match &self.error_gain {
            Answer::Found(gain) => match gain.range {
                Some([low, _]) if low > 1.0 => "wins",
                Some([_, high]) if high < 1.0 => "loses",
                _ => "open",
            },
            Answer::None(_) => "not told",
        }
    }
}

/// What is told by the candidates that were measured.
pub(super) fn ablation(points: &[PointResult], question: Question<'_>) -> Vec<Effect> {
    let is_there = |name: &str| points.iter().any(|point| point.candidate == name);
    PARTS
        .iter()
        .filter(|(_, with, without)| is_there(with) && is_there(without))
        .map(|&(part, with, without)| {
            let gain =
                |of: fn(&Curve, f64, f64) -> Reach| gain(points, question, (with, without), of);
            Effect {
                part: part.into(),
                with: with.into(),
                without: without.into(),
                error_gain: gain(|curve, seconds, error| scaled(curve.error_at(seconds), error)),
                time_gain: gain(|curve, seconds, error| scaled(curve.time_to(error), seconds)),
            }
        })
        .collect()
}

/// What `of` makes of the curve without the part, and seconds and error of the points with it.
fn gain(
    points: &[PointResult],
    question: Question<'_>,
    (with, without): (&str, &str),
    of: impl Fn(&Curve, f64, f64) -> Reach,
) -> Answer {
    let trusted = |p: &&PointResult| p.candidate == with && question.is_trusted(p);
    let points_with: Vec<&PointResult> = points.iter().filter(trusted).collect();
    if points_with.is_empty() {
        return Answer::None(too_inexact(question.target));
    }
    let results: Vec<&RunResult> = points_with.iter().flat_map(|point| &point.runs).collect();
    let mut rounds: Vec<u32> = results.iter().map(|result| result.run.round).collect();
    rounds.sort_unstable();
    rounds.dedup();
    rounds.retain(|round| has_round(points, without, *round));
    let reach = |round: &u32| {
        let curve = question.curve(points, without, *round);
        let of_round = results.iter().filter(|result| result.run.round == *round);
        let reaches = of_round.map(|result| {
            let error = question.error(result).unwrap_or(f64::NAN);
            of(&curve, result.run.seconds, error)
        });
        over_budgets(&reaches.collect::<Vec<_>>())
    };
    over_rounds(&rounds.iter().map(reach).collect::<Vec<_>>())
}

/// The geometric mean of what was found; what the first says where nothing was.
fn over_budgets(reaches: &[Reach]) -> Reach {
    let found = |r: &Reach| if let Reach::At(value) = r { Some(value.ln()) } else { None };
    let found: Vec<f64> = reaches.iter().filter_map(found).collect();
    if found.is_empty() {
        return reaches.first().copied().unwrap_or(Reach::Never);
    }
    Reach::At((found.iter().sum::<f64>() / found.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::super::candidate::CANDIDATES;
    use super::*;

    #[test]
    fn parts_are_of_candidates() {
        for (part, with, without) in PARTS {
            for name in [with, without] {
                assert!(CANDIDATES.iter().any(|(known, _)| *known == name), "{part}: {name}");
            }
        }
    }

    #[test]
    fn budgets_beyond_the_curve_are_left_out() {
        let Reach::At(mean) = over_budgets(&[Reach::At(2.0), Reach::Never, Reach::At(8.0)]) else {
            panic!("two budgets are on the curve")
        };
        assert!((mean - 4.0).abs() < 1e-12);
        assert_eq!(over_budgets(&[Reach::Below, Reach::Never]), Reach::Below);
        assert_eq!(over_budgets(&[]), Reach::Never);
    }
}
