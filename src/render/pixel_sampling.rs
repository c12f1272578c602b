//! The samples of one pixel: their Sobol points, which of them gather indirect light, and when they
//! are enough.

use crate::cache::{DirectedRays, SamplePass};
use crate::director::PixelBudget;
use crate::film::{Accumulator, AovRay, Sample, sample_pass};
use crate::math::{Ray, RayParts, Rgb, Spectrum, Stage, Stream, World};
use crate::medium::Profile;
use crate::scene::Scene;
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
    /// The rays of all pixels, where a director gave them.
    pub directed: Option<&'a DirectedRays>,
    /// Its half, 0 or 1, whose photons it reads and for which it tells what it sees; `None` in pictures that are not in
    /// halves.
    pub half: Option<usize>,
    /// Which of the [times](crate::scene::Scene::times) of the scene it sees, 0 where there are none.
    pub time: usize,
}

/// What the ray of a sample goes through.
#[derive(Debug, Clone, Copy)]
pub struct FilmPlace {
    /// Pixels rightward from the left edge of the film.
    pub x: f64,
    /// Pixels downward from its upper edge.
    pub y: f64,
    /// Place on the lens, uniform in the unit square.
    pub lens: [f64; 2],
    /// Which of the [times](crate::scene::Scene::times) of the scene it sees, 0 where there are none.
    pub time: usize,
}

impl FilmPlace {
    /// The ray of the camera of that time.
    pub fn ray(self, scene: &Scene) -> Ray<World> {
        scene.moments()[self.time].camera.ray(self.x, self.y, self.lens)
    }
}

/// How the samples of a pixel are numbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Numbering {
    /// In one sequence.
    Whole,
    /// In two halves by turns, each a sequence of its own with half of the budget.
    Halves {
        /// The half of the first sample.
        first: u32,
    },
}

/// A sample of a pixel, numbered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberedSample {
    /// Its number among all samples of the pixel, in a pass of the picture among those of the pass.
    pub index: u32,
    /// Its half, 0 or 1, where there are halves.
    pub half: Option<usize>,
    /// Its number in the sequence of its half, or of all.
    pub number: u32,
    /// What all samples of that sequence may spend.
    pub budget: PixelBudget,
}

impl Numbering {
    /// In two halves, in the pixel (x, y): pixels of one ray take turns with their neighbours.
    pub(super) const fn halves([x, y]: [u32; 2]) -> Self {
        Self::Halves { first: (x ^ y) & 1 }
    }

    /// Numbers the sample `index` of a pixel with this `budget`.
    pub(super) fn number(self, index: u32, budget: &PixelBudget) -> NumberedSample {
        match self {
            Self::Whole => NumberedSample { index, half: None, number: index, budget: *budget },
            Self::Halves { first } => {
                let half = (index + first) & 1;
                let budget = self.budget_of(half, budget);
                NumberedSample { index, half: Some(half as usize), number: index / 2, budget }
            }
        }
    }

    /// What the samples of `half` may spend of a `budget`.
    fn budget_of(self, half: u32, budget: &PixelBudget) -> PixelBudget {
        if self == Self::Whole {
            return *budget;
        }
        let [rays, pilot] = [budget.rays, budget.pilot].map(|rays| self.count(half, rays));
        let shared = rays.saturating_sub(pilot);
        let gathers = if budget.gathers_alone() { shared } else { budget.gathers / 2 };
        PixelBudget { rays, pilot, gathers: gathers.clamp(1, shared.max(1)), ..*budget }
    }

    /// How many samples of a pixel with this `budget` gather, in all halves.
    pub(super) fn gathers(self, budget: &PixelBudget) -> u32 {
        match self {
            Self::Whole => budget.gathers,
            Self::Halves { .. } => {
                [0, 1].map(|half| self.budget_of(half, budget).gathers).iter().sum()
            }
        }
    }

    /// How many of the first `samples` belong to `half`.
    fn count(self, half: u32, samples: u32) -> u32 {
        match self {
            Self::Whole if half == 0 => samples,
            Self::Whole => 0,
            Self::Halves { first } if half == first => samples.div_ceil(2),
            Self::Halves { .. } => samples / 2,
        }
    }

    /// The pass, as it is in each half, of the sample `index` of a pixel with this `budget` and up to `rays` rays: that of all
    /// samples, where the picture is a `part` of one.
    pub(super) fn pass(
        self,
        index: u32,
        budget: &PixelBudget,
        rays: u32,
        part: Option<SamplePass>,
    ) -> SamplePass {
        // What a round renders after others is no pilot of it.
        let [number, pilot] = [index, budget.pilot].map(|rays| rays.saturating_sub(budget.earlier));
        let pass = part.unwrap_or_else(|| sample_pass(number, rays, pilot));
        let [rays, shot] = [pass.rays, pass.shot].map(|rays| self.most_of_half(rays));
        SamplePass { rays, shot, ..pass }
    }

    /// Most of `rays` that belong to the same half; all where there are no halves.
    pub(super) const fn most_of_half(self, rays: u32) -> u32 {
        match self {
            Self::Whole => rays,
            Self::Halves { .. } => rays.div_ceil(2),
        }
    }
}

/// Memory that the rays of one thread reuse, and the context that they draw from.
#[derive(Debug)]
pub struct Workspace<S> {
    /// Random numbers of the current ray, and the work of all.
    pub ctx: PathContext,
    /// Memory for marches.
    pub profiles: Profiles<S>,
    /// Objects that the current ray sees, by their identifiers, with their coverages; empty where none are gathered.
    pub objects: Vec<(u32, f64)>,
    /// The parts of the light of the current ray, where they are told apart.
    pub parts: Option<RayParts>,
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
        Self { ctx, profiles: Profiles::default(), objects: Vec::new(), parts: None }
    }

    /// What the current ray, whose `sample` this is, brings to the passes of its pixel.
    pub(super) fn aov_ray<'a>(&'a self, sample: &'a Sample, half: Option<usize>) -> AovRay<'a> {
        AovRay { sample, half, parts: self.parts.as_ref(), objects: &self.objects }
    }
}

/// The Sobol point of the sample with this number in a half, or among all, of the pixel with this index.
pub(super) fn sobol_point(seed: u64, pixel: u64, half: Option<usize>, number: u32) -> SobolPoint {
    // The sequence is good for 2^16 points; further samples start another one.
    let (block, index) = (u64::from(number >> 16), number & 0xffff);
    let block = block | (half.unwrap_or(0) as u64) << 32;
    let mut key = Stream::new(seed, Stage::March, pixel, block | 1 << 63);
    SobolPoint { index, scramble: key.scramble() }
}

/// Makes `ctx` draw the random numbers of one sample of a pixel, by the seed and the number of the pixel.
/// Returns two numbers for the film and two for the lens.
pub(super) fn begin_sample(
    ctx: &mut PathContext,
    [seed, pixel]: [u64; 2],
    stage: Stage,
    sample: &NumberedSample,
) -> [f64; 4] {
    let first = sample.budget.first;
    let point = sobol_point(seed, pixel, sample.half, first + sample.number);
    ctx.rng = Stream::new(seed, stage, pixel, u64::from(first + sample.index));
    ctx.stratified = StratifiedSample::new(point);
    ctx.work.rays += 1;
    point.film_and_lens()
}

/// Weight of the indirect light of a sample: see [`CameraRay::indirect_weight`]. The first sample of a pilot gathers for all
/// of it. Others that gather are evenly spread over those of the pixel.
pub(super) fn indirect_weight(sample: &NumberedSample) -> f64 {
    let NumberedSample { number: sample, budget, .. } = *sample;
    if sample < budget.pilot {
        if sample == 0 { f64::from(budget.pilot) } else { 0.0 }
    } else if budget.gathers_alone() {
        1.0
    } else if budget.gathers_within(sample + 1) != budget.gathers_within(sample) {
        f64::from(budget.shared_rays()) / f64::from(budget.gathers)
    } else {
        0.0
    }
}

/// Radiance to add to the mean of a pixel that has not got all of its rays, so that indirect light
/// counts as if each group of rays were complete.
pub(super) fn indirect_correction(
    samples: &Accumulator,
    budget: &PixelBudget,
    numbering: Numbering,
) -> Rgb {
    let given = samples.given() as u32;
    if given == 0 || given >= budget.rays {
        return Rgb::ZERO;
    }
    // Rays that those given stand for.
    let counted = |half: u32| {
        let (given, part) = (numbering.count(half, given), numbering.budget_of(half, budget));
        let in_pilot = if given > 0 { f64::from(part.pilot) } else { 0.0 };
        in_pilot
            + match part.gathers_within(given) {
                0 => f64::from(given.saturating_sub(part.pilot)),
                groups => groups as f64 * f64::from(part.shared_rays()) / f64::from(part.gathers),
            }
    };
    samples.indirect() * (f64::from(given) / (counted(0) + counted(1)) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unfinished_pixel_has_as_much_light_as_a_finished_one() {
        let budgets = [(16, 4), (10, 4), (64, 3), (3, 4), (7, 7), (5, 2), (1, 1)];
        let budgets = pairs(&budgets, &[0, 1, 2, 5]);
        let numberings = [Numbering::Whole, Numbering::halves([0, 0]), Numbering::halves([1, 0])];
        for (((rays, gathers), pilot), numbering) in pairs(&budgets, &numberings) {
            let pilot = pilot.min(rays);
            let budget = PixelBudget { gathers, pilot, ..PixelBudget::fixed(rays, 0.0, 0.0) };
            let mut samples = Accumulator::default();
            for sample in 0..rays {
                let weight = indirect_weight(&numbering.number(sample, &budget));
                let indirect = Rgb::splat(2.0 * weight);
                samples.add(Sample {
                    radiance: Rgb::ONE + indirect,
                    indirect,
                    ..Sample::default()
                });
                let mean = samples.mean() + indirect_correction(&samples, &budget, numbering);
                assert!((mean - 3.0).abs().max_element() < 1e-5, "{mean} after {sample} of {rays}");
            }
            assert_eq!(indirect_correction(&samples, &budget, numbering), Rgb::ZERO);
        }
    }

    /// Rays that count as gathering are those whose indirect light has the weight of others.
    #[test]
    fn rays_that_gather_for_others_are_counted() {
        for (rays, pilot) in (0..20).flat_map(|rays| (0..=rays.min(6)).map(move |p| (rays, p))) {
            let budget = PixelBudget { pilot, ..PixelBudget::fixed(rays, 0.0, 0.0) };
            let gathers = |numbering: Numbering, given: u32| {
                let weights = (0..given).map(|i| indirect_weight(&numbering.number(i, &budget)));
                weights.filter(|weight| *weight > 1.0).count() as u64
            };
            for given in 0..=pilot {
                for first in [[0, 0], [1, 0]] {
                    let found = budget.all_gathers_within(given);
                    assert_eq!(
                        found,
                        gathers(Numbering::halves(first), given),
                        "{given} of {pilot}"
                    );
                }
            }
        }
    }

    fn pairs<A: Copy, B: Copy>(a: &[A], b: &[B]) -> Vec<(A, B)> {
        a.iter().flat_map(|a| b.iter().map(|b| (*a, *b))).collect()
    }

    #[test]
    fn halves_have_sequences_of_their_own_and_all_samples_between_them() {
        for (rays, first) in (1..20).flat_map(|rays| [(rays, [2, 4]), (rays, [3, 4])]) {
            let budget = PixelBudget::fixed(rays, 0.0, 0.0);
            let numbering = Numbering::halves(first);
            let mut next = [0, 0];
            for index in 0..rays {
                let sample = numbering.number(index, &budget);
                let half = sample.half.unwrap();
                assert_eq!(sample.number, next[half], "{index} of {rays}");
                next[half] += 1;
            }
            for (half, count) in next.into_iter().enumerate() {
                assert_eq!(numbering.count(half as u32, rays), count);
            }
            assert!(next[0].abs_diff(next[1]) <= 1);
        }
    }
}
