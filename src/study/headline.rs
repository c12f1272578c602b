//! The answer of a study: gold against the directed candidate against uniform sampling.

use serde::{Deserialize, Serialize};

use super::answer::{Question, UNIFORM};
use super::candidate::{GOLD, subject};
use super::contrast::{MOST_SEEDS, Outcome, seeds_to_settle};
use super::curve::Curve;
use super::results::{PointResult, TrialResult};
use super::statistics::Interval;
use super::target::Target;

/// What more seeds take beside their renders, as a factor: comparing and writing.
const OVERHEAD: f64 = 1.2;

/// The directed candidate at the largest budget, beside gold and uniform sampling.
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
    /// The error of uniform sampling in its run time over its own, each less the target's own error
    /// where it is a squared one. Where it is slower than gold or quicker than the fewest rays, in
    /// favour of uniform sampling ([`Curve::favoured_error_at`]).
    pub error_gain: Contrast,
    /// Its error over that of one gold standard, likewise.
    pub error_cost: Contrast,
    /// What would settle what is open; nothing where nothing is.
    pub settling: Option<Settling>,
}

/// A ratio over rounds, and what it says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// The ratio, paired by round; nothing where it was not measured.
    pub ratio: Option<Interval>,
    /// What its interval says.
    pub outcome: Outcome,
}

/// What would settle what is open.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settling {
    /// Seeds in all; nothing where [`MOST_SEEDS`] would not do.
    pub seeds: Option<u32>,
    /// Seconds for those that are not there yet.
    pub seconds: Option<f64>,
}

impl Contrast {
    fn of(ratios: &[f64]) -> Self {
        let ratio = Interval::of(ratios);
        let outcome = ratio.as_ref().map_or(Outcome::Open, Outcome::of);
        Self { ratio, outcome }
    }

    /// Seeds that would tell, where it is open and was measured at all.
    fn wanted(&self) -> Option<Option<u32>> {
        let ratio = self.ratio.as_ref().filter(|_| self.outcome == Outcome::Open)?;
        Some(seeds_to_settle(ratio))
    }
}

/// The headline of `points`, nothing where no candidate is directed.
pub(super) fn headline(points: &[PointResult], question: Question<'_>) -> Option<Headline> {
    let names: Vec<String> = points.iter().map(|point| point.candidate.clone()).collect();
    let directed = names.into_iter().filter(|name| name != GOLD).collect::<Vec<_>>();
    let name = subject(&directed)?;
    let point = points.iter().find(|point| point.candidate == name)?;
    let gold = points.iter().find(|point| point.candidate == GOLD)?;
    let over = |of: &dyn Fn(&TrialResult) -> Option<f64>| {
        Contrast::of(&point.trials.iter().filter_map(of).collect::<Vec<_>>())
    };
    let same_round = |result: &TrialResult| {
        gold.trials.iter().find(|other| other.trial.round == result.trial.round)
    };
    let time_saved = over(&|result| Some(same_round(result)?.trial.seconds / result.trial.seconds));
    let error_gain = over(&|result| {
        let uniform = uniform_curve(points, question, result.trial.round)?;
        Some(uniform.favoured_error_at(result.trial.seconds)? / question.corrected(result)?)
    });
    let error_cost = over(&|result| {
        Some(question.corrected(result)? / question.corrected(same_round(result)?)?)
    });
    let error = point.errors.get(&question.target.name).map(|measured| measured.error.clone());
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
    headline.settling = settling(&headline, points, question);
    Some(headline)
}

/// Uniform sampling in one round, gold at its end; nothing where it was not measured.
fn uniform_curve(points: &[PointResult], question: Question<'_>, round: u32) -> Option<Curve> {
    let of = |name: &'static str| {
        let results = points.iter().filter(move |p| p.candidate == name).flat_map(|p| &p.trials);
        results.filter(move |result| result.trial.round == round)
    };
    of(UNIFORM).next()?;
    let both = of(UNIFORM).chain(of(GOLD));
    Some(Curve::new(both.filter_map(|r| Some((r.trial.seconds, question.corrected(r)?)))))
}

/// What would settle the time saved, the gain over uniform sampling and, against the gold standard,
/// how far its error can be trusted.
fn settling(
    headline: &Headline,
    points: &[PointResult],
    question: Question<'_>,
) -> Option<Settling> {
    let now = u32::try_from(headline.seconds.samples).unwrap_or(MOST_SEEDS);
    let own = headline.error.as_ref().map(|error| (question.own(), error.estimate));
    let blurred = own.filter(|(own, error)| !Target::is_trusted(*own, *error));
    let for_trust = blurred.filter(|_| question.target.name == GOLD).map(|(own, error)| {
        let seeds = (f64::from(now) * Target::renders_wanted(own, error)).ceil();
        (seeds <= f64::from(MOST_SEEDS)).then_some((seeds as u32).max(now + 1))
    });
    let open = [headline.time_saved.wanted(), headline.error_gain.wanted(), for_trust];
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
    Some(Settling { seeds, seconds })
}
