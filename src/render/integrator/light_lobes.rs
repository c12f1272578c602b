//! Directions that lead light back to a light in a few scatterings.
//!
//! A phase function makes a lobe of a beam in 1, 2, 4, ... scatterings, round the direction of the beam. Light that
//! gets from a light to a place by as many scatterings comes from the same lobe round the direction to the light.

use glam::DVec3;
use smallvec::SmallVec;

use crate::light::{Light, LightSample};
use crate::math::{Stream, WorldPoint};
use crate::medium::Phase;

/// [`concentration`](Phase::concentration) of a phase function above which final gathers are sent toward
/// lights.
///
/// Unit: none. Limit: on the number of second paths. Broader lobes hit lights often enough by themselves.
const MIN_CONCENTRATION: f64 = 6.0;

/// Smallest mean cosine of a lobe.
///
/// Unit: none. Limit: on the scatterings of second paths. Broader lobes send them toward a light little more often than
/// chance.
const MIN_MEAN_COSINE: f64 = 0.4;

/// Most lights that gathers are sent toward from one place: those that send the most light to it.
///
/// Unit: count. Limit: on the lobes that the density of a direction is summed over.
const MAX_LIGHTS: usize = 4;

/// The two uniform numbers that sample the middle of a light, round which its lobes lie.
///
/// Unit: none. Definition: the middle of the unit square.
const MIDDLE: [f64; 2] = [0.5; 2];

/// Most lobes of a phase function: the broadest then stands for [`MAX_REACH`] scatterings.
///
/// Unit: count. Limit: on the scatterings of second paths.
const MAX_LOBES: usize = 6;

/// Most scatterings of a path that is sent toward a light.
///
/// Unit: count. Derivation: the broadest of the lobes for 1, 2, 4, ... scatterings.
const MAX_REACH: usize = 1 << (MAX_LOBES - 1);

/// The lobes that one phase function makes of a beam of light in 1, 2, 4, ... scatterings, from narrow to broad.
#[derive(Debug)]
pub(super) struct LightLobes(SmallVec<[Phase; MAX_LOBES]>);

impl LightLobes {
    /// Those of `phase`; none where it is so broad that they do not pay.
    pub fn new(phase: &Phase) -> Self {
        let mut lobes = SmallVec::new();
        if phase.concentration() > MIN_CONCENTRATION {
            lobes.push(*phase);
            let mut g = phase.mean_cosine();
            while lobes.len() < MAX_LOBES {
                // Legendre moments of successive scatterings are products.
                g *= g;
                match Phase::henyey_greenstein(g) {
                    Ok(lobe) if g >= MIN_MEAN_COSINE => lobes.push(lobe),
                    _ => break,
                }
            }
        }
        Self(lobes)
    }

    /// Scatterings that the broadest lobe stands for; 0 where there is none.
    pub fn reach(&self) -> usize {
        (1 << self.0.len()) >> 1
    }
}

/// For each of a path's last turns the density of its direction among those toward lights over that by the phase
/// function.
#[derive(Debug, Clone, Copy)]
pub(super) struct SentRatios {
    ratios: [f64; MAX_REACH],
    turns: usize,
}

impl SentRatios {
    /// Of a path that has not turned.
    pub const NONE: Self = Self { ratios: [0.0; MAX_REACH], turns: 0 };

    /// Adds the ratio of another turn.
    pub const fn push(&mut self, ratio: f64) {
        self.ratios[self.turns % MAX_REACH] = ratio;
        self.turns += 1;
    }

    /// Weight by the balance heuristic of what a path like this finds, where paths that are sent toward lights
    /// have `reach` scatterings.
    pub fn weight(&self, reach: usize) -> f64 {
        1.0 / (1.0 + self.sum(reach))
    }

    /// Expected number of paths that were sent toward a light at one of the last `reach` turns and are like this
    /// one, for each that follows phase functions alone.
    fn sum(&self, reach: usize) -> f64 {
        (1..=reach.min(self.turns)).map(|age| self.ratios[(self.turns - age) % MAX_REACH]).sum()
    }
}

/// The middle of a light as seen from a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Middle {
    /// The unit direction to it.
    pub direction: DVec3,
    /// How far it is, in metres; infinite for lights that are.
    pub distance: f64,
}

/// A direction toward a light.
pub(super) struct SentDirection {
    /// The unit direction.
    pub direction: DVec3,
    /// Its density, 1/sr.
    pub density: f64,
    /// The light's middle.
    pub middle: Middle,
}

/// Directions from one place toward lights.
pub(super) struct TowardLights<'a> {
    lobes: &'a [Phase],
    /// Each light's middle, and the probability of taking it.
    lights: SmallVec<[(Middle, f64); MAX_LIGHTS]>,
}

impl<'a> TowardLights<'a> {
    /// Directions from `p` toward these lights by these lobes; `None` where there are none, or no light
    /// arrives.
    pub fn new<'l>(
        LightLobes(lobes): &'a LightLobes,
        of: impl Iterator<Item = &'l Light>,
        p: WorldPoint,
    ) -> Option<Self> {
        if lobes.is_empty() {
            return None;
        }
        let mut lights: SmallVec<[(Middle, f64); MAX_LIGHTS]> = SmallVec::new();
        for light in of {
            let sample = light.sample(p, MIDDLE).filter(LightSample::shines);
            let Some(LightSample { direction, distance, .. }) = sample else { continue };
            lights.push((Middle { direction, distance }, light.incident_estimate(p)));
            if lights.len() > MAX_LIGHTS {
                let weaker = |i: &usize, j: &usize| lights[*i].1.total_cmp(&lights[*j].1);
                let weakest = (0..lights.len()).min_by(weaker)?;
                lights.swap_remove(weakest);
            }
        }
        let total: f64 = lights.iter().map(|(_, estimate)| estimate).sum();
        lights.iter_mut().for_each(|(_, share)| *share /= total);
        (total > 0.0 && total.is_finite()).then_some(Self { lobes, lights })
    }

    /// A direction.
    pub fn sample(&self, rng: &mut Stream) -> SentDirection {
        let mut left = rng.uniform();
        let light = self.lights.iter().find(|(_, probability)| {
            left -= probability;
            left < 0.0
        });
        let (middle, _) = *light.unwrap_or(&self.lights[0]);
        let lobe = (rng.uniform() * self.lobes.len() as f64) as usize;
        let (direction, _) = self.lobes[lobe].sample(middle.direction, rng.uniform2());
        SentDirection { direction, density: self.density(direction), middle }
    }

    /// Density of [`sample`](Self::sample) at the unit `direction`, 1/sr.
    pub fn density(&self, direction: DVec3) -> f64 {
        let lobes = |cosine: f64| self.lobes.iter().map(|lobe| lobe.eval(cosine)).sum::<f64>();
        let of_light =
            |(middle, share): &(Middle, f64)| share * lobes(middle.direction.dot(direction));
        self.lights.iter().map(of_light).sum::<f64>() / self.lobes.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use smallvec::smallvec;

    use super::*;
    use crate::math::{Stage, warp};

    fn toward_two(lobes: &LightLobes) -> TowardLights<'_> {
        let at = |direction| Middle { direction, distance: f64::INFINITY };
        let lights = smallvec![(at(DVec3::X), 0.3), (at(DVec3::new(0.0, 0.6, -0.8)), 0.7)];
        TowardLights { lobes: &lobes.0, lights }
    }

    #[test]
    fn lobes_stand_for_powers_of_two_of_scatterings() {
        let of = |g: f64| LightLobes::new(&Phase::henyey_greenstein(g).unwrap());
        // .95 to the powers 1, 2, 4, 8 and 16 is above .4, to the power 32 below.
        assert_eq!([0.0, 0.5, 0.85, 0.95, 0.999].map(|g| of(g).reach()), [0, 0, 4, 16, MAX_REACH]);
        let lobes = of(0.95).0;
        for (lobe, g) in lobes.iter().zip([0.95f64, 0.95f64.powi(2), 0.95f64.powi(4)]) {
            assert!((lobe.mean_cosine() - g).abs() < 1e-12);
        }
    }

    /// Directions are sampled as their density says: the mean of f / density over samples is the integral of f
    /// over the sphere, for the sphere's area and two moments. Bounds of 4.5 standard errors, a false alarm of 2e-5 at
    /// this fixed seed.
    #[test]
    fn directions_follow_their_density() {
        let lobes = LightLobes::new(&Phase::henyey_greenstein(0.8).unwrap());
        let toward = toward_two(&lobes);
        let mut rng = Stream::new(1, Stage::Test, 0, 0);
        let count = 200_000;
        let (mut sums, mut squares) = ([0.0; 3], [0.0; 3]);
        for _ in 0..count {
            let SentDirection { direction, density, middle } = toward.sample(&mut rng);
            assert!((density - toward.density(direction)).abs() < 1e-12 && density > 0.0);
            assert!(toward.lights.iter().any(|(of, _)| of.direction == middle.direction));
            let values = [1.0, direction.x.powi(2), direction.y * direction.z];
            for (index, value) in values.into_iter().enumerate() {
                sums[index] += value / density;
                squares[index] += (value / density).powi(2);
            }
        }
        let n = f64::from(count);
        let right = [1.0, 1.0 / 3.0, 0.0].map(|mean| mean / warp::uniform_sphere_pdf());
        for ((sum, square), right) in sums.into_iter().zip(squares).zip(right) {
            let mean = sum / n;
            let error = ((square / n - mean * mean) / n).sqrt();
            assert!((mean - right).abs() < 4.5 * error, "{mean} not {right}, within {error}");
        }
    }

    #[test]
    fn ratios_of_the_last_turns_are_summed() {
        let mut ratios = SentRatios::NONE;
        assert_eq!(ratios.sum(MAX_REACH), 0.0);
        let value = |turn: usize| (turn * turn % 17) as f64;
        for turn in 0..3 * MAX_REACH {
            ratios.push(value(turn));
            for reach in [0, 1, 5, MAX_REACH] {
                let right: f64 = (0..=turn).rev().take(reach).map(value).sum();
                assert_eq!(ratios.sum(reach), right, "after {turn}, the last {reach}");
                assert_eq!(ratios.weight(reach), 1.0 / (1.0 + right));
            }
        }
    }
}
