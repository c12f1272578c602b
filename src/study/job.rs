//! Single pictures of a study: the job of rendering one, its seed and cost, and the run that did it.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::candidate::{Candidate, GOLD};
use super::request::Request;
use crate::error::Result;
use crate::image::Film;
use crate::render::{Rendered, Silent, render, render_reference};
use crate::scene::{RenderSettings, Scene};
use crate::strategy::Summary;

/// The name of the unbiased reference among runs.
pub(super) const REFERENCE: &str = "reference";

/// Least number of gold standards: two halves give the error of their mean.
pub(super) const LEAST_GOLDS: u32 = 2;

/// What the jobs of a study follow from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Basis<'a> {
    /// The request.
    pub(super) request: &'a Request,
    /// The gold standard.
    pub(super) gold: &'a RenderSettings,
    /// Whether the scene has grids: without them the march step makes no error.
    pub(super) has_grids: bool,
}

/// Measured costs of single renders, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Costs {
    /// The gold standard.
    pub(super) gold: f64,
    /// The same with one ray a pixel.
    pub(super) least: f64,
    /// The reference with one ray a pixel.
    pub(super) reference: f64,
    /// Comparing two pictures.
    pub(super) comparing: f64,
}

/// One picture to be rendered.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Job {
    /// The candidate's name, [`GOLD`] or [`REFERENCE`].
    pub(super) candidate: &'static str,
    /// Which of its points.
    pub(super) point: usize,
    /// Which of the seeds.
    pub(super) round: u32,
    /// Whether it is the point with the finest march step instead of its own.
    pub(super) finest_step: bool,
    /// How it is rendered, with the seed.
    pub(super) settings: RenderSettings,
}

/// The gold standard of a round.
pub(super) fn gold_job(gold: &RenderSettings, round: u32) -> Job {
    let settings = Candidate::gold(gold).points[0].settings;
    let settings = seeded(&settings, Role::Gold, round);
    Job { candidate: GOLD, point: 0, round, finest_step: false, settings }
}

/// The two halves of the reference.
pub(super) fn reference_jobs(basis: Basis<'_>) -> impl Iterator<Item = Job> {
    let Basis { request, gold, .. } = basis;
    let halves = request.reference.map(|rays| [rays.div_ceil(2); 2]);
    (0..).zip(halves.into_iter().flatten()).map(|(round, rays)| Job {
        candidate: REFERENCE,
        point: 0,
        round,
        finest_step: false,
        settings: seeded(&RenderSettings { rays, ..*gold }, Role::Reference, round),
    })
}

/// Seconds that `job` takes at most: a directed picture costs no more than a fixed one with its
/// ceiling of rays.
pub(super) fn estimated(job: &Job, gold: &RenderSettings, costs: &Costs) -> f64 {
    let rays = f64::from(job.settings.rays);
    if job.candidate == REFERENCE {
        return costs.reference * rays;
    }
    let per_ray = (costs.gold - costs.least).max(0.0) / f64::from(gold.rays.max(2) - 1);
    costs.least + per_ray * (rays - 1.0)
}

/// What a seed is for. Roles share no seeds, so that errors are independent.
#[derive(Clone, Copy)]
pub(super) enum Role {
    Candidate = 1,
    Gold = 2,
    Reference = 3,
}

pub(super) fn seeded(settings: &RenderSettings, role: Role, round: u32) -> RenderSettings {
    let offset = (role as u64) << 32 | u64::from(round);
    RenderSettings { seed: settings.seed.wrapping_add(offset), ..*settings }
}

/// A picture of a study that is rendered: its job, time and work.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The candidate's name, `gold` or `reference`.
    pub candidate: String,
    /// Which of its budgets, from 0.
    pub point: usize,
    /// Which of the seeds, from 0.
    pub round: u32,
    /// Whether the march step is the finest instead of the point's, with the same seed.
    #[serde(default)]
    pub finest_step: bool,
    /// The seed.
    pub seed: u64,
    /// Seconds of all stages, without loading and writing.
    pub seconds: f64,
    /// Seconds of each stage.
    pub stages: Vec<(String, f64)>,
    /// Gather radius of volume photons in metres; `None` for the reference.
    pub radius: Option<f64>,
    /// How light in media was estimated; `None` for the reference and in results stored without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strategy: Option<Summary>,
    /// Counters of the work done.
    pub work: Map<String, Value>,
    /// The picture with all its layers, relative to the study's folder.
    pub exr: String,
}

impl Run {
    /// Renders `job` of `scene`.
    pub(super) fn render(scene: &Scene, job: &Job) -> Result<(Self, Film)> {
        let settings = &job.settings;
        let rendered = rendered(scene, settings, job.candidate == REFERENCE)?;
        let stages = stages(&rendered);
        let work = serde_json::to_value(rendered.work).unwrap_or_default();
        let run = Self {
            candidate: job.candidate.into(),
            point: job.point,
            round: job.round,
            finest_step: job.finest_step,
            seed: settings.seed,
            seconds: stages.iter().map(|(_, seconds)| seconds).sum(),
            stages,
            radius: rendered.radius,
            strategy: rendered.strategy,
            work: work.as_object().cloned().unwrap_or_default(),
            exr: format!(
                "exr/{}-{}-{}{}.exr",
                job.candidate,
                job.point,
                job.round,
                if job.finest_step { "-finest-step" } else { "" }
            ),
        };
        Ok((run, rendered.film))
    }
}

/// The picture of `scene` with these settings, or its unbiased reference: the one place where this
/// room renders.
pub(super) fn rendered(
    scene: &Scene,
    settings: &RenderSettings,
    reference: bool,
) -> Result<Rendered> {
    if reference {
        Ok(render_reference(scene, settings, &Silent))
    } else {
        render(scene, settings, &Silent)
    }
}

/// Seconds of each stage of a render.
pub(super) fn stages(rendered: &Rendered) -> Vec<(String, f64)> {
    let seconds = rendered.timings.iter().map(|(name, time)| (*name, time.as_secs_f64()));
    seconds.map(|(name, seconds)| (name.to_owned(), seconds)).collect()
}
