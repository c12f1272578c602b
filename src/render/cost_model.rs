//! How much of an exposure is left, in units that all take about equally long.
//!
//! Few rays of a pixel gather light for all of them, and take longer. How much longer shows once the
//! first have been shot.

use std::ops::AddAssign;
use std::time::Duration;

use rayon::prelude::*;

use crate::director::PixelBudget;

use super::pixel_sampling::{gather_groups, has_converged};
use crate::film::{Tile, TiledFilm};

/// Units of a ray that gathers nothing for others.
const RAY: u64 = 1000;

/// Times as long as another ray that one which gathers takes, at most.
const MOST: f64 = 1e4;

/// Rays that are left.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Remaining {
    /// The most that one pixel may get in all.
    pub most: u32,
    /// All that are left.
    pub rays: u64,
    /// Those of them that gather for others.
    pub gathers: u64,
}

impl Remaining {
    /// What is left for the pixels of `plate` of what `direct` says that they may spend.
    pub(super) fn of(
        plate: &mut TiledFilm,
        direct: &(impl Fn(u32, u32) -> PixelBudget + Sync),
    ) -> Self {
        let tile = |tile: &mut Tile| {
            tile.pixels().fold(Self::default(), |sum, (x, y, samples)| {
                let budget = direct(x, y);
                let given = samples.given() as u32;
                let settled = given >= budget.least && has_converged(samples, budget.tolerance);
                let rays = if settled { 0 } else { budget.rays.saturating_sub(given) };
                let gathers = gather_groups(budget.rays, &budget)
                    .saturating_sub(gather_groups(given, &budget));
                let gathers = if rays == 0 { 0 } else { gathers };
                sum.and(Self { most: budget.rays, rays: rays.into(), gathers })
            })
        };
        plate.tiles.par_iter_mut().map(tile).reduce(Self::default, Self::and)
    }

    fn and(self, other: Self) -> Self {
        Self {
            most: self.most.max(other.most),
            rays: self.rays + other.rays,
            gathers: self.gathers + other.gathers,
        }
    }
}

/// Rays that were shot, and the time that threads took for them.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Timing {
    /// Rays shot or no longer needed.
    pub rays: u64,
    /// Those that gathered for others.
    pub gathers: u64,
    /// For all.
    pub time: Duration,
    /// For what was gathered.
    pub gathering: Duration,
    /// For what is kept for rays to come.
    pub once: Duration,
}

impl AddAssign for Timing {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.gathers += other.gathers;
        self.time += other.time;
        self.gathering += other.gathering;
        self.once += other.once;
    }
}

/// What rays count.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CostModel {
    /// Units that a ray counts more if it gathers for others, once that is known.
    gather: Option<u64>,
}

impl CostModel {
    /// So many rays, and so many that gather among them.
    pub(super) fn count(&self, rays: u64, gathers: u64) -> u64 {
        rays * RAY + gathers * self.gather.unwrap_or(0)
    }

    /// Learns from what was `spent` what a ray that gathers counts; whether that is news.
    pub(super) fn learn(&mut self, spent: &Timing) -> bool {
        if self.gather.is_some() || spent.gathers == 0 {
            return false;
        }
        let apart = spent.gathering + spent.once;
        let rest = spent.time.saturating_sub(apart).as_secs_f64() / spent.rays as f64;
        let gather = spent.gathering.as_secs_f64() / spent.gathers as f64;
        let more = (gather / rest.max(f64::MIN_POSITIVE)).min(MOST);
        self.gather = Some((more * RAY as f64) as u64);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_gather_count_what_they_take() {
        let mut units = CostModel::default();
        assert_eq!(units.count(7, 3), 7 * RAY);
        assert!(!units.learn(&Timing::default()));
        let [time, gathering, once] = [60, 40, 10].map(Duration::from_secs);
        assert!(units.learn(&Timing { rays: 100, gathers: 20, time, gathering, once }));
        // A tenth of a second for any ray and two seconds more for each that gathers.
        assert_eq!(units.count(7, 3), 7 * RAY + 3 * 20 * RAY);
    }
}
