//! The exposure: camera rays for each pixel of the film, in passes.
//!
//! Each pass covers the whole film, so that there is a picture at any time. Samples of a pixel are taken in one order whatever the
//! passes, and each depends on nothing but seed, pixel and number: an exposure that is halted goes on from the samples that
//! each pixel has, to the same picture.

use std::marker::PhantomData;
use std::time::Instant;

use rayon::prelude::*;

use crate::cache::{LazyCells, SamplePass};
use crate::director::PixelBudget;
use crate::film::{
    Accumulator, ComponentFilm, FilmContents, Pass, Pixel, Sample, Tile, TiledFilm, passes,
};
use crate::image::{Film, FilmPixel, Window};
use crate::math::{Ray, Spectrum, Stage, Stream, World};
use crate::scene::plan::Needs;
use crate::transport::PathContext;
use crate::work::Work;

use super::checkpoint::{CheckpointWriter, Checkpoints};
use super::checkpoint_file::CheckpointState;
use super::control::{Control, Halt, PreviewTimer};
use super::cost_model::{CostModel, Remaining, Timing};
use super::pixel_sampling::{
    CameraRay, FilmPlace, Numbering, Workspace, begin_sample, indirect_correction, indirect_weight,
};
use super::progress::Stages;
use super::rendered::{Ended, Rendered};

/// Samples of a pixel between two readings of the clock, which cost more than a cheap sample.
const CLOCK_INTERVAL: u32 = 16;

/// What is exposed.
#[derive(Debug, Clone, Copy)]
pub struct RenderRegion {
    /// Width and height of the film in pixels.
    pub size: [u32; 2],
    /// The part of it that gets rays.
    pub window: Window,
    /// The part of that which the picture shows.
    pub shown: Window,
    /// Seed of the random streams.
    pub seed: u64,
    /// The stage that the random streams belong to.
    pub stage: Stage,
    /// Rays of a pixel, at most, without those of earlier rounds.
    pub rays: u32,
    /// Where it is a pass of the picture, all of its rays beside those of the others.
    pub pass: Option<SamplePass>,
    /// Times that the scene has, among which rays choose; 1 where nothing moves.
    pub times: u32,
    /// What rays need.
    pub needs: Needs,
    /// What pixels gather beside their samples. Where they gather components their rays are in halves.
    pub contents: FilmContents,
}

/// Samples of the pixels of a film, and the work for them.
#[derive(Debug)]
pub struct Sampled {
    /// The samples.
    pub film: TiledFilm,
    /// Work done for them, that before a checkpoint included.
    pub work: Work,
    /// Why no more were taken.
    pub ended: Ended,
    /// Why no checkpoint could be written.
    pub checkpoint_error: Option<String>,
}

impl Sampled {
    /// None yet, of the film of `region`.
    pub fn none(region: &RenderRegion) -> Self {
        Self {
            film: TiledFilm::new(region.window, region.contents),
            work: Work::default(),
            ended: Ended::Complete,
            checkpoint_error: None,
        }
    }
}

/// The result of an exposure.
#[derive(Debug)]
pub struct Exposure {
    /// What has got rays.
    pub film: Film,
    /// The part of it that is the picture.
    pub shown: Window,
    /// Its components, where they are gathered.
    pub components: Option<ComponentFilm>,
    /// Work done for it, that before a checkpoint included.
    pub work: Work,
    /// Why it ended.
    pub ended: Ended,
    /// Rays that it would still have got.
    pub rays_left: u64,
    /// Why no checkpoint could be written.
    pub checkpoint_error: Option<String>,
}

impl Exposure {
    /// The picture after these `stages`; `work` was done beside it. `radius` is the finest one of gathers, in metres.
    pub fn rendered(self, mut work: Work, stages: Stages, radius: Option<f64>) -> Rendered {
        let Self { film, shown, work: exposing, ended, rays_left, checkpoint_error, .. } = self;
        work += exposing;
        Rendered {
            film: film.cut(shown),
            work,
            timings: stages.timings,
            radius,
            ended,
            rays_left,
            checkpoint_error,
            strategy: None,
            error: None,
            director: None,
            snapshot: None,
        }
    }
}

/// Exposes the film of `region`: `camera` generates the ray through a point on film and lens, `budget`
/// is what the pixel (x, y) may spend, `estimate` the sample that a ray brings. Pixels are sampled with an Owen-scrambled Sobol
/// sequence (Burley 2020) over a box filter and the times of the scene; the samples of a pixel depend on nothing but the
/// seed, the pixel and their number. `caches` are what `estimate` fills; checkpoints store them with the picture.
pub fn expose<S: Spectrum>(
    region: RenderRegion,
    camera: impl Fn(FilmPlace) -> Ray<World> + Sync,
    budget: impl Fn(u32, u32) -> PixelBudget + Sync,
    estimate: impl Fn(&CameraRay<'_>, &mut Workspace<S>) -> Sample + Sync,
    caches: &[&LazyCells<S>],
    control: &Control<'_>,
) -> Exposure {
    let begun = Sampled::none(&region);
    let sampled = sample(region, camera, &budget, estimate, begun, caches, control);
    resolve(&region, &budget, sampled)
}

/// As [`expose`], from samples that were taken before, and without making a film of them.
pub fn sample<S: Spectrum>(
    region: RenderRegion,
    camera: impl Fn(FilmPlace) -> Ray<World> + Sync,
    budget: impl Fn(u32, u32) -> PixelBudget + Sync,
    estimate: impl Fn(&CameraRay<'_>, &mut Workspace<S>) -> Sample + Sync,
    begun: Sampled,
    caches: &[&LazyCells<S>],
    control: &Control<'_>,
) -> Sampled {
    let exposer = Exposer { region, camera, budget, estimate, control, spectrum: PhantomData };
    exposer.sample(begun, caches)
}

/// Makes the film of `region` of its samples, where `budget` is what the pixel (x, y) might have spent. Pixels without
/// rays of an exposure that was cut short are filled from their neighbours.
pub fn resolve(
    region: &RenderRegion,
    budget: impl Fn(u32, u32) -> PixelBudget + Sync,
    sampled: Sampled,
) -> Exposure {
    let Sampled { mut film, work, ended, checkpoint_error } = sampled;
    let is_cut = ended != Ended::Complete;
    let rays_left = if is_cut { Remaining::count(&mut film, &budget).rays } else { 0 };
    let known = is_cut.then(|| has_rays(&mut film, &budget));
    let (mut film, components) = film.resolve(region.size, |x, y, samples: &Accumulator| {
        let budget = budget(x, y);
        let PixelBudget { radius, step, saliency, xs, .. } = budget;
        let pixel = FilmPixel::from(samples);
        let correction = indirect_correction(samples, &budget, region.numbering([x, y]));
        // Noise of moments makes rays negative, and cutting each of them off would brighten the pixel.
        let radiance = (pixel.radiance + correction).not_negative();
        FilmPixel { radiance, saliency, xs, radius, step, ..pixel }
    });
    known.iter().for_each(|known| film.fill(known));
    Exposure { film, shown: region.shown, components, work, ended, rays_left, checkpoint_error }
}

/// The picture of the samples that the `film` of `region` has so far, for which so much `work` was done.
pub fn picture_so_far(
    region: &RenderRegion,
    budget: impl Fn(u32, u32) -> PixelBudget + Sync,
    film: &TiledFilm,
    work: &Work,
) -> Rendered {
    let (film, work) = (film.without_aovs(), *work);
    let sampled = Sampled { film, work, ended: Ended::Stopped, checkpoint_error: None };
    let exposed = resolve(region, budget, sampled);
    exposed.rendered(Work::default(), Stages::default(), None)
}

/// Whether each pixel has a ray or needs none, row by row from the top.
fn has_rays(film: &mut TiledFilm, budget: impl Fn(u32, u32) -> PixelBudget) -> Vec<bool> {
    let Window { left, top, width, .. } = film.window;
    let mut known = vec![false; film.window.pixels() as usize];
    for (x, y, samples) in film.tiles.iter_mut().flat_map(Tile::pixels) {
        let index = (y - top) as usize * width as usize + (x - left) as usize;
        known[index] = samples.given() > 0 || budget(x, y).rays == 0;
    }
    known
}

impl RenderRegion {
    /// How the samples of the pixel (x, y) are numbered.
    pub(super) fn numbering(&self, pixel: [u32; 2]) -> Numbering {
        if self.contents.components { Numbering::halves(pixel) } else { Numbering::Whole }
    }
}

/// An exposure's functions of pixels, and who controls it.
struct Exposer<'a, S, C, B, E> {
    region: RenderRegion,
    camera: C,
    budget: B,
    estimate: E,
    control: &'a Control<'a>,
    spectrum: PhantomData<fn(S)>,
}

/// One pass over the film.
struct PassRun<'a> {
    pass: Pass,
    halt: &'a Halt<'a>,
    costs: &'a CostModel,
}

/// One thread's work on a tile.
struct TileRun<S> {
    workspace: Workspace<S>,
    timing: Timing,
}

impl<S, C, B, E> Exposer<'_, S, C, B, E>
where
    S: Spectrum,
    C: Fn(FilmPlace) -> Ray<World> + Sync,
    B: Fn(u32, u32) -> PixelBudget + Sync,
    E: Fn(&CameraRay<'_>, &mut Workspace<S>) -> Sample + Sync,
{
    /// All passes from samples that were taken before.
    fn sample(&self, begun: Sampled, caches: &[&LazyCells<S>]) -> Sampled {
        let control = self.control;
        let Sampled { mut film, mut work, .. } = begun;
        self.restore(&mut film, &mut work);
        let left = Remaining::count(&mut film, &self.budget);
        let (mut costs, mut timing) = (CostModel::default(), Timing::default());
        control.progress.stage("rays", costs.count(left.rays, left.gathers));
        if let Some(stop) = control.stop {
            stop.begin_picture();
        }
        let mut writer = CheckpointWriter::new(control.checkpoints);
        let mut previews = PreviewTimer::new(control.preview);
        let mut ended = Ended::Complete;
        let mut passes = passes(left.most).peekable();
        while let Some(&pass) = passes.peek() {
            // The first pass ignores the deadline: however short the time, there is a picture.
            let untimed = Control { deadline: None, ..*control };
            let due = [writer.due(), previews.due()].into_iter().flatten().min();
            let halt = Halt::new(if pass.is_first() { &untimed } else { control }, due);
            let run = PassRun { pass, halt: &halt, costs: &costs };
            let (done, took) = self.expose_pass(&mut film, &run);
            work += done;
            timing += took;
            if pass.every == 1 && costs.learn(&timing) {
                self.update_progress(&mut film, &costs, &timing);
            }
            if !halt.has_halted() {
                passes.next();
                continue;
            }
            ended = if pass.is_first() { untimed.ended() } else { control.ended() };
            if ended != Ended::Complete || writer.is_due() {
                writer.write(&work, &film, caches, control.progress);
            }
            if ended != Ended::Complete {
                break;
            }
            previews.show(&|| picture_so_far(&self.region, &self.budget, &film, &work));
        }
        control.progress.finish();
        Sampled { film, work, ended, checkpoint_error: writer.problem() }
    }

    /// Takes the samples of a checkpoint, if there is one, into `film`, and the work done for them into `work`.
    fn restore(&self, film: &mut TiledFilm, work: &mut Work) {
        let checkpoint = self.control.checkpoints.and_then(Checkpoints::take);
        if let Some(CheckpointState { work: done, film: state, .. }) = checkpoint {
            film.restore(state);
            *work = done;
        }
    }

    /// Counts progress anew by what rays have been found to cost.
    fn update_progress(&self, film: &mut TiledFilm, costs: &CostModel, timing: &Timing) {
        let left = Remaining::count(film, &self.budget);
        let done = costs.count(timing.rays, timing.gathers);
        self.control.progress.weigh(done, done + costs.count(left.rays, left.gathers));
    }

    /// One pass over all tiles.
    fn expose_pass(&self, film: &mut TiledFilm, run: &PassRun<'_>) -> (Work, Timing) {
        let tiles = film.tiles.par_iter_mut().with_max_len(1);
        tiles.map(|tile| self.expose_tile(tile, run)).reduce(Default::default, sum)
    }

    /// One pass over the pixels of a tile.
    fn expose_tile(&self, tile: &mut Tile, run: &PassRun<'_>) -> (Work, Timing) {
        let RenderRegion { seed, stage, needs, .. } = self.region;
        let ctx = PathContext::new(Stream::new(seed, stage, 0, 0), needs);
        let mut of = TileRun { workspace: Workspace::new(ctx), timing: Timing::default() };
        let start = Instant::now();
        let every = run.pass.every;
        for pixel in tile.all_pixels() {
            if pixel.x % every == 0 && pixel.y % every == 0 {
                self.expose_pixel(pixel, run, &mut of);
            }
        }
        let TileRun { workspace: Workspace { ctx, .. }, mut timing } = of;
        (timing.time, timing.gathering) = (start.elapsed(), ctx.amortized.gathers);
        timing.once = ctx.amortized.cells;
        let threads = rayon::current_num_threads() as u32;
        self.control.progress.once(timing.once / threads);
        self.control.progress.advance(run.costs.count(timing.rays, timing.gathers));
        let mut work = ctx.work;
        work += ctx.amortized.work;
        (work, timing)
    }

    /// The samples of a pixel that belong to a pass.
    fn expose_pixel(&self, pixel: Pixel<'_>, run: &PassRun<'_>, of: &mut TileRun<S>) {
        let Pixel { x, y, samples, mut features, mut components, aovs } = pixel;
        let contents = self.region.contents;
        let budget = (self.budget)(x, y);
        let begin = samples.given() as u32;
        let [first, last] = [run.pass.begin, run.pass.end].map(|ray| budget.earlier + ray);
        let end = last.min(budget.rays);
        let mut reads_clock = true;
        for index in begin..end {
            if run.halt.halts(reads_clock || index % CLOCK_INTERVAL == 0) {
                of.timing.rays += u64::from(index - begin);
                return;
            }
            let cells = of.workspace.ctx.amortized.cells;
            let (sample, half) = self.trace([x, y], index, &budget, of);
            let dropped = samples.dropped();
            samples.add(sample);
            if let (Some(mean), Some(seen)) = (features.as_deref_mut(), sample.features) {
                mean.add(&seen);
            }
            if let (Some(components), Some(half)) = (components.as_deref_mut(), half) {
                components.add(half, &sample);
            }
            if !aovs.is_empty() {
                contents.aovs.add(aovs, &of.workspace.aov_ray(&sample, half));
            }
            of.workspace.ctx.work.dropped_samples += samples.dropped() - dropped;
            // Filling cells of caches may have taken long.
            reads_clock = of.workspace.ctx.amortized.cells > cells;
        }
        // Rays that a pixel no longer needs since an earlier pass are counted already.
        let before = begin.max(first);
        of.timing.rays += u64::from(end.saturating_sub(before));
    }

    /// Traces the camera ray of one sample of the pixel (x, y). Returns its half as well.
    fn trace(
        &self,
        [x, y]: [u32; 2],
        index: u32,
        budget: &PixelBudget,
        of: &mut TileRun<S>,
    ) -> (Sample, Option<usize>) {
        let RenderRegion { size, seed, stage, rays, pass, times, .. } = self.region;
        let pixel = u64::from(y) * u64::from(size[0]) + u64::from(x);
        let ctx = &mut of.workspace.ctx;
        let numbering = self.region.numbering([x, y]);
        let numbered = numbering.number(index, budget);
        let [u, v, a, b] = begin_sample(ctx, [seed, pixel], stage, &numbered);
        ctx.work.colored_paths += u64::from(S::CHANNELS > 1);
        let time = ctx.stratified.time(times);
        let (x, y) = (f64::from(x) + u, f64::from(y) + v);
        let ray = (self.camera)(FilmPlace { x, y, lens: [a, b], time });
        let (half, indirect_weight) = (numbered.half, indirect_weight(&numbered));
        of.timing.gathers += u64::from(indirect_weight > 1.0);
        let pass = numbering.pass(index, budget, rays, pass);
        let camera_ray =
            CameraRay { ray, budget, indirect_weight, pass, directed: None, half, time };
        ((self.estimate)(&camera_ray, &mut of.workspace), half)
    }
}

/// Both sums.
fn sum(mut a: (Work, Timing), b: (Work, Timing)) -> (Work, Timing) {
    a.0 += b.0;
    a.1 += b.1;
    a
}
