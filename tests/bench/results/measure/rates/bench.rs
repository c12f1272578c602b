//! How much is done in a second, on one thread and on all.

use std::hint::black_box;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::measure::spent::{Spent, median};
use crate::pages::Result;
use crate::pages::rates::Row;

const ROUNDS: usize = 5;

/// A pool of one thread and one of all.
pub struct Bench {
    pools: [ThreadPool; 2],
    rounds: usize,
}

/// A piece of work and what it does, in one unit or more.
pub struct Job<'a> {
    name: String,
    counts: Vec<(&'static str, f64)>,
    work: Box<dyn Fn() + Sync + 'a>,
}

impl<'a> Job<'a> {
    /// What `work` does, counted in one unit.
    pub fn new<T>(
        name: impl Into<String>,
        count: (&'static str, f64),
        work: impl Fn() -> T + Sync + 'a,
    ) -> Self {
        Self::of(name, &[count], work)
    }

    /// What `work` does, counted in several.
    pub fn of<T>(
        name: impl Into<String>,
        counts: &[(&'static str, f64)],
        work: impl Fn() -> T + Sync + 'a,
    ) -> Self {
        let work = Box::new(move || drop(black_box(work())));
        Self { name: name.into(), counts: counts.to_vec(), work }
    }
}

impl Bench {
    /// Pools for medians of several rounds, of one where it is to be quick.
    pub fn new(quick: bool) -> Result<Self> {
        let all = std::thread::available_parallelism()?.get();
        let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(Self { pools: [pool(1)?, pool(all)?], rounds: if quick { 1 } else { ROUNDS } })
    }

    /// The median rates of `jobs`, which take turns, freed of what other programs took, and how many
    /// times as fast the first is as each of the others, on one thread.
    pub fn group(&self, jobs: &[Job<'_>]) -> Vec<Row> {
        let mut seconds: Vec<[Vec<f64>; 2]> = jobs.iter().map(|_| Default::default()).collect();
        for _ in 0..self.rounds {
            for (job, seconds) in jobs.iter().zip(&mut seconds) {
                for (pool, seconds) in self.pools.iter().zip(seconds) {
                    let ((), spent) = Spent::on(|| pool.install(&job.work));
                    seconds.push(spent.unhindered());
                }
            }
        }
        let times = |job: usize| {
            let rounds = seconds[job][0].iter().zip(&seconds[0][0]);
            median(rounds.map(|(own, first)| own / first).collect())
        };
        let mut rows = Vec::new();
        for (index, job) in jobs.iter().enumerate() {
            for (unit, count) in &job.counts {
                let [one, all] = [0, 1].map(|pool| count / median(seconds[index][pool].clone()));
                rows.push(Row {
                    work: job.name.clone(),
                    unit: (*unit).into(),
                    one_thread: Some(one),
                    all_threads: Some(all),
                    fogbow_over_it: (index > 0).then(|| times(index)),
                });
            }
        }
        rows
    }
}
