//! Compares the renders of a study with its targets, and answers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::ablation::ablation;
use super::answer::{Question, answer_curves, answer_points};
use super::candidate::{Candidate, GOLD, Settings, at_finest_step};
use super::convergence::convergence;
use super::headline::headline;
use super::job::REFERENCE;
use super::metric::{Options, compare, default_epsilon};
use super::plan::{Basis, Plan};
use super::request::Metric;
use super::results::{Answer, Measured, PointResult, Results, TrialResult};
use super::run::Study;
use super::split::{Measurement, displaced};
use super::statistics::{CONFIDENCE, Interval};
use super::target::{Pictures, Target, mean};
use super::trial::Trial;
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
        let trials: Vec<&Trial> = jobs.iter().filter_map(|job| self.store.find(job)).collect();
        let mut options =
            Options { exposure: self.scene.film.shown().exposure, ..Options::default() };
        let mut targets = Vec::new();
        for name in [GOLD, REFERENCE] {
            let renders: Vec<&Trial> =
                trials.iter().copied().filter(|trial| trial.candidate == name).collect();
            if renders.is_empty() {
                continue;
            }
            let (target, pictures) = self.target(name, &renders, &mut options)?;
            targets.push((target, pictures));
        }
        progress.stage("comparing", trials.len() as u64);
        let candidates = std::iter::once(Candidate::gold(gold)).chain(plan.candidates(gold));
        let mut points = Vec::new();
        for candidate in candidates {
            for (index, point) in candidate.points.iter().enumerate() {
                let of = |t: &&&Trial| t.candidate == candidate.name && t.point == index;
                let trials: Vec<&Trial> = trials.iter().filter(of).copied().collect();
                let makes_step_errors =
                    basis.has_grids && at_finest_step(&point.settings).is_some();
                let step = StepMeasured { is_exact: !makes_step_errors, rounds: plan.step_seeds };
                let mut result = self.point(&trials, &targets, step, &options, progress)?;
                result.about = candidate.about.into();
                result.label.clone_from(&point.label);
                result.settings = Settings::from(&point.settings);
                points.push(result);
            }
        }
        progress.finish();
        let targets: Vec<Target> = targets.into_iter().map(|(target, _)| target).collect();
        let target = &targets[targets.len() - 1];
        let question = Question { target, metric: self.request.metric };
        answer_points(&mut points, question);
        let curves = answer_curves(&points, question, &self.request.errors);
        let ablation = ablation(&points, question);
        let convergence = convergence(&points, question);
        let headline = headline(&points, question);
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
        renders: &[&Trial],
        options: &mut Options,
    ) -> Result<(Target, Pictures)> {
        let folder = self.store.folder();
        let (pictures, own) = Pictures::of(folder, renders, options)?;
        options.epsilon = options.epsilon.or_else(|| default_epsilon(&pictures.mean));
        let exr = format!("exr/{name}-mean.exr");
        write_exr_image(&folder.join(&exr), &pictures.mean)?;
        let pixels = u64::from(self.store.header.size[0]) * u64::from(self.store.header.size[1]);
        let rays = |t: &&Trial| t.work.get("rays").and_then(serde_json::Value::as_u64);
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
        all: &[&Trial],
        targets: &[(Target, Pictures)],
        step: StepMeasured,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<PointResult> {
        let (finest, trials): (Vec<&Trial>, Vec<&Trial>) =
            all.iter().copied().partition(|trial| trial.finest_step);
        let read = |trials: &[&Trial]| -> Result<Vec<Image>> {
            let read = |trial: &&Trial| read_exr(&self.store.folder().join(&trial.exr));
            trials.par_iter().map(read).collect()
        };
        let images = read(&trials)?;
        let is_part = |trial: &Trial, target: &Target| trial.candidate == target.name;
        let results: Vec<TrialResult> = trials
            .par_iter()
            .zip(&images)
            .map(|(trial, image)| {
                let mut errors = BTreeMap::new();
                for (target, pictures) in targets {
                    let of = if is_part(trial, target) {
                        pictures.without(trial.round)
                    } else {
                        &pictures.mean
                    };
                    errors.insert(target.name.clone(), compare(of, image, options)?.errors);
                }
                progress.advance(1);
                Ok(TrialResult { trial: (*trial).clone(), errors })
            })
            .collect::<Result<_>>()?;
        let seconds: Vec<f64> = trials.iter().map(|trial| trial.seconds).collect();
        let lost = || Error::file(self.store.folder(), "lost trials; go on with --resume");
        let first = trials.first().ok_or_else(lost)?;
        let metric = self.request.metric;
        let measured = targets.iter().filter_map(|(target, _)| {
            let errors: Option<Vec<f64>> =
                results.iter().map(|r| metric.of(&r.errors[&target.name])).collect();
            let error = Interval::of(&errors?)?;
            let own = metric.of(&target.own)?;
            let trusted = Target::is_trusted(own, error.estimate) && !is_part(first, target);
            Some((target.name.clone(), Measured { error, trusted }))
        });
        let (target, pictures) = &targets[targets.len() - 1];
        let whole = mean(&images.iter().collect::<Vec<_>>()).filter(|_| !is_part(first, target));
        let steps: Vec<Image> = read(&finest)?
            .iter()
            .zip(&finest)
            .filter_map(|(fine, trial)| {
                let same = trials.iter().position(|other| other.round == trial.round)?;
                Some(displaced(&pictures.mean, &images[same], fine))
            })
            .collect();
        let is_told = step.is_exact || step.rounds > 1;
        let split = |metric: Metric| {
            let errors = results.iter().map(|r| metric.of(&r.errors[&target.name]));
            let measurement = Measurement {
                target: &pictures.mean,
                own: metric.of(&target.own)?,
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
            seconds: Interval::of(&seconds).ok_or_else(lost)?,
            errors: measured.collect(),
            speed_up: None,
            gain_at_equal_error: Answer::None(String::new()),
            gain_at_equal_time: Answer::None(String::new()),
            mse_split: split(Metric::Mse),
            relative_mse_split: split(Metric::RelativeMse),
            trials: results,
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
