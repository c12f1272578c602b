//! Compares the renders of a study with its targets, and answers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::ablation::ablation;
use super::candidate::{Candidate, GOLD, Settings, at_finest_step};
use super::convergence::convergence;
use super::gain::{ErrorMeasure, curve_results, fill_gains};
use super::headline::headline;
use super::job::{Basis, REFERENCE, Run};
use super::measured::{Estimate, Measured, PointResult, RunResult};
use super::metric::{Options, compare, default_epsilon};
use super::plan::Plan;
use super::request::Metric;
use super::results::Results;
use super::runner::Study;
use super::split::{Measurement, displaced};
use super::statistics::{CONFIDENCE, Interval};
use super::target::{Target, TargetImages, mean};
use super::verdict::verdict;
use crate::error::{Error, Result};
use crate::image::{Image, read_exr, write_exr_image};
use crate::render::Progress;

impl Study<'_> {
    /// What the renders of `plan` say.
    pub(super) fn analyse(
        &self,
        basis: Basis<'_>,
        plan: Plan,
        command: &str,
        progress: &dyn Progress,
    ) -> Result<Results> {
        let gold = basis.gold;
        let jobs = plan.jobs(basis);
        let runs: Vec<&Run> = jobs.iter().filter_map(|job| self.store.find(job)).collect();
        let mut options =
            Options { exposure: self.scene.film.shown().exposure, ..Options::default() };
        let mut targets = Vec::new();
        for name in [GOLD, REFERENCE] {
            let renders: Vec<&Run> =
                runs.iter().copied().filter(|run| run.candidate == name).collect();
            if renders.is_empty() {
                continue;
            }
            let (target, pictures) = self.target(name, &renders, &mut options)?;
            targets.push((target, pictures));
        }
        progress.stage("comparing", runs.len() as u64);
        let candidates = std::iter::once(Candidate::gold(gold)).chain(plan.candidates(gold));
        let mut points = Vec::new();
        for candidate in candidates {
            for (index, point) in candidate.points.iter().enumerate() {
                let of = |t: &&&Run| t.candidate == candidate.name && t.point == index;
                let runs: Vec<&Run> = runs.iter().filter(of).copied().collect();
                let makes_step_errors =
                    basis.has_grids && at_finest_step(&point.settings).is_some();
                let step = StepMeasured { is_exact: !makes_step_errors, rounds: plan.step_seeds };
                let mut result = self.point(&runs, &targets, step, &options, progress)?;
                result.about = candidate.about.into();
                result.label.clone_from(&point.label);
                result.settings = Settings::from(&point.settings);
                points.push(result);
            }
        }
        progress.finish();
        let targets: Vec<Target> = targets.into_iter().map(|(target, _)| target).collect();
        let target = &targets[targets.len() - 1];
        let measure = ErrorMeasure { target, metric: self.request.metric };
        fill_gains(&mut points, measure);
        let curves = curve_results(&points, measure, &self.request.errors);
        let ablation = ablation(&points, measure);
        let convergence = convergence(&points, measure);
        let headline = headline(&points, measure);
        let header = &self.store.header;
        let mut results = Results {
            schema: header.schema,
            version: header.version.clone(),
            command: command.into(),
            machine: header.machine.clone(),
            scene: header.scene.clone(),
            hash: header.hash.clone(),
            size: header.size,
            seed: header.seed,
            gold: Settings::from(gold),
            request: self.request.clone(),
            plan,
            view: self.scene.film.shown(),
            metrics: options,
            statistics: format!(
                "Geometric means over seeds with Student's t intervals of the logarithms at {} %; \
                 ratios are paired by seed",
                100.0 * CONFIDENCE
            ),
            targets,
            points,
            curves,
            ablation,
            convergence,
            headline,
            verdict: Vec::new(),
        };
        results.verdict = verdict(&results);
        Ok(results)
    }

    /// The target made of `renders`, written beside them. The first fixes the epsilon of relative
    /// errors for all.
    fn target(
        &self,
        name: &str,
        renders: &[&Run],
        options: &mut Options,
    ) -> Result<(Target, TargetImages)> {
        let folder = self.store.folder();
        let (pictures, own) = TargetImages::from_runs(folder, renders, options)?;
        options.epsilon = options.epsilon.or_else(|| default_epsilon(&pictures.mean));
        let exr = format!("exr/{name}-mean.exr");
        write_exr_image(&folder.join(&exr), &pictures.mean)?;
        let pixels = u64::from(self.store.header.size[0]) * u64::from(self.store.header.size[1]);
        let rays = |t: &&Run| t.work.get("rays").and_then(serde_json::Value::as_u64);
        let target = Target {
            name: name.into(),
            renders: renders.len(),
            rays: renders.iter().filter_map(rays).sum::<u64>() / pixels,
            seconds: renders.iter().map(|t| t.seconds).sum::<f64>() / renders.len() as f64,
            own,
            exr,
        };
        Ok((target, pictures))
    }

    /// Compares all renders of a point with all targets. Gold is compared with the half of the
    /// gold standard that it is no part of.
    fn point(
        &self,
        all: &[&Run],
        targets: &[(Target, TargetImages)],
        step: StepMeasured,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<PointResult> {
        let (finest, runs): (Vec<&Run>, Vec<&Run>) =
            all.iter().copied().partition(|run| run.finest_step);
        let read = |runs: &[&Run]| -> Result<Vec<Image>> {
            let read = |run: &&Run| read_exr(&self.store.folder().join(&run.exr));
            runs.par_iter().map(read).collect()
        };
        let images = read(&runs)?;
        let is_part = |run: &Run, target: &Target| run.candidate == target.name;
        let results: Vec<RunResult> = runs
            .par_iter()
            .zip(&images)
            .map(|(run, image)| {
                let mut errors = BTreeMap::new();
                for (target, pictures) in targets {
                    let of = if is_part(run, target) {
                        pictures.without(run.round)
                    } else {
                        &pictures.mean
                    };
                    errors.insert(target.name.clone(), compare(of, image, options)?.errors);
                }
                progress.advance(1);
                Ok(RunResult { run: (*run).clone(), errors })
            })
            .collect::<Result<_>>()?;
        let seconds: Vec<f64> = runs.iter().map(|run| run.seconds).collect();
        let lost = || Error::file(self.store.folder(), "lost runs; go on with --resume");
        let first = runs.first().ok_or_else(lost)?;
        let metric = self.request.metric;
        let measured = targets.iter().filter_map(|(target, _)| {
            let errors: Option<Vec<f64>> =
                results.iter().map(|r| metric.value(&r.errors[&target.name])).collect();
            let error = Interval::from_values(&errors?)?;
            let own = metric.value(&target.own)?;
            let trusted = Target::is_trusted(own, error.estimate) && !is_part(first, target);
            Some((target.name.clone(), Measured { error, trusted }))
        });
        let (target, pictures) = &targets[targets.len() - 1];
        let whole = mean(&images.iter().collect::<Vec<_>>()).filter(|_| !is_part(first, target));
        let steps: Vec<Image> = read(&finest)?
            .iter()
            .zip(&finest)
            .filter_map(|(fine, run)| {
                let same = runs.iter().position(|other| other.round == run.round)?;
                Some(displaced(&pictures.mean, &images[same], fine))
            })
            .collect();
        let is_told = step.is_exact || step.rounds > 1;
        let split = |metric: Metric| {
            let errors = results.iter().map(|r| metric.value(&r.errors[&target.name]));
            let measurement = Measurement {
                target: &pictures.mean,
                own: metric.value(&target.own)?,
                mean: whole.as_ref()?,
                steps: is_told.then_some(&steps),
            };
            measurement.split(&errors.collect::<Option<Vec<_>>>()?, metric, options)
        };
        Ok(PointResult {
            candidate: first.candidate.clone(),
            about: String::new(),
            label: String::new(),
            settings: self.store.header.gold.clone(),
            seconds: Interval::from_values(&seconds).ok_or_else(lost)?,
            errors: measured.collect(),
            speed_up: None,
            gain_at_equal_error: Estimate::None(String::new()),
            gain_at_equal_time: Estimate::None(String::new()),
            mse_split: split(Metric::Mse),
            relative_mse_split: split(Metric::RelativeMse),
            runs: results,
            finest_step: finest.into_iter().cloned().collect(),
        })
    }
}

/// What is known of a point's step error.
#[derive(Clone, Copy)]
struct StepMeasured {
    /// There is none.
    is_exact: bool,
    /// Seeds that were rendered with the finest step as well.
    rounds: u32,
}
