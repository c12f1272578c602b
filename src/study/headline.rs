//! The headline of a study: the directed candidate against gold and against uniform sampling.

use serde::{Deserialize, Serialize};

use super::candidate::{GOLD, subject};
use super::contrast::{MOST_SEEDS, Outcome, seeds_to_settle};
use super::curve::Curve;
use super::gain::{ErrorMeasure, UNIFORM};
use super::measured::{PointResult, RunResult};
use super::statistics::Interval;
use super::target::Target;

/// Time for more seeds over the time of their renders: pictures are compared and written too.
const OVERHEAD: f64 = 1.2;

/// The directed candidate at its largest budget against gold and uniform sampling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Headline {
    /// The candidate's name.
    pub candidate: String,
    /// Its budget.
    pub label: String,
    /// Its run time in seconds.
    pub seconds: Interval,
    /// Gold's.
    pub gold_seconds: Interval,
    /// Its error against the target as measured, by the study's metric.
    pub error: Option<Interval>,
    /// Gold's run time over its own.
    pub time_saved: Contrast,
    /// The error of uniform sampling in the candidate's run time over the candidate's error; the target's
    /// own error is subtracted from squared errors. Beyond the measured curve the error of uniform
    /// sampling is extrapolated in its favour ([`Curve::favoured_error_at`]).
    pub error_gain: Contrast,
    /// The candidate's error over that of one render of gold; the target's own error is subtracted from
    /// squared errors.
    pub error_cost: Contrast,
    /// Seeds that would decide the contrasts; `None` where all are decided.
    pub settling: Option<SeedsToSettle>,
}

/// A ratio over rounds, with the outcome of its interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// The ratio, paired by round; `None` where it was not measured.
    pub ratio: Option<Interval>,
    /// The outcome of its interval.
    pub outcome: Outcome,
}

/// Seeds and time that would decide all contrasts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeedsToSettle {
    /// Seeds in all; `None` where even [`MOST_SEEDS`] would not decide.
    pub seeds: Option<u32>,
    /// Seconds for the seeds that have not been rendered.
    pub seconds: Option<f64>,
}

impl Contrast {
    fn from_ratios(ratios: &[f64]) -> Self {
        let ratio = Interval::from_values(ratios);
        let outcome = ratio.as_ref().map_or(Outcome::Open, Outcome::from_interval);
        Self { ratio, outcome }
    }

    /// Seeds that would decide it, where it is undecided: `Some(None)` where [`MOST_SEEDS`] would not.
    fn seeds_wanted(&self) -> Option<Option<u32>> {
        let ratio = self.ratio.as_ref().filter(|_| self.outcome == Outcome::Open)?;
        Some(seeds_to_settle(ratio))
    }
}

/// The headline of `points`; `None` where no candidate is directed.
pub(super) fn headline(points: &[PointResult], measure: ErrorMeasure<'_>) -> Option<Headline> {
    let names: Vec<String> = points.iter().map(|point| point.candidate.clone()).collect();
    let directed = names.into_iter().filter(|name| name != GOLD).collect::<Vec<_>>();
    let name = subject(&directed)?;
    let point = points.iter().find(|point| point.candidate == name)?;
    let gold = points.iter().find(|point| point.candidate == GOLD)?;
    let over = |of: &dyn Fn(&RunResult) -> Option<f64>| {
        Contrast::from_ratios(&point.runs.iter().filter_map(of).collect::<Vec<_>>())
    };
    let same_round =
        |result: &RunResult| gold.runs.iter().find(|other| other.run.round == result.run.round);
    let time_saved = over(&|result| Some(same_round(result)?.run.seconds / result.run.seconds));
    let error_gain = over(&|result| {
        let uniform = uniform_curve(points, measure, result.run.round)?;
        Some(uniform.favoured_error_at(result.run.seconds)? / measure.corrected(result)?)
    });
    let error_cost =
        over(&|result| Some(measure.corrected(result)? / measure.corrected(same_round(result)?)?));
    let error = point.errors.get(&measure.target.name).map(|measured| measured.error.clone());
    let mut headline = Headline {
        candidate: name.into(),
        label: point.label.clone(),
        seconds: point.seconds.clone(),
        gold_seconds: gold.seconds.clone(),
        error,
        time_saved,
        error_gain,
        error_cost,
        settling: None,
    };
    headline.settling = settling(&headline, points, measure);
    Some(headline)
}

/// The curve of uniform sampling in one round, with gold as its last point; `None` where it was not
/// measured.
fn uniform_curve(points: &[PointResult], measure: ErrorMeasure<'_>, round: u32) -> Option<Curve> {
    let of = |name: &'static str| {
        let results = points.iter().filter(move |p| p.candidate == name).flat_map(|p| &p.runs);
        results.filter(move |result| result.run.round == round)
    };
    of(UNIFORM).next()?;
    let both = of(UNIFORM).chain(of(GOLD));
    Some(Curve::new(both.filter_map(|r| Some((r.run.seconds, measure.corrected(r)?)))))
}

/// Seeds that would decide the time saved and the gain over uniform sampling, and make the target's own
/// error small enough where gold is the target.
fn settling(
    headline: &Headline,
    points: &[PointResult],
    measure: ErrorMeasure<'_>,
) -> Option<SeedsToSettle> {
    let now = u32::try_from(headline.seconds.samples).unwrap_or(MOST_SEEDS);
    let own = headline.error.as_ref().map(|error| (measure.own(), error.estimate));
    let untrusted = own.filter(|(own, error)| !Target::is_trusted(*own, *error));
    let for_trust = untrusted.filter(|_| measure.target.name == GOLD).map(|(own, error)| {
        let seeds = (f64::from(now) * Target::renders_wanted(own, error)).ceil();
        (seeds <= f64::from(MOST_SEEDS)).then_some((seeds as u32).max(now + 1))
    });
    let open = [headline.time_saved.seeds_wanted(), headline.error_gain.seeds_wanted(), for_trust];
    let wanted: Vec<Option<u32>> = open.into_iter().flatten().collect();
    if wanted.is_empty() {
        return None;
    }
    let seeds =
        wanted.into_iter().collect::<Option<Vec<u32>>>().and_then(|all| all.into_iter().max());
    let core = |point: &&PointResult| {
        [GOLD, UNIFORM, headline.candidate.as_str()].contains(&point.candidate.as_str())
    };
    let round: f64 = points.iter().filter(core).map(|point| point.seconds.estimate).sum();
    let seconds = seeds.map(|seeds| OVERHEAD * round * f64::from(seeds.saturating_sub(now)));
    Some(SeedsToSettle { seeds, seconds })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::candidate::Settings;
    use super::super::job::{REFERENCE, Run};
    use super::super::measured::{Estimate, Measured};
    use super::super::metric::{Errors, Options, compare};
    use super::super::request::Metric;
    use super::*;
    use crate::image::Image;
    use crate::scene::RenderSettings;

    fn errors(relative_mse: f64) -> Errors {
        let grey = Image::new(1, 1, vec![[0.5; 3]]);
        let same = compare(&grey, &grey, &Options::default()).unwrap().errors;
        Errors { relative_mse: Some(relative_mse), ..same }
    }

    /// A candidate with these run times and errors by round.
    fn point(candidate: &str, rounds: &[(f64, f64)]) -> PointResult {
        let run = |(round, (seconds, error)): (u32, &(f64, f64))| RunResult {
            run: Run {
                candidate: candidate.into(),
                point: 0,
                round,
                finest_step: false,
                seed: 0,
                seconds: *seconds,
                stages: Vec::new(),
                radius: None,
                strategy: None,
                work: serde_json::Map::new(),
                exr: String::new(),
            },
            errors: BTreeMap::from([(REFERENCE.into(), errors(*error))]),
        };
        let of = |value: fn(&(f64, f64)) -> f64| {
            Interval::from_values(&rounds.iter().map(value).collect::<Vec<_>>()).unwrap()
        };
        let measured = Measured { error: of(|round| round.1), trusted: true };
        PointResult {
            candidate: candidate.into(),
            about: String::new(),
            label: "8 rays".into(),
            settings: Settings::from(&RenderSettings::default()),
            runs: (0..).zip(rounds).map(run).collect(),
            finest_step: Vec::new(),
            seconds: of(|round| round.0),
            errors: BTreeMap::from([(REFERENCE.into(), measured)]),
            speed_up: None,
            gain_at_equal_error: Estimate::None(String::new()),
            gain_at_equal_time: Estimate::None(String::new()),
            mse_split: None,
            relative_mse_split: None,
        }
    }

    fn made_headline(directed: &[(f64, f64)]) -> Headline {
        let target = Target {
            name: REFERENCE.into(),
            renders: 2,
            rays: 64,
            seconds: 9.0,
            own: errors(0.0),
            exr: String::new(),
        };
        let measure = ErrorMeasure { target: &target, metric: Metric::RelativeMse };
        // Errors as 0.4 over time.
        let points = [
            point(GOLD, &[(4.0, 0.1), (4.1, 0.098), (3.9, 0.102)]),
            point(UNIFORM, &[(1.0, 0.4), (1.02, 0.39), (0.98, 0.41)]),
            point("xs-scattering", directed),
        ];
        headline(&points, measure).unwrap()
    }

    #[test]
    fn ratios_of_a_made_study() {
        let headline = made_headline(&[(2.0, 0.1), (2.04, 0.098), (1.96, 0.102)]);
        assert_eq!(headline.time_saved.outcome, Outcome::Above);
        assert_eq!(headline.error_gain.outcome, Outcome::Above);
        assert_eq!(headline.error_cost.outcome, Outcome::Equal);
        let ratio = |contrast: &Contrast| contrast.ratio.as_ref().unwrap().estimate;
        assert!((ratio(&headline.time_saved) - 2.0).abs() < 0.02);
        assert!((ratio(&headline.error_gain) - 2.0).abs() < 0.02, "{headline:?}");
        assert_eq!(headline.settling, None);
    }

    #[test]
    fn undecided_contrasts_name_the_seeds_that_decide_them() {
        let headline = made_headline(&[(2.0, 0.1), (2.04, 0.3), (1.96, 0.2)]);
        assert_eq!(headline.error_gain.outcome, Outcome::Open);
        let settling = headline.settling.unwrap();
        let seeds = seeds_to_settle(headline.error_gain.ratio.as_ref().unwrap()).unwrap();
        assert_eq!(settling.seeds, Some(seeds));
        // A round takes 4, 1 and 2 seconds.
        let seconds = OVERHEAD * 7.0 * f64::from(seeds - 3);
        assert!((settling.seconds.unwrap() / seconds - 1.0).abs() < 0.01, "{settling:?}");
    }

    #[test]
    fn slower_than_gold_uniform_sampling_is_favoured() {
        // At twice gold's time uniform sampling would have half its error.
        let headline = made_headline(&[(8.0, 0.05), (8.2, 0.049), (7.8, 0.051)]);
        assert_eq!(headline.time_saved.outcome, Outcome::Below);
        assert_eq!(headline.error_gain.outcome, Outcome::Equal, "{:?}", headline.error_gain);
    }
}
