//! Which trials there are, and in which order.

use serde::{Deserialize, Serialize};

use super::candidate::{Candidate, GOLD};
use super::request::Request;
use crate::scene::RenderSettings;

/// The name of the unbiased reference among trials.
pub(super) const REFERENCE: &str = "reference";

/// Budgets and seeds, chosen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// Ceilings of rays a pixel, the largest first.
    pub budgets: Vec<u32>,
    /// Seeds of every candidate at every budget.
    pub seeds: u32,
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
    /// How it is rendered, with the seed.
    pub(super) settings: RenderSettings,
}

impl Plan {
    /// What `request` names, whatever it takes.
    pub(super) fn asked(request: &Request, gold: &RenderSettings) -> Self {
        let mut budgets = request.budgets.clone();
        if budgets.is_empty() {
            budgets = std::iter::successors(Some(gold.rays), |rays| Some(rays / 2))
                .take_while(|rays| *rays > 0)
                .collect();
        }
        budgets.sort_unstable_by(|a, b| b.cmp(a));
        budgets.dedup();
        Self { budgets, seeds: request.seeds }
    }

    /// As many seeds as fit into `seconds`, with every second budget left out where fewer than
    /// three would, and so on; one seed at the largest and the smallest budget in any case.
    pub(super) fn fitting(
        request: &Request,
        gold: &RenderSettings,
        costs: &Costs,
        seconds: f64,
    ) -> Self {
        let mut plan = Self::asked(request, gold);
        loop {
            let fits = (1..=request.seeds).rev().find(|seeds| {
                let plan = Self { seeds: *seeds, ..plan.clone() };
                plan.seconds(request, gold, costs) <= seconds
            });
            plan.seeds = fits.unwrap_or(1);
            if plan.seeds >= request.seeds.min(3) || plan.budgets.len() <= 2 {
                return plan;
            }
            plan.budgets = plan.budgets.iter().copied().step_by(2).collect();
        }
    }

    /// What the study takes at most: a directed picture costs no more than a fixed one with its
    /// ceiling of rays.
    pub(super) fn seconds(&self, request: &Request, gold: &RenderSettings, costs: &Costs) -> f64 {
        let per_ray = (costs.gold - costs.least).max(0.0) / f64::from(gold.rays.max(2) - 1);
        let render =
            |settings: &RenderSettings| costs.least + per_ray * f64::from(settings.rays - 1);
        let targets = if request.reference.is_some() { 2.0 } else { 1.0 };
        let candidates = Candidate::all(gold, &request.candidates, &self.budgets);
        let points = candidates.iter().flat_map(|candidate| &candidate.points);
        let round: f64 =
            points.map(|point| render(&point.settings) + targets * costs.comparing).sum();
        let golds = f64::from(gold_seeds(self.seeds)) * (costs.gold + targets * costs.comparing);
        let reference = f64::from(request.reference.unwrap_or(0)) * costs.reference;
        f64::from(self.seeds) * round + golds + reference
    }

    /// All pictures. A round has every candidate at every budget once and the gold standard among
    /// them; each begins elsewhere, so that nothing always comes first.
    pub(super) fn jobs(&self, request: &Request, gold: &RenderSettings) -> Vec<Job> {
        let candidates = Candidate::all(gold, &request.candidates, &self.budgets);
        let mut jobs = Vec::new();
        for round in 0..gold_seeds(self.seeds) {
            jobs.push(gold_job(gold, round));
            if round >= self.seeds {
                continue;
            }
            let mut tour: Vec<Job> = candidates
                .iter()
                .flat_map(|candidate| {
                    candidate.points.iter().enumerate().map(|(point, at)| Job {
                        candidate: candidate.name,
                        point,
                        round,
                        settings: seeded(&at.settings, Role::Candidate, round),
                    })
                })
                .collect();
            let start = tour.len() * round as usize / self.seeds as usize;
            tour.rotate_left(start);
            jobs.extend(tour);
        }
        if let Some(rays) = request.reference {
            let halves = [rays.div_ceil(2); 2];
            jobs.extend((0..).zip(halves).map(|(round, rays)| Job {
                candidate: REFERENCE,
                point: 0,
                round,
                settings: seeded(&RenderSettings { rays, ..*gold }, Role::Reference, round),
            }));
        }
        jobs
    }
}

/// The gold standard of a round.
pub(super) fn gold_job(gold: &RenderSettings, round: u32) -> Job {
    let settings = Candidate::gold(gold).points[0].settings;
    Job { candidate: GOLD, point: 0, round, settings: seeded(&settings, Role::Gold, round) }
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
        Request { candidates: vec!["fixed".into(), "xs-rays".into()], ..Request::default() }
    }

    #[test]
    fn rounds_have_everything_once() {
        let gold = RenderSettings::default();
        let plan = Plan::asked(&request(), &gold);
        assert_eq!(plan.budgets, [16, 8, 4, 2, 1]);
        let jobs = plan.jobs(&Request { reference: Some(9), ..request() }, &gold);
        assert_eq!(jobs.len(), 6 + 5 * (4 + 5) + 2);
        let mut seen: Vec<_> = jobs.iter().map(|j| (j.candidate, j.point, j.round)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), jobs.len());
    }

    #[test]
    fn a_study_fits_in_the_time_given() {
        let gold = RenderSettings::default();
        let full = Plan::asked(&request(), &gold).seconds(&request(), &gold, &COSTS);
        let mut last = 0.0;
        for seconds in [100.0, 150.0, full / 2.0, full] {
            let plan = Plan::fitting(&request(), &gold, &COSTS, seconds);
            let takes = plan.seconds(&request(), &gold, &COSTS);
            assert!(takes <= seconds, "{plan:?} takes {takes} of {seconds}");
            last = takes;
        }
        assert_eq!(last, full);
        let least = Plan::fitting(&request(), &gold, &COSTS, 1e-3);
        assert_eq!(least.seeds, 1);
        assert!(least.budgets.len() <= 2 && least.budgets[0] == 16);
    }
}
