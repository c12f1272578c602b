//! The samples of one pixel: their Sobol points, which of them gather indirect light, and when they
//! are enough.

use crate::cache::SamplePass;
use crate::director::PixelBudget;
use crate::film::Accumulator;
use crate::math::{Ray, Rgb, Spectrum, Stage, Stream, World};
use crate::medium::Profile;
use crate::transport::{PathContext, SobolPoint, StratifiedSample};

/// A camera ray and what it may spend.
#[derive(Debug, Clone, Copy)]
pub struct CameraRay<'a> {
    /// The ray (unit direction).
    pub ray: Ray<World>,
    /// Gather radius, march step and rays of its pixel.
    pub budget: &'a PixelBudget,
    /// Weight of the indirect light that is estimated along it: rays over gathers of the pixel on
    /// rays that gather for others too, 0 on those others, 1 where each ray gathers.
    pub indirect_weight: f64,
    /// The pass that it belongs to.
    pub pass: SamplePass,
}

/// Memory that the rays of one thread reuse, and the context that they draw from.
#[derive(Debug)]
pub struct Workspace<S> {
    /// Random numbers of the current ray, and the work of all.
    pub ctx: PathContext,
    /// Memory for marches.
    pub profiles: Profiles<S>,
}

/// Optical thickness along the rays in hand, in memory that is reused.
#[derive(Debug, Default)]
pub struct Profiles<S> {
    /// Along the camera path.
    pub path: Profile<S>,
    /// Along a ray toward a punctual light, while the path's is in use.
    pub toward_light: Profile<S>,
}

impl<S: Spectrum> Workspace<S> {
    /// Empty memory, and a context to draw from.
    pub(super) fn new(ctx: PathContext) -> Self {
        Self { ctx, profiles: Profiles::default() }
    }
}

/// The Sobol point of a sample of the pixel with this index.
fn sobol_point(seed: u64, pixel: u64, sample: u32) -> SobolPoint {
    // The sequence is good for 2^16 points; further samples start another one.
    let (block, index) = (sample >> 16, sample & 0xffff);
    let mut key = Stream::new(seed, Stage::March, pixel, u64::from(block) | 1 << 63);
    SobolPoint { index, scramble: key.scramble() }
}

/// Makes `ctx` draw the random numbers of one sample of a pixel, by the seed and the number of the pixel.
/// Returns two numbers for the film and two for the lens.
pub(super) fn begin_sample(
    ctx: &mut PathContext,
    [seed, pixel]: [u64; 2],
    stage: Stage,
    sample: u32,
) -> [f64; 4] {
    let point = sobol_point(seed, pixel, sample);
    ctx.rng = Stream::new(seed, stage, pixel, u64::from(sample));
    ctx.stratified = StratifiedSample::new(point);
    ctx.work.rays += 1;
    point.film_and_lens()
}

/// Weight of the indirect light of a sample: see [`CameraRay::indirect_weight`]. The samples that gather
/// are evenly spread over those of the pixel.
pub(super) fn indirect_weight(sample: u32, budget: &PixelBudget) -> f64 {
    if budget.rays <= budget.gathers {
        1.0
    } else if budget.gathers_within(sample + 1) != budget.gathers_within(sample) {
        f64::from(budget.rays) / f64::from(budget.gathers)
    } else {
        0.0
    }
}

/// Radiance to add to the mean of a pixel that has not got all of its rays, so that indirect light
/// counts as if each group of rays were complete.
pub(super) fn indirect_correction(samples: &Accumulator, budget: &PixelBudget) -> Rgb {
    let given = samples.given() as u32;
    let groups = budget.gathers_within(given);
    if groups == 0 || given >= budget.rays {
        return Rgb::ZERO;
    }
    let counted = groups as f64 * f64::from(budget.rays) / f64::from(budget.gathers);
    samples.indirect() * (f64::from(given) / counted - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Sample;

    #[test]
    fn an_unfinished_pixel_has_as_much_light_as_a_finished_one() {
        for (rays, gathers) in [(16, 4), (10, 4), (64, 3), (3, 4), (7, 7)] {
            let budget = PixelBudget { gathers, ..PixelBudget::fixed(rays, 0.0, 0.0) };
            let mut samples = Accumulator::default();
            for sample in 0..rays {
                let indirect = Rgb::splat(2.0 * indirect_weight(sample, &budget));
                let is_shared = budget.rays > budget.gathers;
                samples.add(Sample {
                    radiance: Rgb::ONE + indirect,
                    indirect: if is_shared { indirect } else { Rgb::ZERO },
                    visible_emission: Rgb::ZERO,
                    alpha: 1.0,
                    transmittance: 1.0,
                    depth: 1.0,
                    features: None,
                });
                let mean = samples.mean() + indirect_correction(&samples, &budget);
                assert!((mean - 3.0).abs().max_element() < 1e-5, "{mean} after {sample} of {rays}");
            }
            assert_eq!(indirect_correction(&samples, &budget), Rgb::ZERO);
        }
    }
}
