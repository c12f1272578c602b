//! The budget of a pixel: camera rays, gathers, gather radius and march step.

use std::ops::Range;

use crate::scene::{Directing, RenderSettings};
use crate::strategy::places_at;

/// What rendering a pixel may spend. It is fixed before the pixel's first sample, so that sampling stays
/// unbiased.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelBudget {
    /// Camera rays.
    pub rays: u32,
    /// Number of the first of them in the sequence of the pixel: other passes of the picture have those before.
    pub first: u32,
    /// The first of them, which measured the error before there was a budget. The first of these gathers indirect light for all,
    /// in each half.
    pub pilot: u32,
    /// The first of them, by photons and caches of earlier rounds, which count as a pilot.
    pub earlier: u32,
    /// Those of the others that gather indirect light, weighted for the rest; spread evenly among those.
    pub gathers: u32,
    /// Gather radius of volume photons, in metres.
    pub radius: f64,
    /// Places along a ray at which caches are looked up.
    pub places: u32,
    /// March step, in metres; grids are integrated exactly where it is at most a voxel.
    pub step: f64,
    /// Value of the S-map, 0 to 1; 1 where nothing is directed.
    pub saliency: f64,
    /// Value of the XS-map, 0 to 1; 1 where nothing is directed.
    pub xs: f64,
}

/// Rays of a pixel for each of them that gathers indirect light, which varies little within it. The noise of r rays of
/// which g gather, V/r + W/g, costs least where g/r is the same for all r.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only equal-time`.
const RAYS_PER_GATHERING_RAY: u32 = 4;

/// Largest exponent of a gather radius over the finest, to base 2: the thinned photon map of level l has
/// one photon in 8^l.
///
/// Unit: none. Limit: on levels: one photon in 17 million is left in the last one.
const MAX_LEVEL: f64 = 8.0;

impl PixelBudget {
    /// The budget that every pixel of the gold standard has: `radius` and `step` in metres are its finest.
    pub const fn fixed(rays: u32, radius: f64, step: f64) -> Self {
        let (saliency, xs) = (1.0, 1.0);
        let places = places_at(0);
        Self {
            rays,
            first: 0,
            pilot: 0,
            earlier: 0,
            gathers: gathering_rays(rays),
            radius,
            places,
            step,
            saliency,
            xs,
        }
    }

    /// The budget of a pixel of the importance `xs`, 0 to 1, where `self` is the gold standard's. Rays
    /// are in proportion to `xs`, and at least the floor. Radius and step go geometrically from the finest
    /// to the coarsest; the radius in powers of two, for each of which there is a thinned photon map.
    /// `voxel` is the shortest voxel edge in metres, where there is a grid.
    pub fn for_importance(self, xs: f32, directing: &Directing, voxel: Option<f64>) -> Self {
        let importance = f64::from(xs);
        let mut budget = Self { xs: importance, ..self };
        if directing.directed.rays {
            let rays = (f64::from(self.rays) * importance).round() as u32;
            budget.rays = rays.clamp(directing.floor.max(self.pilot).min(self.rays), self.rays);
            // As many gathers a ray as the gold standard has.
            budget.gathers = self.gathers_for(budget.shared_rays());
        }
        if directing.directed.radius {
            let level = radius_level(directing, xs);
            budget.radius *= f64::from(1_u32 << level);
            budget.places = places_at(level);
        }
        if let Some(voxel) = voxel.filter(|_| directing.directed.step) {
            let coarsest = (directing.coarsest_step * voxel).max(self.step);
            budget.step = if importance >= 1.0 {
                self.step
            } else {
                let finest = self.step.max(voxel);
                finest * (coarsest / finest).max(1.0).powf(1.0 - importance)
            };
        }
        budget
    }

    /// The same, of which each ray gathers for itself.
    #[must_use]
    pub const fn each_gathering(self) -> Self {
        Self { gathers: self.rays, ..self }
    }

    /// The part of it that the pilot spends.
    #[must_use]
    pub const fn of_pilot(self) -> Self {
        Self { rays: self.pilot, ..self }
    }

    /// The same with so many rays more, after those that it has.
    #[must_use]
    pub const fn with_round(self, rays: u32) -> Self {
        let earlier = self.rays;
        Self {
            rays: earlier + rays,
            gathers: gathering_rays(rays),
            pilot: earlier,
            earlier,
            ..self
        }
    }

    /// The part of it that the pass of a picture under `settings` spends; all where that is no pass. Each pass has a
    /// ray of its own in each pixel that has any, so that it is unbiased: where there are more passes than rays, one
    /// beyond those of the whole. As many rays in a hundred gather indirect light as in the whole, and at least one. One
    /// of n passes that shoot has 1/n of the photons, so that a gather has n times the noise for 1/n of the cost: the best number of
    /// gathers, in proportion to the root of noise over cost, is n times as large.
    #[must_use]
    pub fn of_pass(self, settings: &RenderSettings) -> Self {
        let Some(pass) = settings.pass.filter(|_| self.rays > 0) else { return self };
        let Range { start, end } = pass.share(self.rays.into(), settings.rays);
        let (first, rays) = match end - start {
            0 => (self.rays + pass.number - 1, 1),
            rays => (start as u32, rays as u32),
        };
        let gathers = self.gathers_for(rays);
        let gathers = match settings.saved_photons {
            Some(_) => gathers,
            None => gathers.saturating_mul(pass.count).min(rays),
        };
        Self { rays, first, gathers, ..self }
    }

    /// Gathers of so many of its rays: in proportion to those of all, rounded up, and at least one.
    fn gathers_for(&self, rays: u32) -> u32 {
        let gathers = u64::from(self.gathers) * u64::from(rays);
        gathers.div_ceil(self.rays.into()).max(1) as u32
    }

    /// How many of the first `rays` rays gather for others, those of both halves of a pilot among them.
    pub fn all_gathers_within(&self, rays: u32) -> u64 {
        // A ray that is alone in its half gathers for itself.
        let in_pilot = self.pilot.saturating_sub(2).min(2);
        u64::from(rays.min(in_pilot)) + self.gathers_within(rays)
    }

    /// Rays after the pilot's, some of which gather for others.
    pub const fn shared_rays(&self) -> u32 {
        self.rays.saturating_sub(self.pilot)
    }

    /// Whether each ray gathers for itself.
    pub const fn gathers_alone(&self) -> bool {
        self.shared_rays() <= self.gathers
    }

    /// How many of the first `rays` rays gather for others; 0 where every ray gathers for itself.
    pub fn gathers_within(&self, rays: u32) -> u64 {
        let shared = rays.saturating_sub(self.pilot);
        if shared == 0 || self.gathers_alone() {
            return 0;
        }
        u64::from(shared - 1) * u64::from(self.gathers) / u64::from(self.shared_rays()) + 1
    }
}

/// How many of the `rays` of a pixel gather indirect light.
const fn gathering_rays(rays: u32) -> u32 {
    rays.div_ceil(RAYS_PER_GATHERING_RAY)
}

/// Ratio of the gather radius of a pixel of the importance `xs` to the finest, as the exponent of the
/// nearest power of two.
pub fn radius_level(directing: &Directing, xs: f32) -> u32 {
    let octaves = directing.coarsest_radius.max(1.0).log2() * (1.0 - f64::from(xs));
    octaves.round().clamp(0.0, MAX_LEVEL) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Directed, PhotonsName, PicturePass};
    use proptest::prelude::*;

    const GOLD: PixelBudget = PixelBudget::fixed(16, 0.1, 0.02);

    #[test]
    fn the_ends_of_importance() {
        let directing = Directing { directed: Directed::ALL, ..Directing::default() };
        assert_eq!(GOLD.for_importance(1.0, &directing, Some(0.02)), GOLD);
        let least = GOLD.for_importance(0.0, &directing, Some(0.02));
        assert_eq!((least.rays, least.radius), (directing.floor, 0.1 * directing.coarsest_radius));
        assert!((least.step - 0.02 * directing.coarsest_step).abs() < 1e-12);
        assert_eq!(least.places, places_at(radius_level(&directing, 0.0)));
        assert!(least.places < GOLD.places);
    }

    #[test]
    fn each_is_directed_alone() {
        let none = Directed { rays: false, radius: false, step: false };
        for (directed, changes) in [
            (none, [false; 3]),
            (Directed { rays: true, ..none }, [true, false, false]),
            (Directed { radius: true, ..none }, [false, true, false]),
            (Directed { step: true, ..none }, [false, false, true]),
        ] {
            let directing = Directing { directed, ..Directing::default() };
            let budget = GOLD.for_importance(0.0, &directing, Some(0.02));
            let changed =
                [budget.rays < GOLD.rays, budget.radius > GOLD.radius, budget.step > GOLD.step];
            assert_eq!(changed, changes, "{directed:?}");
        }
    }

    /// What a pass spends of `whole`, in a picture of so many rays a pixel, by saved photons or those that it shoots.
    fn part(whole: PixelBudget, rays: u32, pass: PicturePass, is_saved: bool) -> PixelBudget {
        let saved_photons = is_saved.then_some(PhotonsName([0; 8]));
        let pass = Some(pass);
        whole.of_pass(&RenderSettings { rays, pass, saved_photons, ..RenderSettings::default() })
    }

    #[test]
    fn passes_share_the_rays_of_a_pixel() {
        for (rays, of_pixel, count) in
            [(16, 16, 4), (16, 16, 8), (10, 10, 4), (16, 5, 8), (9, 1, 9)]
        {
            let whole = PixelBudget { rays: of_pixel, ..GOLD };
            let mut numbers = Vec::new();
            for number in 1..=count {
                let budget = part(whole, rays, PicturePass { count, number }, true);
                assert!(budget.rays > 0 && budget.gathers > 0);
                let share = f64::from(budget.rays) / f64::from(of_pixel);
                assert!(f64::from(budget.gathers) < f64::from(whole.gathers) * share + 1.0);
                numbers.extend(budget.first..budget.first + budget.rays);
            }
            numbers.sort_unstable();
            let all = numbers.len();
            numbers.dedup();
            assert_eq!(all, numbers.len(), "a ray is shot twice");
            assert!((0..of_pixel).all(|number| numbers.contains(&number)));
            assert!(of_pixel < count || numbers.len() == of_pixel as usize);
        }
        let none = PixelBudget { rays: 0, ..GOLD };
        assert_eq!(part(none, 16, PicturePass { count: 4, number: 2 }, true), none);
    }

    #[test]
    fn gathers_rise_with_rays_and_are_shared_among_passes() {
        for (rays, gathers) in [(1, 1), (4, 1), (16, 4), (17, 5), (64, 16), (1024, 256)] {
            assert_eq!(PixelBudget::fixed(rays, 0.1, 0.02).gathers, gathers, "of {rays}");
        }
        for rays in [64, 1 << 20] {
            let whole = PixelBudget::fixed(rays, 0.1, 0.02);
            let of_pass = |count, is_saved| {
                let gathers =
                    |number| part(whole, rays, PicturePass { count, number }, is_saved).gathers;
                (1..=count).map(gathers).sum::<u32>()
            };
            assert_eq!(of_pass(8, true), whole.gathers);
            // Half of the photons have twice the noise for half of the cost, and of fewer each ray gathers.
            assert_eq!((of_pass(2, false), of_pass(8, false)), (2 * whole.gathers, rays));
        }
        // Those of a round are its own.
        assert_eq!(PixelBudget::fixed(64, 0.1, 0.02).with_round(32).gathers, 8);
    }

    proptest! {
        #[test]
        fn more_important_is_never_coarser(a in 0.0..=1.0f32, b in 0.0..=1.0f32) {
            let directing = Directing { directed: Directed::ALL, ..Directing::default() };
            let of = |xs| GOLD.for_importance(xs, &directing, Some(0.02));
            let (low, high) = (of(a.min(b)), of(a.max(b)));
            prop_assert!(low.rays <= high.rays && low.radius >= high.radius);
            prop_assert!(low.step >= high.step);
        }
    }
}
