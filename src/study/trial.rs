//! One picture of a study.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::plan::{Job, REFERENCE};
use crate::error::Result;
use crate::image::Film;
use crate::render::{Silent, render, render_reference};
use crate::scene::Scene;

/// One picture of a study: what was rendered, and what it took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// The candidate's name, `gold` or `reference`.
    pub candidate: String,
    /// Which of its budgets, from 0.
    pub point: usize,
    /// Which of the seeds, from 0.
    pub round: u32,
    /// The seed.
    pub seed: u64,
    /// Seconds of all stages after loading.
    pub seconds: f64,
    /// Seconds of each stage.
    pub stages: Vec<(String, f64)>,
    /// Gather radius of the volume photons in metres, nothing for the reference.
    pub radius: Option<f64>,
    /// Counters of the work done.
    pub work: Map<String, Value>,
    /// The picture with all its layers, relative to the study's folder.
    pub exr: String,
}

impl Trial {
    /// Renders `job`.
    pub(super) fn run(scene: &Scene, job: &Job) -> Result<(Self, Film)> {
        let settings = &job.settings;
        let rendered = if job.candidate == REFERENCE {
            render_reference(scene, settings, &Silent)
        } else {
            render(scene, settings, &Silent)?
        };
        let stages: Vec<(String, f64)> = rendered
            .timings
            .iter()
            .map(|(name, time)| ((*name).to_owned(), time.as_secs_f64()))
            .collect();
        let work = serde_json::to_value(rendered.work).unwrap_or_default();
        let trial = Self {
            candidate: job.candidate.into(),
            point: job.point,
            round: job.round,
            seed: settings.seed,
            seconds: stages.iter().map(|(_, seconds)| seconds).sum(),
            stages,
            radius: rendered.radius,
            work: work.as_object().cloned().unwrap_or_default(),
            exr: format!("exr/{}-{}-{}.exr", job.candidate, job.point, job.round),
        };
        Ok((trial, rendered.film))
    }

    /// Whether this is the picture that `job` asks for.
    pub(super) fn is_of(&self, job: &Job) -> bool {
        self.candidate == job.candidate && self.point == job.point && self.round == job.round
    }
}
