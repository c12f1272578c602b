//! Single pictures of a study, their seeds and what they cost.

use serde::{Deserialize, Serialize};

use super::candidate::{Candidate, GOLD};
use super::plan::Basis;
use crate::scene::RenderSettings;

/// The name of the unbiased reference among trials.
pub(super) const REFERENCE: &str = "reference";

/// Gold standards that tell how far they can be trusted.
pub(super) const LEAST_GOLDS: u32 = 2;

/// What single renders take, in seconds, as measured.
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

/// Whose seeds; none are shared, so that errors are independent.
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
