//! Next-event estimation of emissive media: places that glow are sampled at each scattering of a final
//! gather.
//!
//! A small flame is seldom hit by gathers from the smoke above it, and bright where it is. Places are
//! sampled by what they emit, as photons start there (volumetric emission sampling, Villemin and Hery
//! 2013, "Practical Illumination from Flames"), and combined by the balance heuristic (Veach 1997, section
//! 9.2.2) with the emission that gathers find at collisions. The weights leave the transmittance out of
//! the density of collisions: any weights that sum to 1 at each place are unbiased, and these need no march
//! where a gather hits. Emission that has a grid of its own is integrated along flights, and left to those.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::{Cdf, Ray, Rgb, Span, Spectrum, WorldPoint, luminance};
use crate::medium::{EmissionSampler, Medium, Phase};
use crate::scene::Scene;
use crate::transport::{PathContext, Scattering, direct_light};

/// The emissive media that gathers sample.
#[derive(Debug)]
pub(super) struct EmissionNee<'a> {
    /// Of each medium of the scene.
    samplers: &'a [Option<EmissionSampler>],
    /// Which medium, by its power in W.
    choice: Cdf,
}

impl<'a> EmissionNee<'a> {
    /// Those of `scene`; `None` where none can be sampled.
    pub fn new(scene: &'a Scene) -> Option<Self> {
        let samplers = scene.media.emission_samplers().ok()?;
        let power = |(medium, sampler): (&Medium, &Option<EmissionSampler>)| {
            let sampler = sampler.as_ref().filter(|_| !medium.emits_apart());
            sampler.map_or(0.0, EmissionSampler::power)
        };
        let choice = Cdf::new(scene.media.iter().zip(samplers).map(power))?;
        Some(Self { samplers, choice })
    }

    /// Densities of sampled places and of a gather's collisions where a medium emits `emission`, W/(m³ sr),
    /// each times the squared distance, 1/m: at `distance` metres, in a direction that the gather takes
    /// with density `pdf`, 1/sr, where its rate of collisions is `sigma_t`, 1/m.
    fn densities(&self, emission: Rgb, distance: f64, pdf: f64, sigma_t: Rgb) -> [f64; 2] {
        let sampled = 4.0 * PI * luminance(emission) / self.choice.total();
        [sampled * distance * distance, pdf * sigma_t.element_sum() / 3.0]
    }

    /// MIS weight of the `emission` of the medium of this index, W/(m³ sr), that a gather finds at a collision
    /// at `p`, flying from `last`, where the medium's extinction coefficient is `sigma_t`, 1/m.
    pub fn weight_of_hit(
        &self,
        last: &Scattering,
        medium: usize,
        p: WorldPoint,
        emission: Rgb,
        sigma_t: Rgb,
    ) -> f64 {
        // What is never sampled is left to hits.
        if self.choice.probability(medium) == 0.0 {
            return 1.0;
        }
        let distance = (p - last.position).length();
        let [sampled, hit] = self.densities(emission, distance, last.pdf, sigma_t);
        if sampled > 0.0 { hit / (sampled + hit) } else { 1.0 }
    }

    /// The emission of media that a medium with this `phase` scatters at `p` back along a ray that arrived
    /// along the unit `incoming`, W/(m² sr): the part of it that sampling has by the balance heuristic.
    pub fn sample<S: Spectrum>(
        &self,
        scene: &Scene,
        p: WorldPoint,
        incoming: DVec3,
        phase: &Phase,
        ctx: &mut PathContext,
    ) -> S {
        let (index, _) = self.choice.sample(ctx.rng.uniform());
        let emitter = scene.media.get(index);
        let place = self.samplers[index].as_ref().and_then(|s| s.place(emitter, &mut ctx.rng));
        let Some((at, pdf)) = place else { return S::ZERO };
        ctx.work.emission_lookups += 1;
        let emission = emitter.emission_at(at);
        let way = at - p;
        let distance = way.length();
        if emission == Rgb::ZERO || distance == 0.0 {
            return S::ZERO;
        }
        let ray = Ray::new(p, way / distance);
        let value = phase.eval(incoming.dot(ray.direction));
        let [sampled, hit] = self.densities(emission, distance, value, emitter.sigma_t_at(at));
        if !direct_light::is_clear(scene, &ray, distance, ctx) {
            return S::ZERO;
        }
        let span = Span::new(0.0, distance);
        let through: S = scene.media.transmittance_counted(&ray, span, &mut ctx.work);
        // The weight over the squared distance, which is finite where that is 0.
        let weight = sampled / (distance * distance) / (sampled + hit);
        let emitted = S::of_group(emission, scene.media.group(index));
        through * emitted * (value * weight / (self.choice.probability(index) * pdf))
    }
}
