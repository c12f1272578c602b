//! Splitting and Russian roulette of photons by a weight window (Vorba and Křivánek 2016, "Adjoint-Driven
//! Russian Roulette and Splitting in Light Transport Simulation"): of heavy photons most would miss what
//! the camera sees, and the few others would show as bright spots.

use crate::light::aim_from;
use crate::math::{Ray, Spectrum, Stream, WorldPoint};
use crate::medium::Phase;
use crate::surface::{SurfaceHit, TransportMode};

use super::path::{PhotonState, PhotonTracer};

/// Photons that one is split into at most, which bounds the time of a path.
///
/// Unit: count. Limit: on the photons of a path.
const MAX_COPIES: f64 = 64.0;

/// Power over the window's above which a medium splits a photon. Lighter ones are left alone, as media
/// scatter photons often.
///
/// Unit: none. Derivation: powers spread evenly, by their logarithm, over a factor of 4 have a mean
/// square over squared mean of 1.16: splitting has little variance to gain.
const SPLIT_ABOVE: f64 = 4.0;

impl PhotonTracer<'_> {
    /// Reflects a photon at a surface that is not specular, toward the emission target, and as several
    /// photons where one would be heavier than `window` (Spanier and Gelbard 1969, section 3.4).
    /// `more` takes them.
    pub fn reflect<S: Spectrum>(
        &self,
        photon: &PhotonState<S>,
        hit: &SurfaceHit<'_>,
        window: f64,
        rng: &mut Stream,
        more: &mut Vec<PhotonState<S>>,
    ) {
        let incoming = photon.ray.direction;
        let side = if incoming.dot(hit.shading_normal) > 0.0 { -1.0 } else { 1.0 };
        let normal = hit.shading_normal * side;
        let draw = |u: [f64; 2]| {
            let (direction, pdf) = aim_from(hit.point, normal, &self.reflection_target, u)?;
            let f = hit.material.eval(incoming, direction, hit, TransportMode::Importance);
            let power = photon.power * S::from_rgb(f) * (direction.dot(normal) / pdf);
            (power.element_sum() > 0.0).then_some((direction, power))
        };
        // One sample estimates their power. It is not used again: their number must not depend on the
        // samples that are.
        let weighed = draw(rng.uniform2()).map_or(0.0, |(_, power)| power.element_sum());
        let count = (weighed / window).ceil().clamp(1.0, MAX_COPIES) as u32;
        for index in 0..count {
            let [u, v] = rng.uniform2();
            let drawn = draw([(f64::from(index) + u) / f64::from(count), v]);
            let Some((direction, power)) = drawn else { continue };
            let mut power = power / f64::from(count);
            let survival = power.element_sum() / window;
            if survival < 1.0 {
                if rng.uniform() >= survival {
                    continue;
                }
                power /= survival;
            }
            let power = self.scene.groups.reflected(power);
            let ray = hit.leave(direction);
            more.push(PhotonState { ray, power, direct: false, sampled: false, ..*photon });
        }
    }

    /// Splits a photon that a medium scatters at `p`, where it is much heavier than the window. `more`
    /// takes the others.
    pub fn split<S: Spectrum>(
        &self,
        photon: &mut PhotonState<S>,
        p: WorldPoint,
        phase: &Phase,
        rng: &mut Stream,
        more: &mut Vec<PhotonState<S>>,
    ) {
        let Some(window) = self.window else { return };
        let heavy = photon.power.element_sum() / window;
        if heavy < SPLIT_ABOVE {
            return;
        }
        let count = heavy.ceil().min(MAX_COPIES) as u32;
        photon.power /= f64::from(count);
        for _ in 1..count {
            let (direction, _) = phase.sample(photon.ray.direction, rng.uniform2());
            more.push(PhotonState { ray: Ray::new(p, direction), ..*photon });
        }
    }
}
