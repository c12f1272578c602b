//! Rays by the variance of pixels, as a pilot measured it.

use super::budget::PixelBudget;
use crate::image::{Film, within};

use crate::scene::Directing;

/// Pixels from a pixel to the edge of the square over which variance and mean of the pilot are averaged: by
/// itself the variance of a few rays says little.
///
/// Unit: pixels. Derivation: nine pixels of four rays have 27 degrees of freedom, which tell the variance of
/// normal samples to its quarter.
const REACH: usize = 1;

/// The budget of each pixel of the `pilot`'s window, row by row from the top: as many rays as make the
/// standard error of the mean luminance the tolerance of `directing` times that mean, at least the floor and at most as
/// many as `gold` has, which is also what a pixel gets round which no light is seen. The pilot's pixels have
/// `rays` rays each, all of which gather.
///
/// The numbers of rays depend on none of the samples that pixels keep, so that their means are unbiased
/// (two-stage sampling, Stein 1945, "A Two-Sample Test for a Linear Hypothesis whose Power is Independent of
/// the Variance"). A pixel that ended by its own samples would end soonest where a rare bright one is still
/// missing.
pub fn variance_budgets(
    pilot: &Film,
    rays: u32,
    gold: PixelBudget,
    directing: &Directing,
) -> Vec<PixelBudget> {
    let size = [pilot.width(), pilot.height()];
    let means: Vec<f64> = pilot.image().luminances().collect();
    let variances = pilot.layer("variance").unwrap_or_default();
    let floor = directing.floor.min(gold.rays);
    let budget = |pixel: usize| {
        let (mut mean, mut variance, mut count) = (0.0, 0.0, 0.0);
        for near in within(size, pixel, REACH) {
            mean += means[near];
            variance += f64::from(variances[near]);
            count += 1.0;
        }
        let (mean, of_ray) = (mean / count, f64::from(rays) * variance / count);
        let needed = (of_ray / (directing.tolerance * mean).powi(2)).ceil();
        // Without light it is not a number.
        let needed = if mean > 0.0 { (needed as u32).clamp(floor, gold.rays) } else { gold.rays };
        // The variance is that of rays that all gather.
        PixelBudget { rays: needed, ..gold }.each_gathering()
    };
    (0..means.len()).map(budget).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::FilmPixel;
    use crate::math::Rgb;

    const GOLD: PixelBudget = PixelBudget::fixed(64, 0.1, 0.02);

    /// Rays by a pilot of four rays a pixel, 5 x 3 pixels with this radiance and variance of the mean.
    fn rays(radiance: impl Fn(usize) -> f64, variance: impl Fn(usize) -> f64) -> Vec<u32> {
        let mut film = Film::new(5, 3);
        for index in 0..15 {
            let radiance = Rgb::splat(radiance(index));
            let pixel = FilmPixel { radiance, variance: variance(index), ..Default::default() };
            film.set(index % 5, index / 5, &pixel);
        }
        let directing = Directing { floor: 2, tolerance: 0.1, ..Directing::default() };
        let budgets = variance_budgets(&film, 4, GOLD, &directing);
        budgets.iter().map(|budget| budget.rays).collect()
    }

    #[test]
    fn rays_make_the_error_the_tolerance() {
        // 4 * 0.125 / (0.1 * 2)² = 12.5, and so on.
        for (variance, right) in [(0.125, 13), (0.25, 25), (1e-9, 2), (9.0, 64)] {
            assert_eq!(rays(|_| 2.0, |_| variance), [right; 15], "{variance}");
        }
    }

    #[test]
    fn neighbours_count_and_darkness_gets_all_rays() {
        // A ninth of the variance of one pixel is that of those round it, a sixth at the border.
        let found = rays(|_| 2.0, |index| if index == 6 { 0.875 } else { 0.0 });
        assert_eq!((found[6], found[1], found[4]), (10, 15, 2));
        let found = rays(|index| f64::from(u8::from(index % 5 == 0)), |_| 0.0);
        assert_eq!(found[..5], [2, 2, 64, 64, 64]);
    }
}
