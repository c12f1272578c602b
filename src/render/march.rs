//! The march: light along a camera ray from the photon maps and from direct light.

use std::time::Instant;

use smallvec::SmallVec;

use crate::director::Budget;
use crate::image::Sample;
use crate::light::Light;
use crate::math::{Ray, Rgb, Span, World, WorldPoint, luminance};
use crate::medium::{Phase, Place, Profile};
use crate::photon::PhotonMaps;
use crate::scene::plan::Needs;
use crate::scene::{Scene, lighting};
use crate::surface::{SurfaceHit, TransportMode};

use super::expose::State;
use super::lamps::Lamps;

/// Mirrors and panes of glass that a camera ray follows at most.
const MAX_SPECULAR: u32 = 64;

/// Places along a ray, spread by opacity, at which direct light in media is evaluated.
const PLACES: u32 = 4;

/// Places along a ray, dense where it passes a lamp, at which the lamp's light is evaluated; as
/// many spread by opacity do where all lights are lamps.
const PLACES_BESIDE: u32 = 2;

/// Places along a ray, spread by opacity, at which lattices are asked.
const LOOKUPS: u32 = 8;

/// Such places where cells are widest.
const FEWEST_LOOKUPS: u32 = 2;

/// How far beyond a surface photons in front of it are gathered, in radii.
const MOST_BEYOND: f64 = 4.0;

/// Phase functions with their weights.
type Scatterers<'a> = SmallVec<[(&'a Phase, Rgb); 1]>;

/// Marches camera rays through a scene lit by its photon maps.
#[derive(Debug)]
pub struct Marcher<'a> {
    scene: &'a Scene,
    maps: &'a PhotonMaps,
    needs: Needs,
    /// Grid lookups of [`scatterers`](Self::scatterers).
    lookups: u64,
    isotropic: bool,
    /// For each light whether lattices keep what comes straight from it.
    kept: Vec<bool>,
    all_kept: bool,
}

impl<'a> Marcher<'a> {
    /// Marches through `scene` for what `needs` say.
    pub fn new(scene: &'a Scene, maps: &'a PhotonMaps, needs: Needs) -> Self {
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
                && (light.is_environment() || maps.direct.iter().all(|d| d.keeps(index)))
        };
        let kept: Vec<bool> = scene.lights.lights.iter().enumerate().map(is_kept).collect();
        let all_kept = kept.iter().all(|&kept| kept);
        Self { scene, maps, needs, lookups, isotropic, kept, all_kept }
    }

    /// The light that arrives along `ray` (unit direction) at its origin. Mirrors and glass are
    /// followed to the first diffuse surface.
    pub fn radiance(&self, mut ray: Ray<World>, budget: &Budget, state: &mut State) -> Sample {
        let mut sample = Sample {
            radiance: Rgb::ZERO,
            shared: Rgb::ZERO,
            alpha: 0.0,
            depth: f64::INFINITY,
            transmittance: 1.0,
        };
        let (mut throughput, mut inside) = (Rgb::ONE, 0);
        for depth in 0..MAX_SPECULAR {
            let hit = lighting::first_surface(self.scene, &ray, &mut state.draws);
            let mut transmittance = Rgb::ONE;
            if inside == 0 && self.needs.media {
                let (light, through) =
                    self.through_media(&ray, hit.as_ref(), depth == 0, budget, state);
                sample.radiance += throughput * light;
                sample.shared += throughput * std::mem::take(&mut state.stands_in);
                transmittance = through;
            }
            if depth == 0 {
                sample.transmittance = luminance(transmittance);
                sample.depth = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
                sample.alpha = if hit.is_some() { 1.0 } else { 1.0 - sample.transmittance };
            }
            throughput *= transmittance;
            let Some(hit) = hit else {
                let sky = lighting::environment(self.scene, &ray, &mut state.draws);
                sample.radiance += throughput * sky;
                break;
            };
            sample.radiance += throughput * lighting::emitted(self.scene, &ray, &hit);
            if !hit.material.is_specular() {
                sample.radiance += throughput * self.reflected(&ray, &hit, state);
                sample.shared += throughput * std::mem::take(&mut state.stands_in);
                break;
            }
            let u = std::array::from_fn(|_| state.draws.rng.uniform());
            let scattered = hit.material.scatter(ray.direction, &hit, u, TransportMode::Radiance);
            let Some(scattered) = scattered else { break };
            throughput *= scattered.weight;
            state.draws.work.specular_bounces += 1;
            inside = (inside + i32::from(scattered.crossing)).max(0);
            ray = hit.leave(scattered.direction);
        }
        sample
    }

    /// Light from the media in front of `hit`, and their transmittance.
    fn through_media(
        &self,
        ray: &Ray<World>,
        hit: Option<&SurfaceHit<'_>>,
        from_eye: bool,
        budget: &Budget,
        state: &mut State,
    ) -> (Rgb, Rgb) {
        let end = hit.map_or(f64::INFINITY, |h| h.t);
        let jitter = state.draws.rng.uniform();
        let mut profile = std::mem::take(&mut state.profile);
        profile.trace(&self.scene.media, ray, Span::new(0.0, end), budget.step, jitter);
        profile.count(&mut state.draws.work);
        let mut light = if self.needs.emission { profile.emitted() } else { Rgb::ZERO };
        let scatters = self.needs.scattering;
        if scatters && !self.maps.lattices.is_empty() && (from_eye || self.isotropic) {
            if !self.all_kept {
                light += self.direct(ray, &profile, &self.kept, state);
            }
            light += self.kept_along(ray, &profile, budget.radius, state);
        } else if scatters {
            light += self.direct(ray, &profile, &[], state);
            if state.shared > 0.0 {
                let start = Instant::now();
                let indirect = self.indirect(ray, hit, &profile, budget.radius, state);
                state.gathering += start.elapsed();
                state.stands_in += state.shared * indirect;
                light += state.shared * indirect;
            }
        }
        let transmittance = profile.transmittance();
        state.profile = profile;
        (light, transmittance)
    }

    /// Light that comes straight from a light and is scattered once along `ray`: evaluated at
    /// places spread by opacity and, for lamps, at places dense near them, weighed by the balance
    /// heuristic over both (Veach 1997, section 9.2.2).
    ///
    /// Lights for which `kept` is true are left out; those beyond its end are not.
    fn direct(&self, ray: &Ray<World>, profile: &Profile, kept: &[bool], state: &mut State) -> Rgb {
        let is_kept = |light: usize| kept.get(light).is_some_and(|&kept| kept);
        let (lights, toward) = (&self.scene.lights, -ray.direction);
        let lamps = Lamps::beside(lights, ray, profile.extent());
        let places = if lamps.are_all() { PLACES_BESIDE } else { PLACES };
        // How many places, in effect, share in the light found at one: those spread by opacity,
        // and those beside lamps in the proportion of the densities.
        let count = |place: &Place, light: usize, choice: f64| {
            if is_kept(light) {
                return f64::INFINITY;
            }
            let beside = f64::from(PLACES_BESIDE) * lamps.pdf(light, place.t);
            f64::from(places) + beside / (choice * place.pdf)
        };
        let mut sum = Rgb::ZERO;
        for index in 0..places {
            let u = stratum(index, places, state);
            let Some(place) = profile.sample([u, state.draws.rng.uniform()]) else { break };
            let p = ray.at(place.t);
            let scatterers = self.scatterers(p);
            state.draws.work.grid_lookups += self.lookups;
            if !scatterers.is_empty() {
                state.draws.work.gathers += 1;
                let count = |light, choice| count(&place, light, choice);
                let light = lighting::in_medium(
                    self.scene,
                    p,
                    toward,
                    &scatterers,
                    count,
                    &mut state.draws,
                );
                sum += place.weight * light;
            }
        }
        for index in 0..PLACES_BESIDE {
            let picked = lamps.pick(state.draws.rng.uniform());
            for (lamp, distances) in picked.iter().filter(|(lamp, _)| !is_kept(*lamp)) {
                let t = distances.sample(stratum(index, PLACES_BESIDE, state));
                let Some(place) = profile.place_at(t) else { continue };
                let p = ray.at(t);
                let (choice, scatterers) = (lights.pick_probability(p, *lamp), self.scatterers(p));
                state.draws.work.grid_lookups += self.lookups;
                let sample = lights.lights[*lamp].sample(p, state.draws.rng.uniform2());
                if let Some(light) = sample.filter(|_| choice > 0.0 && !scatterers.is_empty()) {
                    state.draws.work.gathers += 1;
                    let light = lighting::scattered(
                        self.scene,
                        p,
                        toward,
                        &scatterers,
                        &light,
                        &mut state.draws,
                    );
                    sum += place.weight * light / (choice * count(&place, *lamp, choice));
                }
            }
        }
        sum
    }

    /// Light kept on lattices that is scattered along `ray`, at places spread by opacity: fewer
    /// where cells are wider.
    fn kept_along(
        &self,
        ray: &Ray<World>,
        profile: &Profile,
        radius: f64,
        state: &mut State,
    ) -> Rgb {
        let level = self.maps.level(radius);
        let lookups = (LOOKUPS >> level).max(FEWEST_LOOKUPS);
        let mut sum = Rgb::ZERO;
        for index in 0..lookups {
            let u = stratum(index, lookups, state);
            let Some(place) = profile.sample([u, state.draws.rng.uniform()]) else { break };
            let p = ray.at(place.t);
            let media = &self.scene.media;
            state.draws.work.gathers += 1;
            state.draws.work.grid_lookups += self.lookups;
            if media.len() == 1 {
                let light = self.kept_at(0, p, level, state);
                sum += place.weight * media.get(0).albedo.at(p) * light;
                continue;
            }
            let sigma_t = media.sigma_t_at(p);
            for (medium, sigma_s) in media.mixture_at(p) {
                let share = Rgb::select(sigma_t.cmpgt(Rgb::ZERO), sigma_s / sigma_t, Rgb::ZERO);
                sum += place.weight * share * self.kept_at(medium, p, level, state);
            }
        }
        sum / f64::from(lookups)
    }

    /// Light kept on the lattices of a medium at `p`.
    fn kept_at(&self, medium: usize, p: WorldPoint, level: usize, state: &mut State) -> Rgb {
        let indirect = self.maps.lattices[medium].at(p, level);
        let direct = self.maps.direct.get(medium);
        indirect + direct.map_or(Rgb::ZERO, |d| d.at(self.scene, p, &mut state.draws))
    }

    /// Light of the photons along `ray`.
    fn indirect(
        &self,
        ray: &Ray<World>,
        hit: Option<&SurfaceHit<'_>>,
        profile: &Profile,
        radius: f64,
        state: &mut State,
    ) -> Rgb {
        if self.maps.volume[0].is_empty() || profile.pieces().is_empty() {
            return Rgb::ZERO;
        }
        // Where the ray meets a surface at a slant, the disk round its end lies partly behind the
        // surface; photons in front of it beyond the end stand in for those.
        let end = hit.map_or(f64::INFINITY, |h| h.t);
        let beyond = hit.map_or(0.0, |h| {
            let cosine = ray.direction.dot(h.normal).abs().min(1.0);
            radius * ((1.0 - cosine * cosine).sqrt() / cosine).min(MOST_BEYOND)
        });
        let work = &mut state.draws.work;
        work.gathers += 1;
        let before = work.gathered;
        let span = Span::new(0.0, end + beyond);
        let respond = |t: f64| {
            let t = t.min(end);
            let Some((transmittance, sigma_t)) = profile.at(t) else {
                return Scatterers::new();
            };
            let mut scatterers = self.scatterers(ray.at(t));
            for (_, share) in &mut scatterers {
                *share *= transmittance * sigma_t;
            }
            scatterers
        };
        work.directed_gathers += u64::from(self.needs.directions);
        let light = if self.needs.directions {
            self.maps.along::<true, _>(ray, span, radius, &mut work.gathered, respond)
        } else {
            self.maps.along::<false, _>(ray, span, radius, &mut work.gathered, respond)
        };
        work.grid_lookups += (work.gathered - before) * self.lookups;
        light
    }

    /// The phase functions at `p`, each weighed by its share of the extinction there.
    fn scatterers(&self, p: WorldPoint) -> Scatterers<'a> {
        let media = &self.scene.media;
        if media.len() == 1 {
            let medium = media.get(0);
            let albedo = medium.albedo.at(p);
            return (albedo != Rgb::ZERO).then_some((&medium.phase, albedo)).into_iter().collect();
        }
        let sigma_t = media.sigma_t_at(p);
        let share =
            |sigma_s: Rgb| Rgb::select(sigma_t.cmpgt(Rgb::ZERO), sigma_s / sigma_t, Rgb::ZERO);
        let mixture = media.mixture_at(p);
        mixture.iter().map(|(m, sigma_s)| (&media.get(*m).phase, share(*sigma_s))).collect()
    }

    /// Light that a diffuse surface reflects along `ray` back to its origin.
    fn reflected(&self, ray: &Ray<World>, hit: &SurfaceHit<'_>, state: &mut State) -> Rgb {
        let direct = lighting::on_surface(
            self.scene,
            &self.scene.media,
            ray.direction,
            hit,
            &mut state.draws,
        );
        if self.maps.surface.is_empty() || state.shared == 0.0 {
            return direct;
        }
        let facing = if ray.direction.dot(hit.normal) < 0.0 { hit.normal } else { -hit.normal };
        state.draws.work.surface_gathers += 1;
        let start = Instant::now();
        let irradiance = self.maps.irradiance(hit.point, facing, &mut state.draws.work.gathered);
        state.gathering += start.elapsed();
        let reflectance = hit.material.eval(ray.direction, facing, hit, TransportMode::Radiance);
        let indirect = state.shared * reflectance * irradiance;
        state.stands_in += indirect;
        direct + indirect
    }
}

/// A number for the stratum `index` of `count` of the unit interval.
fn stratum(index: u32, count: u32, state: &mut State) -> f64 {
    (f64::from(index) + state.draws.rng.uniform()) / f64::from(count)
}
