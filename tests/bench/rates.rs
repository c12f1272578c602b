//! How much is done in a second, on one thread and on all.

use std::hint::black_box;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::spent::{Spent, median};

const ROUNDS: usize = 5;

/// A pool of one thread and one of all.
pub struct Bench {
    pools: [ThreadPool; 2],
}

/// A piece of work and what it does, in one unit or more.
pub struct Row<'a> {
    name: String,
    counts: Vec<(&'static str, f64)>,
    work: Box<dyn Fn() + Sync + 'a>,
}

impl<'a> Row<'a> {
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
    /// Prints the head of the table.
    pub fn new() -> Result<Self, Box<dyn std::error::Error>> {
        let all = std::thread::available_parallelism()?.get();
        let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
        let many = format!("{all} threads");
        println!("medians of {ROUNDS} rounds, freed of what other programs took");
        println!(
            "{:34} {:>12} {many:>12} {:>9}  {:12} the first over this",
            "", "1 thread", "speed-up", ""
        );
        Ok(Self { pools: [pool(1)?, pool(all)?] })
    }

    /// Prints the median rates of `rows`, which take turns, and how many times as fast the first is
    /// as each of the others, on one thread and on all.
    pub fn group(&self, rows: &[Row<'_>]) {
        let mut seconds: Vec<[Vec<f64>; 2]> = rows.iter().map(|_| Default::default()).collect();
        for _ in 0..ROUNDS {
            for (row, seconds) in rows.iter().zip(&mut seconds) {
                for (pool, seconds) in self.pools.iter().zip(seconds) {
                    let ((), spent) = Spent::on(|| pool.install(&row.work));
                    seconds.push(spent.unhindered());
                }
            }
        }
        let ratio = |row: usize, pool: usize| {
            let rounds = seconds[row][pool].iter().zip(&seconds[0][pool]);
            median(rounds.map(|(own, first)| own / first).collect())
        };
        for (index, row) in rows.iter().enumerate() {
            for (unit, count) in &row.counts {
                let [one, many] = [0, 1].map(|pool| count / median(seconds[index][pool].clone()));
                print!("{:34} {one:12.0} {many:12.0} {:8.2}x  {unit:12}", row.name, many / one);
                if index > 0 {
                    print!(" {:.2}, {:.2}", ratio(index, 0), ratio(index, 1));
                }
                println!();
            }
        }
    }
}
