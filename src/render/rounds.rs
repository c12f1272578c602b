//! Rounds of a picture that is rendered until its error is small enough: each has photons and rays of its own.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::stated_error::StatedError;
use crate::scene::{ErrorGoal, MAX_PHOTONS, MAX_RAYS, RenderSettings};
use crate::strategy::Assignment;

/// Rays of a pixel in the first round: two in each half.
const FIRST_RAYS: u32 = 4;

/// Fewest photon paths of the first round, if there are any.
const FIRST_PHOTONS: u64 = 4096;

/// Most photon paths of a round, whose maps are in memory at once.
const MAX_ROUND_PHOTONS: u64 = 1 << 22;

/// Least and largest factor by which a round makes all rays more: a small one would measure again for little, and an error
/// that is known badly is not to ask for too much.
const GROWTH: [f64; 2] = [1.25, 8.0];

/// Factor on the work that the error asks for, so that one round suffices where it is a little larger than it seemed.
const MARGIN: f64 = 1.1;

/// Largest factor between the proportion of photons to rays in the settings and that which costs least.
const MAX_SHIFT: f64 = 64.0;

/// Rays of a pixel after which a picture that shows no light is given up.
const BLACK_RAYS: u32 = 4096;

/// Photon paths and rays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Extent {
    /// Photon paths.
    pub photons: u64,
    /// Rays of a pixel.
    pub rays: u32,
}

/// One round.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// What it adds.
    pub adds: Extent,
    /// What all rounds are expected to have together, for which cells and kernels are sized.
    pub whole: Extent,
    /// The error of the picture of all rounds so far, once it is finished.
    pub found: Option<StatedError>,
}

/// The sum of `rounds`.
pub fn total(rounds: &[Round]) -> Extent {
    rounds.iter().fold(Extent::default(), |sum, round| Extent {
        photons: sum.photons + round.adds.photons,
        rays: sum.rays + round.adds.rays,
    })
}

/// The error of the picture of all `rounds`: the larger of what the last one found and of the mean of what each found, scaled
/// to all rays. By the last alone, rounds would end where their noise seems small by chance.
pub fn pooled(rounds: &[Round]) -> Option<StatedError> {
    let last = rounds.last()?.found?;
    let all = f64::from(total(rounds).rays);
    let [mut rays, mut weights, mut square] = [0.0; 3];
    for round in rounds {
        let weight = f64::from(round.adds.rays);
        rays += weight;
        if let Some(found) = round.found {
            weights += weight;
            square += weight * found.value.powi(2) * rays / all;
        }
    }
    let mean = (square / weights).sqrt();
    Some(StatedError { value: mean.max(last.value), ..last })
}

/// How rounds follow from what was measured.
#[derive(Debug, Clone, Copy)]
pub struct Schedule {
    goal: ErrorGoal,
    /// Photon paths for each ray of a pixel.
    photons_per_ray: f64,
    /// Squared relative error that the first round is expected to have in the mean over the picture.
    first_error: Option<f64>,
}

impl Schedule {
    /// That of a picture under `settings` with this `goal`, of which the pilot of strategies may have measured what the
    /// `assignment` brings. `needs_photons` says whether there are any.
    pub fn new(
        settings: &RenderSettings,
        goal: ErrorGoal,
        assignment: &Assignment,
        needs_photons: bool,
    ) -> Self {
        let Assignment { strategies, measured, .. } = assignment;
        let asked = settings.photons.max(1) as f64 / f64::from(settings.rays);
        let chosen = measured.iter().find(|measured| measured.strategies == *strategies);
        let Some(measured) = chosen.filter(|_| needs_photons) else {
            let photons_per_ray = if needs_photons { asked } else { 0.0 };
            return Self { goal, photons_per_ray, first_error: None };
        };
        // Variance falls as one over the number of either and cost rises with it: the least cost for an error has numbers
        // in proportion to the root of variance over cost (by the method of Lagrange).
        let variance = measured.variance;
        let ratio = variance.photon_variance * (measured.cost - measured.photon_cost)
            / (variance.ray_variance * measured.photon_cost);
        let shift = if ratio.is_finite() && ratio > 0.0 { ratio.sqrt() } else { 1.0 };
        let photons_per_ray = asked * shift.clamp(1.0 / MAX_SHIFT, MAX_SHIFT);
        let first = Self { goal, photons_per_ray, first_error: None };
        let Extent { photons, rays } = first.extent(FIRST_RAYS);
        let of_photons = variance.photon_variance * settings.photons as f64 / photons as f64;
        let of_rays = variance.ray_variance * f64::from(settings.rays) / f64::from(rays);
        Self { first_error: Some(of_photons + of_rays).filter(|error| error.is_finite()), ..first }
    }

    /// The first round.
    pub fn first(&self) -> Round {
        let adds = self.extent(FIRST_RAYS);
        let growth = match (self.goal, self.first_error) {
            (ErrorGoal::Relative(goal), Some(error)) => error / goal.powi(2),
            _ => 1.0,
        };
        Round { adds, whole: grown(adds, growth.max(1.0)), found: None }
    }

    /// The round after `rounds`, after which the picture has the error `stated`; `None` where that is small enough even one
    /// standard error higher, or there can be no more rays. `time` is what all rounds took and what is left, where there is a deadline.
    pub fn next(
        &self,
        rounds: &[Round],
        stated: Option<StatedError>,
        time: Option<[Duration; 2]>,
    ) -> Option<Round> {
        let done = total(rounds);
        let [least, most] = GROWTH;
        let wanted = match stated {
            Some(stated) if stated.upper().reaches(self.goal) => return None,
            Some(stated) => MARGIN * stated.upper().work_to(self.goal),
            None if done.rays >= BLACK_RAYS => return None,
            None => most,
        };
        let affordable = time.map_or(f64::INFINITY, |[took, left]| {
            1.0 + left.as_secs_f64() / took.as_secs_f64().max(f64::MIN_POSITIVE)
        });
        if affordable < least {
            return None;
        }
        let mut growth = wanted.clamp(least, most).min(affordable);
        if done.photons > 0 {
            let photons = MAX_ROUND_PHOTONS as f64 / done.photons as f64;
            growth = growth.min(1.0 + photons);
        }
        let rays = even((growth - 1.0) * f64::from(done.rays)).min(MAX_RAYS - done.rays);
        if rays < 2 {
            return None;
        }
        let part = f64::from(rays) / f64::from(done.rays);
        let photons = ((part * done.photons as f64) as u64).min(MAX_ROUND_PHOTONS);
        let adds = Extent { photons, rays };
        let whole = grown(done, wanted.min(affordable).max(1.0 + part));
        Some(Round { adds, whole, found: None })
    }

    /// The rounds that the picture should take, of which the `first` leaves the error `stated`.
    pub fn foretold(&self, first: Round, stated: StatedError) -> Vec<Round> {
        let mut rounds = vec![first];
        let left = |rounds: &[Round]| {
            let share = f64::from(first.adds.rays) / f64::from(total(rounds).rays);
            StatedError { value: stated.value * share.sqrt(), ..stated }
        };
        while let Some(next) = self.next(&rounds, Some(left(&rounds)), None) {
            rounds.push(next);
        }
        rounds
    }

    /// So many rays, with the photons that belong to them.
    fn extent(&self, rays: u32) -> Extent {
        let photons = self.photons_per_ray * f64::from(rays);
        let photons = if photons > 0.0 {
            (photons as u64).clamp(FIRST_PHOTONS, MAX_ROUND_PHOTONS)
        } else {
            0
        };
        Extent { photons, rays }
    }
}

/// `factor` times an extent, as far as there may be so much.
fn grown(Extent { photons, rays }: Extent, factor: f64) -> Extent {
    Extent {
        photons: ((photons as f64 * factor) as u64).clamp(photons, MAX_PHOTONS.max(photons)),
        rays: even(f64::from(rays) * factor).clamp(rays, MAX_RAYS.max(rays)),
    }
}

/// The nearest even number of rays, so that both halves have as many.
fn even(rays: f64) -> u32 {
    2 * (0.5 * rays).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategy::{Measured, Strategy, Variance};
    use proptest::prelude::*;

    /// What is asked for and how its rounds begin, where a pilot measured these variances and costs of rays and photons.
    fn schedule(variances: [f64; 2], costs: [f64; 2], goal: f64) -> Schedule {
        let [ray_variance, photon_variance] = variances;
        let variance =
            Variance { ray_variance, smooth_ray_variance: ray_variance, photon_variance };
        let strategies = vec![Strategy::Beams];
        let measured = vec![Measured {
            strategies: strategies.clone(),
            variance,
            cost: costs[0] + costs[1],
            photon_cost: costs[1],
            ray_power: 1.0,
        }];
        let assignment = Assignment { strategies, measured, ..Assignment::default() };
        let settings = RenderSettings { rays: 16, photons: 160_000, ..RenderSettings::default() };
        Schedule::new(&settings, ErrorGoal::Relative(goal), &assignment, true)
    }

    #[test]
    fn photons_and_rays_have_the_proportion_that_costs_least() {
        let even = schedule([1e-3, 1e-3], [2.0, 2.0], 0.01).first();
        assert_eq!(even.adds, Extent { photons: 40_000, rays: 4 });
        // Four times the noise of photons at the cost of rays: twice as many.
        assert_eq!(schedule([1e-3, 4e-3], [2.0, 2.0], 0.01).first().adds.photons, 80_000);
        // 16 rays would have an error of 2e-3, so that 20 times as much is needed.
        assert_eq!(even.whole, Extent { photons: 3_200_000, rays: 320 });
        let few = schedule([1e-3, 0.0], [2.0, 2.0], 0.01).first();
        assert_eq!(few.adds, even.adds, "no noise of photons tells nothing");
    }

    proptest! {
        /// However wrong the error was at first, rounds end with as much work as it asks for, and hardly more.
        #[test]
        fn rounds_end_near_the_work_that_the_error_asks_for(
            goal in 0.01..0.5_f64, at_first in 0.001..1.0_f64, misjudged in 0.1..10.0_f64
        ) {
            let schedule = schedule([misjudged * 1e-3, 1e-3], [2.0, 3.0], goal);
            let mut rounds = vec![schedule.first()];
            let stated = |rounds: &[Round]| {
                let value = at_first * (4.0 / f64::from(total(rounds).rays)).sqrt();
                Some(StatedError { value, uncertainty: 0.0 })
            };
            while let Some(next) = schedule.next(&rounds, stated(&rounds), None) {
                prop_assert!(next.adds.rays % 2 == 0 && next.adds.rays > 0);
                prop_assert!(next.adds.photons <= MAX_ROUND_PHOTONS);
                prop_assert!(next.whole.rays >= total(&rounds).rays + next.adds.rays);
                rounds.push(next);
                prop_assert!(rounds.len() < 1000);
            }
            let rays = f64::from(total(&rounds).rays);
            let foretold = schedule.foretold(rounds[0], stated(&rounds[..1]).unwrap());
            prop_assert!((f64::from(total(&foretold).rays) - rays).abs() <= 0.01 * rays + 2.0);
            prop_assert!(foretold.len().abs_diff(rounds.len()) <= 1);
            let wanted = 4.0 * (at_first / goal).powi(2);
            prop_assert!(rays >= wanted.min(f64::from(MAX_RAYS)) * 0.999, "{rays} for {wanted}");
            prop_assert!(rays <= (1.4 * wanted + 2.0).max(4.0), "{rays} for {wanted}");
        }
    }

    /// An error that is small by chance does not stand alone, and one that is found late counts whole.
    #[test]
    fn all_rounds_tell_the_error() {
        let round = |rays: u32, value: f64| Round {
            adds: Extent { photons: 0, rays },
            whole: Extent::default(),
            found: Some(StatedError { value, uncertainty: 0.1 }),
        };
        let value = |rounds: &[Round]| pooled(rounds).unwrap().value;
        assert_eq!(pooled(&[]), None);
        assert_eq!(value(&[round(4, 0.2)]), 0.2);
        // The first says 0.2² / 2 of all eight rays.
        let mean = ((0.02 + 0.1 * 0.1) / 2.0_f64).sqrt();
        assert!((value(&[round(4, 0.2), round(4, 0.1)]) - mean).abs() < 1e-12);
        assert_eq!(value(&[round(4, 0.1), round(4, 0.3)]), 0.3);
        let unknown = Round { found: None, ..round(4, 0.0) };
        assert_eq!(value(&[unknown, round(4, 0.1)]), 0.1);
        assert_eq!(pooled(&[round(4, 0.1), unknown]), None);
    }

    #[test]
    fn black_is_given_up_late_and_time_ends_rounds() {
        let schedule = schedule([1e-3, 1e-3], [2.0, 2.0], 0.01);
        let mut rounds = vec![schedule.first()];
        while let Some(next) = schedule.next(&rounds, None, None) {
            rounds.push(next);
        }
        assert!(total(&rounds).rays >= BLACK_RAYS);
        let stated = Some(StatedError { value: 1.0, uncertainty: 0.1 });
        let first = [schedule.first()];
        let second = Duration::from_secs(1);
        assert_eq!(schedule.next(&first, stated, Some([10 * second, second])), None);
        let next = schedule.next(&first, stated, Some([second, second])).unwrap();
        assert_eq!(next.adds.rays, 4, "as much as there was");
    }
}
