//! Which trials there are, and in which order.

use serde::{Deserialize, Serialize};

use super::candidate::{CANDIDATES, Candidate, GOLD, at_finest_step};
use super::request::Request;
use crate::scene::RenderSettings;

/// The name of the unbiased reference among trials.
pub(super) const REFERENCE: &str = "reference";

/// Rounds in which the step error is measured. The difference of two pictures from the same seed
/// has little noise, so that few tell.
const STEP_ROUNDS: u32 = 2;

/// Budgets that are kept as long as can be: the uniform curve wants two below the ceiling.
const LEAST_BUDGETS: usize = 3;

/// Candidates in the order in which they are left out where time is short.
const FIRST_LEFT_OUT: [&str; 12] = [
    "xs-step",
    "xs-radius",
    "xs-rays",
    "photons",
    "fixed-photons",
    "xs-product",
    "variance",
    "xs-paper",
    "x-scattering",
    "s",
    "xs-transmittance",
    "x-transmittance",
];

/// Budgets, seeds and candidates, chosen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// Names of the candidates.
    pub candidates: Vec<String>,
    /// Ceilings of rays a pixel, the largest first.
    pub budgets: Vec<u32>,
    /// Seeds of every candidate at every budget.
    pub seeds: u32,
    /// How many of them are rendered with the finest march step as well, for the step error.
    pub step_seeds: u32,
}

/// What a plan is made for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Basis<'a> {
    /// What is asked.
    pub(super) request: &'a Request,
    /// The gold standard.
    pub(super) gold: &'a RenderSettings,
    /// Whether there is any grid: without one a march step makes no error.
    pub(super) has_grids: bool,
}

/// What single renders take, in seconds, as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
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

impl Job {
    /// Whether a study that is out of time can do without.
    pub(super) fn is_optional(&self) -> bool {
        // Two gold standards tell how far they can be trusted.
        let needed = if self.candidate == GOLD { 2 } else { 1 };
        self.candidate != REFERENCE && self.round >= needed
    }
}

impl Plan {
    /// What `basis` names, whatever it takes.
    pub(super) fn asked(basis: Basis<'_>) -> Self {
        let Basis { request, gold, has_grids } = basis;
        let mut budgets = request.budgets.clone();
        if budgets.is_empty() {
            budgets = std::iter::successors(Some(gold.rays), |rays| Some(rays / 2))
                .take_while(|rays| *rays > 0)
                .collect();
        }
        budgets.sort_unstable_by(|a, b| b.cmp(a));
        budgets.dedup();
        let mut candidates = request.candidates.clone();
        if candidates.is_empty() {
            candidates = CANDIDATES.map(|(name, _)| name.to_owned()).to_vec();
        }
        let step_seeds = if has_grids { STEP_ROUNDS } else { 0 };
        Self { candidates, budgets, seeds: 0, step_seeds }.with_seeds(request.seeds)
    }

    /// The same with other seeds.
    pub(super) fn with_seeds(&self, seeds: u32) -> Self {
        // One seed tells nothing of bias, to which the step error belongs.
        let step_seeds = if seeds < STEP_ROUNDS { 0 } else { self.step_seeds };
        Self { seeds, step_seeds, ..self.clone() }
    }

    /// As many seeds as fit into `seconds`, with every second budget left out where fewer than
    /// three would, and so on; where one seed at [`LEAST_BUDGETS`] is too much, fewer candidates,
    /// at least two of them, and then the largest and the smallest budget alone.
    pub(super) fn fitting(basis: Basis<'_>, costs: &Costs, seconds: f64) -> Self {
        let most = basis.request.seeds;
        let mut plan = Self::asked(basis);
        loop {
            let seeds = plan.most_seeds(basis, costs, seconds);
            if plan.budgets.len() <= LEAST_BUDGETS || seeds >= most.min(3) {
                return if seeds > 0 {
                    plan.with_seeds(seeds)
                } else {
                    plan.with_seeds(1).fewer(basis, costs, seconds)
                };
            }
            plan.budgets = plan.budgets.iter().copied().step_by(2).collect();
        }
    }

    /// How many seeds fit, at most as many as asked for; 0 where one is too many.
    fn most_seeds(&self, basis: Basis<'_>, costs: &Costs, seconds: f64) -> u32 {
        let fits = |seeds| self.with_seeds(seeds).seconds(basis, costs) <= seconds;
        let (mut fit, mut too_many) = (0, basis.request.seeds + 1);
        while too_many - fit > 1 {
            let middle = u32::midpoint(fit, too_many);
            *(if fits(middle) { &mut fit } else { &mut too_many }) = middle;
        }
        fit
    }

    /// What is left of the plan without the rounds of which a job is `missing`; nothing where the
    /// first is, or the reference.
    pub(super) fn without(&self, missing: &[&Job]) -> Option<Self> {
        let whole_rounds = |job: &&Job| match job.candidate {
            REFERENCE => 0,
            // As many as have an even number of gold standards.
            GOLD => job.round - job.round % 2,
            _ => job.round,
        };
        let seeds = missing.iter().map(whole_rounds).min().unwrap_or(self.seeds);
        (seeds > 0).then(|| self.with_seeds(seeds.min(self.seeds)))
    }

    /// With as many candidates left out as must be.
    fn fewer(mut self, basis: Basis<'_>, costs: &Costs, seconds: f64) -> Self {
        for name in FIRST_LEFT_OUT {
            if self.candidates.len() <= 2 || self.seconds(basis, costs) <= seconds {
                break;
            }
            self.candidates.retain(|kept| kept != name);
        }
        if self.seconds(basis, costs) > seconds && self.budgets.len() > 2 {
            self.budgets.drain(1..self.budgets.len() - 1);
        }
        self
    }

    /// What the study takes at most: a directed picture costs no more than a fixed one with its
    /// ceiling of rays.
    pub(super) fn seconds(&self, basis: Basis<'_>, costs: &Costs) -> f64 {
        let Basis { request, gold, .. } = basis;
        let per_ray = (costs.gold - costs.least).max(0.0) / f64::from(gold.rays.max(2) - 1);
        let render = |job: &Job| {
            if job.candidate == REFERENCE {
                costs.reference * f64::from(job.settings.rays)
            } else {
                costs.least + per_ray * f64::from(job.settings.rays - 1)
            }
        };
        let jobs = self.jobs(basis);
        let rendering: f64 = jobs.iter().map(render).sum();
        let compared = jobs.iter().filter(|job| job.candidate != REFERENCE && !job.finest_step);
        let targets = if request.reference.is_some() { 2.0 } else { 1.0 };
        rendering + targets * costs.comparing * compared.count() as f64
    }

    /// The candidates with their points.
    pub(super) fn candidates(&self, gold: &RenderSettings) -> Vec<Candidate> {
        Candidate::all(gold, &self.candidates, &self.budgets)
    }

    /// All pictures. A round has every candidate at every budget once and the gold standard among
    /// them; each begins elsewhere, so that nothing always comes first. The reference follows the
    /// first round, so that a study that runs out of time has one.
    pub(super) fn jobs(&self, basis: Basis<'_>) -> Vec<Job> {
        let gold = basis.gold;
        let candidates = self.candidates(gold);
        let mut jobs = Vec::new();
        for round in 0..gold_seeds(self.seeds) {
            jobs.push(gold_job(gold, round));
            if round < self.seeds {
                let mut tour: Vec<Job> = candidates
                    .iter()
                    .flat_map(|candidate| {
                        let points = candidate.points.iter().enumerate();
                        points.flat_map(|(point, at)| {
                            self.of_point(candidate.name, point, &at.settings, round)
                        })
                    })
                    .collect();
                let start = tour.len() * round as usize / self.seeds as usize;
                tour.rotate_left(start);
                jobs.extend(tour);
            }
            if round == 0 {
                jobs.extend(reference_jobs(basis));
            }
        }
        jobs
    }

    /// A point in one round, and with the finest step where that is measured.
    fn of_point(
        &self,
        candidate: &'static str,
        point: usize,
        settings: &RenderSettings,
        round: u32,
    ) -> impl Iterator<Item = Job> + use<> {
        let job = |settings: &RenderSettings, finest_step| Job {
            candidate,
            point,
            round,
            finest_step,
            settings: seeded(settings, Role::Candidate, round),
        };
        let finest = at_finest_step(settings).filter(|_| round < self.step_seeds);
        let pair = [Some(job(settings, false)), finest.map(|settings| job(&settings, true))];
        pair.into_iter().flatten()
    }
}

/// The gold standard of a round.
pub(super) fn gold_job(gold: &RenderSettings, round: u32) -> Job {
    let settings = Candidate::gold(gold).points[0].settings;
    let settings = seeded(&settings, Role::Gold, round);
    Job { candidate: GOLD, point: 0, round, finest_step: false, settings }
}

/// The two halves of the reference.
fn reference_jobs(basis: Basis<'_>) -> impl Iterator<Item = Job> {
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

/// How often the gold standard is rendered: in every round, and an even number of times, so that
/// its halves tell its own error.
fn gold_seeds(seeds: u32) -> u32 {
    seeds.next_multiple_of(2)
}

/// Whose seeds; none are shared, so that errors are independent.
#[derive(Clone, Copy)]
enum Role {
    Candidate = 1,
    Gold = 2,
    Reference = 3,
}

fn seeded(settings: &RenderSettings, role: Role, round: u32) -> RenderSettings {
    let offset = (role as u64) << 32 | u64::from(round);
    RenderSettings { seed: settings.seed.wrapping_add(offset), ..*settings }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COSTS: Costs = Costs { gold: 8.0, least: 1.0, reference: 0.5, comparing: 0.1 };

    fn request() -> Request {
        Request { candidates: vec!["fixed".into(), "xs-step".into()], ..Request::default() }
    }

    fn basis<'a>(request: &'a Request, gold: &'a RenderSettings) -> Basis<'a> {
        Basis { request, gold, has_grids: true }
    }

    #[test]
    fn rounds_have_everything_once() {
        let gold = RenderSettings::default();
        let request = Request { reference: Some(9), ..request() };
        let plan = Plan::asked(basis(&request, &gold));
        assert_eq!(plan.budgets, [16, 8, 4, 2, 1]);
        let jobs = plan.jobs(basis(&request, &gold));
        // Gold six times, every point with five seeds and with two at the finest step, halves.
        assert_eq!(jobs.len(), 6 + 5 * (4 + 5) + 2 * 5 + 2);
        let mut seen: Vec<_> =
            jobs.iter().map(|j| (j.candidate, j.point, j.round, j.finest_step)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), jobs.len());
        for pair in jobs.windows(2).filter(|pair| pair[1].finest_step) {
            assert_eq!(pair[0].settings.seed, pair[1].settings.seed, "a pair shares its seed");
        }
    }

    #[test]
    fn a_study_fits_in_the_time_given() {
        let gold = RenderSettings::default();
        let request = request();
        let basis = basis(&request, &gold);
        let full = Plan::asked(basis).seconds(basis, &COSTS);
        let mut last = 0.0;
        for seconds in [100.0, 150.0, full / 2.0, full] {
            let plan = Plan::fitting(basis, &COSTS, seconds);
            let takes = plan.seconds(basis, &COSTS);
            assert!(takes <= seconds, "{plan:?} takes {takes} of {seconds}");
            last = takes;
        }
        assert_eq!(last, full);
        let least = Plan::fitting(basis, &COSTS, 1e-3);
        assert_eq!((least.seeds, least.candidates.len()), (1, 2));
        assert!(least.budgets.len() <= 2 && least.budgets[0] == 16);
    }

    #[test]
    fn rounds_that_are_not_whole_are_left_out() {
        let gold = RenderSettings::default();
        let request = request();
        let basis = basis(&request, &gold);
        let plan = Plan::asked(basis);
        let jobs = plan.jobs(basis);
        let missing = |of: &dyn Fn(&Job) -> bool| {
            let missing: Vec<&Job> = jobs.iter().filter(|job| of(job)).collect();
            plan.without(&missing).map(|left| left.seeds)
        };
        assert_eq!(missing(&|_| false), Some(5));
        assert_eq!(missing(&|job| job.round == 3 && job.candidate == "fixed"), Some(3));
        // Three seeds need four gold standards.
        assert_eq!(missing(&|job| job.round == 3 && job.candidate == GOLD), Some(2));
        assert_eq!(missing(&|job| job.round == 0), None);
        for seeds in 2..=5 {
            let fewer = plan.with_seeds(seeds).jobs(basis);
            let is_kept = |job: &Job| fewer.contains(job);
            let left: Vec<&Job> = jobs.iter().filter(|job| !is_kept(job)).collect();
            assert_eq!(plan.without(&left).map(|left| left.seeds), Some(seeds));
        }
    }

    #[test]
    fn candidates_are_left_out_before_time_runs_out() {
        let gold = RenderSettings::default();
        let all = Request::default();
        let plan = Plan::fitting(basis(&all, &gold), &COSTS, 1.0);
        assert_eq!(plan.candidates, ["fixed", "xs-scattering"]);
        let plan = Plan::fitting(basis(&all, &gold), &COSTS, 100.0);
        assert!(plan.candidates.len() > 2 && plan.seconds(basis(&all, &gold), &COSTS) <= 100.0);
    }
}
