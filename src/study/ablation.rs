//! The gain of each part of the director: a candidate with it against one without.

use serde::{Deserialize, Serialize};

use super::curve::{Crossing, Curve};
use super::gain::{ErrorMeasure, UNIFORM, has_round, over_rounds, scaled, too_inexact};
use super::measured::{Estimate, PointResult, RunResult};

/// Parts, each with the candidate that has it and the one that has not.
const PARTS: [(&str, &str, &str); 13] = [
    ("X, by transmittance", "x-transmittance", UNIFORM),
    ("S", "s", UNIFORM),
    ("X and S, their sum", "xs-transmittance", UNIFORM),
    ("X and S, their product", "xs-product", UNIFORM),
    ("product instead of sum", "xs-product", "xs-scattering"),
    ("scattering-awareness, in X", "x-scattering", "x-transmittance"),
    ("scattering-awareness, in XS", "xs-scattering", "xs-transmittance"),
    ("X by measured error, tolerance by S", "xs-error", "xs-scattering"),
    ("directed rays alone", "xs-rays", UNIFORM),
    ("directed radius alone", "xs-radius", UNIFORM),
    ("directed step alone", "xs-step", UNIFORM),
    ("radius and step beside rays", "xs-scattering", "xs-rays"),
    ("all as in the paper", "xs-paper", UNIFORM),
];

/// The gain of a part over doing without it.
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
    pub error_gain: Estimate,
    /// Run time without it over run time with it at the same error, likewise.
    pub time_gain: Estimate,
}

impl Effect {
    /// Whether the part wins or loses at equal time, by the interval.
    pub fn outcome(&self) -> &'static str {
        match &self.error_gain {
            Estimate::Found(gain) => match gain.range {
                Some([low, _]) if low > 1.0 => "wins",
                Some([_, high]) if high < 1.0 => "loses",
                _ => "open",
            },
            Estimate::None(_) => "not told",
        }
    }
}

/// The effects of the parts whose two candidates were measured.
pub(super) fn ablation(points: &[PointResult], measure: ErrorMeasure<'_>) -> Vec<Effect> {
    let is_there = |name: &str| points.iter().any(|point| point.candidate == name);
    PARTS
        .iter()
        .filter(|(_, with, without)| is_there(with) && is_there(without))
        .map(|&(part, with, without)| {
            let gain =
                |of: fn(&Curve, f64, f64) -> Crossing| gain(points, measure, (with, without), of);
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

/// The interval over rounds of `of`, a function of the curve without the part and of seconds and error of the
/// points with it.
fn gain(
    points: &[PointResult],
    measure: ErrorMeasure<'_>,
    (with, without): (&str, &str),
    of: impl Fn(&Curve, f64, f64) -> Crossing,
) -> Estimate {
    let trusted = |p: &&PointResult| p.candidate == with && measure.is_trusted(p);
    let points_with: Vec<&PointResult> = points.iter().filter(trusted).collect();
    if points_with.is_empty() {
        return Estimate::None(too_inexact(measure.target));
    }
    let results: Vec<&RunResult> = points_with.iter().flat_map(|point| &point.runs).collect();
    let mut rounds: Vec<u32> = results.iter().map(|result| result.run.round).collect();
    rounds.sort_unstable();
    rounds.dedup();
    rounds.retain(|round| has_round(points, without, *round));
    let crossing = |round: &u32| {
        let curve = measure.curve(points, without, *round);
        let of_round = results.iter().filter(|result| result.run.round == *round);
        let crossings = of_round.map(|result| {
            let error = measure.error(result).unwrap_or(f64::NAN);
            of(&curve, result.run.seconds, error)
        });
        over_budgets(&crossings.collect::<Vec<_>>())
    };
    over_rounds(&rounds.iter().map(crossing).collect::<Vec<_>>())
}

/// The geometric mean of the values found; the first crossing where there are none.
fn over_budgets(crossings: &[Crossing]) -> Crossing {
    let found = |r: &Crossing| if let Crossing::At(value) = r { Some(value.ln()) } else { None };
    let found: Vec<f64> = crossings.iter().filter_map(found).collect();
    if found.is_empty() {
        return crossings.first().copied().unwrap_or(Crossing::Never);
    }
    Crossing::At((found.iter().sum::<f64>() / found.len() as f64).exp())
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
        let Crossing::At(mean) =
            over_budgets(&[Crossing::At(2.0), Crossing::Never, Crossing::At(8.0)])
        else {
            panic!("two budgets are on the curve")
        };
        assert!((mean - 4.0).abs() < 1e-12);
        assert_eq!(over_budgets(&[Crossing::Below, Crossing::Never]), Crossing::Below);
        assert_eq!(over_budgets(&[]), Crossing::Never);
    }
}
