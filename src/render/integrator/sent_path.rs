//! Final gathers that are sent toward lights.
//!
//! A peaked phase function scatters a light's light back along few directions, those that lead nearly at the
//! light, and there much of it. After a turn away from the light it takes several scatterings to get back to
//! these, and paths that only follow the phase function seldom do. So at each scattering of a gather a second
//! path starts along a direction round that to a light, from the lobe that the phase function makes of a beam
//! in 1, 2, 4, ... scatterings, and ends after as many as the broadest of these stands for. What a path finds it
//! might have found in several ways: by following phase functions alone, or sent toward a light at any of its last
//! scatterings. The balance heuristic over all of them (Veach 1997, section 9.2.2) bounds what one path brings;
//! after Georgiev et al. 2013, "Joint Importance Sampling of Low-Order Volumetric Scattering", which is this with
//! one scattering.

use glam::DVec3;

use crate::math::{Ray, Span, Spectrum, WorldPoint, warp};
use crate::photon::PhotonDirection;
use crate::transport::tracking::{self, Absorption, FlightEnd};
use crate::transport::{PathContext, PathState, Scattering, direct_light, survives_roulette};

use super::light_lobes::{SentDirection, SentRatios, TowardLights};
use super::setup::Integrator;

/// Paths that are sent toward lights undergo Russian roulette where they should find less than this part of
/// what one finds after isotropic scattering.
///
/// Unit: none. Limit: on the number of such paths.
const SMALLEST_EXPECTED: f64 = 0.3;

/// Smallest probability with which such a path survives roulette by the light that gets to where it starts.
///
/// Unit: none. Limit: on the weight of what it finds of other lights, and nearer to the light.
const SMALLEST_ARRIVAL: f64 = 0.1;

/// A path through media, with what its balance heuristic and its end depend on.
#[derive(Debug, Clone, Copy)]
pub(super) struct MediumWalk<S> {
    pub path: PathState<S>,
    /// How likely its last turns were to be sent toward lights.
    pub sent_ratios: SentRatios,
    /// The first Legendre moment that fluence grids do not hold, as far as it is unresolved: 1 before
    /// the first scattering.
    pub unresolved: f64,
}

impl<S: Spectrum> MediumWalk<S> {
    /// Along `path`, which has not been scattered yet.
    pub const fn new(path: PathState<S>) -> Self {
        Self { path, sent_ratios: SentRatios::NONE, unresolved: 1.0 }
    }

    /// Turns to the unit `direction`, which has the density `pdf` by the phase function of `medium` at `p` and the
    /// density `sent` among directions toward lights, 1/sr.
    pub fn turn(&mut self, p: WorldPoint, medium: usize, direction: DVec3, [pdf, sent]: [f64; 2]) {
        self.sent_ratios.push(sent / pdf);
        self.path.ray = Ray::new(p, direction);
        self.path.scattering = Some(Scattering { position: p, pdf, medium: Some(medium) });
    }
}

impl<S: Spectrum, H: PhotonDirection> Integrator<'_, S, H> {
    /// Directions from `p` in `medium` toward the lights that gathers do not hit themselves and that come from about
    /// one direction; `None` where the medium has no lobes, or none of these lights sends light to `p`.
    pub(super) fn toward_lights(&self, p: WorldPoint, medium: usize) -> Option<TowardLights<'_>> {
        let lights = self.scene.lights.lights.iter().zip(&self.handled_by_gather);
        let aims = lights.filter(|(light, is_hit)| !**is_hit && !light.is_environment());
        TowardLights::new(&self.media.light_lobes[medium], aims.map(|(light, _)| light), p)
    }

    /// Direct light, W/(m² sr) times throughput, that a second path finds which is sent `toward` a light where
    /// `medium` scatters the gather at `p`: its part by the balance heuristic. The path brings no other light, and ends
    /// at surfaces.
    pub(super) fn sent_light(
        &self,
        mut sent: MediumWalk<S>,
        p: WorldPoint,
        medium: usize,
        toward: &TowardLights<'_>,
        ctx: &mut PathContext,
    ) -> S {
        let reach = self.media.sent_reach;
        let phase = &self.scene.media.get(medium).phase;
        let SentDirection { direction, density, middle } = toward.sample(&mut ctx.rng);
        let pdf = phase.eval(sent.path.ray.direction.dot(direction));
        if pdf <= 0.0 {
            return S::ZERO;
        }
        sent.turn(p, medium, direction, [pdf, density]);
        // What it should find over what a path finds after isotropic scattering.
        let weight = sent.path.throughput.max_element() * sent.sent_ratios.weight(reach);
        let expected = weight * density / warp::uniform_sphere_pdf();
        let survival = (expected / SMALLEST_EXPECTED).min(1.0);
        if ctx.rng.uniform() >= survival {
            return S::ZERO;
        }
        // Light that is scattered on its way falls off by the reduced coefficient (1 - g) sigma_t (similarity
        // relation, van de Hulst 1980).
        let (ray, span) = (Ray::new(p, middle.direction), Span::new(0.0, middle.distance));
        let through: S = self.scene.media.transmittance_counted(&ray, span, &mut ctx.work);
        let arrives =
            through.max_element().powf(1.0 - phase.mean_cosine().abs()).max(SMALLEST_ARRIVAL);
        if ctx.rng.uniform() >= arrives {
            return S::ZERO;
        }
        sent.path.throughput /= survival * arrives;
        sent.path.radiance = S::ZERO;
        (0..reach).any(|_| !self.sent_step(&mut sent, ctx));
        sent.path.radiance
    }

    /// Traces the path to its next scattering; whether it goes on from there.
    fn sent_step(&self, sent: &mut MediumWalk<S>, ctx: &mut PathContext) -> bool {
        let path = &mut sent.path;
        let hit = direct_light::first_surface(self.scene, &path.ray, ctx);
        let end = hit.map_or(f64::INFINITY, |hit| hit.t);
        let weight = sent.sent_ratios.weight(self.media.sent_reach);
        let lamps = self.lamps_along(&path.ray, end);
        path.radiance += path.throughput * self.sampled_lamps(path, &lamps, ctx) * weight;
        let (media, how) = (&self.scene.media, Absorption::Weighted);
        let flown = tracking::fly(media, &path.ray, end, &mut path.throughput, how, ctx, |_, _| ());
        if !survives_roulette(&mut path.throughput, &mut ctx.rng) {
            return false;
        }
        let FlightEnd::Scattered { t, medium } = flown else { return false };
        path.radiance += self.sampled_direct(path, weight, t, medium, &lamps, ctx);
        let termination = &self.choice.termination;
        sent.unresolved = termination.after(sent.unresolved, medium);
        if self.media.holds_moments[medium] && termination.ends(sent.unresolved, medium) {
            return false;
        }
        path.throughput = self.scene.groups.scattered(path.throughput);
        let (p, incoming) = (path.ray.at(t), path.ray.direction);
        let (direction, pdf) = media.get(medium).phase.sample(incoming, ctx.rng.uniform2());
        let toward = self.toward_lights(p, medium);
        let density = toward.map_or(0.0, |toward| toward.density(direction));
        sent.turn(p, medium, direction, [pdf, density]);
        true
    }
}
