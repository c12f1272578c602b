//! Runs a study: renders what is missing, compares, answers.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::ablation::ablation;
use super::answer::{Question, answer_curves, answer_points};
use super::candidate::{Candidate, GOLD, Settings, at_finest_step};
use super::convergence::convergence;
use super::metric::{Options, compare, default_epsilon};
use super::plan::{Basis, Costs, Job, Plan, REFERENCE, gold_job};
use super::request::{Metric, Request};
use super::results::{Answer, Measured, PointResult, Results, TrialResult};
use super::split::{Measurement, displaced};
use super::statistics::{CONFIDENCE, Interval};
use super::store::{Header, Store};
use super::target::{Pictures, Target, mean};
use super::trial::{Trial, rendered, stages};
use super::verdict::verdict;
use crate::error::{Error, Result};
use crate::image::{Image, read_exr, write_exr_image};
use crate::render::{Progress, Silent};
use crate::scene::{RenderSettings, Scene};

/// The share of a study's time that is kept for its report and for what takes longer than it
/// seemed at first.
const RESERVE: f64 = 0.2;

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
        let request = self.request.clone();
        let has_grids = self.scene.media.detail().is_some();
        let basis = Basis { request: &request, gold: &gold, has_grids };
        let (planned, deadline) = self.plan(basis)?;
        let jobs = planned.jobs(basis);
        self.render(&jobs, deadline, progress)?;
        let missing: Vec<&Job> = jobs.iter().filter(|job| self.store.find(job).is_none()).collect();
        let lost = || Error::file(self.store.folder(), "lost trials; go on with --resume");
        let plan = planned.without(&missing).ok_or_else(lost)?;
        let mut results = self.analyse(basis, plan, progress)?;
        results.command = command.into();
        results.left_out = missing.len();
        results.write(self.store.folder())?;
        Ok(results)
    }

    /// What is rendered: as asked, or what fits in the time given as first renders tell.
    fn plan(&mut self, basis: Basis<'_>) -> Result<(Plan, Option<Deadline>)> {
        if let Some(plan) = &self.store.header.plan {
            return Ok((plan.clone(), None));
        }
        let mut deadline = None;
        let plan = if let Some(seconds) = self.request.seconds {
            let start = Instant::now();
            let costs = self.costs(basis.gold)?;
            let usable = seconds * (1.0 - RESERVE);
            let targets = if self.request.reference.is_some() { 2.0 } else { 1.0 };
            let comparing = targets * costs.comparing;
            deadline = Some(Deadline { start, seconds: usable, comparing, longest: 0.0 });
            Plan::fitting(basis, &costs, usable - start.elapsed().as_secs_f64())
        } else {
            Plan::asked(basis)
        };
        self.store.settle(plan.clone())?;
        Ok((plan, deadline))
    }

    fn costs(&mut self, gold: &RenderSettings) -> Result<Costs> {
        let job = gold_job(gold, 0);
        self.render(std::slice::from_ref(&job), None, &Silent)?;
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
        let (full, least_image) = (read_exr(&self.store.folder().join(&first.exr))?, film.image());
        // Pictures are compared side by side, one a thread: what that gains is measured as well.
        let threads = rayon::current_num_threads();
        let start = Instant::now();
        let compared: Result<Vec<_>> = (0..threads)
            .into_par_iter()
            .map(|_| compare(&full, &least_image, &Options::default()))
            .collect();
        compared?;
        let comparing = start.elapsed().as_secs_f64() / threads as f64;
        Ok(Costs { gold: first.seconds, least: least.seconds, reference, comparing })
    }

    /// Renders what is missing of `jobs`. What a study can do without is left out where it would
    /// not be done by the deadline.
    fn render(
        &mut self,
        jobs: &[Job],
        mut deadline: Option<Deadline>,
        progress: &dyn Progress,
    ) -> Result<()> {
        let missing: Vec<&Job> = jobs.iter().filter(|job| self.store.find(job).is_none()).collect();
        if missing.is_empty() {
            return Ok(());
        }
        progress.stage("trials", missing.len() as u64);
        for job in missing {
            let late = deadline.as_ref().is_some_and(|d| d.is_near(self.store.len()));
            if !(late && job.is_optional()) {
                let start = Instant::now();
                let (trial, film) = Trial::run(self.scene, job)?;
                self.store.add(trial, &film)?;
                if let Some(deadline) = &mut deadline {
                    deadline.longest = deadline.longest.max(start.elapsed().as_secs_f64());
                }
            }
            progress.advance(1);
        }
        progress.finish();
        Ok(())
    }

    fn analyse(&self, basis: Basis<'_>, plan: Plan, progress: &dyn Progress) -> Result<Results> {
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
        let header = &self.store.header;
        let mut results = Results {
            schema: header.schema,
            version: header.version.clone(),
            command: String::new(),
            machine: header.machine.clone(),
            scene: header.scene.clone(),
            hash: header.hash.clone(),
            size: header.size,
            seed: header.seed,
            gold: Settings::from(gold),
            request: self.request.clone(),
            plan,
            left_out: 0,
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

/// When a study has to be done, but for its report.
#[derive(Clone, Copy, Debug)]
struct Deadline {
    start: Instant,
    /// Seconds from the start to the end.
    seconds: f64,
    /// Seconds to compare one picture with all targets.
    comparing: f64,
    /// Seconds of the longest trial so far.
    longest: f64,
}

impl Deadline {
    /// Whether another trial beside `done` ones would come too late, with their comparing.
    fn is_near(&self, done: usize) -> bool {
        let after = self.longest + self.comparing * (done + 1) as f64;
        self.start.elapsed() + Duration::from_secs_f64(after)
            > Duration::from_secs_f64(self.seconds)
    }
}
