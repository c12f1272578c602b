//! The photons that a directed picture needs for the gold standard's error.

use crate::strategy::{EDGE_POWER, Measured};

/// Fewest photons of a directed picture, as a share of the gold standard's.
///
/// Unit: none. Derivation: twice those of the pilot that measures their variance.
const MIN_SHARE: f64 = 1.0 / 16.0;

/// Most photons of a directed picture, as a multiple of the gold standard's.
///
/// Unit: none. Limit: on memory, and on what noise that a pilot overrates may cost.
const MAX_SHARE: f64 = 4.0;

/// Cost of photons over that of rays up to which there are more photons than their measured noise asks for.
///
/// Unit: none. Limit: on what it costs where a pilot underrates their noise, as it does where final gathers end in cells that are
/// narrower than its own.
const CHEAP: f64 = 0.1;

/// Share of the variance of rays that reconstruction leaves.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only director`.
const RECONSTRUCTED: f64 = 0.25;

/// Rays of each pixel in the pilot that measures error: the fewer where no pixel needs more.
///
/// Unit: count. Definition: one or two in each half.
const PILOT_RAYS: [u32; 2] = [2, 4];

/// What a directed picture spends on photons, and leaves to rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotonDemand {
    /// Photon paths.
    pub paths: u64,
    /// Rays of each pixel in the pilot that measures error.
    pub pilot: u32,
    /// Variance that is left to the rays, over that of the gold standard's rays.
    pub ray_share: f64,
    /// Power of the number of rays by which that falls.
    pub ray_power: f64,
    /// Variance of these photons over that of the gold standard's rays, where both are known.
    photons_over_rays: Option<f64>,
}

impl PhotonDemand {
    /// All `photons` of the gold standard, and as much noise of rays as it has.
    pub fn all(photons: u64, rays: u32) -> Self {
        Self {
            paths: photons,
            pilot: PILOT_RAYS[1].min(rays),
            ray_share: 1.0,
            ray_power: EDGE_POWER,
            photons_over_rays: None,
        }
    }

    /// The photons and rays that together have the error of the gold standard, which has these `photons` and `rays`, at the least
    /// cost. A pilot `measured` variance V and cost c of its photons and of its rays: V falls as one over their number and
    /// c rises with it, so that each of both gets a part of the error in proportion to its √(V c) (by the method of
    /// Lagrange). Of the variance of rays reconstruction leaves a share. Photons may be more than the gold standard's: where
    /// each pixel has as few rays as it can, they make up for the noise of those; where they cost little, they are shot anyway.
    pub fn new(measured: &Measured, photons: u64, rays: u32) -> Self {
        let variance = measured.variance;
        let of_photons = variance.photon_variance.max(0.0);
        let of_rays = variance.ray_variance.max(0.0);
        let error = of_photons + of_rays;
        let reconstructed = RECONSTRUCTED * of_rays;
        let ray_cost = (measured.cost - measured.photon_cost).max(0.0);
        let [photon_part, ray_part] =
            [(of_photons * measured.photon_cost).sqrt(), (reconstructed * ray_cost).sqrt()];
        // The photons' part of the error in the split of least cost, and the rays of a pixel that have the rest.
        let best = error * photon_part / (photon_part + ray_part);
        let needed = f64::from(rays) * reconstructed / (error - best);
        let [few, more] = PILOT_RAYS.map(f64::from);
        let pilot = PILOT_RAYS[usize::from(needed > 0.5 * (few + more))].min(rays);
        let least = f64::from(pilot);
        // Where the pilot's rays are more than needed, photons may have all that those leave.
        let of_least = reconstructed * (f64::from(rays) / least).powf(measured.ray_power);
        let allowed = if needed < least && of_least < error { error - of_least } else { best };
        let cost_of_rays = ray_cost * needed.max(least) / f64::from(rays);
        let cheap = CHEAP * cost_of_rays / measured.photon_cost;
        // Without photons, or without any noise, it is not a number.
        let share = if allowed > 0.0 { (of_photons / allowed).max(cheap) } else { 1.0 };
        let share = share.clamp(MIN_SHARE, MAX_SHARE);
        let paths = (photons as f64 * share).ceil() as u64;
        let left = (error - of_photons / share) / of_rays;
        let ray_share = if left > 0.0 && left.is_finite() { left } else { 1.0 };
        let photons_over_rays =
            Some(of_photons / share / of_rays).filter(|ratio| ratio.is_finite());
        Self { paths, pilot, ray_share, ray_power: measured.ray_power, photons_over_rays }
    }

    /// The share that these photons have in the noise of a picture with `times` the rays of the gold standard: all of it where
    /// nothing was measured.
    pub fn photon_part(&self, times: f64) -> f64 {
        self.photons_over_rays.map_or(1.0, |ratio| {
            let ratio = ratio * times.powf(self.ray_power);
            ratio / (1.0 + ratio)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategy::Variance;
    use proptest::prelude::*;

    fn measured(variances: [f64; 2], costs: [f64; 2]) -> Measured {
        let [ray_variance, photon_variance] = variances;
        let variance =
            Variance { ray_variance, smooth_ray_variance: ray_variance, photon_variance };
        Measured {
            strategies: Vec::new(),
            variance,
            cost: costs[0] + costs[1],
            photon_cost: costs[1],
            ray_power: EDGE_POWER,
        }
    }

    /// A photon costs so little that few rays with many photons are best; or so much that photons are spared.
    #[test]
    fn photons_follow_their_variance_and_cost() {
        let found = PhotonDemand::new(&measured([1.0, 3.0], [16.0, 1.0]), 1000, 16);
        // Four units of error. A quarter of the rays' is left, at 16: √3 parts for photons, 2 for rays.
        let best = 4.0 * 3.0_f64.sqrt() / (3.0_f64.sqrt() + 2.0);
        // 16 rays times a quarter over what is left are fewer than 2, and two have 8^1.5 quarters.
        assert!(16.0 * 0.25 / (4.0 - best) < 3.0);
        let of_two = 0.25 * 8.0_f64.powf(EDGE_POWER);
        assert!(of_two > 4.0, "more than all of the error, so that more rays come");
        assert_eq!((found.pilot, found.paths), (2, (1000.0 * 3.0 / best).ceil() as u64));
        assert!((found.ray_share - (4.0 - best)).abs() < 1e-3, "{found:?}");
        // By power 1 they have 2 of 4.
        let noise = Measured { ray_power: 1.0, ..measured([1.0, 3.0], [16.0, 1.0]) };
        let found = PhotonDemand::new(&noise, 1000, 16);
        assert_eq!((found.pilot, found.paths, found.ray_share), (2, 1500, 2.0));
        // Twice the photons' noise beside that of twice the rays' share.
        assert!((found.photon_part(1.0) - 2.0 / 3.0).abs() < 1e-12, "{found:?}");
        assert!((found.photon_part(0.25) - 0.5 / 1.5).abs() < 1e-12, "{found:?}");
        // Rays have the noise, and photons are dear: a sixteenth of them is the least.
        let found = PhotonDemand::new(&measured([1.0, 1e-6], [1.0, 1e4]), 1600, 16);
        assert_eq!((found.pilot, found.paths), (4, 100));
        // Photons have all the noise, of which there may not be more.
        let found = PhotonDemand::new(&measured([1e-9, 1.0], [1.0, 1.0]), 1000, 16);
        assert_eq!((found.pilot, found.paths), (2, 1001));
        for none in [[0.0, 0.0], [0.0, 1.0]] {
            let found = PhotonDemand::new(&measured(none, [1.0, 1.0]), 1000, 1);
            assert_eq!((found.paths, found.pilot, found.ray_share), (1000, 1, 1.0));
            assert_eq!(found.photon_part(0.25), 1.0);
        }
    }

    proptest! {
        /// Photons and rays together have the gold standard's error; and where pixels may have any number of rays no split
        /// of it costs less, unless photons are so cheap that there are more.
        #[test]
        fn the_error_stays_and_the_cost_is_least(
            rays in 1e-6..1e-2_f64,
            photons in 1e-6..1e-2_f64,
            ray_cost in 0.1..10.0_f64,
            photon_cost in 0.1..10.0_f64,
            other in 0.0..1.0_f64,
        ) {
            let measured = measured([rays, photons], [ray_cost, photon_cost]);
            let gold = 1 << 20;
            let found = PhotonDemand::new(&measured, 1_000_000, gold);
            let share = found.paths as f64 / 1e6;
            let error = photons / share + rays * found.ray_share;
            prop_assert!(error <= (rays + photons) * 1.0001, "{found:?}");
            // A split of the same error, by no more photons than may be and no fewer.
            let left = RECONSTRUCTED * rays;
            let cost = |share: f64| {
                let allowed = rays + photons - photons / share;
                (allowed > 0.0).then(|| share * photon_cost + ray_cost * left / allowed)
            };
            let split = MIN_SHARE + (MAX_SHARE - MIN_SHARE) * other;
            if let (Some(least), Some(other)) = (cost(share), cost(split)) {
                let are_cheap = photons * photon_cost < CHEAP.powi(2) * left * ray_cost;
                let bound = if are_cheap { 1.0 + CHEAP } else { 1.0001 };
                prop_assert!(least <= other * bound, "{found:?} costs {least}, {split} {other}");
            }
        }
    }
}
