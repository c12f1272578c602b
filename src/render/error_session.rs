//! A render that ends at a stated error: rounds of photons and rays, whose samples make one picture.

use std::time::Instant;

use super::checkpoint::Checkpoints;
use super::control::Control;
use super::exposure::{RenderRegion, Sampled, picture_so_far, resolve, sample};
use super::photon_pass::{PhotonPass, ShotPaths, aim};
use super::photon_stage::{Lit, lazy_cells, shoot};
use super::pixel_sampling::{CameraRay, Workspace};
use super::progress::Stages;
use super::reconstruction::finish;
use super::rendered::{Ended, ReachedError, Rendered};
use super::rounds::{Extent, Round, Schedule, pooled, total};
use super::stage_settings::{finest_step, pass_settings, render_region};
use super::stated_error::StatedError;
use crate::director::PixelBudget;
use crate::error::Result;
use crate::math::{Spectrum, Stage};
use crate::photon::PhotonDirection;
use crate::scene::plan::Needs;
use crate::scene::{ErrorGoal, RenderSettings, Scene};
use crate::strategy::{Assignment, Summary};
use crate::work::Work;

/// Multiplies the number of a round for the seed of its photons. Any odd number does; this one has no pattern (2^64 over
/// the square root of 2).
const ROUND_SEED: u64 = 0xb504_f333_f9de_6485;

/// A picture to render until its error is small enough.
pub(super) struct ErrorJob<'a> {
    pub scene: &'a Scene,
    pub settings: &'a RenderSettings,
    pub goal: ErrorGoal,
    pub strategies: &'a Assignment,
}

/// Samples of the rounds so far, and what the last one says of how they were taken.
struct RoundsDone {
    sampled: Sampled,
    rounds: Vec<Round>,
    budget: PixelBudget,
    radius: f64,
    strategy: Option<Summary>,
}

impl ErrorJob<'_> {
    fn schedule(&self) -> Schedule {
        let needs_photons = Needs::new(self.scene, self.settings).photons();
        Schedule::new(self.settings, self.goal, self.strategies, needs_photons)
    }
}

impl RoundsDone {
    /// Those that a checkpoint knows, without their samples.
    fn none(region: &RenderRegion, control: &Control<'_>) -> Self {
        Self {
            sampled: Sampled::none(region),
            rounds: control.checkpoints.map_or_else(Vec::new, Checkpoints::rounds),
            budget: PixelBudget::fixed(0, 0.0, 0.0),
            radius: 0.0,
            strategy: None,
        }
    }

    /// The error that it has by what is `stated`, and what it took.
    fn reached(&self, goal: ErrorGoal, stated: Option<StatedError>) -> ReachedError {
        let Extent { photons, rays } = total(&self.rounds);
        ReachedError { goal, stated, photons, rays }
    }

    /// Shows the picture so far.
    fn show(&self, region: &RenderRegion, control: &Control<'_>) {
        let Sampled { film, work, .. } = &self.sampled;
        if let Some(preview) = control.preview {
            (preview.show)(false, &|| picture_so_far(region, |_, _| self.budget, film, work));
        }
    }

    /// Finds the error of the picture so far: by all rounds, or of one that was cut short by what it left.
    fn find_error(&mut self, goal: ErrorGoal) -> Option<StatedError> {
        let found = StatedError::new(&self.sampled.film.component_film(), goal);
        if let Some(last) = self.rounds.last_mut() {
            last.found = found;
        }
        if self.sampled.ended == Ended::Complete { pooled(&self.rounds) } else { found }
    }
}

/// The rounds that a picture should take, by the first of them.
pub(super) struct Foretold {
    /// All rounds.
    pub rounds: Vec<Round>,
    /// What the first did.
    pub work: Work,
    /// What the first took.
    pub stages: Stages,
}

/// Renders the first round of the picture of `job`, and foretells the others; `None` where it shows no light.
///
/// # Errors
/// Where an emitter cannot be sampled.
pub(super) fn foretell<S: Spectrum, H: PhotonDirection>(
    job: &ErrorJob<'_>,
) -> Result<Option<Foretold>> {
    let (schedule, control) = (job.schedule(), Control::silent());
    let region = render_region(job.scene, job.settings, Stage::March);
    let none = RoundsDone::none(&region, &control);
    let mut stages = Stages::default();
    let first = schedule.first();
    let mut done = expose_round::<S, H>(job, &region, none, first, &control, &mut stages)?;
    let stated = done.find_error(job.goal);
    let rounds = stated.map(|stated| schedule.foretold(first, stated));
    Ok(rounds.map(|rounds| Foretold { rounds, work: done.sampled.work, stages }))
}

/// Renders the picture of `job` in rounds. `stages` are those that ran before.
///
/// # Errors
/// Where an emitter cannot be sampled, or a checkpoint does not fit the scene.
pub(super) fn render_to_error<S: Spectrum, H: PhotonDirection>(
    job: &ErrorJob<'_>,
    control: &Control<'_>,
    mut stages: Stages,
) -> Result<Rendered> {
    let ErrorJob { scene, settings, goal, .. } = *job;
    let region = render_region(scene, settings, Stage::March);
    let schedule = job.schedule();
    let begin = control.deadline.map(|deadline| deadline.clock.elapsed());
    let mut done = RoundsDone::none(&region, control);
    let mut next = Some(done.rounds.pop().unwrap_or_else(|| schedule.first()));
    let mut stated = None;
    while let Some(round) = next {
        done = expose_round::<S, H>(job, &region, done, round, control, &mut stages)?;
        let start = Instant::now();
        stated = done.find_error(goal);
        stages.done("error", start);
        control.progress.reached(&done.reached(goal, stated));
        if done.sampled.ended != Ended::Complete {
            break;
        }
        let time = control.deadline.zip(begin).map(|(deadline, begin)| {
            [deadline.clock.elapsed().saturating_sub(begin), deadline.left()]
        });
        next = schedule.next(&done.rounds, stated, time);
        if next.is_none() && time.is_some() && !stated.is_some_and(|stated| stated.reaches(goal)) {
            done.sampled.ended = Ended::OutOfTime;
        }
        if next.is_some() {
            done.show(&region, control);
        }
    }
    // The picture of all rounds.
    let reached = done.reached(goal, stated);
    let RoundsDone { sampled, budget, radius, strategy, .. } = done;
    let mut exposed = resolve(&region, |_, _| budget, sampled);
    let mut work = finish::<S>(scene, settings, &region, &mut exposed, &mut stages);
    work.unseen_voxels = scene.unseen.map_or(0, |unseen| unseen.held());
    let rendered = exposed.rendered(work, stages, Some(radius));
    Ok(Rendered { strategy, error: Some(reached), ..rendered })
}

/// Takes the samples of one `round` more.
fn expose_round<S: Spectrum, H: PhotonDirection>(
    job: &ErrorJob<'_>,
    region: &RenderRegion,
    mut done: RoundsDone,
    round: Round,
    control: &Control<'_>,
    stages: &mut Stages,
) -> Result<RoundsDone> {
    let ErrorJob { scene, settings, strategies, .. } = *job;
    let earlier = total(&done.rounds).rays;
    let seed = settings.seed ^ ROUND_SEED.wrapping_mul(done.rounds.len() as u64);
    done.rounds.push(round);
    control.checkpoints.iter().for_each(|checkpoints| checkpoints.begin_round(&done.rounds));
    // Photons, with cells and kernels for those of all rounds.
    let start = Instant::now();
    let Extent { photons, rays } = round.whole;
    let of_round = RenderSettings { photons, rays, seed, ..*settings };
    let pass = pass_settings(scene, &of_round);
    let aimed = aim::<S, H>(scene, &pass)?;
    let paths = round.adds.photons;
    let halves = ShotPaths::Halves(paths);
    let (photons, shot) = shoot::<S, H>(scene, &pass, strategies, aimed, halves, paths, control)?;
    done.sampled.work += shot;
    stages.done("photons", start);
    // Rays, after those of the rounds before.
    let start = Instant::now();
    let radius = PhotonPass::finest_radius(&photons);
    let step = finest_step(scene, settings);
    let budget = PixelBudget::fixed(earlier, radius, step).with_round(round.adds.rays);
    let lit = Lit::new(scene, settings, &photons);
    let caches = lazy_cells(scene, &photons, control)?;
    done.sampled = sample(
        RenderRegion { rays: round.adds.rays, ..*region },
        |place| place.ray(scene),
        |_, _| budget,
        |camera_ray: &CameraRay<'_>, workspace: &mut Workspace<S>| {
            lit.estimate(camera_ray, workspace)
        },
        done.sampled,
        &caches,
        control,
    );
    stages.done("march", start);
    Ok(RoundsDone { budget, radius, strategy: Some(photons[0].choice.summary()), ..done })
}
