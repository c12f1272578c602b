//! Which light a photon path starts from.

use crate::error::Result;
use crate::light::Reach;
use crate::math::{Ray, Rgb, Stream, World, luminance};
use crate::medium::EmissionSampler;
use crate::scene::Scene;

/// All that emits photons: lights and emissive media, chosen in proportion to their power until
/// [`choose_by`](Self::choose_by) says otherwise.
#[derive(Debug)]
pub struct Emitters<'a> {
    scene: &'a Scene,
    reach: Reach,
    /// Whether lattices keep light that comes straight from the sky.
    keeps_sky: bool,
    emitters: Vec<Emitter>,
    /// About the power of each, W.
    powers: Vec<f64>,
    /// Running sum of the weights by which they are chosen.
    cdf: Vec<f64>,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one a light")]
enum Emitter {
    Light(usize),
    Medium(usize, EmissionSampler),
}

/// The start of a photon path.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// The photon's ray, of unit direction.
    pub ray: Ray<World>,
    /// Its power if it were the only path, in W.
    pub power: Rgb,
    /// Whether it comes from a light that pass 2 samples directly.
    pub direct: bool,
    /// Whether pass 2 finds that light in media even where lattices keep light.
    pub sampled: bool,
}

impl<'a> Emitters<'a> {
    /// The emitters of `scene`, whose photons should reach `reach`; `keeps_sky` says whether
    /// lattices keep light that comes straight from the sky.
    ///
    /// # Errors
    /// Where a medium glows without end.
    pub fn new(scene: &'a Scene, reach: Reach, keeps_sky: bool) -> Result<Self> {
        let (mut emitters, mut powers) = (Vec::new(), Vec::new());
        for (index, light) in scene.lights.lights.iter().enumerate() {
            let power = luminance(light.power(&reach));
            if power > 0.0 {
                powers.push(power);
                emitters.push(Emitter::Light(index));
            }
        }
        for (index, medium) in scene.media.iter().enumerate() {
            if let Some(sampler) = EmissionSampler::new(medium)? {
                powers.push(sampler.power());
                emitters.push(Emitter::Medium(index, sampler));
            }
        }
        let cdf = running_sum(powers.iter().copied());
        Ok(Self { scene, reach, keeps_sky, emitters, powers, cdf })
    }

    /// Chooses emitters in proportion to what `weight` gives for their numbers from now on.
    pub fn choose_by(&mut self, weight: impl Fn(usize) -> f64) {
        self.cdf = running_sum((0..self.emitters.len()).map(weight));
    }

    /// About the power of each, W.
    pub fn powers(&self) -> &[f64] {
        &self.powers
    }

    /// What photons should reach.
    pub const fn reach(&self) -> &Reach {
        &self.reach
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

    /// The start of a path; nothing where the light sends this one nowhere. `u` chooses the light
    /// and how it emits.
    pub fn emit(&self, u: [f64; 5], rng: &mut Stream) -> Option<Start> {
        let [choice, u @ ..] = u;
        let total = *self.cdf.last()?;
        let target = choice * total;
        let index = self.cdf.partition_point(|&sum| sum <= target).min(self.cdf.len() - 1);
        let below = if index == 0 { 0.0 } else { self.cdf[index - 1] };
        let probability = (self.cdf[index] - below) / total;
        let (ray, power, direct, sampled) = match &self.emitters[index] {
            Emitter::Light(light) => {
                let light = &self.scene.lights.lights[*light];
                let start = light.emit(&self.reach, u)?;
                (start.ray, start.power, true, !(self.keeps_sky && light.is_environment()))
            }
            Emitter::Medium(medium, sampler) => {
                let start = sampler.emit(self.scene.media.get(*medium), rng)?;
                (start.ray, start.power, false, false)
            }
        };
        (power.is_finite() && power.max_element() > 0.0).then(|| Start {
            ray,
            power: power / probability,
            direct,
            sampled,
        })
    }
}

fn running_sum(weights: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |weight| {
        sum += weight;
        sum
    };
    weights.map(add).collect()
}
