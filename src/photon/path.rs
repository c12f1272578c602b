//! One photon path: flights through media, scattering at surfaces, and what it leaves in the maps.
//!
//! What a collision is is chosen in proportion to the mean over channels of power times coefficient
//! (see [`tracking`]), so the mean power of a photon never changes in media and stored photons weigh
//! alike.

use std::ops::Range;

use crate::light::EmissionTarget;
use crate::math::{Aabb, Ray, Span, Spectrum, Stage, Stream, World, WorldPoint};
use crate::medium::Collision;
use crate::scene::Scene;
use crate::surface::{SurfaceHit, TransportMode};
use crate::transport::tracking::{self, Absorption, FlightEnd, FlightStep};
use crate::transport::{EnclosingSolids, FlightSegment, MAX_EVENTS, PathContext, direct_light};
use crate::work::Work;

use super::deposit_regions::DepositRegions;
use super::emitters::Emitters;
use super::{Photon, PhotonAt, PhotonDirection, PhotonSettings};

/// Relative change of power below which it is rounding: null collisions in grey media change nothing
/// else.
///
/// Unit: none. Derivation: thousands of roundings of f64, 1e-16 each.
const ROUNDING: f64 = 1e-12;

/// What all photon paths of a render share.
#[derive(Debug)]
pub(super) struct PhotonTracer<'a> {
    pub scene: &'a Scene,
    pub emitters: Emitters<'a>,
    pub settings: PhotonSettings,
    /// What photons that a surface reflects are aimed at.
    pub reflection_target: EmissionTarget,
    pub deposit_regions: DepositRegions,
    /// Origin of stored positions.
    pub origin: WorldPoint,
    /// Probability of storing a volume photon; the stored ones carry the power of the others. 0 where
    /// no beam map is needed.
    pub store_probability: f64,
    /// Box in which flight segments are recorded, for fluence grids; `None` where there are none.
    pub flight_bounds: Option<Aabb<World>>,
    /// Power, summed over channels, that photons should have: heavier ones are split where a
    /// surface reflects them, lighter ones play Russian roulette; much heavier ones are split in media.
    pub window: Option<f64>,
    /// Units of stored powers.
    pub units: Units,
}

/// Units of stored power, so that it fits 32 bits at any brightness and scale of the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    /// Of volume photons, in W m.
    pub volume: f64,
    /// Of surface photons, in W.
    pub surface: f64,
}

impl Units {
    /// For photons of about `power` W in a world of about `size` m. Powers of two: rounding is then
    /// the same in any unit.
    pub fn around(power: f64, size: f64) -> Self {
        let unit = |x: f64| if x.is_normal() { x.log2().round().exp2() } else { 1.0 };
        Self { volume: unit(power * size), surface: unit(power) }
    }
}

/// What a range of paths leaves in the maps.
#[derive(Debug)]
pub(super) struct Deposits<S: Spectrum, H> {
    pub volume: Vec<PhotonAt<S, H>>,
    /// Index of one volume photon, chosen at random, of each path that left any.
    pub independent: Vec<usize>,
    pub surface: Vec<PhotonAt<S>>,
    pub tracks: Vec<FlightSegment<S>>,
    pub work: Work,
}

impl<S: Spectrum, H: PhotonDirection> Deposits<S, H> {
    /// No deposits.
    pub fn none() -> Self {
        Self {
            volume: Vec::new(),
            independent: Vec::new(),
            surface: Vec::new(),
            tracks: Vec::new(),
            work: Work::default(),
        }
    }

    /// Appends what other paths left, without their flight segments.
    pub fn append(&mut self, other: &Self) {
        let before = self.volume.len();
        self.independent.extend(other.independent.iter().map(|index| before + index));
        self.volume.extend_from_slice(&other.volume);
        self.surface.extend_from_slice(&other.surface);
        self.work += other.work;
    }
}

/// A photon in flight.
pub(super) struct PhotonState<S> {
    pub ray: Ray<World>,
    pub power: S,
    /// Order of volume scattering so far.
    pub scattered: u32,
    /// Whether this is direct light, which rays find by sampling lights.
    pub direct: bool,
    /// Whether rays sample this direct light in media even where fluence grids hold light.
    pub sampled: bool,
    /// Solids of glass around the ray's origin.
    pub solids: EnclosingSolids,
}

impl PhotonTracer<'_> {
    /// Traces the paths of these indices.
    pub fn trace<S: Spectrum, H: PhotonDirection>(&self, paths: Range<u64>) -> Deposits<S, H> {
        let mut out = Deposits::none();
        let rng = |index: u64| Stream::new(self.settings.seed, Stage::Photons, index, 0);
        let mut ctx = PathContext::new(rng(paths.start), self.settings.needs);
        for index in paths {
            ctx.rng = rng(index);
            let Some(photon) = self.emit(index, &mut ctx) else { continue };
            let mut flying = vec![photon];
            let first = out.volume.len();
            let mut events = 0;
            while let Some(mut photon) = flying.pop() {
                let more = &mut flying;
                while events < MAX_EVENTS && self.step(&mut photon, &mut ctx, more, &mut out) {
                    events += 1;
                }
            }
            let ended = events < MAX_EVENTS;
            ctx.work.capped_paths += u64::from(!ended);
            let left = out.volume.len() - first;
            if left > 0 {
                out.independent.push(first + (ctx.rng.uniform() * left as f64) as usize);
            }
        }
        out.work += ctx.work;
        out
    }

    /// The photon that the path `index` starts with; `None` where it can reach nothing.
    fn emit<S: Spectrum>(&self, index: u64, ctx: &mut PathContext) -> Option<PhotonState<S>> {
        let u = self.pattern(index);
        let Some(start) = self.emitters.emit(u, &mut ctx.rng) else {
            ctx.work.starts_rejected += 1;
            return None;
        };
        if !self.reaches(&start.ray) {
            if !self.settings.needs.void {
                ctx.work.starts_rejected += 1;
                return None;
            }
            ctx.work.photons_missed += 1;
        }
        ctx.work.photons_emitted += 1;
        ctx.work.colored_paths += u64::from(S::CHANNELS > 1);
        ctx.work.emission_lookups += u64::from(!start.direct);
        ctx.work.light_choices += u64::from(self.emitters.len() > 1);
        Some(PhotonState {
            ray: start.ray,
            power: S::of_group(start.power, start.group) / self.settings.photons as f64,
            scattered: 0,
            direct: start.direct,
            sampled: start.sampled,
            solids: EnclosingSolids::NONE,
        })
    }

    /// Whether a photon along `ray` can leave anything behind.
    fn reaches(&self, ray: &Ray<World>) -> bool {
        let needs = &self.settings.needs;
        let is_recorded = |bounds: Aabb<World>| !bounds.clip(ray).intersect(Span::AHEAD).is_empty();
        (needs.volume_photons
            && (self.scene.media.is_endless()
                || self.deposit_regions.intersect(ray)
                || self.flight_bounds.is_some_and(is_recorded)))
            || (needs.surfaces && self.scene.surfaces.occluded(ray, Span::AHEAD))
    }

    /// The choices at a path's start: an Owen-scrambled Sobol sequence (Burley 2020) over the
    /// paths, so that every part of every light sends its share.
    fn pattern(&self, path: u64) -> [f64; 5] {
        // The sequence is good for 2^16 points; further paths start another one.
        let (block, index) = (path >> 16, (path & 0xffff) as u32);
        let mut key = Stream::new(self.settings.seed, Stage::Photons, block, 1);
        let scramble = key.scramble();
        let [a, b, c, d] = sobol_burley::sample_4d(index, 0, scramble).map(f64::from);
        [a, b, c, d, f64::from(sobol_burley::sample(index, 4, scramble))]
    }

    /// Flies to the next scattering or surface and through it; whether the path goes on. `more` takes
    /// photons that are split off.
    fn step<S: Spectrum, H: PhotonDirection>(
        &self,
        photon: &mut PhotonState<S>,
        ctx: &mut PathContext,
        more: &mut Vec<PhotonState<S>>,
        out: &mut Deposits<S, H>,
    ) -> bool {
        let hit = direct_light::first_surface(self.scene, &photon.ray, ctx);
        let end = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
        if photon.solids.is_none() && self.settings.needs.media {
            match self.fly(photon, end, ctx, out) {
                FlightEnd::Through => (),
                FlightEnd::Scattered { t, medium } => {
                    return self.scatter_in_medium(photon, t, medium, &mut ctx.rng, more);
                }
                FlightEnd::Absorbed(_) => return false,
            }
        }
        hit.is_some_and(|hit| self.scatter_at_surface(photon, &hit, &mut ctx.rng, more, out))
    }

    /// Flies through the media as far as `end` metres, leaving photons and flight segments behind.
    fn fly<S: Spectrum, H: PhotonDirection>(
        &self,
        photon: &mut PhotonState<S>,
        end: f64,
        ctx: &mut PathContext,
        out: &mut Deposits<S, H>,
    ) -> FlightEnd {
        // A photon stored here is scattered once more toward the camera.
        let counts = self.settings.needs.volume_photons
            && self.settings.max_scatter.is_none_or(|max| photon.scattered < max);
        let deposits = counts && !photon.direct && self.store_probability > 0.0;
        let flight_bounds = self.flight_bounds.filter(|_| counts && !photon.sampled);
        let (ray, power) = (&photon.ray, &mut photon.power);
        // The start of what has been flown with one power.
        let (mut since, mut flown_with) = (0.0, *power);
        let visit = |step: &FlightStep<S>, ctx: &mut PathContext| {
            let changed = flight_bounds.is_some()
                && (step.throughput - flown_with).map(f64::abs).max_element()
                    > ROUNDING * step.throughput.max_element();
            if changed {
                self.record_segment(flight_bounds, ray, since..step.span.start, flown_with, out);
                since = step.span.start;
            }
            flown_with = step.throughput;
            if deposits {
                self.deposit_along(ray, step, &mut ctx.rng, out);
            }
        };
        let media = &self.scene.media;
        let flown = tracking::fly(media, ray, end, power, Absorption::Sampled, ctx, visit);
        let until = match flown {
            FlightEnd::Through => end,
            FlightEnd::Scattered { t, .. } | FlightEnd::Absorbed(t) => t,
        };
        self.record_segment(flight_bounds, ray, since..until, flown_with, out);
        flown
    }

    /// Keeps the part of `ray` between two distances that is within `bounds`, if there are any, as
    /// flown with `power`.
    fn record_segment<S: Spectrum, H>(
        &self,
        bounds: Option<Aabb<World>>,
        ray: &Ray<World>,
        distances: Range<f64>,
        power: S,
        out: &mut Deposits<S, H>,
    ) {
        let span = Span::new(distances.start, distances.end);
        let span = bounds.map(|bounds| bounds.clip(ray).intersect(span));
        if let Some(span) = span.filter(|span| !span.is_empty()) {
            let (from, to) = (ray.at(span.start), ray.at(span.end));
            let power = power / self.units.surface;
            out.tracks.push(FlightSegment::new(self.origin, from, to, power));
        }
    }

    /// Keeps photons of one step of a flight: where the deposit regions say along the segment, and at
    /// the tentative collision.
    fn deposit_along<S: Spectrum, H: PhotonDirection>(
        &self,
        ray: &Ray<World>,
        step: &FlightStep<S>,
        rng: &mut Stream,
        out: &mut Deposits<S, H>,
    ) {
        let power = step.throughput;
        self.deposit_regions.sample_deposits(ray, step.span, rng, |t, rng| {
            self.store(ray.at(t), ray.direction, power, None, rng, out);
        });
        if let Some(c) = &step.collision {
            self.store(ray.at(c.t), ray.direction, power, Some(c), rng, out);
        }
    }

    /// Scatters a photon in a medium at the distance `t`; whether it goes on.
    fn scatter_in_medium<S: Spectrum>(
        &self,
        photon: &mut PhotonState<S>,
        t: f64,
        medium: usize,
        rng: &mut Stream,
        more: &mut Vec<PhotonState<S>>,
    ) -> bool {
        photon.scattered += 1;
        if self.settings.max_scatter.is_some_and(|max| photon.scattered > max) {
            return false;
        }
        let (p, phase) = (photon.ray.at(t), &self.scene.media.get(medium).phase);
        (photon.direct, photon.sampled) = (false, false);
        photon.power = self.scene.groups.scattered(photon.power);
        self.split(photon, p, phase, rng, more);
        let (direction, _) = phase.sample(photon.ray.direction, rng.uniform2());
        photon.ray = Ray::new(p, direction);
        true
    }

    /// Keeps a photon on a surface and scatters it there; whether it goes on.
    fn scatter_at_surface<S: Spectrum, H: PhotonDirection>(
        &self,
        photon: &mut PhotonState<S>,
        hit: &SurfaceHit<'_>,
        rng: &mut Stream,
        more: &mut Vec<PhotonState<S>>,
        out: &mut Deposits<S, H>,
    ) -> bool {
        let incoming = photon.ray.direction;
        if self.settings.needs.surface_photons && !hit.material.is_followed() && !photon.direct {
            let share = hit.material.irradiance_share(incoming, hit);
            let power = photon.power * share / self.units.surface;
            out.surface.push(self.deposit(hit.point, incoming, power));
        }
        if let Some(window) =
            self.window.filter(|_| !hit.material.is_specular() && !hit.material.is_rough())
        {
            self.reflect(photon, hit, window, rng, more);
            return false;
        }
        let u = [rng.uniform(), rng.uniform(), rng.uniform()];
        let scattered = hit.material.scatter(incoming, hit, u, TransportMode::Importance);
        let Some(scattered) = scattered else { return false };
        let power = photon.power * S::from_rgb(scattered.weight);
        let survival = power.element_sum() / photon.power.element_sum();
        if rng.uniform() >= survival {
            return false;
        }
        // Survivors carry the power of those that were absorbed; a weight above 1 absorbs none.
        photon.power = self.scene.groups.reflected(power / survival.min(1.0));
        (photon.direct, photon.sampled) = (false, false);
        photon.solids = photon.solids.after(scattered.crossing);
        photon.ray = hit.leave(scattered.direction);
        true
    }

    /// Keeps a volume photon with the probability [`store_probability`](Self::store_probability), its power divided by the rate
    /// of deposits at `p`. Where finer majorants lower that rate, those of bricks and regions weigh
    /// each kind of deposit: any weights do that add up to 1 at a point (Veach 1997, section 9.2).
    fn store<S: Spectrum, H: PhotonDirection>(
        &self,
        p: WorldPoint,
        direction: glam::DVec3,
        power: S,
        collision: Option<&Collision>,
        rng: &mut Stream,
        out: &mut Deposits<S, H>,
    ) {
        if rng.uniform() >= self.store_probability {
            return;
        }
        let collisions = match collision {
            Some(c) if self.scene.media.len() == 1 => c.region_majorant,
            _ => {
                out.work.grid_lookups += self.scene.media.density_grids();
                self.scene.media.majorant_at(p, power)
            }
        };
        let share = collision.map_or(1.0, |c| c.region_majorant / c.majorant);
        let rate = (collisions + self.deposit_regions.rate_at(p)) * self.store_probability;
        if rate > 0.0 {
            let power = power * (share / rate / self.units.volume);
            out.volume.push(self.deposit(p, direction, power));
        }
    }

    fn deposit<S: Spectrum, H: PhotonDirection>(
        &self,
        p: WorldPoint,
        direction: glam::DVec3,
        power: S,
    ) -> PhotonAt<S, H> {
        let place = (p - self.origin).as_vec3().to_array();
        PhotonAt { place, photon: Photon::new(power, direction) }
    }
}
