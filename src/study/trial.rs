//! One picture of a study.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::job::{Job, REFERENCE};
use crate::error::Result;
use crate::image::Film;
use crate::render::{Rendered, Silent, render, render_reference};
use crate::scene::{RenderSettings, Scene};
use crate::strategy::Summary;

/// One picture of a study: what was rendered, and what it took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// The candidate's name, `gold` or `reference`.
    pub candidate: String,
    /// Which of its budgets, from 0.
    pub point: usize,
    /// Which of the seeds, from 0.
    pub round: u32,
    /// Whether it is the same picture with the finest march step, from the same seed.
    #[serde(default)]
    pub finest_step: bool,
    /// The seed.
    pub seed: u64,
    /// Seconds of all stages after loading.
    pub seconds: f64,
    /// Seconds of each stage.
    pub stages: Vec<(String, f64)>,
    /// Gather radius of the volume photons in metres, nothing for the reference.
    pub radius: Option<f64>,
    /// How light in media was estimated; `None` for the reference and in results stored without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strategy: Option<Summary>,
    /// Counters of the work done.
    pub work: Map<String, Value>,
    /// The picture with all its layers, relative to the study's folder.
    pub exr: String,
}

impl Trial {
    /// Renders `job`.
    pub(super) fn run(scene: &Scene, job: &Job) -> Result<(Self, Film)> {
        let settings = &job.settings;
        let rendered = rendered(scene, settings, job.candidate == REFERENCE)?;
        let stages = stages(&rendered);
        let work = serde_json::to_value(rendered.work).unwrap_or_default();
        let trial = Self {
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
        Ok((trial, rendered.film))
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
