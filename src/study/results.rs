//! Results of a study: the schema of `results.json`, and `results.csv`.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::ablation::Effect;
use super::candidate::Settings;
use super::convergence::Convergence;
use super::headline::Headline;
use super::job::Run;
use super::machine::Machine;
use super::measured::{CurveResult, PointResult};
use super::metric::{Errors, Options};
use super::plan::Plan;
use super::request::{Metric, Request};
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
