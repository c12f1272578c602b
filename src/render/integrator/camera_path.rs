//! Camera rays, followed to the first diffuse surface.

use crate::director::PixelBudget;
use crate::film::Sample;
use crate::math::{Ray, Spectrum, World, luminance};
use crate::photon::PhotonDirection;
use crate::surface::TransportMode;
use crate::transport::direct_light;

use super::forward_peak::{Onward, Way};
use super::in_scattering::Marcher;
use crate::render::exposure::State;

/// Mirrors and panes of glass that a camera ray follows at most.
const MAX_SPECULAR: u32 = 64;

/// What is found along a ray, W/(m² sr).
pub(super) struct Found<S> {
    pub(super) light: S,
    /// What of it stands in for that of other rays.
    pub(super) shared: S,
    /// What of it is seen straight, through media, and hardly differs from ray to ray.
    calm: S,
    /// Distance to the first surface, in metres.
    depth: f64,
    /// Of the media before it.
    transmittance: f64,
}

impl<S: Spectrum> Found<S> {
    /// Adds light that is seen, `straight` or in a mirror.
    fn see(&mut self, light: S, straight: bool) {
        self.light += light;
        if straight {
            self.calm += light;
        }
    }
}

impl<S: Spectrum, H: PhotonDirection> Marcher<'_, S, H> {
    /// The light that arrives along `ray` (unit direction) at its origin. Mirrors and glass are
    /// followed to the first diffuse surface, as is what peaks of phase functions scatter.
    pub fn radiance(&self, ray: Ray<World>, budget: &PixelBudget, state: &mut State<S>) -> Sample {
        let mut onward = Onward::new();
        let eye = Way { ray, throughput: S::ONE, lamps: 1.0, shared: state.shared, from_eye: true };
        let seen = self.follow(eye, budget, &mut onward, state);
        let (deflected, stands_in) = self.follow_deflected(onward, budget, state);
        Sample {
            radiance: (seen.light + deflected).rgb(),
            shared: (seen.shared + stands_in).rgb(),
            calm: seen.calm.rgb(),
            alpha: if seen.depth.is_finite() { 1.0 } else { 1.0 - seen.transmittance },
            depth: seen.depth,
            transmittance: seen.transmittance,
            features: None,
        }
    }

    /// The light along `way`. Rays that peaks deflect on the way are put on `onward`.
    ///
    /// Lights that the eye does not see, straight or in mirrors, count nothing: they are sampled
    /// where the ray was scattered.
    pub(super) fn follow(
        &self,
        mut way: Way<S>,
        budget: &PixelBudget,
        onward: &mut Onward<S>,
        state: &mut State<S>,
    ) -> Found<S> {
        let mut found = Found {
            light: S::ZERO,
            shared: S::ZERO,
            calm: S::ZERO,
            depth: f64::INFINITY,
            transmittance: 1.0,
        };
        let (mut inside, mut sees_lights) = (0, way.from_eye);
        for depth in 0..MAX_SPECULAR {
            let hit = direct_light::first_surface(self.scene, &way.ray, &mut state.ctx);
            let mut transmittance = S::ONE;
            if inside == 0 && self.needs.media {
                let media = self.through_media(&way, hit.as_ref(), budget, state);
                found.light += way.throughput * media.light;
                found.shared += way.throughput * std::mem::take(&mut state.stands_in);
                onward.extend(media.deflected.map(|next| next.times(way.throughput)));
                transmittance = media.transmittance;
            }
            if depth == 0 {
                found.transmittance = luminance(transmittance.rgb());
                found.depth = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
            }
            way.throughput *= transmittance;
            let Some(hit) = hit else {
                if sees_lights {
                    let sky = direct_light::environment(self.scene, &way.ray, &mut state.ctx);
                    found.see(way.throughput * S::from_rgb(sky), way.from_eye);
                }
                break;
            };
            if sees_lights {
                let emitted = direct_light::emitted(self.scene, &way.ray, &hit);
                found.see(way.throughput * S::from_rgb(emitted), way.from_eye);
            }
            if !hit.material.is_specular() {
                found.light += way.throughput * self.reflected(&way.ray, &hit, state);
                found.shared += way.throughput * std::mem::take(&mut state.stands_in);
                break;
            }
            let u = std::array::from_fn(|_| state.ctx.rng.uniform());
            let scattered =
                hit.material.scatter(way.ray.direction, &hit, u, TransportMode::Radiance);
            let Some(scattered) = scattered else { break };
            state.ctx.work.specular_bounces += 1;
            inside = (inside + i32::from(scattered.crossing)).max(0);
            let throughput = way.throughput * S::from_rgb(scattered.weight);
            let ray = hit.leave(scattered.direction);
            way = Way { ray, throughput, lamps: 1.0, from_eye: false, ..way };
            sees_lights = true;
        }
        found
    }
}
