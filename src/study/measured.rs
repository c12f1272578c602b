//! Measurements of candidates: points, runs, errors, and estimates from them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::candidate::Settings;
use super::job::Run;
use super::metric::Errors;
use super::split::ErrorSplit;
use super::statistics::Interval;

/// A candidate at one budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointResult {
    /// Its name in [`CANDIDATES`](super::CANDIDATES), or `gold`.
    pub candidate: String,
    /// What it is.
    pub about: String,
    /// Its budget.
    pub label: String,
    /// How it was rendered, but for seeds.
    pub settings: Settings,
    /// Its runs by seed.
    #[serde(rename = "trials")]
    pub runs: Vec<RunResult>,
    /// Runs with the same seeds and the finest march step, for the step error.
    pub finest_step: Vec<Run>,
    /// Run time in seconds, without loading and writing.
    pub seconds: Interval,
    /// The error by the study's metric, by each target's name.
    pub errors: BTreeMap<String, Measured>,
    /// Gold's run time over its own, paired by round.
    pub speed_up: Option<Interval>,
    /// Run time of `fixed` at its error over its own, paired by round: above 1 it wins.
    pub gain_at_equal_error: Estimate,
    /// Error of `fixed` in its run time over its own, paired by round: above 1 it wins.
    pub gain_at_equal_time: Estimate,
    /// The parts of the error, by MSE; `None` for one seed.
    pub mse_split: Option<ErrorSplit>,
    /// The same by relative MSE.
    pub relative_mse_split: Option<ErrorSplit>,
}

/// An error, and whether the target is exact enough for a verdict on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The error over seeds.
    pub error: Interval,
    /// Whether the target's own error is at most a third of it; else no verdict is given.
    pub trusted: bool,
}

/// A run with its errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// The run.
    #[serde(flatten)]
    pub run: Run,
    /// Errors by every metric, by each target's name.
    pub errors: BTreeMap<String, Errors>,
}

/// An interval, or the reason why there is none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimate {
    /// The interval.
    Found(Interval),
    /// Why there is none.
    None(String),
}

/// Results of a candidate over all its budgets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveResult {
    /// Its name.
    pub candidate: String,
    /// Seconds to reach each of the requested errors.
    pub time_to: Vec<(f64, Estimate)>,
    /// Slope of log MSE over log rays shot; -1 is that of independent samples.
    pub slope: Option<f64>,
}
