//! Results of a study: the schema of `results.json`, and `results.csv`.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::ablation::Effect;
use super::candidate::Settings;
use super::convergence::Convergence;
use super::headline::Headline;
use super::job::Run;
use super::machine::Machine;
use super::metric::{Errors, Options};
use super::plan::Plan;
use super::request::{Metric, Request};
use super::split::Split;
use super::statistics::Interval;
use super::target::Target;
use crate::error::{Error, Result};
use crate::file;
use crate::image::View;

/// The version of the schema; it changes where a field changes its meaning or goes.
pub const SCHEMA: u32 = 3;

/// Results of a study, with all that is needed to repeat it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`SCHEMA`].
    pub schema: u32,
    /// fogbow's version.
    pub version: String,
    /// The command line.
    pub command: String,
    /// The machine.
    pub machine: Machine,
    /// The scene file.
    pub scene: PathBuf,
    /// Hash of the scene and of all files it names.
    pub hash: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The seed that all others are counted from.
    pub seed: u64,
    /// The gold standard.
    pub gold: Settings,
    /// The request.
    pub request: Request,
    /// The plan as it was done: with fewer seeds where time ran out.
    pub plan: Plan,
    /// How the scene's film shows pictures.
    pub view: View,
    /// How errors were counted.
    pub metrics: Options,
    /// How intervals were made.
    pub statistics: String,
    /// Gold and, where requested, reference; answers use the last.
    pub targets: Vec<Target>,
    /// Gold, then every candidate at every budget.
    pub points: Vec<PointResult>,
    /// Results of candidates over all budgets.
    pub curves: Vec<CurveResult>,
    /// Effect of each part of the director.
    pub ablation: Vec<Effect>,
    /// Errors against photons, beside theory; `None` where that was not measured.
    pub convergence: Option<Convergence>,
    /// Gold, directed candidate and uniform sampling compared; `None` where no candidate is directed.
    pub headline: Option<Headline>,
    /// The findings in sentences, the answer first.
    pub verdict: Vec<String>,
}

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
    /// The error that answers are about, by each target's name.
    pub errors: BTreeMap<String, Measured>,
    /// Gold's run time over its own, paired by round.
    pub speed_up: Option<Interval>,
    /// Run time of `fixed` at its error over its own, paired by round: above 1 it wins.
    pub gain_at_equal_error: Answer,
    /// Error of `fixed` in its run time over its own, paired by round: above 1 it wins.
    pub gain_at_equal_time: Answer,
    /// Where the error comes from, by MSE; nothing for one seed.
    pub mse_split: Option<Split>,
    /// The same by relative MSE.
    pub relative_mse_split: Option<Split>,
}

/// An error with what it may be said of.
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

/// An answer, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The answer.
    Found(Interval),
    /// Why there is none.
    None(String),
}

/// Results of a candidate over all its budgets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveResult {
    /// Its name.
    pub candidate: String,
    /// Seconds to reach each of the errors asked for.
    pub time_to: Vec<(f64, Answer)>,
    /// Slope of log MSE over log rays shot; -1 is that of independent samples.
    pub slope: Option<f64>,
}

impl Results {
    /// The target that answers are about.
    pub fn target(&self) -> &Target {
        &self.targets[self.targets.len() - 1]
    }

    /// The error that answers are about.
    pub fn metric(&self) -> Metric {
        self.request.metric
    }

    /// Writes `results.json` and `results.csv` to `folder`.
    ///
    /// # Errors
    /// Where one cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = folder.join("results.json");
        let text = serde_json::to_vec_pretty(self)
            .map_err(|e| Error::file(&path, format!("cannot be told as JSON: {e}")))?;
        file::write(&path, |out| out.write_all(&text))?;
        file::write(&folder.join("results.csv"), |out| self.write_csv(out))
    }

    /// Writes one row for each run and target.
    fn write_csv(&self, out: impl Write) -> std::io::Result<()> {
        let mut csv = csv::Writer::from_writer(out);
        let fixed = [
            "candidate",
            "label",
            "round",
            "seed",
            "rays",
            "photons",
            "director",
            "x",
            "operator",
            "directs",
            "tolerance",
            "seconds",
            "rays_shot",
            "target",
        ];
        let made = ["version", "scene", "scene_hash", "size", "machine", "command", "exr"];
        let metrics = Metric::ALL.iter().map(|row| row.0);
        csv.write_record(fixed.into_iter().chain(metrics).chain(["mean_ratio"]).chain(made))?;
        for point in &self.points {
            for result in &point.runs {
                for (target, errors) in &result.errors {
                    csv.write_record(self.row(point, &result.run, target, errors))?;
                }
            }
        }
        csv.flush()
    }

    fn row(&self, point: &PointResult, run: &Run, target: &str, errors: &Errors) -> Vec<String> {
        let number = |v: Option<f64>| v.map(|v| v.to_string()).unwrap_or_default();
        let settings = &point.settings;
        let mut row = vec![
            point.candidate.clone(),
            point.label.clone(),
            run.round.to_string(),
            run.seed.to_string(),
            settings.rays.to_string(),
            settings.photons.to_string(),
            settings.director.clone(),
            settings.x.clone(),
            settings.operator.clone(),
            settings.directs.clone(),
            settings.tolerance.to_string(),
            run.seconds.to_string(),
            run.work.get("rays").map(ToString::to_string).unwrap_or_default(),
            target.to_owned(),
        ];
        row.extend(Metric::ALL.iter().map(|(_, metric, _)| number(metric.value(errors))));
        row.push(number(errors.mean_ratio));
        row.extend([
            self.version.clone(),
            self.scene.display().to_string(),
            self.hash.clone(),
            format!("{}x{}", self.size[0], self.size[1]),
            self.machine.to_string(),
            self.command.clone(),
            run.exr.clone(),
        ]);
        row
    }
}
