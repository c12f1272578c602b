//! Which light or emissive medium a photon path starts from.

use crate::error::Result;
use crate::light::EmissionTarget;
use crate::math::{Cdf, Group, Ray, Rgb, Span, Stream, World, luminance};
use crate::medium::EmissionSampler;
use crate::scene::Scene;

/// All that emits photons: lights and emissive media, chosen in proportion to their power until
/// [`choose_by`](Self::choose_by) says otherwise.
#[derive(Debug)]
pub struct Emitters<'a> {
    scene: &'a Scene,
    target: EmissionTarget,
    /// Whether flights straight from the sky are recorded for a cache.
    records_sky: bool,
    /// How many surfaces are infinite.
    infinite: usize,
    emitters: Vec<Emitter<'a>>,
    /// About the power of each, W.
    powers: Vec<f64>,
    /// By which they are chosen; `None` where none has a weight.
    cdf: Option<Cdf>,
}

#[derive(Debug)]
enum Emitter<'a> {
    Light(usize),
    Medium(usize, &'a EmissionSampler),
}

/// The start of a photon path.
#[derive(Debug, Clone, Copy)]
pub struct PathStart {
    /// The photon's ray, of unit direction.
    pub ray: Ray<World>,
    /// Its power if it were the only path, in W.
    pub power: Rgb,
    /// The group of its emitter.
    pub group: Group,
    /// Whether it comes from a light that rays sample directly.
    pub direct: bool,
    /// Whether rays sample that light in media even where flights are recorded.
    pub sampled: bool,
}

impl<'a> Emitters<'a> {
    /// The emitters of `scene`, whose photons are aimed at `target`. `records_sky` says whether
    /// flights straight from the sky are recorded for a cache.
    ///
    /// # Errors
    /// Where an unbounded medium emits light.
    pub fn new(scene: &'a Scene, target: EmissionTarget, records_sky: bool) -> Result<Self> {
        let (mut emitters, mut powers) = (Vec::new(), Vec::new());
        for (index, light) in scene.lights.lights.iter().enumerate() {
            let power = luminance(light.power(&target));
            if power > 0.0 {
                powers.push(power);
                emitters.push(Emitter::Light(index));
            }
        }
        for (index, sampler) in scene.media.emission_samplers()?.iter().enumerate() {
            if let Some(sampler) = sampler {
                powers.push(sampler.power());
                emitters.push(Emitter::Medium(index, sampler));
            }
        }
        let cdf = Cdf::new(powers.iter().copied());
        let infinite = scene.surfaces.infinite_feet(target.center()).count();
        Ok(Self { scene, target, records_sky, infinite, emitters, powers, cdf })
    }

    /// Chooses emitters in proportion to what `weight` gives for their numbers from now on.
    pub fn choose_by(&mut self, weight: impl Fn(usize) -> f64) {
        self.cdf = Cdf::new((0..self.emitters.len()).map(weight));
    }

    /// About the power of each, W.
    pub fn powers(&self) -> &[f64] {
        &self.powers
    }

    /// About the power of all together, W.
    pub fn power(&self) -> f64 {
        self.powers.iter().sum()
    }

    /// Whether nothing emits.
    pub const fn is_empty(&self) -> bool {
        self.emitters.is_empty()
    }

    /// How many emit.
    pub const fn len(&self) -> usize {
        self.emitters.len()
    }

    /// The start of a path; `None` where the light emits nothing for `u`, which chooses the light and
    /// how it emits.
    pub fn emit(&self, u: [f64; 5], rng: &mut Stream) -> Option<PathStart> {
        let [choice, u @ ..] = u;
        let cdf = self.cdf.as_ref()?;
        let (index, _) = cdf.sample(choice);
        let (ray, power, group, direct, sampled) = match &self.emitters[index] {
            Emitter::Light(number) => {
                let light = &self.scene.lights.lights[*number];
                let start = light.emit(&self.target, u)?;
                let ray =
                    if light.is_infinite() { self.before_surfaces(start.ray) } else { start.ray };
                let group = self.scene.groups.of_light(*number);
                (ray, start.power, group, true, !(self.records_sky && light.is_environment()))
            }
            Emitter::Medium(medium, sampler) => {
                let start = sampler.emit(self.scene.media.get(*medium), rng)?;
                (start.ray, start.power, self.scene.media.group(*medium), false, false)
            }
        };
        (power.is_finite() && power.max_element() > 0.0).then(|| PathStart {
            ray,
            power: power / cdf.probability(index),
            group,
            direct,
            sampled,
        })
    }

    /// `ray`, which comes from infinitely far, moved back before all surfaces: only infinite ones can
    /// lie behind its origin.
    fn before_surfaces(&self, ray: Ray<World>) -> Ray<World> {
        let surfaces = &self.scene.surfaces;
        let mut back = Ray::new(ray.origin, -ray.direction);
        for _ in 0..self.infinite {
            let Some(hit) = surfaces.intersect(&back, Span::AHEAD) else { break };
            back = hit.leave(back.direction);
        }
        Ray::new(back.origin, ray.direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, WorldPoint};

    /// Lamps of one channel each, which tells where a path starts.
    const LAMPS: &str = r#"
        [camera]
        position = [0.0, 0.0, 5.0]
        target = [0.0, 0.0, 0.0]
        fov = 40.0
        [[light]]
        type = "point"
        position = [1.0, 0.0, 0.0]
        intensity = [1.0, 0.0, 0.0]
        [[light]]
        type = "spot"
        position = [0.0, 1.0, 0.0]
        target = [0.0, 0.0, 0.0]
        angle = 30.0
        intensity = [0.0, 9.0, 0.0]
        [[light]]
        type = "point"
        position = [0.0, 0.0, 1.0]
        intensity = [0.0, 0.0, 30.0]
    "#;

    const PATHS: u32 = 100_000;

    /// Each emitter starts its share of the paths, to five standard deviations (false alarm 6e-7 each),
    /// and the mean of all starts is the power of each lamp however they are chosen.
    #[test]
    fn emitters_are_chosen_by_weight() {
        let scene = Scene::of_text(LAMPS);
        let reach = EmissionTarget::new(WorldPoint::new(0.0, 0.0, 0.0), 3.0).unwrap();
        let mut emitters = Emitters::new(&scene, reach, false).unwrap();
        let powers = emitters.powers().to_vec();
        for weights in [powers.clone(), vec![1.0, 0.0, 3.0]] {
            emitters.choose_by(|index| weights[index]);
            let mut rng = Stream::new(3, Stage::Test, 0, 0);
            let (mut times, mut sums) = ([0.0; 3], [0.0; 3]);
            for _ in 0..PATHS {
                let u = std::array::from_fn(|_| rng.uniform());
                let start = emitters.emit(u, &mut rng).unwrap();
                let of = (0..3).find(|&channel| start.power[channel] > 0.0).unwrap();
                times[of] += 1.0;
                sums[of] += luminance(start.power) / f64::from(PATHS);
            }
            let total: f64 = weights.iter().sum();
            for (index, weight) in weights.iter().enumerate() {
                let expected = weight / total * f64::from(PATHS);
                let off: f64 = times[index] - expected;
                assert!(off.abs() <= 5.0 * expected.sqrt(), "{index}: {times:?} for {weights:?}");
                let right = if *weight > 0.0 { powers[index] } else { 0.0 };
                let off = sums[index] - right;
                assert!(off.abs() <= 5.0 / expected.max(1.0).sqrt() * right, "{index}: {sums:?}");
            }
        }
    }

    /// Light over endless ground, whose photons mostly set out near the horizon.
    const SKY: &str = r#"
        [camera]
        position = [0.0, 2.0, 5.0]
        target = [0.0, 2.0, 0.0]
        fov = 40.0
        [[surface]]
        shape = "plane"
        point = [0.0, 0.0, 0.0]
        normal = [0.0, 1.0, 0.0]
        material = { type = "diffuse", reflectance = 0.5 }
        [[light]]
        type = "environment"
        radiance = 1.0
        [[light]]
        type = "sun"
        direction = [1.0, -0.02, 0.0]
        irradiance = 9.0
    "#;

    #[test]
    fn light_from_far_starts_before_endless_ground() {
        let scene = Scene::of_text(SKY);
        let reach = EmissionTarget::with_ring(WorldPoint::new(0.0, 2.0, 0.0), 1.0, 20.0).unwrap();
        let emitters = Emitters::new(&scene, reach.over_ground(Some(2.0)), false).unwrap();
        let mut rng = Stream::new(5, Stage::Test, 0, 0);
        for _ in 0..PATHS {
            let u = std::array::from_fn(|_| rng.uniform());
            let Ray { origin, direction, .. } = emitters.emit(u, &mut rng).unwrap().ray;
            let above = origin.xyz.y > 0.0;
            assert_eq!(above, direction.y < 0.0, "along {direction} from {}", origin.xyz);
        }
    }
}
