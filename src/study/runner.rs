//! The run of a study: missing pictures are rendered, all are compared, questions are answered.

use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;

use super::candidate::{Candidate, GOLD};
use super::deadline::{Deadline, PLANNED};
use super::job::{Basis, Costs, Job, Run, estimated, gold_job, rendered, stages};
use super::metric::{Options, compare};
use super::plan::Plan;
use super::request::Request;
use super::results::Results;
use super::store::{Header, Store};
use crate::error::{Error, Result};
use crate::image::read_exr;
use crate::render::{Progress, Silent};
use crate::scene::{RenderSettings, Scene};

/// A study of one scene in one folder.
#[derive(Debug)]
pub struct Study<'a> {
    pub(super) scene: &'a Scene,
    pub(super) request: Request,
    pub(super) store: Store,
}

impl<'a> Study<'a> {
    /// Opens a study of `scene` in `folder`, which is made where it is missing. With `resume` it continues
    /// the study that lies there.
    ///
    /// # Errors
    /// Where the request is out of range, the folder cannot be used, or a study lies in it that is
    /// not to be resumed or is of something else.
    pub fn new(scene: &'a Scene, folder: &Path, request: &Request, resume: bool) -> Result<Self> {
        request.check()?;
        let store = Store::open(folder, Header::new(scene, request), resume)?;
        Ok(Self { scene, request: request.clone(), store })
    }

    /// Renders the pictures that are not on disk, each of which is written at once; then compares them,
    /// answers the questions and writes `results.json` and `results.csv`. `command` is the command line.
    ///
    /// # Errors
    /// Where an emitter cannot be sampled or a file cannot be written or read.
    pub fn run(mut self, command: &str, progress: &dyn Progress) -> Result<Results> {
        let start = Instant::now();
        let gold = Candidate::gold(&self.scene.render).points[0].settings;
        let request = self.request.clone();
        let has_grids = self.scene.media.detail().is_some();
        let basis = Basis { request: &request, gold: &gold, has_grids };
        let planned = self.plan(basis, start)?;
        let jobs = planned.jobs(basis);
        match (request.seconds, self.store.header.costs) {
            (Some(seconds), Some(costs)) => {
                let limit = TimeLimit { start, seconds, costs };
                self.render_within(limit, &planned, &jobs, basis, progress)?;
            }
            _ => self.render(&jobs, progress)?,
        }
        let is_done = |job: &Job| self.store.find(job).is_some();
        let lost = || Error::file(self.store.folder(), "lost runs; go on with --resume");
        let plan = planned.completed(&jobs, is_done).ok_or_else(lost)?;
        let results = self.analyse(basis, plan, command, progress)?;
        results.write(self.store.folder())?;
        Ok(results)
    }

    /// The plan: as requested, or as much as fits in the time, by the cost of first renders. The seeds of a
    /// plan that is bounded by time are not limited.
    fn plan(&mut self, basis: Basis<'_>, start: Instant) -> Result<Plan> {
        let request = basis.request;
        let (stored, costs) = (self.store.header.plan.clone(), self.store.header.costs);
        let Some(seconds) = request.seconds else {
            let plan = match stored {
                // One that was bounded by time is done with the seeds that it has begun.
                Some(plan) if costs.is_some() => {
                    plan.with_seeds(plan.seeds.max(self.store.rounds()))
                }
                Some(plan) => plan.with_seeds(plan.seeds.max(request.seeds)),
                None => Plan::requested(basis),
            };
            self.store.settle(plan.clone(), costs)?;
            return Ok(plan);
        };
        let costs = match costs {
            Some(costs) => costs,
            None => self.costs(basis.gold)?,
        };
        let left = || PLANNED * seconds - start.elapsed().as_secs_f64();
        let plan = stored.unwrap_or_else(|| Plan::fitting(basis, &costs, left()));
        self.store.settle(plan.clone(), Some(costs))?;
        Ok(plan.with_seeds(plan.seeds.max(request.seeds)))
    }

    fn costs(&mut self, gold: &RenderSettings) -> Result<Costs> {
        let job = gold_job(gold, 0);
        self.render(std::slice::from_ref(&job), &Silent)?;
        let missing = || Error::file(self.store.folder(), "lost its first run");
        let first = self.store.find(&job).ok_or_else(missing)?;
        let settings = RenderSettings { rays: 1, ..job.settings };
        let (least, film) = Run::render(self.scene, &Job { settings, ..job.clone() })?;
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

    /// Renders those of `jobs` that have no run.
    fn render(&mut self, jobs: &[Job], progress: &dyn Progress) -> Result<()> {
        let missing: Vec<&Job> = jobs.iter().filter(|job| self.store.find(job).is_none()).collect();
        if missing.is_empty() {
            return Ok(());
        }
        progress.stage("runs", missing.len() as u64);
        for job in missing {
            let (run, film) = Run::render(self.scene, job)?;
            self.store.add(run, &film)?;
            progress.advance(1);
        }
        progress.finish();
        Ok(())
    }

    /// Renders those of `jobs` that have no run, within the time. An optional job is left out where it would
    /// not end in time, or would leave no time for the first seeds of the core.
    fn render_within(
        &mut self,
        limit: TimeLimit,
        plan: &Plan,
        jobs: &[Job],
        basis: Basis<'_>,
        progress: &dyn Progress,
    ) -> Result<()> {
        let TimeLimit { start, seconds, costs } = limit;
        let targets = if basis.request.reference.is_some() { 2.0 } else { 1.0 };
        let pictures = plan.candidates.len() + 1;
        let mut deadline = Deadline::new(seconds, targets * costs.comparing, pictures);
        let least = self.store.header.plan.as_ref().map_or(0, |plan| plan.seeds);
        let elapsed = || start.elapsed().as_secs_f64();
        let hundredths = |seconds: f64| (100.0 * seconds) as u64;
        progress.stage("runs", hundredths(seconds));
        let mut reported = 0;
        for job in jobs {
            if self.store.find(job).is_some() {
                continue;
            }
            let owed = |other: &&Job| {
                let core = other.candidate == GOLD || plan.is_core(other.candidate);
                core && other.round < least && self.store.find(other).is_none()
            };
            let first: f64 = if plan.is_core(job.candidate) {
                0.0
            } else {
                let jobs = jobs.iter().take_while(|other| other.round <= least).filter(owed);
                jobs.map(|job| deadline.expected(job, estimated(job, basis.gold, &costs))).sum()
            };
            let expected = deadline.expected(job, estimated(job, basis.gold, &costs));
            let left = deadline.left(elapsed(), self.store.len()) - first;
            if plan.is_optional(job) && !deadline.admits(job, expected, left) {
                continue;
            }
            let begun = elapsed();
            let (run, film) = Run::render(self.scene, job)?;
            self.store.add(run, &film)?;
            deadline.note(job, elapsed() - begun);
            let now = hundredths(elapsed());
            progress.advance(now - reported);
            reported = now;
        }
        progress.finish();
        Ok(())
    }
}

/// The time limit of a study.
#[derive(Clone, Copy)]
struct TimeLimit {
    start: Instant,
    /// Seconds from the start to the end.
    seconds: f64,
    /// Costs of single renders.
    costs: Costs,
}
