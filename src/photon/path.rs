//! One photon path: null-collision tracking through media, scattering at surfaces.
//!
//! Whether a photon scatters, goes on or is absorbed is chosen in proportion to the mean over
//! channels of its power times each coefficient (history-aware avg of Kutz et al. 2017, "Spectral
//! and Decomposition Tracking"), so the mean power of a photon never changes and stored photons
//! weigh alike.

use std::ops::Range;

use crate::light::EmissionTarget;
use crate::math::{Aabb, Ray, Span, Spectrum, Stage, Stream, World, WorldPoint};
use crate::medium::Collision;
use crate::scene::Scene;
use crate::surface::TransportMode;
use crate::transport::{FlightSegment, MAX_EVENTS};
use crate::work::Work;

use super::deposit_regions::DepositRegions;
use super::emitters::Emitters;
use super::{Photon, PhotonAt, PhotonDirection, PhotonSettings};

/// Change of power, as a share of it, that is rounding.
const SAME: f64 = 1e-12;

/// What all paths share.
#[derive(Debug)]
pub(super) struct PhotonTracer<'a> {
    pub scene: &'a Scene,
    pub emitters: Emitters<'a>,
    /// What photons that a surface reflects should reach.
    pub reach: EmissionTarget,
    pub zones: DepositRegions,
    pub shooting: PhotonSettings,
    /// What stored places are relative to.
    pub origin: WorldPoint,
    /// Share of the volume photons that is kept; the rest is spread over them. 0 where beams need
    /// none.
    pub keep: f64,
    /// Where flights are kept, for lattices; nothing where there are none.
    pub tracked: Option<Aabb<World>>,
    /// Power, summed over channels, that photons should have: heavier ones are split where a
    /// surface reflects them, lighter ones gambled with; much heavier ones are split in media.
    pub window: Option<f64>,
    /// What stored powers are counted in.
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

/// What a number of paths left behind.
#[derive(Debug)]
pub(super) struct Deposits<S: Spectrum, H> {
    pub volume: Vec<PhotonAt<S, H>>,
    /// One volume photon, at random, of each path that left any, by its index.
    pub independent: Vec<usize>,
    pub surface: Vec<PhotonAt<S>>,
    pub tracks: Vec<FlightSegment<S>>,
    pub work: Work,
}

impl<S: Spectrum, H: PhotonDirection> Deposits<S, H> {
    /// Nothing yet.
    pub fn none() -> Self {
        Self {
            volume: Vec::new(),
            independent: Vec::new(),
            surface: Vec::new(),
            tracks: Vec::new(),
            work: Work::default(),
        }
    }

    /// Takes in what other paths left, but for their flights.
    pub fn append(&mut self, other: &Self) {
        let before = self.volume.len();
        self.independent.extend(other.independent.iter().map(|index| before + index));
        self.volume.extend_from_slice(&other.volume);
        self.surface.extend_from_slice(&other.surface);
        self.work += other.work;
    }
}

/// A photon on its way.
pub(super) struct PhotonState<S> {
    pub ray: Ray<World>,
    pub power: S,
    /// Order of volume scattering so far.
    pub scattered: u32,
    /// Whether pass 2 finds this light by itself, by sampling the light directly.
    pub direct: bool,
    /// Whether pass 2 finds this light in media even where lattices keep light.
    pub sampled: bool,
    /// How many solids of glass the photon is inside of; media do not fill them.
    pub inside: i32,
}

impl PhotonTracer<'_> {
    /// Traces the paths of these indices.
    pub fn trace<S: Spectrum, H: PhotonDirection>(&self, paths: Range<u64>) -> Deposits<S, H> {
        let mut out = Deposits::none();
        for index in paths {
            let mut rng = Stream::new(self.shooting.seed, Stage::Photons, index, 0);
            let u = self.pattern(index);
            let Some(start) = self.emitters.emit(u, &mut rng) else {
                out.work.starts_rejected += 1;
                continue;
            };
            if !self.reaches(&start.ray) {
                if !self.shooting.needs.void {
                    out.work.starts_rejected += 1;
                    continue;
                }
                out.work.photons_missed += 1;
            }
            out.work.photons_emitted += 1;
            out.work.colored_paths += u64::from(S::CHANNELS > 1);
            out.work.emission_lookups += u64::from(!start.direct);
            out.work.light_choices += u64::from(self.emitters.len() > 1);
            let mut flying = vec![PhotonState {
                ray: start.ray,
                power: S::from_rgb(start.power) / self.shooting.photons as f64,
                scattered: 0,
                direct: start.direct,
                sampled: start.sampled,
                inside: 0,
            }];
            let first = out.volume.len();
            let mut events = 0;
            while let Some(mut photon) = flying.pop() {
                let more = &mut flying;
                while events < MAX_EVENTS && self.step(&mut photon, &mut rng, more, &mut out) {
                    events += 1;
                }
            }
            let ended = events < MAX_EVENTS;
            out.work.capped_paths += u64::from(!ended);
            let left = out.volume.len() - first;
            if left > 0 {
                out.independent.push(first + (rng.uniform() * left as f64) as usize);
            }
        }
        out
    }

    /// Whether a photon along `ray` can leave anything behind.
    fn reaches(&self, ray: &Ray<World>) -> bool {
        let needs = &self.shooting.needs;
        (needs.volume_photons && (self.scene.media.is_endless() || self.zones.meet(ray)))
            || (needs.surfaces && self.scene.surfaces.occluded(ray, Span::AHEAD))
    }

    /// The choices at a path's start: an Owen-scrambled Sobol sequence (Burley 2020) over the
    /// paths, so that every part of every light sends its share.
    fn pattern(&self, path: u64) -> [f64; 5] {
        // The sequence is good for 2^16 points; further paths start another one.
        let (block, index) = (path >> 16, (path & 0xffff) as u32);
        let mut key = Stream::new(self.shooting.seed, Stage::Photons, block, 1);
        let scramble = key.scramble();
        let [a, b, c, d] = sobol_burley::sample_4d(index, 0, scramble).map(f64::from);
        [a, b, c, d, f64::from(sobol_burley::sample(index, 4, scramble))]
    }

    /// Flies to the next scattering or surface and through it; whether the path goes on. `more` takes
    /// photons that are split off.
    fn step<S: Spectrum, H: PhotonDirection>(
        &self,
        photon: &mut PhotonState<S>,
        rng: &mut Stream,
        more: &mut Vec<PhotonState<S>>,
        out: &mut Deposits<S, H>,
    ) -> bool {
        let mut hit = None;
        if self.shooting.needs.surfaces {
            out.work.intersections += 1;
            hit = self.scene.surfaces.intersect(&photon.ray, Span::AHEAD);
        }
        let end = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
        if photon.inside == 0 && self.shooting.needs.media {
            match self.fly(photon, end, rng, more, out) {
                Flight::Through => (),
                Flight::Scattered => return true,
                Flight::Absorbed => return false,
            }
        }
        let Some(hit) = hit else { return false };
        let incoming = photon.ray.direction;
        if self.shooting.needs.surface_photons && !hit.material.is_specular() && !photon.direct {
            let power = photon.power / self.units.surface;
            out.surface.push(self.deposit(hit.point, incoming, power));
        }
        if let Some(window) = self.window.filter(|_| !hit.material.is_specular()) {
            self.reflect(photon, &hit, window, rng, more);
            return false;
        }
        let u = [rng.uniform(), rng.uniform(), rng.uniform()];
        let scattered = hit.material.scatter(incoming, &hit, u, TransportMode::Importance);
        let Some(scattered) = scattered else { return false };
        let power = photon.power * S::from_rgb(scattered.weight);
        let survival = power.element_sum() / photon.power.element_sum();
        if rng.uniform() >= survival {
            return false;
        }
        // Survivors stand for those that were absorbed; where a weight exceeds 1 nothing is.
        photon.power = power / survival.min(1.0);
        (photon.direct, photon.sampled) = (false, false);
        photon.inside = (photon.inside + i32::from(scattered.crossing)).max(0);
        photon.ray = hit.leave(scattered.direction);
        true
    }

    /// Flies through the media as far as `end`, leaving photons behind. `more` takes photons that
    /// are split off.
    fn fly<S: Spectrum, H: PhotonDirection>(
        &self,
        photon: &mut PhotonState<S>,
        end: f64,
        rng: &mut Stream,
        more: &mut Vec<PhotonState<S>>,
        out: &mut Deposits<S, H>,
    ) -> Flight {
        // A photon kept here is scattered once more towards the eye.
        let counts = self.shooting.needs.volume_photons
            && self.shooting.max_scatter.is_none_or(|max| photon.scattered < max);
        let keeps = counts && !photon.direct && self.keep > 0.0;
        let tracked = self.tracked.filter(|_| counts && !photon.sampled);
        // Flown with one power since here.
        let mut since = 0.0;
        let track = |photon: &PhotonState<S>, from: f64, to: f64, out: &mut Deposits<S, H>| {
            let span =
                tracked.map(|bounds| bounds.clip(&photon.ray).intersect(Span::new(from, to)));
            if let Some(span) = span.filter(|span| !span.is_empty()) {
                let (from, to) = (photon.ray.at(span.start), photon.ray.at(span.end));
                let power = photon.power / self.units.surface;
                out.tracks.push(FlightSegment::new(self.origin, from, to, power));
            }
        };
        let media = &self.scene.media;
        let mut flights = media.flights(&photon.ray, Span::new(0.0, end), photon.power, rng);
        let mut at = 0.0;
        loop {
            let next = flights.next(rng);
            out.work.grid_lookups += flights.take_lookups();
            let until = next.map_or(end, |c| c.t);
            if keeps {
                let (ray, power) = (photon.ray, photon.power);
                self.zones.events(&ray, Span::new(at, until), rng, |t, rng| {
                    self.store(ray.at(t), ray.direction, power, None, rng, out);
                });
            }
            let Some(c) = next else {
                track(photon, since, end, out);
                return Flight::Through;
            };
            out.work.collisions += 1;
            let p = photon.ray.at(c.t);
            if keeps {
                self.store(p, photon.ray.direction, photon.power, Some(&c), rng, out);
            }
            let medium = media.get(c.medium);
            out.work.grid_lookups += u64::from(!medium.albedo.is_constant());
            let scattering = photon.power * S::from_rgb(media.sigma_s(&c, p));
            let null = S::splat(c.majorant) - S::from_rgb(medium.sigma_t) * c.density;
            let null = (photon.power * null).not_negative();
            let rate = photon.power.element_sum() * c.majorant;
            let (p_scatter, p_null) = (scattering.element_sum() / rate, null.element_sum() / rate);
            let u = rng.uniform();
            if u < p_scatter || u >= p_scatter + p_null {
                track(photon, since, c.t, out);
            }
            if u < p_scatter {
                photon.scattered += 1;
                if self.shooting.max_scatter.is_some_and(|max| photon.scattered > max) {
                    return Flight::Absorbed;
                }
                photon.power = scattering / (c.majorant * p_scatter);
                (photon.direct, photon.sampled) = (false, false);
                self.split(photon, p, &medium.phase, rng, more);
                let (direction, _) = medium.phase.sample(photon.ray.direction, rng.uniform2());
                photon.ray = Ray::new(p, direction);
                return Flight::Scattered;
            } else if u < p_scatter + p_null {
                out.work.null_collisions += 1;
                let power = null / (c.majorant * p_null);
                if (power - photon.power).map(f64::abs).max_element() > SAME * power.max_element() {
                    track(photon, since, c.t, out);
                    since = c.t;
                }
                photon.power = power;
                flights.carry_on(photon.power, c.t, rng);
                at = c.t;
            } else {
                return Flight::Absorbed;
            }
        }
    }

    /// Keeps a volume photon with its share, weighed by one over the rate of deposits at `p`. Where
    /// finer majorants lower that rate, those of bricks and regions say how much each kind of
    /// deposit counts: any weights do that add up to 1 at a place (Veach 1997, section 9.2).
    fn store<S: Spectrum, H: PhotonDirection>(
        &self,
        p: WorldPoint,
        direction: glam::DVec3,
        power: S,
        collision: Option<&Collision>,
        rng: &mut Stream,
        out: &mut Deposits<S, H>,
    ) {
        if rng.uniform() >= self.keep {
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
        let rate = (collisions + self.zones.rate_at(p)) * self.keep;
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

/// How a flight through media ended.
enum Flight {
    Through,
    Scattered,
    Absorbed,
}
