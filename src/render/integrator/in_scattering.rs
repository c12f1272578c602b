//! The march: light along a camera ray from the photon maps and from direct light.

use std::time::Instant;

use smallvec::SmallVec;

use crate::director::PixelBudget;
use crate::light::Light;
use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::{Phase, Place, Profile};
use crate::photon::{PhotonDirection, PhotonMaps};
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::surface::{SurfaceHit, TransportMode};
use crate::transport::direct_light;

use super::forward_peak::Way;
use crate::render::exposure::State;
use crate::transport::EquiangularLights;

/// Places along a ray, spread by opacity, at which direct light in media is evaluated.
const PLACES: u32 = 4;

/// Places along a ray, dense where it passes a lamp, at which the lamp's light is evaluated; as
/// many spread by opacity do where all lights are lamps.
const PLACES_BESIDE: u32 = 2;

/// [`concentration`](Phase::concentration) of a phase function from which final gathers send rays
/// nearly at lights.
const AIMED: f64 = 6.0;

/// How far beyond a surface photons in front of it are gathered, in radii.
const MOST_BEYOND: f64 = 4.0;

/// Phase functions with their weights.
type Scatterers<'a, S> = SmallVec<[(&'a Phase, S); 1]>;

/// What of the light that comes straight from lights is asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked<'a> {
    /// Lights for which it is true are left out; those beyond its end are not.
    kept: &'a [bool],
    /// What the light of lamps counts.
    lamps: f64,
    /// Whether the light of others counts, and places spread by opacity are looked at.
    others: bool,
}

impl Asked<'_> {
    /// Light of lamps alone, where the ray passes them.
    pub(super) const LAMPS: Self = Self { kept: &[], lamps: 1.0, others: false };
}

/// What media do to a ray.
pub(super) struct Crossed<S> {
    /// Their light, W/(m² sr).
    pub(super) light: S,
    pub(super) transmittance: S,
    /// A ray on which more of their light comes.
    pub(super) deflected: Option<Way<S>>,
}

/// Marches camera rays through a scene lit by its photon maps.
#[derive(Debug)]
pub struct Marcher<'a, S: Spectrum, H: PhotonDirection> {
    pub(super) scene: &'a Scene,
    pub(super) maps: &'a PhotonMaps<S, H>,
    pub(super) needs: Needs,
    /// Whether any phase function has a peak that rays follow.
    pub(super) peaked: bool,
    /// Grid lookups of [`shares`](Self::shares).
    pub(super) lookups: u64,
    isotropic: bool,
    /// Phase function of each medium.
    phases: Vec<Phase>,
    /// For each light whether lattices keep what comes straight from it.
    kept: Vec<bool>,
    all_kept: bool,
    /// For each light whether final gathers find what comes straight from it: the sky, where
    /// lattices keep that.
    pub(super) found: Vec<bool>,
    /// For each medium whether final gathers send rays nearly at lights where it scatters.
    pub(super) aims: Vec<bool>,
}

impl<'a, S: Spectrum, H: PhotonDirection> Marcher<'a, S, H> {
    /// Marches through `scene` for what `needs` say.
    pub fn new(scene: &'a Scene, maps: &'a PhotonMaps<S, H>, needs: Needs) -> Self {
        let media = &scene.media;
        let lookups = media.scattering_grids();
        // One medium's share of the extinction does not depend on the density.
        let lookups = match media.len() {
            1 => lookups - media.density_grids(),
            _ => lookups + media.density_grids(),
        };
        let isotropic = media.iter().all(|m| m.phase.is_isotropic());
        let is_kept = |(index, light): (usize, &Light)| {
            !maps.direct.is_empty()
                && match light.is_environment() {
                    true => !maps.lattices.is_empty(),
                    false => maps.direct.iter().all(|d| d.keeps(index)),
                }
        };
        let kept: Vec<bool> = scene.lights.lights.iter().enumerate().map(is_kept).collect();
        let all_kept = kept.iter().all(|&kept| kept);
        let found = scene.lights.lights.iter().zip(&kept);
        let found = found
            .map(|(light, kept)| maps.gather.is_some() && *kept && light.is_environment())
            .collect();
        let phases = media.iter().map(|m| m.phase).collect();
        let peaked = maps.scatterings.iter().any(|scattering| scattering.peak.is_some());
        let aims = media.iter().map(|m| m.phase.concentration() > AIMED).collect();
        Self { scene, maps, needs, peaked, lookups, isotropic, phases, kept, all_kept, found, aims }
    }

    /// What the media in front of `hit` do to the ray of `way`.
    pub(super) fn through_media(
        &self,
        way: &Way<S>,
        hit: Option<&SurfaceHit<'_>>,
        budget: &PixelBudget,
        state: &mut State<S>,
    ) -> Crossed<S> {
        let end = hit.map_or(f64::INFINITY, |h| h.t);
        let jitter = state.ctx.rng.uniform();
        let mut profile = std::mem::take(&mut state.profile);
        profile.trace(&self.scene.media, &way.ray, Span::new(0.0, end), budget.step, jitter);
        profile.count(&mut state.ctx.work);
        let mut light = if self.needs.emission { profile.emitted() } else { S::ZERO };
        let mut deflected = None;
        if self.needs.scattering {
            light += self.scattered(way, hit, &profile, budget.radius, state);
            let (next, of_lamps) = self.deflected(&way.ray, &profile, budget, state);
            deflected = next;
            light += of_lamps;
        }
        let transmittance = profile.transmittance();
        state.profile = profile;
        Crossed { light, transmittance, deflected }
    }

    /// Light that the media scatter along `way` to its origin: what lattices keep, where it leads
    /// to the eye or is scattered to all sides alike, and what they do not.
    fn scattered(
        &self,
        way: &Way<S>,
        hit: Option<&SurfaceHit<'_>>,
        profile: &Profile<S>,
        radius: f64,
        state: &mut State<S>,
    ) -> S {
        let ray = &way.ray;
        let holds = way.from_eye || self.isotropic;
        let keeps_direct = holds && !self.maps.direct.is_empty();
        let gathers = self.maps.gather.is_some();
        let keeps_flights = holds && !gathers && !self.maps.lattices.is_empty();
        let mut light = S::ZERO;
        if !(keeps_direct && self.all_kept) {
            let kept = if keeps_direct { &self.kept } else { &self.found };
            let asked = Asked { kept, lamps: way.lamps, others: true };
            light += self.direct(ray, profile, asked, state);
        }
        let keeps_gathers = holds && !self.maps.gathered.is_empty();
        if let Some(gather) = self.maps.gather.as_ref().filter(|_| !keeps_gathers) {
            light += self.gathered(gather, ray, profile, radius, state);
        }
        if keeps_direct || keeps_flights {
            light += self.kept_along(ray, profile, radius, state);
        }
        if !gathers && !keeps_flights && state.shared > 0.0 {
            let start = Instant::now();
            let indirect = self.indirect(ray, hit, profile, radius, state);
            state.gathering += start.elapsed();
            let stands_in = indirect * state.shared;
            state.stands_in += stands_in;
            light += stands_in;
        }
        light
    }

    /// Light that comes straight from a light and is scattered once along `ray`: evaluated at
    /// places spread by opacity and, for lamps, at places dense near them, weighed by the balance
    /// heuristic over both (Veach 1997, section 9.2.2).
    pub(super) fn direct(
        &self,
        ray: &Ray<World>,
        profile: &Profile<S>,
        asked: Asked<'_>,
        state: &mut State<S>,
    ) -> S {
        let is_kept = |light: usize| asked.kept.get(light).is_some_and(|&kept| kept);
        let (lights, toward) = (&self.scene.lights, -ray.direction);
        let lamps = EquiangularLights::beside(lights, ray, profile.extent());
        let places = match (asked.others, lamps.are_all()) {
            (false, _) => 0,
            (true, true) => PLACES_BESIDE,
            (true, false) => PLACES,
        };
        // How many places, in effect, share in the light found at one: those spread by opacity,
        // and those beside lamps in the proportion of the densities.
        let count = |place: &Place<S>, light: usize, choice: f64| {
            if is_kept(light) {
                return f64::INFINITY;
            }
            let beside = f64::from(PLACES_BESIDE) * lamps.pdf(light, place.t);
            let counts = if lights.lights[light].place().is_some() { asked.lamps } else { 1.0 };
            (f64::from(places) + beside / (choice * place.pdf)) / counts
        };
        let mut sum = S::ZERO;
        for index in 0..places {
            let u = stratum(index, places, state);
            let Some(place) = profile.sample([u, state.ctx.rng.uniform()]) else { break };
            let p = ray.at(place.t);
            let scatterers = self.scatterers(p);
            state.ctx.work.grid_lookups += self.lookups;
            if !scatterers.is_empty() {
                state.ctx.work.gathers += 1;
                let count = |light, choice| count(&place, light, choice);
                let light = direct_light::in_medium(
                    self.scene,
                    p,
                    toward,
                    &scatterers,
                    count,
                    &mut state.ctx,
                );
                sum += place.weight * light;
            }
        }
        for index in 0..PLACES_BESIDE {
            let picked = lamps.pick(state.ctx.rng.uniform());
            for (lamp, distances) in picked.iter().filter(|(lamp, _)| !is_kept(*lamp)) {
                let t = distances.sample(stratum(index, PLACES_BESIDE, state));
                let Some(place) = profile.place_at(t) else { continue };
                let p = ray.at(t);
                let (choice, scatterers) = (lights.pick_probability(p, *lamp), self.scatterers(p));
                state.ctx.work.grid_lookups += self.lookups;
                let sample = lights.lights[*lamp].sample(p, state.ctx.rng.uniform2());
                if let Some(light) = sample.filter(|_| choice > 0.0 && !scatterers.is_empty()) {
                    state.ctx.work.gathers += 1;
                    let light = direct_light::scattered(
                        self.scene,
                        p,
                        toward,
                        &scatterers,
                        &light,
                        &mut state.ctx,
                    );
                    sum += place.weight * light / (choice * count(&place, *lamp, choice));
                }
            }
        }
        sum
    }

    /// Light of the photons along `ray`.
    fn indirect(
        &self,
        ray: &Ray<World>,
        hit: Option<&SurfaceHit<'_>>,
        profile: &Profile<S>,
        radius: f64,
        state: &mut State<S>,
    ) -> S {
        if self.maps.volume[0].is_empty() || profile.pieces().is_empty() {
            return S::ZERO;
        }
        // Where the ray meets a surface at a slant, the disk round its end lies partly behind the
        // surface; photons in front of it beyond the end stand in for those.
        let end = hit.map_or(f64::INFINITY, |h| h.t);
        let beyond = hit.map_or(0.0, |h| {
            let cosine = ray.direction.dot(h.normal).abs().min(1.0);
            radius * ((1.0 - cosine * cosine).sqrt() / cosine).min(MOST_BEYOND)
        });
        let work = &mut state.ctx.work;
        work.gathers += 1;
        let before = work.gathered;
        let span = Span::new(0.0, end + beyond);
        let respond = |t: f64| {
            let t = t.min(end);
            let Some((transmittance, sigma_t)) = profile.at(t) else {
                return Scatterers::new();
            };
            let here = transmittance * sigma_t;
            let scatterer = |(medium, share): (usize, S)| {
                let scattering = &self.maps.scatterings[medium];
                (&scattering.phase, share * here * scattering.share)
            };
            self.shares(ray.at(t)).into_iter().map(scatterer).collect()
        };
        work.directed_gathers += u64::from(H::KNOWN);
        let light = self.maps.along(ray, span, radius, &mut work.gathered, respond);
        work.grid_lookups += (work.gathered - before) * self.lookups;
        light
    }

    /// The phase functions of the media that scatter at `p`, each weighed by its share of the
    /// extinction there.
    fn scatterers(&self, p: WorldPoint) -> Scatterers<'_, S> {
        let scatterer = |(medium, share): (usize, S)| (&self.phases[medium], share);
        self.shares(p).into_iter().map(scatterer).collect()
    }

    /// The media that scatter at `p`, each with the share of the extinction there that it scatters.
    pub(super) fn shares(&self, p: WorldPoint) -> SmallVec<[(usize, S); 1]> {
        let media = &self.scene.media;
        if media.len() == 1 {
            let albedo = S::from_rgb(media.get(0).albedo.at(p));
            return (albedo != S::ZERO).then_some((0, albedo)).into_iter().collect();
        }
        let sigma_t = media.sigma_t_at(p);
        let mixture = media.mixture_at(p);
        mixture.iter().map(|(medium, sigma_s)| (*medium, share_of(*sigma_s, sigma_t))).collect()
    }

    /// Light that a diffuse surface reflects along `ray` back to its origin.
    pub(super) fn reflected(
        &self,
        ray: &Ray<World>,
        hit: &SurfaceHit<'_>,
        state: &mut State<S>,
    ) -> S {
        let direct: S = direct_light::on_surface(
            self.scene,
            &self.scene.media,
            ray.direction,
            hit,
            &mut state.ctx,
        );
        if self.maps.surface.is_empty() || state.shared == 0.0 {
            return direct;
        }
        let facing = if ray.direction.dot(hit.normal) < 0.0 { hit.normal } else { -hit.normal };
        state.ctx.work.surface_gathers += 1;
        let start = Instant::now();
        let irradiance = self.maps.irradiance(hit.point, facing, &mut state.ctx.work.gathered);
        state.gathering += start.elapsed();
        let reflectance = hit.material.eval(ray.direction, facing, hit, TransportMode::Radiance);
        let indirect = S::from_rgb(reflectance) * state.shared * irradiance;
        state.stands_in += indirect;
        direct + indirect
    }
}

/// The share of `sigma_t` that `sigma_s` is; 0 where there is no extinction.
fn share_of<S: Spectrum>(sigma_s: Rgb, sigma_t: Rgb) -> S {
    S::from_rgb(Rgb::select(sigma_t.cmpgt(Rgb::ZERO), sigma_s / sigma_t, Rgb::ZERO))
}

/// A number for the stratum `index` of `count` of the unit interval.
pub(super) fn stratum<S>(index: u32, count: u32, state: &mut State<S>) -> f64 {
    (f64::from(index) + state.ctx.rng.uniform()) / f64::from(count)
}
