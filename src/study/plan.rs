//! The plan of a study: which pictures are rendered, and in which order.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::candidate::{CANDIDATES, Candidate, GOLD, at_finest_step, subject};
use super::contrast::FEWEST_SEEDS;
use super::gain::UNIFORM;
use super::job::{
    Basis, Costs, Job, LEAST_GOLDS, REFERENCE, Role, estimated, gold_job, reference_jobs, seeded,
};
use crate::scene::RenderSettings;

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

/// Candidates, budgets and seeds of a study.
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
    /// Candidates with fewer seeds, and how many.
    #[serde(default)]
    pub fewer: BTreeMap<String, u32>,
}

impl Plan {
    /// The plan that is requested, whatever it costs.
    pub(super) fn requested(basis: Basis<'_>) -> Self {
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
        Self { candidates, budgets, seeds: 0, step_seeds, fewer: BTreeMap::new() }
            .with_seeds(request.seeds)
    }

    /// The same with other seeds.
    pub(super) fn with_seeds(&self, seeds: u32) -> Self {
        // One seed tells nothing of bias, to which the step error belongs.
        let step_seeds = if seeds < STEP_ROUNDS { 0 } else { self.step_seeds };
        Self { seeds, step_seeds, ..self.clone() }
    }

    /// What `seconds` are spent on: [`FEWEST_SEEDS`] of the gold standard, the directed candidate
    /// and uniform sampling, the core of every answer, with fewer budgets, then fewer seeds where
    /// that is too much; then as many other candidates with as many seeds as fit into half of what
    /// is left, or into all of it where they are asked for by name. The rest is for more seeds of
    /// the core, which [`Plan::with_seeds`] adds.
    pub(super) fn fitting(basis: Basis<'_>, costs: &Costs, seconds: f64) -> Self {
        let mut plan = Self::requested(basis).with_seeds(basis.request.seeds.min(FEWEST_SEEDS));
        let asked = plan.candidates.clone();
        let core = [Some(UNIFORM), subject(&asked)];
        plan.candidates.retain(|name| core.contains(&Some(name.as_str())));
        if plan.candidates.is_empty() {
            plan.candidates.extend(asked.first().cloned());
        }
        while plan.seconds(basis, costs) > seconds && plan.budgets.len() > LEAST_BUDGETS {
            plan.budgets = plan.budgets.iter().copied().step_by(2).collect();
        }
        if plan.seconds(basis, costs) > seconds && plan.budgets.len() > 2 {
            plan.budgets.drain(1..plan.budgets.len() - 1);
        }
        while plan.seconds(basis, costs) > seconds && plan.seeds > 1 {
            plan = plan.with_seeds(plan.seeds - 1);
        }
        let taken = plan.seconds(basis, costs);
        let share = if basis.request.candidates.is_empty() { 0.5 } else { 1.0 };
        let most = taken + share * (seconds - taken);
        for name in by_importance(&asked).filter(|name| !core.contains(&Some(*name))) {
            let mut more = plan.clone();
            more.candidates.push(name.to_owned());
            more.fewer.insert(name.to_owned(), plan.seeds);
            if plan.seeds >= FEWEST_SEEDS.min(basis.request.seeds)
                && more.seconds(basis, costs) <= most
            {
                plan = more;
            }
        }
        plan
    }

    /// Seeds of a candidate.
    pub(super) fn seeds_of(&self, candidate: &str) -> u32 {
        self.fewer.get(candidate).map_or(self.seeds, |fewer| self.seeds.min(*fewer))
    }

    /// Whether a candidate has as many seeds as there are.
    pub(super) fn is_core(&self, candidate: &str) -> bool {
        !self.fewer.contains_key(candidate)
    }

    /// Whether a study that is out of time can do without `job`.
    pub(super) fn is_optional(&self, job: &Job) -> bool {
        match job.candidate {
            REFERENCE => false,
            GOLD => job.round >= LEAST_GOLDS,
            name => job.round > 0 || !self.is_core(name),
        }
    }

    /// What is left of the plan, of whose `jobs` some are done, without the seeds that are not
    /// whole; nothing where gold standards, a reference, or the first round of the core are missing.
    pub(super) fn completed(&self, jobs: &[Job], is_done: impl Fn(&Job) -> bool) -> Option<Self> {
        let mut seeds: BTreeMap<&str, u32> =
            self.candidates.iter().map(|name| (name.as_str(), self.seeds_of(name))).collect();
        for job in jobs.iter().filter(|job| !is_done(job)) {
            match job.candidate {
                REFERENCE => return None,
                GOLD if job.round < LEAST_GOLDS => return None,
                GOLD => {}
                name => {
                    seeds.entry(name).and_modify(|n| *n = job.round.min(*n));
                }
            }
        }
        let has_points = |name: &str| jobs.iter().any(|job| job.candidate == name);
        let lost = |name: &&str| seeds[name] == 0 && self.is_core(name) && has_points(name);
        if self.seeds == 0 || seeds.keys().any(lost) {
            return None;
        }
        let most = seeds.iter().filter(|(name, _)| has_points(name)).map(|(_, n)| *n).max();
        let mut plan = self.with_seeds(most.unwrap_or(self.seeds));
        plan.candidates.retain(|name| seeds[name.as_str()] > 0);
        let fewer = plan.candidates.iter().map(|name| (name.clone(), seeds[name.as_str()]));
        plan.fewer = fewer.filter(|(_, n)| *n < plan.seeds).collect();
        Some(plan)
    }

    /// What the study takes at most: a directed picture costs no more than a fixed one with its
    /// ceiling of rays.
    pub(super) fn seconds(&self, basis: Basis<'_>, costs: &Costs) -> f64 {
        let Basis { request, gold, .. } = basis;
        let jobs = self.jobs(basis);
        let rendering: f64 = jobs.iter().map(|job| estimated(job, gold, costs)).sum();
        let compared = jobs.iter().filter(|job| job.candidate != REFERENCE && !job.finest_step);
        let targets = if request.reference.is_some() { 2.0 } else { 1.0 };
        rendering + targets * costs.comparing * compared.count() as f64
    }

    /// The candidates with their points.
    pub(super) fn candidates(&self, gold: &RenderSettings) -> Vec<Candidate> {
        Candidate::all(gold, &self.candidates, &self.budgets)
    }

    /// All pictures. A round has the gold standard, then every candidate at every budget once, the
    /// core first; each begins elsewhere, so that nothing always comes first. The reference follows
    /// the first round, so that a study that runs out of time has one.
    pub(super) fn jobs(&self, basis: Basis<'_>) -> Vec<Job> {
        let gold = basis.gold;
        let (core, others): (Vec<Candidate>, Vec<Candidate>) =
            self.candidates(gold).into_iter().partition(|candidate| self.is_core(candidate.name));
        let mut jobs = Vec::new();
        for round in 0..self.seeds.max(LEAST_GOLDS) {
            jobs.push(gold_job(gold, round));
            for candidates in [&core, &others] {
                jobs.extend(self.tour(candidates, round));
            }
            if round == 0 {
                jobs.extend(reference_jobs(basis));
            }
        }
        jobs
    }

    /// Every candidate that has this round at every budget.
    fn tour(&self, candidates: &[Candidate], round: u32) -> Vec<Job> {
        let in_round = candidates.iter().filter(|c| round < self.seeds_of(c.name));
        let mut tour: Vec<Job> = in_round
            .flat_map(|candidate| {
                let points = candidate.points.iter().enumerate();
                points.flat_map(|(point, at)| {
                    self.of_point(candidate.name, point, &at.settings, round)
                })
            })
            .collect();
        if !tour.is_empty() {
            let start = round as usize * (tour.len() / 2 + 1) % tour.len();
            tour.rotate_left(start);
        }
        tour
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

/// Names, the one that is left out last first.
fn by_importance(names: &[String]) -> impl Iterator<Item = &str> {
    let rank = |name: &str| FIRST_LEFT_OUT.iter().position(|known| *known == name);
    let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
    names.sort_by_key(|name| std::cmp::Reverse(rank(name).unwrap_or(usize::MAX)));
    names.into_iter()
}

#[cfg(test)]
mod tests {
    use super::super::request::Request;
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
        let plan = Plan::requested(basis(&request, &gold));
        assert_eq!(plan.budgets, [16, 8, 4, 2, 1]);
        let jobs = plan.jobs(basis(&request, &gold));
        // Gold five times, every point with five seeds and with two at the finest step, halves.
        assert_eq!(jobs.len(), 5 + 5 * (4 + 5) + 2 * 5 + 2);
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
        let request = Request::default();
        let basis = basis(&request, &gold);
        let mut last = 0;
        for seconds in [150.0, 300.0, 600.0, 3000.0] {
            let plan = Plan::fitting(basis, &COSTS, seconds);
            let takes = plan.seconds(basis, &COSTS);
            assert!(takes <= seconds, "{plan:?} takes {takes} of {seconds}");
            assert_eq!(plan.seeds, 3, "{seconds}");
            assert!(plan.candidates.len() >= last.max(2), "{plan:?}");
            assert!(["fixed", "xs-error"].iter().all(|name| plan.is_core(name)));
            last = plan.candidates.len();
        }
        assert!(last > 8, "there is time for others");
        let least = Plan::fitting(basis, &COSTS, 1e-3);
        assert_eq!((least.seeds, least.candidates.len(), least.budgets.len()), (1, 2, 2));
    }

    #[test]
    fn candidates_asked_for_share_the_time() {
        let gold = RenderSettings::default();
        let candidates = ["s", "variance"].map(str::to_owned).to_vec();
        let request = Request { candidates, ..Request::default() };
        let plan = Plan::fitting(basis(&request, &gold), &COSTS, 1000.0);
        assert_eq!(plan.candidates, ["s", "variance"]);
        assert!(plan.is_core("s") && plan.seeds_of("variance") == 3);
    }

    #[test]
    fn seeds_that_are_not_whole_are_left_out() {
        let gold = RenderSettings::default();
        let request = request();
        let basis = basis(&request, &gold);
        let plan = Plan::requested(basis);
        let jobs = plan.jobs(basis);
        let without = |of: &dyn Fn(&Job) -> bool| plan.completed(&jobs, |job| !of(job));
        assert_eq!(without(&|_| false), Some(plan.clone()));
        let left = without(&|job| job.round == 3 && job.candidate == "fixed").unwrap();
        assert_eq!((left.seeds, left.seeds_of("fixed"), left.seeds_of("xs-step")), (5, 3, 5));
        assert_eq!(without(&|job| job.round >= 3).unwrap().seeds, 3);
        assert_eq!(without(&|job| job.round == 0), None);
        assert_eq!(without(&|job| job.candidate == GOLD && job.round == 1), None);
    }
}
