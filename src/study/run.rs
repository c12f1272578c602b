//! Runs a study: renders what is missing, compares, answers.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;

use super::answer::{Question, answer_curves, answer_points};
use super::candidate::{Candidate, GOLD, Settings};
use super::metric::{Options, compare, default_epsilon, mse, relative_map};
use super::plan::{Costs, Job, Plan, REFERENCE, gold_job};
use super::request::{Metric, Request};
use super::results::{Answer, Measured, PointResult, Results, Split, TrialResult};
use super::statistics::{CONFIDENCE, Interval};
use super::store::{Header, Store};
use super::target::{Pictures, Target, mean};
use super::trial::{Trial, rendered, stages};
use super::verdict::verdict;
use crate::error::{Error, Result};
use crate::image::{Image, read_exr, write_exr_image};
use crate::render::{Progress, Silent};
use crate::scene::{RenderSettings, Scene};

/// A study of one scene in one folder.
#[derive(Debug)]
pub struct Study<'a> {
    scene: &'a Scene,
    request: Request,
    store: Store,
}

impl<'a> Study<'a> {
    /// Begins a study of `scene` in `folder`, which is made where it is missing; with `resume`
    /// goes on with what lies there.
    ///
    /// # Errors
    /// Where the request is out of range, the folder cannot be used, or a study lies in it that is
    /// not to be resumed or is of something else.
    pub fn new(scene: &'a Scene, folder: &Path, request: &Request, resume: bool) -> Result<Self> {
        request.check()?;
        let store = Store::open(folder, Header::new(scene, request), resume)?;
        Ok(Self { scene, request: request.clone(), store })
    }

    /// Renders all that is not yet on disk and writes it there at once, then compares it, answers
    /// and writes `results.json` and `results.csv`. `command` is what asked for it.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled or a file cannot be written or read.
    pub fn run(mut self, command: &str, progress: &dyn Progress) -> Result<Results> {
        let gold = Candidate::gold(&self.scene.render).points[0].settings;
        let plan = self.plan(&gold)?;
        let jobs = plan.jobs(&self.request, &gold);
        self.render(&jobs, progress)?;
        let results = self.analyse(&gold, plan, command, progress)?;
        results.write(self.store.folder())?;
        Ok(results)
    }

    /// What is rendered: as asked, or what fits in the time given as first renders tell.
    fn plan(&mut self, gold: &RenderSettings) -> Result<Plan> {
        if let Some(plan) = &self.store.header.plan {
            return Ok(plan.clone());
        }
        let plan = if let Some(seconds) = self.request.seconds {
            let start = Instant::now();
            let costs = self.costs(gold)?;
            let left = seconds - start.elapsed().as_secs_f64();
            Plan::fitting(&self.request, gold, &costs, left)
        } else {
            Plan::asked(&self.request, gold)
        };
        self.store.settle(plan.clone())?;
        Ok(plan)
    }

    fn costs(&mut self, gold: &RenderSettings) -> Result<Costs> {
        let job = gold_job(gold, 0);
        self.render(std::slice::from_ref(&job), &Silent)?;
        let missing = || Error::file(self.store.folder(), "lost its first trial");
        let first = self.store.find(&job).ok_or_else(missing)?;
        let settings = RenderSettings { rays: 1, ..job.settings };
        let (least, film) = Trial::run(self.scene, &Job { settings, ..job.clone() })?;
        let reference = if self.request.reference.is_some() {
            let rendered = rendered(self.scene, &settings, true)?;
            stages(&rendered).iter().map(|(_, seconds)| seconds).sum()
        } else {
            0.0
        };
        let full = read_exr(&self.store.folder().join(&first.exr))?;
        let start = Instant::now();
        compare(&full, &film.image(), &Options::default())?;
        // Pictures are compared side by side, one a thread.
        let comparing = start.elapsed().as_secs_f64() / rayon::current_num_threads() as f64;
        Ok(Costs { gold: first.seconds, least: least.seconds, reference, comparing })
    }

    fn render(&mut self, jobs: &[Job], progress: &dyn Progress) -> Result<()> {
        let missing: Vec<&Job> = jobs.iter().filter(|job| self.store.find(job).is_none()).collect();
        if missing.is_empty() {
            return Ok(());
        }
        progress.stage("trials", missing.len() as u64);
        for job in missing {
            let (trial, film) = Trial::run(self.scene, job)?;
            self.store.add(trial, &film)?;
            progress.advance(1);
        }
        progress.finish();
        Ok(())
    }

    fn analyse(
        &self,
        gold: &RenderSettings,
        plan: Plan,
        command: &str,
        progress: &dyn Progress,
    ) -> Result<Results> {
        let jobs = plan.jobs(&self.request, gold);
        let trials: Vec<&Trial> = jobs.iter().filter_map(|job| self.store.find(job)).collect();
        let mut options = Options { exposure: self.scene.film.exposure, ..Options::default() };
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
        let candidates = std::iter::once(Candidate::gold(gold)).chain(Candidate::all(
            gold,
            &self.request.candidates,
            &plan.budgets,
        ));
        let mut points = Vec::new();
        for candidate in candidates {
            for (index, point) in candidate.points.iter().enumerate() {
                let of = |t: &&&Trial| t.candidate == candidate.name && t.point == index;
                let trials: Vec<&Trial> = trials.iter().filter(of).copied().collect();
                let mut result = self.point(&trials, &targets, &options, progress)?;
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
            metrics: options,
            statistics: format!(
                "geometric means over seeds with Student's t intervals of the logarithms at {} %; \
                 ratios are paired by seed",
                100.0 * CONFIDENCE
            ),
            targets,
            points,
            curves,
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
        trials: &[&Trial],
        targets: &[(Target, Pictures)],
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<PointResult> {
        let images: Vec<Image> = trials
            .par_iter()
            .map(|trial| read_exr(&self.store.folder().join(&trial.exr)))
            .collect::<Result<_>>()?;
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
        let split = |metric: Metric| {
            let errors = results.iter().map(|r| metric.of(&r.errors[&target.name]));
            let of_mean = squared(metric, &pictures.mean, whole.as_ref()?, options)?;
            split(&errors.collect::<Option<Vec<_>>>()?, of_mean, metric.of(&target.own)?)
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
        })
    }
}

/// A squared error of one picture.
fn squared(metric: Metric, reference: &Image, image: &Image, options: &Options) -> Option<f64> {
    match metric {
        Metric::Mse => Some(mse(reference, image)),
        Metric::RelativeMse => {
            options.epsilon.map(|epsilon| relative_map(reference, image, epsilon).mean())
        }
        _ => None,
    }
}

/// Noise and bias of renders with these squared `errors`, whose mean picture has `of_mean` and
/// whose target has `own`. With n renders the mean of `errors` is bias + noise + own and `of_mean`
/// bias + noise / n + own.
fn split(errors: &[f64], of_mean: f64, own: f64) -> Option<Split> {
    let n = errors.len() as f64;
    let all = errors.iter().sum::<f64>() / n;
    let noise = (all - of_mean) * n / (n - 1.0);
    (errors.len() > 1).then(|| Split { noise, bias: of_mean - noise / n - own })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_and_bias_of_numbers_worked_by_hand() {
        // Two renders 1 and 3 of a target 0: errors 1 and 9, mean picture 2 with error 4. The
        // variance is 2, and the squared bias 4 less half of it.
        assert_eq!(split(&[1.0, 9.0], 4.0, 0.0), Some(Split { noise: 2.0, bias: 3.0 }));
        assert_eq!(split(&[1.0, 9.0], 4.0, 0.5), Some(Split { noise: 2.0, bias: 2.5 }));
        assert_eq!(split(&[1.0], 1.0, 0.0), None);
    }
}
