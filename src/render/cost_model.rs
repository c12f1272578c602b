//! Rays that are left of an exposure, in units that take about equally long, for progress reports.
//!
//! Some rays of a pixel gather light for the others and take longer. How much longer is measured in the
//! first passes. Nothing but the report depends on it.

use std::ops::AddAssign;
use std::time::Duration;

use rayon::prelude::*;

use crate::director::PixelBudget;
use crate::film::{Tile, TiledFilm};

/// Units of a ray that does not gather; so fine that rounding a gather's does not matter.
const RAY: u64 = 1000;

/// Upper bound of the ratio of a gather's time to a ray's: keeps the units within 64 bits where rays
/// take no time that a clock can tell.
const MAX_GATHER_RATIO: f64 = 1e4;

/// Rays that are left to shoot.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Remaining {
    /// Largest number of rays of a pixel without those of earlier rounds, those included that are shot.
    pub most: u32,
    /// Rays that are left.
    pub rays: u64,
    /// Those of them that gather.
    pub gathers: u64,
}

impl Remaining {
    /// Counts what is left for the pixels of `film`, whose budgets `direct` gives.
    pub(super) fn count(
        film: &mut TiledFilm,
        direct: &(impl Fn(u32, u32) -> PixelBudget + Sync),
    ) -> Self {
        let tile = |tile: &mut Tile| {
            tile.pixels().fold(Self::default(), |sum, (x, y, samples)| {
                let budget = direct(x, y);
                let given = samples.given() as u32;
                let rays = budget.rays.saturating_sub(given);
                let all = budget.all_gathers_within(budget.rays);
                let gathers = all.saturating_sub(budget.all_gathers_within(given));
                let most = budget.rays - budget.earlier;
                sum.and(Self { most, rays: rays.into(), gathers })
            })
        };
        film.tiles.par_iter_mut().map(tile).reduce(Self::default, Self::and)
    }

    fn and(self, other: Self) -> Self {
        Self {
            most: self.most.max(other.most),
            rays: self.rays + other.rays,
            gathers: self.gathers + other.gathers,
        }
    }
}

/// Rays that were shot, and the time that they took, summed over threads.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Timing {
    /// Rays that were shot or have become unnecessary.
    pub rays: u64,
    /// Rays that gathered.
    pub gathers: u64,
    /// Time of all rays.
    pub time: Duration,
    /// The part of it that gathers took.
    pub gathering: Duration,
    /// The part of it that filling caches took.
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

/// Units of a ray and of a gather.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CostModel {
    /// Units that a gather adds to its ray's, once they are measured.
    gather: Option<u64>,
}

impl CostModel {
    /// Units of `rays` rays, `gathers` of which gather.
    pub(super) fn count(&self, rays: u64, gathers: u64) -> u64 {
        rays * RAY + gathers * self.gather.unwrap_or(0)
    }

    /// Takes the units of a gather from `spent`, the first time that it holds gathers. Returns whether it
    /// did.
    pub(super) fn learn(&mut self, spent: &Timing) -> bool {
        if self.gather.is_some() || spent.gathers == 0 {
            return false;
        }
        let apart = spent.gathering + spent.once;
        let rest = spent.time.saturating_sub(apart).as_secs_f64() / spent.rays as f64;
        let gather = spent.gathering.as_secs_f64() / spent.gathers as f64;
        let more = (gather / rest.max(f64::MIN_POSITIVE)).min(MAX_GATHER_RATIO);
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
