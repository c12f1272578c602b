//! The error of a picture, told by two halves of its rays and photons without a reference.
//!
//! The halves A and B are independent, so that the difference of A and B, halved, is distributed as the noise of their
//! mean: its largest squares are as large as the largest of the true ones. It is the error of the picture as it is
//! rendered: what takes noise off in the end is not counted.

use serde::{Deserialize, Serialize};

use crate::director::visible_differences;
use crate::film::{ComponentFilm, PixelComponents};
use crate::image::Image;
use crate::scene::ErrorGoal;

/// Pixels along each side of a block, over which squared errors are averaged.
const BLOCK: usize = 8;

/// Blocks of a picture for each of the worst, whose error is that of the picture.
const BLOCKS_PER_WORST: usize = 100;

/// Epsilon of relative errors over the mean radiance: that of the metric of studies.
const EPSILON: f64 = 0.5;

/// Standard deviations of a pixel's noise that are to be invisible.
///
/// Unit: none. Derivation: of noise with a normal distribution three pixels in a thousand are further off.
const DEVIATIONS: f64 = 3.0;

/// Relative variance of the square of a number with a normal distribution over the mean of its fourth power: (3 - 1) / 3.
///
/// Unit: none. Derivation: of the moments of that distribution.
const SQUARE_VARIANCE: f64 = 2.0 / 3.0;

/// Error of a picture: of the worst hundredth of its blocks of 8 x 8 pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StatedError {
    /// Root of the mean square over those blocks: relative to the mean radiance of each and half of that of the picture, or
    /// three times as much in least visible differences, so that hardly a pixel is further off.
    pub value: f64,
    /// Standard error of `value` over it.
    pub uncertainty: f64,
}

/// Mean squared error of a block, and the variance of that mean.
#[derive(Debug, Clone, Copy)]
struct BlockError {
    mean: f64,
    variance: f64,
}

impl StatedError {
    /// That of a picture with these `components`, as `goal` counts it; `None` where it shows no light, or a pixel has not
    /// yet a ray in each half.
    pub fn new(components: &ComponentFilm, goal: ErrorGoal) -> Option<Self> {
        let is_known = |pixel: &PixelComponents| pixel.halves.iter().all(|half| half.rays > 0.0);
        if !components.pixels.iter().all(is_known) {
            return None;
        }
        let [width, height] = components.size();
        let picture = Image::new(width, height, components.pixels.iter().map(radiance).collect());
        let noises: Vec<f32> = components.pixels.iter().map(PixelComponents::noise).collect();
        let lights: Vec<f64> = picture.luminances().collect();
        let mean = lights.iter().sum::<f64>() / lights.len().max(1) as f64;
        if mean <= 0.0 {
            return None;
        }
        let blocks = match goal {
            ErrorGoal::Relative(_) => block_errors([width, height], |block| {
                let light = block.iter().map(|&pixel| lights[pixel]).sum::<f64>();
                let light = light / block.len() as f64;
                let scale = 1.0 / light.hypot(EPSILON * mean);
                block.iter().map(|&pixel| scale * f64::from(noises[pixel])).collect()
            }),
            ErrorGoal::Visible => {
                let squares: Vec<f32> = noises.iter().map(|noise| noise * noise).collect();
                let visible = visible_differences(&picture, &squares);
                let in_differences = |&pixel: &usize| {
                    f64::from(noises[pixel]) * DEVIATIONS / f64::from(visible[pixel])
                };
                block_errors([width, height], |block| block.iter().map(in_differences).collect())
            }
        };
        Some(Self::of_blocks(blocks))
    }

    /// That of the worst of `blocks`, of which there is at least one.
    fn of_blocks(mut blocks: Vec<BlockError>) -> Self {
        blocks.sort_by(|a, b| b.mean.total_cmp(&a.mean));
        let worst = &blocks[..blocks.len().div_ceil(BLOCKS_PER_WORST)];
        let count = worst.len() as f64;
        let mean = worst.iter().map(|block| block.mean).sum::<f64>() / count;
        let variance = worst.iter().map(|block| block.variance).sum::<f64>() / count.powi(2);
        // Of the root: half of that of the square.
        let uncertainty = if mean > 0.0 { 0.5 * variance.sqrt() / mean } else { 0.0 };
        Self { value: mean.max(0.0).sqrt(), uncertainty }
    }

    /// It and its standard error, in percent of what `value` is relative to.
    pub fn percent(&self) -> [f64; 2] {
        [self.value, self.value * self.uncertainty].map(|error| 100.0 * error)
    }

    /// The error at the upper end of what it may be, one standard error above.
    #[must_use]
    pub fn upper(&self) -> Self {
        Self { value: self.value * (1.0 + self.uncertainty), ..*self }
    }

    /// Factor on all rays and photons after which the error is that of `goal`: variance falls as one over their number.
    pub fn work_to(&self, goal: ErrorGoal) -> f64 {
        (self.value / goal.value()).powi(2)
    }

    /// Whether it is at most that of `goal`.
    pub fn reaches(&self, goal: ErrorGoal) -> bool {
        self.value <= goal.value()
    }
}

/// Mean radiance of a pixel.
fn radiance(pixel: &PixelComponents) -> [f32; 3] {
    let [a, b] = &pixel.halves;
    ((a.radiance + b.radiance) / pixel.rays().max(1.0)).to_array()
}

/// The errors of all blocks of a picture of the size (width, height), of which `noises` tells that of some pixels. What all
/// pixels of a block have in common, as the noise of photons, is one number.
fn block_errors(
    [width, height]: [usize; 2],
    noises: impl Fn(&[usize]) -> Vec<f64>,
) -> Vec<BlockError> {
    let of_block = |left: usize, top: usize| {
        let rows = top..height.min(top + BLOCK);
        let columns = left..width.min(left + BLOCK);
        let pixels = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
        let noises = noises(&pixels.collect::<Vec<usize>>());
        let count = noises.len() as f64;
        let mean = noises.iter().map(|noise| noise.powi(2)).sum::<f64>() / count;
        let spread = noises.iter().map(|noise| (noise.powi(2) - mean).powi(2)).sum::<f64>();
        let common = (noises.iter().sum::<f64>() / count).powi(4);
        let variance = spread / (count * (count - 1.0)).max(1.0) + SQUARE_VARIANCE * common;
        BlockError { mean, variance }
    };
    let tops = (0..height).step_by(BLOCK);
    tops.flat_map(|top| (0..width).step_by(BLOCK).map(move |left| (left, top)))
        .map(|(left, top)| of_block(left, top))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Sample;
    use crate::math::{Rgb, Stage, Stream};

    const SIZE: [usize; 2] = [160, 80];

    /// A film of two rays in each half whose light is `light(x, y)` with noise of the deviation `noise(x, y)`, and the
    /// relative squared error that its mean has in truth.
    fn film(
        seed: u64,
        light: impl Fn(usize, usize) -> f64,
        noise: impl Fn(usize, usize) -> f64,
    ) -> (ComponentFilm, Vec<f64>) {
        let [width, height] = SIZE;
        let mut errors = Vec::new();
        let pixels = (0..width * height).map(|index| {
            let (x, y) = (index % width, index / width);
            let mut rng = Stream::new(seed, Stage::Test, index as u64, 0);
            let (mut pixel, mut sum) = (PixelComponents::default(), 0.0);
            for ray in 0..4 {
                // The sum of twelve uniform numbers is nearly normal.
                let normal = (0..12).map(|_| rng.uniform()).sum::<f64>() - 6.0;
                let radiance = light(x, y) + noise(x, y) * normal;
                sum += radiance;
                let sample = Sample { radiance: Rgb::splat(radiance), ..Sample::default() };
                pixel.add(ray % 2, &sample);
            }
            errors.push((sum / 4.0 - light(x, y)).powi(2));
            pixel
        });
        let pixels = pixels.collect();
        (ComponentFilm { width, pixels, parts: Vec::new() }, errors)
    }

    /// The true error of the worst blocks in `errors`, relative to `light` everywhere and half of it.
    fn true_error(errors: &[f64], light: f64) -> f64 {
        let scale = 1.0 / (light.powi(2) * 1.25);
        let of = |block: &[usize]| block.iter().map(|&p| (scale * errors[p]).sqrt()).collect();
        let blocks = block_errors(SIZE, of);
        StatedError::of_blocks(blocks).value
    }

    /// Two blocks of 200 tell their true mean within a quarter: each mean of 128 squares has a relative error of 1/8, and
    /// the root half of it, so that a false alarm at these fixed seeds is one of four standard errors, 6e-5.
    #[test]
    fn the_worst_blocks_are_told_as_they_are_in_truth() {
        let noises: [fn(usize, usize) -> f64; 2] =
            [|_, _| 0.2, |x, y| if x < 16 && y < 8 { 0.8 } else { 0.1 }];
        for (seed, noise) in (1..).zip(noises) {
            let (film, errors) = film(seed, |_, _| 3.0, noise);
            let stated = StatedError::new(&film, ErrorGoal::Relative(0.1)).unwrap();
            let truth = true_error(&errors, 3.0);
            assert!((stated.value / truth - 1.0).abs() < 0.25, "{stated:?} for {truth}");
            assert!(stated.uncertainty > 0.02 && stated.uncertainty < 0.1, "{stated:?}");
        }
    }

    #[test]
    fn black_has_no_error_and_dark_blocks_count_by_the_picture() {
        let (black, _) = film(1, |_, _| 0.0, |_, _| 0.0);
        assert_eq!(StatedError::new(&black, ErrorGoal::Relative(0.1)), None);
        // Noise of a block in the dark, beside light of 1.
        let lit = |x: usize, _: usize| if x < 80 { 1.0 } else { 0.0 };
        let (dark, errors) = film(2, lit, |x, y| if x > 150 && y < 8 { 0.1 } else { 0.0 });
        let stated = StatedError::new(&dark, ErrorGoal::Relative(0.1)).unwrap();
        let scale = 1.0 / (0.5_f64 * 0.5).powi(2);
        let of =
            |block: &[usize]| block.iter().map(|&pixel| (scale * errors[pixel]).sqrt()).collect();
        let truth = StatedError::of_blocks(block_errors(SIZE, of)).value;
        assert!((stated.value / truth - 1.0).abs() < 0.35, "{stated:?} for {truth}");
    }

    #[test]
    fn an_unfinished_first_round_tells_no_error() {
        let (mut film, _) = film(1, |_, _| 1.0, |_, _| 0.1);
        film.pixels[77].halves[1] = Default::default();
        assert_eq!(StatedError::new(&film, ErrorGoal::Visible), None);
    }

    /// Even light shows the same differences everywhere, and its noise is to be a third of them.
    #[test]
    fn three_deviations_are_to_be_invisible() {
        let (film, errors) = film(4, |_, _| 1.0, |_, _| 0.1);
        let even = Image::new(SIZE[0], SIZE[1], vec![[1.0; 3]; errors.len()]);
        let visible = f64::from(visible_differences(&even, &vec![0.0; errors.len()])[0]);
        let seen = |block: &[usize]| block.iter().map(|&p| errors[p].sqrt() / visible).collect();
        let truth = 3.0 * StatedError::of_blocks(block_errors(SIZE, seen)).value;
        let stated = StatedError::new(&film, ErrorGoal::Visible).unwrap();
        assert!((stated.value / truth - 1.0).abs() < 0.25, "{stated:?} for {truth}");
    }

    /// Noise that a block has in common is one number z of a normal distribution. The variance of z² is 2/3 of the mean of z⁴,
    /// and the relative deviation of the root is half of that of the square.
    #[test]
    fn what_pixels_have_in_common_is_known_badly() {
        let of = |common: &dyn Fn(&[usize]) -> f64| {
            let blocks = block_errors(SIZE, |block| {
                let sign = |&pixel: &usize| if pixel % 2 == 0 { 1.0 } else { -1.0 };
                block.iter().map(|pixel| common(block) + 0.1 * sign(pixel)).collect()
            });
            StatedError::of_blocks(blocks).uncertainty
        };
        assert!(of(&|_| 0.0) < 1e-9, "pixels of the same square");
        let one = of(&|block| if block[0] == 0 { 10.0 } else { 0.0 });
        assert!((one / (1.0 / 6.0_f64).sqrt() - 1.0).abs() < 0.01, "{one}");
    }

    #[test]
    fn work_goes_with_the_square_of_the_error() {
        let stated = StatedError { value: 0.2, uncertainty: 0.1 };
        assert!((stated.work_to(ErrorGoal::Relative(0.1)) - 4.0).abs() < 1e-12);
        assert!((stated.work_to(ErrorGoal::Visible) - 0.04).abs() < 1e-12);
        assert!(stated.reaches(ErrorGoal::Visible) && !stated.reaches(ErrorGoal::Relative(0.1)));
    }
}
