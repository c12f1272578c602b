//! The photons that a directed picture needs for the gold standard's error.

use crate::strategy::{EDGE_POWER, Measured};

/// Fewest photons of a directed picture, as a share of the gold standard's.
///
/// Unit: none. Derivation: twice those of the pilot that measures their variance.
const MIN_SHARE: f64 = 1.0 / 16.0;

/// What a directed picture spends on photons, and leaves to rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotonDemand {
    /// Photon paths.
    pub paths: u64,
    /// Variance that is left to the rays, over that of the gold standard's rays, 0 to 1.
    pub ray_share: f64,
    /// Power of the number of rays by which that falls.
    pub ray_power: f64,
    /// Variance of these photons over that of the gold standard's rays, where both are known.
    photons_over_rays: Option<f64>,
}

impl PhotonDemand {
    /// All `photons` of the gold standard, and as much noise of rays as it has.
    pub const fn all(photons: u64) -> Self {
        Self { paths: photons, ray_share: 1.0, ray_power: EDGE_POWER, photons_over_rays: None }
    }

    /// The photons and rays that together have the gold standard's error at the least cost. A pilot `measured` variance V
    /// and cost c of its `photons` and of its rays: V falls as one over their number and c rises with it, so that each of
    /// both gets a part of the error in proportion to its √(V c) (by the method of Lagrange). There are never more photons
    /// than the gold standard has.
    pub fn new(measured: &Measured, photons: u64) -> Self {
        let variance = measured.variance;
        let of_photons = variance.photon_variance.max(0.0);
        let of_rays = variance.ray_variance.max(0.0);
        let photon_part = (of_photons * measured.photon_cost).sqrt();
        let ray_part = (of_rays * (measured.cost - measured.photon_cost).max(0.0)).sqrt();
        let error = of_photons + of_rays;
        let allowed = error * photon_part / (photon_part + ray_part);
        // Without photons, or without any noise, it is not a number.
        let share = if allowed > 0.0 { of_photons / allowed } else { 1.0 };
        let share = share.clamp(MIN_SHARE, 1.0);
        let paths = (photons as f64 * share).ceil() as u64;
        let left = (error - of_photons / share) / of_rays;
        let ray_share = if left > 0.0 { left.min(1.0) } else { 1.0 };
        let photons_over_rays =
            Some(of_photons / share / of_rays).filter(|ratio| ratio.is_finite());
        Self { paths, ray_share, ray_power: measured.ray_power, photons_over_rays }
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

    #[test]
    fn photons_are_spared_where_rays_have_the_noise() {
        // Photons may have half of the error, of which they have an eighth.
        let found = PhotonDemand::new(&measured([7.0, 1.0], [1.0, 7.0]), 1000);
        assert_eq!(found.paths, 250);
        assert!((found.ray_share - 4.0 / 7.0).abs() < 1e-12, "{found:?}");
        // Four times the noise of photons beside four sevenths of that of rays; a quarter of the rays has more.
        assert!((found.photon_part(1.0) - 4.0 / 11.0).abs() < 1e-12, "{found:?}");
        assert!((found.photon_part(0.25) - 0.5 / 7.5).abs() < 1e-12, "{found:?}");
        // They have more than what is best: rays alone are to have their noise.
        let all = PhotonDemand::all(1000);
        let found = PhotonDemand::new(&measured([1.0, 7.0], [1.0, 1.0]), 1000);
        assert_eq!((found.paths, found.ray_share), (all.paths, all.ray_share));
        for none in [[0.0, 0.0], [0.0, 1.0]] {
            let found = PhotonDemand::new(&measured(none, [1.0, 1.0]), 1000);
            assert_eq!(found, all);
            assert_eq!(found.photon_part(0.25), 1.0);
        }
    }

    proptest! {
        /// Photons and rays together have the gold standard's error, and no split of it costs less.
        #[test]
        fn the_error_stays_and_the_cost_is_least(
            rays in 1e-6..1e-2_f64,
            photons in 1e-6..1e-2_f64,
            ray_cost in 0.1..10.0_f64,
            photon_cost in 0.1..10.0_f64,
            other in 0.0..1.0_f64,
        ) {
            let measured = measured([rays, photons], [ray_cost, photon_cost]);
            let found = PhotonDemand::new(&measured, 1_000_000);
            let share = found.paths as f64 / 1e6;
            let error = photons / share + rays * found.ray_share;
            prop_assert!(error <= (rays + photons) * 1.0001, "{found:?}");
            // A split of the same error, with no more photons than there are and no fewer than the floor.
            let cost = |share: f64| {
                let left = rays + photons - photons / share;
                (left > 0.0).then(|| share * photon_cost + ray_cost * rays / left)
            };
            let split = MIN_SHARE + (1.0 - MIN_SHARE) * other;
            if let (Some(least), Some(other)) = (cost(share), cost(split)) {
                prop_assert!(least <= other * 1.0001, "{found:?} costs {least}, {split} {other}");
            }
        }
    }
}
