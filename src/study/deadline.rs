//! Keeps a study within its time.

use std::collections::{BTreeMap, BTreeSet};

use super::job::Job;

/// The share of the time that is kept for what cannot be foreseen.
const SLACK: f64 = 0.02;

/// The share of the time that a plan is made for: jobs can take longer than it seems at first.
pub(super) const PLANNED: f64 = 0.9;

/// What a candidate's pictures cost in the report, in comparisons of two pictures.
const REPORTED: f64 = 2.0;

/// Jobs that cost alike: candidate, point, and whether the march step is the finest.
type Kind = (&'static str, usize, bool);

/// The time of a study, and what its jobs take as far as is known.
#[derive(Clone, Debug)]
pub(super) struct Deadline {
    /// Seconds from the start to the end, the report among them.
    seconds: f64,
    /// Seconds to compare one picture with all targets.
    comparing: f64,
    /// Candidates in the report.
    candidates: usize,
    /// Seconds of the last job of each kind.
    taken: BTreeMap<Kind, f64>,
    /// Candidates of which a job was left out: what they had in later rounds would not count.
    left_out: BTreeSet<&'static str>,
}

impl Deadline {
    pub(super) fn new(seconds: f64, comparing: f64, candidates: usize) -> Self {
        let (taken, left_out) = (BTreeMap::new(), BTreeSet::new());
        Self { seconds, comparing, candidates, taken, left_out }
    }

    /// Seconds that `job` should take: those of its kind, or `estimate` where there was none yet.
    pub(super) fn expected(&self, job: &Job, estimate: f64) -> f64 {
        self.taken.get(&kind(job)).copied().unwrap_or(estimate)
    }

    /// Seconds that are left for rendering at `elapsed` seconds, with `done` pictures to compare.
    pub(super) fn left(&self, elapsed: f64, done: usize) -> f64 {
        let comparing = self.comparing * (done as f64 + REPORTED * self.candidates as f64);
        self.seconds * (1.0 - SLACK) - elapsed - comparing
    }

    /// Whether there is time for `job`, which should take this many seconds, when this many are
    /// left. Once there is not, there is none for its candidate any more.
    pub(super) fn admits(&mut self, job: &Job, seconds: f64, left: f64) -> bool {
        let fits = seconds + self.comparing <= left && !self.left_out.contains(job.candidate);
        if !fits {
            self.left_out.insert(job.candidate);
        }
        fits
    }

    /// `job` took this many seconds.
    pub(super) fn note(&mut self, job: &Job, seconds: f64) {
        self.taken.insert(kind(job), seconds);
    }
}

fn kind(job: &Job) -> Kind {
    (job.candidate, job.point, job.finest_step)
}

#[cfg(test)]
mod tests {
    use super::super::job::{Basis, Costs, estimated};
    use super::super::plan::Plan;
    use super::super::request::Request;
    use super::*;
    use crate::scene::RenderSettings;
    use proptest::prelude::*;

    /// Runs a study whose jobs take `factor` times what was estimated: seconds spent on rendering
    /// and comparing, and the longest job.
    fn spent(seconds: f64, factor: f64) -> (f64, f64, Plan) {
        let gold = RenderSettings::default();
        let request = Request { seeds: 1000, seconds: Some(seconds), ..Request::default() };
        let basis = Basis { request: &request, gold: &gold, has_grids: true };
        let costs = Costs { gold: 1.0, least: 0.2, reference: 0.0, comparing: 0.01 };
        let plan = Plan::fitting(basis, &costs, PLANNED * seconds);
        let jobs = plan.with_seeds(request.seeds).jobs(basis);
        let mut deadline = Deadline::new(seconds, costs.comparing, plan.candidates.len() + 1);
        let (mut elapsed, mut longest) = (0.0, 0.0_f64);
        let mut done: Vec<&Job> = Vec::new();
        for job in &jobs {
            let estimate = deadline.expected(job, estimated(job, &gold, &costs));
            let left = deadline.left(elapsed, done.len());
            if plan.is_optional(job) && !deadline.admits(job, estimate, left) {
                continue;
            }
            let takes = factor * estimated(job, &gold, &costs);
            deadline.note(job, takes);
            (elapsed, longest) = (elapsed + takes, longest.max(takes));
            done.push(job);
        }
        let all = elapsed + costs.comparing * (done.len() + 2 * (plan.candidates.len() + 1)) as f64;
        let is_done = |job: &Job| done.contains(&job);
        (all, longest, plan.with_seeds(request.seeds).completed(&jobs, is_done).unwrap())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn time_is_spent_as_asked(seconds in 20.0..300.0_f64, factor in 0.5..2.0_f64) {
            let (spent, longest, plan) = spent(seconds, factor);
            prop_assert!(spent <= seconds + longest, "{spent} of {seconds}, {plan:?}");
            prop_assert!(spent >= 0.85 * seconds, "{spent} of {seconds}, {plan:?}");
            for name in ["fixed", "xs-error"] {
                prop_assert!(plan.candidates.iter().any(|known| known == name));
                prop_assert!(factor > 1.0 || plan.seeds_of(name) >= 3, "{plan:?}");
            }
        }
    }
}
