//! Random numbers of a camera sample that are stratified over the samples of its pixel.

use crate::math::Stream;

/// Length of a Sobol sequence; longer ones go on with another scrambling.
///
/// Unit: count. Limit: of the sequences' tables.
const SEQUENCE: u64 = 1 << 16;

/// Odd number that spreads consecutive ones over all bits.
///
/// Unit: none. Definition: 2^32 over the golden ratio.
const SPREAD: u32 = 0x9e37_79b9;

/// What a camera path takes stratified numbers for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// Distances at which caches are read, channels, and cells around.
    CachedPlaces,
    /// Distances sampled by opacity at which direct light is evaluated, and channels.
    OpacityPlaces,
    /// Positions on lights, or directions, at those.
    OpacityLights,
    /// Distances sampled equiangularly, and positions on lights.
    EquiangularPlaces,
    /// Distance, channel and direction of a final gather.
    FinalGather,
    /// Distance and channel of where the forward peak of a phase function deflects the ray, and the direction.
    ForwardPeak,
    /// Positions on lights, or directions, at the first diffuse surface.
    SurfaceLights,
}

/// The decisions of one camera sample.
///
/// Each is stratified the first times that a path makes it; later ones of the same kind take independent numbers, as
/// stratification over a pixel helps little after some bounces.
#[derive(Debug, Clone, Copy, Default)]
pub struct StratifiedSample {
    point: Option<SobolPoint>,
    /// How often each decision was made.
    made: [u8; DECISIONS],
}

/// Number of decisions.
///
/// Unit: count. Definition: of the variants of [`Decision`].
const DECISIONS: usize = Decision::SurfaceLights as usize + 1;

/// Times that a decision of a path is stratified over the samples of a pixel.
///
/// Unit: count. Limit: on the sequences of a path in fog that is deflected again and again.
const STRATIFIED_TIMES: u8 = 4;

/// Four numbers in [0, 1) for each of the parts of a decision.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    /// Where they are stratified over the samples of a pixel.
    point: Option<SobolPoint>,
    /// Which sequence.
    sequence: u32,
    count: u32,
}

/// One point of Owen-scrambled Sobol sequences (Burley 2020, "Practical Hash-based Owen
/// Scrambling").
#[derive(Debug, Clone, Copy)]
pub struct SobolPoint {
    /// Index in the sequences.
    pub index: u32,
    /// Seed of the scrambling.
    pub scramble: u32,
}

impl StratifiedSample {
    /// Those of the camera sample `point`.
    pub const fn new(point: SobolPoint) -> Self {
        Self { point: Some(point), made: [0; DECISIONS] }
    }

    /// Which of so many equal parts of the time that the shutter is open the sample sees.
    pub fn time(&self, parts: u32) -> usize {
        self.point.filter(|_| parts > 1).map_or(0, |point| point.time(parts))
    }

    /// The numbers for a decision of `count` parts: stratified over its parts, and the first times over the samples
    /// of the pixel too.
    pub fn draws(&mut self, decision: Decision, count: u32) -> Draws {
        let made = &mut self.made[decision as usize];
        let point = self.point.filter(|_| *made < STRATIFIED_TIMES);
        let sequence = u32::from(*made) * DECISIONS as u32 + decision as u32;
        *made = made.saturating_add(1);
        Draws { point, sequence, count }
    }
}

impl Draws {
    /// The numbers of the part with this index.
    pub fn numbers(&self, index: u32, rng: &mut Stream) -> [f64; 4] {
        let Some(point) = self.point else {
            let first = (f64::from(index) + rng.uniform()) / f64::from(self.count);
            return [first, rng.uniform(), rng.uniform(), rng.uniform()];
        };
        // All parts of all samples of the pixel are one sequence. Sequences of different decisions are padded: their
        // order is shuffled too (Burley 2020, section 5).
        let part = u64::from(point.index) * u64::from(self.count) + u64::from(index);
        let block = (part / SEQUENCE) as u32;
        let key = (self.sequence + 1) << 16 | block;
        let scramble = point.scramble ^ key.wrapping_mul(SPREAD);
        sobol_burley::sample_4d((part % SEQUENCE) as u32, 0, scramble).map(f64::from)
    }
}

impl SobolPoint {
    /// Two numbers for the film and two for the lens.
    pub fn film_and_lens(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 0, self.scramble).map(f64::from)
    }

    /// Which of so many equal parts of the time that the shutter is open it sees: each as often as the others over the samples
    /// of a pixel, and in another order in each pixel.
    pub fn time(self, parts: u32) -> usize {
        let [u, ..] = sobol_burley::sample_4d(self.index, 1, self.scramble);
        ((f64::from(u) * f64::from(parts)) as usize).min(parts as usize - 1)
    }

    /// Four numbers for a scattering: two for distance and channel, two for the direction.
    pub fn scattering(self) -> [f64; 4] {
        sobol_burley::sample_4d(self.index, 2, self.scramble).map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stage;

    const SOME: [Decision; 3] =
        [Decision::CachedPlaces, Decision::OpacityPlaces, Decision::FinalGather];

    /// Each number of every decision has one value in each stratum, over the parts of all samples of a pixel
    /// whose number is a power of two.
    #[test]
    fn parts_of_all_samples_share_strata() {
        let mut rng = Stream::new(3, Stage::Test, 0, 0);
        for decision in SOME {
            let (samples, count) = (16, 4);
            let mut seen = vec![[0; 4]; 64];
            for index in 0..samples {
                let mut sample = StratifiedSample::new(SobolPoint { index, scramble: 77 });
                let draws = sample.draws(decision, count);
                for part in 0..count {
                    for (axis, u) in draws.numbers(part, &mut rng).into_iter().enumerate() {
                        seen[(u * 64.0) as usize][axis] += 1;
                    }
                }
            }
            assert!(seen.iter().flatten().all(|&count| count == 1), "{decision:?}: {seen:?}");
        }
    }

    /// Over 16 samples the mean of the product of two decisions' numbers has the variance 1/144 a sample, for what depends
    /// on both, if they are in independent order. Blocks of samples are shuffled, not samples, which leaves up to twice as
    /// much; were both in the same order, it would be nine times as much. Over 4000 pixels a variance is known to
    /// 2.2 %: the bound of 2.2 is 4.5 times that above 2.
    #[test]
    fn decisions_are_independent_of_each_other() {
        let mut rng = Stream::new(4, Stage::Test, 0, 0);
        let (pixels, samples) = (4000_u32, 16_u32);
        let mut squares = 0.0;
        for pixel in 0..pixels {
            let scramble = pixel.wrapping_mul(0x0101_4c2d) ^ 0x51ed;
            let mut sum = 0.0;
            for index in 0..samples {
                let mut sample = StratifiedSample::new(SobolPoint { index, scramble });
                let [a, ..] = sample.draws(Decision::CachedPlaces, 1).numbers(0, &mut rng);
                let [b, ..] = sample.draws(Decision::SurfaceLights, 1).numbers(0, &mut rng);
                sum += a * b;
            }
            squares += (sum / f64::from(samples) - 0.25).powi(2);
        }
        let variance = squares / f64::from(pixels) * 144.0 * f64::from(samples);
        assert!(variance < 2.2, "{variance}");
    }

    /// After some times, and without a pixel, only the parts of one sample share strata.
    #[test]
    fn later_decisions_are_stratified_over_their_parts() {
        let mut rng = Stream::new(5, Stage::Test, 0, 0);
        let mut sample = StratifiedSample::new(SobolPoint { index: 3, scramble: 5 });
        let first =
            [(); STRATIFIED_TIMES as usize].map(|()| sample.draws(Decision::CachedPlaces, 4));
        let again = sample.draws(Decision::CachedPlaces, 4);
        let nowhere = StratifiedSample::default().draws(Decision::CachedPlaces, 4);
        assert!(first.iter().all(|draws| draws.point.is_some()));
        assert!(again.point.is_none() && nowhere.point.is_none());
        let numbers = first.map(|draws| draws.numbers(0, &mut rng));
        assert!(numbers.windows(2).all(|pair| pair[0] != pair[1]), "{numbers:?}");
        for part in 0..4 {
            let [u, ..] = again.numbers(part, &mut rng);
            assert_eq!((4.0 * u) as u32, part);
        }
    }
}
