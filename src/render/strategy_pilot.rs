//! The strategy pilot: a few rays and photons by each strategy, in two independent halves of the photons.

use std::mem;

use rayon::prelude::*;

use super::integrator::Integrator;
use super::pass_settings::{PassSettings, fluence_builders};
use super::pixel_sampling::{CameraRay, Workspace};
use crate::cache::{
    Caches, DirectLightCache, FluenceBuilder, FluenceGrid, GATHERS_PER_RAY, SamplePass,
};
use crate::director::PixelBudget;
use crate::math::{Aabb, Rgb, Spectrum, Stage, Stream, luminance};
use crate::photon::{AimedPhotons, PathSample, PhotonDirection, PhotonMaps, Recording};
use crate::scene::Scene;
use crate::strategy::{
    self, Assignment, BLOCK, Choice, Errors, Evidence, Measured, MediumCells, PhotonScale,
    RaySamples, Strategy,
};
use crate::transport::{FlightSegment, PathContext, StratifiedSample};
use crate::work::Work;

/// Photon paths of the render for each path of one half of the pilot: both halves together cost a
/// thirty-second of all photons.
const PHOTONS_PER_PATH: u64 = 64;

/// Fewest paths of a half, if there are so many: variances by 256 paths have a relative error of about 1 /
/// sqrt(128), a tenth.
const MIN_PATHS: u64 = 256;

/// Width of the pilot's cells over that which suits its photons: wider ones show more bias and less noise,
/// and are fewer.
const WIDENING: f64 = 2.0;

/// Rays of the picture for each ray of the pilot. With six samples of each by up to four contenders the
/// pilot costs a fifth of the picture's rays where it is smallest, and less than a hundredth at 512 x 512.
const RAYS_PER_RAY: f64 = 128.0;

/// Share of the cost of a picture by the cheapest contender so far that measuring another may take. One that
/// takes more is given up: its rays cost at least twice as much as that whole picture.
const MAX_SHARE: f64 = 0.1;

/// Samples of a ray by one half of the photons: two, and a wide one.
const SAMPLES: f64 = 3.0;

/// Fewest rays of the pilot along each side of the film, in blocks: nine blocks to tell bias from noise by.
const MIN_BLOCKS: usize = 3;

/// Most of them: variances by 32² rays are known to a few per cent.
const MAX_BLOCKS: usize = 8;

/// An assignment of strategies that the pilot measures.
struct Contender {
    choice: Choice,
    /// Factors for all photons.
    scale: PhotonScale,
    /// Flights through cells, each with every value that a cell holds, for all photons.
    crossings: f64,
}

/// Costs of a contender, in nanoseconds of a typical core.
struct ContenderCost {
    /// Its index.
    index: usize,
    /// Of a ray.
    ray: f64,
    /// Of all photons.
    photons: f64,
}

impl ContenderCost {
    /// Of a picture of so many rays.
    fn total(&self, rays: f64) -> f64 {
        self.photons + rays * self.ray
    }
}

/// One half of the photons.
struct Half<S: Spectrum, H: PhotonDirection> {
    maps: PhotonMaps<S, H>,
    /// Grids of each contender.
    fluence: Vec<Vec<Option<FluenceGrid<S>>>>,
    work: Work,
}

/// What the pilot works with.
pub(super) struct StrategyPilot<'a, 'b> {
    pub scene: &'a Scene,
    pub settings: &'b PassSettings,
    pub evidence: Evidence<'b>,
}

impl<'a> StrategyPilot<'a, '_> {
    /// Measures all contenders that differ, and returns the one with the least squared error times cost;
    /// `None` where no light is seen, or the picture has too few rays for a pilot. `direct` are the caches of direct light.
    pub fn measure<S: Spectrum, H: PhotonDirection>(
        &self,
        aimed: &mut AimedPhotons<'a>,
        direct: Vec<Option<DirectLightCache<S>>>,
    ) -> Option<Assignment> {
        if self.picture_rays() < RAYS_PER_RAY * ((BLOCK * MIN_BLOCKS).pow(2) as f64) {
            return None;
        }
        let paths = (aimed.count() / PHOTONS_PER_PATH).max(MIN_PATHS).min(aimed.count());
        if paths == 0 {
            return None;
        }
        let represents = aimed.count() as f64 / paths as f64;
        let (contenders, cells): (Vec<_>, Vec<_>) = self.contenders(represents).into_iter().unzip();
        let strategies = |contender: &Contender| -> Vec<Strategy> {
            contender.choice.media.iter().map(|medium| medium.strategy).collect()
        };
        if let [only] = &contenders[..]
            && !strategies(only).contains(&Strategy::Moments)
        {
            let reason = "no other is possible".into();
            return Some(Assignment { strategies: strategies(only), reason, measured: Vec::new() });
        }
        // Two halves of photons, others than those of the render.
        let half = |half: u64, aimed: &mut AimedPhotons<'a>| {
            let first = aimed.count() + half * paths;
            let part = PathSample { paths: first..first + paths, represents, levels: 1 };
            self.shoot::<S, H>(aimed, &contenders, &cells, &part)
        };
        let mut halves = [0, 1].map(|index| half(index, aimed));
        // Rays by each contender.
        let mut caches = Caches { direct, ..Caches::default() };
        let shot = halves[0].work;
        let (mut samples, mut costs) = (Vec::new(), Vec::<ContenderCost>::new());
        for (index, contender) in contenders.iter().enumerate() {
            let photons = represents * self.photon_cost(&shot, &contender.choice)
                + strategy::cost_of_crossings(contender.crossings);
            let cheapest = costs.iter().map(|cost| cost.total(self.picture_rays()));
            let most = MAX_SHARE * cheapest.fold(f64::INFINITY, f64::min);
            let grids = halves.each_mut().map(|half| mem::take(&mut half.fluence[index]));
            let maps = halves.each_ref().map(|half| &half.maps);
            let traced = self.trace(&contender.choice, maps, grids, &mut caches, most);
            let Some((rays, ray)) = traced else { continue };
            samples.push(rays);
            costs.push(ContenderCost { index, ray, photons });
        }
        let weights = strategy::weights(&samples);
        if weights.iter().all(|weight| *weight == 0.0) {
            return None;
        }
        let conditions = self.settings.conditions();
        let measured = |(rays, cost): (&Vec<RaySamples>, &ContenderCost)| Measured {
            strategies: strategies(&contenders[cost.index]),
            errors: strategy::errors(rays, &weights, contenders[cost.index].scale),
            ray_cost: cost.ray,
            photon_cost: cost.photons,
            pixels: self.pixels(),
            rays: f64::from(self.settings.rays),
        };
        let mut all: Vec<Measured> = samples.iter().zip(&costs).map(measured).collect();
        all.extend(self.shared(&all));
        let allowed =
            |measured: &&Measured| strategy::is_allowed(&measured.strategies, &conditions);
        let best = all.iter().filter(allowed).min_by(|a, b| a.product().total_cmp(&b.product()))?;
        let reason = "in a pilot it has the least squared error times cost".into();
        Some(Assignment { strategies: best.strategies.clone(), reason, measured: all })
    }

    /// Profiles that differ, with their cells for a pilot whose paths each represent so many.
    fn contenders(&self, represents: f64) -> Vec<(Contender, Vec<MediumCells>)> {
        let conditions = self.settings.conditions();
        let widening = WIDENING * strategy::width_for_photons(1.0 / represents);
        let evidence = Evidence { widening, ..self.evidence };
        let mut contenders: Vec<(Contender, Vec<MediumCells>)> = Vec::new();
        for strategies in strategy::assignments(self.scene, &conditions) {
            let assignment = Assignment { strategies, ..Assignment::default() };
            let (choice, cells) =
                strategy::choose(self.scene, &conditions, &evidence, Some(&assignment));
            let of = |choice: &Choice| choice.media.iter().map(|m| m.strategy).collect::<Vec<_>>();
            let is_new =
                contenders.iter().all(|(contender, _)| of(&contender.choice) != of(&choice));
            if let Some(contender) = self.contender(choice, represents).filter(|_| is_new) {
                contenders.push((contender, cells));
            }
        }
        contenders
    }

    /// A contender with its factors from the pilot's cells and photons to the render's; `None` where those
    /// cells, which are narrower, are too many.
    fn contender(&self, choice: Choice, represents: f64) -> Option<Contender> {
        let conditions = self.settings.conditions();
        let (mut narrower, mut crossings) = (0.0_f64, 0.0);
        for (index, medium) in choice.media.iter().enumerate() {
            let width = strategy::cell_width(
                self.scene,
                &conditions,
                &self.evidence,
                index,
                medium.strategy,
            );
            if let Some(pilot) = medium.cell_width {
                let width = width?;
                narrower = narrower.max(width / pilot);
                let values = match medium.strategy {
                    Strategy::FluenceTowardEye => 1.0,
                    _ => choice.termination.values(index) as f64,
                };
                // The mean chord of a cube is 2/3 of its edge.
                crossings += 3.0 / 2.0 * values * self.evidence.flight_length / width;
            }
        }
        let narrower = if narrower > 0.0 { narrower } else { 1.0 };
        let toward_eye = choice.media.iter().any(|m| m.strategy == Strategy::FluenceTowardEye);
        // A ray's light comes from a place or a line, through cells of the width w: its variance is as
        // 1 / w² or 1 / w. Gathers of a pixel end everywhere, whatever the cells.
        let scale = PhotonScale {
            shared: 1.0 / represents / if toward_eye { narrower } else { 1.0 },
            of_ray: 1.0 / represents / narrower.powi(2),
            bias: narrower.powi(4),
        };
        Some(Contender { choice, scale, crossings })
    }

    /// Shoots the photons of one half, with what all contenders need.
    fn shoot<S: Spectrum, H: PhotonDirection>(
        &self,
        aimed: &mut AimedPhotons<'a>,
        contenders: &[Contender],
        cells: &[Vec<MediumCells>],
        part: &PathSample,
    ) -> Half<S, H> {
        let (origin, unit) = (aimed.origin(), aimed.flight_unit() * part.represents);
        let mut builders: Vec<Vec<Option<FluenceBuilder<'_, S>>>> = Vec::new();
        for (contender, cells) in contenders.iter().zip(cells) {
            let cells = cells.iter().map(|cells| cells.fluence.clone()).collect();
            builders.push(fluence_builders(self.scene, &contender.choice, cells, origin));
        }
        let bounds = builders.iter().flatten().flatten().map(FluenceBuilder::bounds);
        let phases: Vec<_> = contenders[0].choice.splits.iter().map(|split| split.phase).collect();
        let recording = Recording {
            volume_photons: contenders.iter().any(|contender| contender.choice.stores_photons),
            flight_bounds: bounds.reduce(Aabb::union),
            flights: &mut |segments: &[&[FlightSegment<S>]]| {
                builders.iter_mut().flatten().flatten().for_each(|builder| builder.add(segments));
            },
        };
        let (maps, work) = aimed.shoot_part::<S, H>(recording, &phases, part, &|_| ());
        let finish = |builder: FluenceBuilder<'_, S>| builder.finish(part.levels, unit);
        let fluence = builders
            .into_iter()
            .map(|own| own.into_iter().map(|builder| builder.map(finish)).collect())
            .collect();
        Half { maps, fluence, work }
    }

    /// Samples of all rays by one contender, and the cost of a ray, where measuring it costs at most `most`.
    /// `caches` hold direct light, and take the contender's grids of each half.
    fn trace<S: Spectrum, H: PhotonDirection>(
        &self,
        choice: &Choice,
        maps: [&PhotonMaps<S, H>; 2],
        grids: [Vec<Option<FluenceGrid<S>>>; 2],
        caches: &mut Caches<S>,
        most: f64,
    ) -> Option<(Vec<RaySamples>, f64)> {
        let needs = self.settings.photons.needs;
        let side = self.side();
        let mut rays = vec![RaySamples::default(); side * side];
        let (mut work, mut traced) = (Work::default(), 0.0);
        for (half, (maps, grids)) in maps.into_iter().zip(grids).enumerate() {
            caches.fluence = grids;
            let integrator = Integrator::new(self.scene, maps, caches, choice, needs);
            let radius = maps.volume_radius;
            let ray = |(index, ray): (usize, &mut RaySamples)| {
                let mut workspace = self.workspace();
                let mut sample =
                    |radius, set| self.luminance(&integrator, index, radius, set, &mut workspace);
                ray.samples[half] = [0, 1].map(|set| sample(radius, set));
                ray.wide[half] = sample(2.0 * radius, 0);
                workspace.ctx.work
            };
            // Row of blocks by row: what is too expensive is given up soon.
            for (row, rays) in rays.chunks_mut(BLOCK * side).enumerate() {
                let first = row * BLOCK * side;
                let indexed = rays.par_iter_mut().enumerate();
                let works: Vec<Work> =
                    indexed.map(|(index, rays)| ray((first + index, rays))).collect();
                works.into_iter().for_each(|done| work += done);
                traced += SAMPLES * rays.len() as f64;
                let all = 2.0 * SAMPLES * (side * side) as f64;
                if strategy::cost(&work, self.gathering()) * all / traced > most {
                    return None;
                }
            }
        }
        Some((rays, strategy::cost(&work, self.gathering()) / traced))
    }

    fn workspace<S: Spectrum>(&self) -> Workspace<S> {
        let stream = Stream::new(self.settings.photons.seed, Stage::Strategy, 0, 0);
        Workspace::new(PathContext::new(stream, self.settings.photons.needs))
    }

    /// Luminance along one ray of the grid over the film, with this set of random numbers.
    fn luminance<S: Spectrum, H: PhotonDirection>(
        &self,
        integrator: &Integrator<'_, S, H>,
        ray: usize,
        radius: f64,
        set: u64,
        workspace: &mut Workspace<S>,
    ) -> f64 {
        let (seed, side) = (self.settings.photons.seed, self.side());
        let mut place = Stream::new(seed, Stage::Strategy, ray as u64, u64::MAX);
        let scale = self.scene.film.size.map(|pixels| f64::from(pixels) / side as f64);
        let x = ((ray % side) as f64 + place.uniform()) * scale[0];
        let y = ((ray / side) as f64 + place.uniform()) * scale[1];
        // Rays of one pixel.
        workspace.ctx.rng = Stream::new(seed, Stage::Strategy, ray as u64, set);
        let [u, v] = workspace.ctx.rng.uniform2();
        let pixels = self.settings.film_pixels;
        let [x, y] = [(x, u), (y, v)].map(|(at, u)| ((at / pixels).floor() + u) * pixels);
        let camera_ray = CameraRay {
            ray: self.scene.camera.ray(x, y, workspace.ctx.rng.uniform2()),
            budget: &PixelBudget::fixed(self.settings.rays, radius, self.settings.step),
            indirect_weight: 1.0,
            pass: SamplePass { index: 0, rays: self.settings.rays },
        };
        workspace.ctx.stratified = StratifiedSample::default();
        workspace.ctx.work.rays += 1;
        let radiance = integrator.radiance(&camera_ray, workspace).radiance;
        if radiance.is_finite() { luminance(Rgb::from(radiance)) } else { 0.0 }
    }

    /// Rays of the picture.
    fn picture_rays(&self) -> f64 {
        self.pixels() * f64::from(self.settings.rays)
    }

    /// Rays along each side of the film.
    fn side(&self) -> usize {
        let rays = self.picture_rays() / RAYS_PER_RAY;
        let blocks = (rays.sqrt() / BLOCK as f64) as usize;
        BLOCK * blocks.clamp(MIN_BLOCKS, MAX_BLOCKS)
    }

    /// Pixels of the picture.
    fn pixels(&self) -> f64 {
        let [width, height] = self.scene.film.size.map(f64::from);
        width * height / self.settings.film_pixels.powi(2)
    }

    /// Share of the rays of a pixel that gather photons.
    fn gathering(&self) -> f64 {
        let budget = PixelBudget::fixed(self.settings.rays, 0.0, 0.0);
        f64::from(budget.gathers.min(budget.rays)) / f64::from(budget.rays.max(1))
    }

    /// Cost of the photons of a half by a contender; none where it does without them.
    fn photon_cost(&self, shot: &Work, choice: &Choice) -> f64 {
        let reads_flights = choice.media.iter().any(|medium| medium.cell_width.is_some());
        let surfaces = self.settings.photons.needs.surface_photons;
        if !choice.stores_photons && !reads_flights && !surfaces {
            return 0.0;
        }
        let stored = if choice.stores_photons { shot.volume_photons as f64 } else { 0.0 };
        strategy::cost(shot, 1.0) + strategy::cost_of_storing(stored)
    }

    /// What shared gathers would bring, by what was measured of moments.
    fn shared(&self, measured: &[Measured]) -> Option<Measured> {
        let conditions = self.settings.conditions();
        let is_moments = |m: &&Measured| m.strategies.contains(&Strategy::Moments);
        let moments = measured.iter().find(is_moments)?;
        let strategies: Vec<Strategy> = moments
            .strategies
            .iter()
            .map(|s| if *s == Strategy::Moments { Strategy::SharedGathers } else { *s })
            .collect();
        let footprint = strategy::shared_footprint(self.scene, &conditions, &self.evidence)?;
        let least = |f: fn(&Measured) -> f64| measured.iter().map(f).fold(f64::INFINITY, f64::min);
        let common = least(|m| m.errors.ray_variance);
        let common_cost = least(|m| m.ray_cost);
        Some(Measured {
            strategies,
            errors: Errors {
                ray_variance: common
                    + (moments.errors.ray_variance - common) / (GATHERS_PER_RAY * footprint),
                ..moments.errors
            },
            ray_cost: common_cost + GATHERS_PER_RAY * (moments.ray_cost - common_cost),
            ..moments.clone()
        })
    }
}
