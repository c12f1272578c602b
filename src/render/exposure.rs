//! From rays to the film: pixels, their samples and their budget.
//!
//! Pixels get their rays in passes, each over the whole film, so that at any time there is a picture.
//! Samples of a pixel are taken in one order whatever the passes, and each depends on nothing but
//! seed, pixel and number: wherever work is halted, the samples that a pixel has say how it goes on,
//! and the picture is the same in the end.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::cache::{LazyCells, SamplePass};
use crate::director::PixelBudget;
use crate::film::{Accumulator, Sample};
use crate::image::{Film, FilmPixel, Window};
use crate::math::{Ray, Rgb, Spectrum, Stage, Stream, World};
use crate::medium::Profile;
use crate::scene::plan::Needs;
use crate::transport::{PathContext, SobolPoint};
use crate::work::Work;

use super::checkpoint::{CheckpointWriter, Checkpoints};
use super::checkpoint_file::CheckpointState;
use super::control::{Control, Halt};
use super::cost_model::{CostModel, Remaining, Timing};
use super::rendered::Ended;
use crate::film::{Pass, passes, sample_pass};
use crate::film::{Pixel, Tile, TiledFilm};

/// Rays of a pixel after which the clock is looked at.
const LOOK: u32 = 16;

/// What an estimator needs at hand for one ray: random numbers, counters, memory to reuse.
#[derive(Debug)]
pub struct State<S> {
    /// Random numbers of this ray, the work done so far and what is needed.
    pub ctx: PathContext,
    /// Memory for the march.
    pub profile: Profile<S>,
    /// What light that varies little within a pixel counts along this ray: 0 where another ray of
    /// the pixel stands in for it.
    pub shared: f64,
    /// What has been found so and not yet been told, W/(m² sr).
    pub stands_in: S,
    /// Time that finding it took.
    pub gathering: Duration,
    /// The round that this ray belongs to.
    pub round: SamplePass,
}

impl<S: Spectrum> State<S> {
    /// For rays of a round.
    pub(super) fn new(ctx: PathContext, round: SamplePass) -> Self {
        let (profile, gathering) = (Profile::default(), Duration::ZERO);
        Self { ctx, profile, shared: 1.0, stands_in: S::ZERO, gathering, round }
    }
}

/// What is exposed.
#[derive(Debug, Clone, Copy)]
pub struct RenderRegion {
    /// Width and height of the film in pixels.
    pub size: [u32; 2],
    /// The part of it that gets rays.
    pub window: Window,
    /// Seed of the random streams.
    pub seed: u64,
    /// What they are drawn for.
    pub stage: Stage,
    /// Rays of a pixel, at most.
    pub rays: u32,
    /// What rays need.
    pub needs: Needs,
    /// Whether `estimate` tells what rays see.
    pub features: bool,
}

/// What an exposure left.
#[derive(Debug)]
pub struct Exposure {
    /// The picture.
    pub film: Film,
    /// Work done for it, before it was taken up again too.
    pub work: Work,
    /// Why it ended.
    pub ended: Ended,
    /// Rays that it would still have got.
    pub rays_left: u64,
    /// Why its state could not be kept on disk.
    pub checkpoint_error: Option<String>,
}

/// Exposes the film of `sheet`: `camera` aims a ray through a place on it and on the lens, `direct`
/// says what the pixel (x, y) may spend, `estimate` what one ray brings. Pixels are sampled with an
/// Owen-scrambled Sobol sequence (Burley 2020) over a box filter; the samples of a pixel depend on
/// nothing but the seed, the pixel and their number. `lattices` are what `estimate` fills on its
/// way; they are kept with the picture where `control` keeps it.
pub fn expose<S: Spectrum>(
    sheet: RenderRegion,
    camera: impl Fn(f64, f64, [f64; 2]) -> Ray<World> + Sync,
    direct: impl Fn(u32, u32) -> PixelBudget + Sync,
    estimate: impl Fn(Ray<World>, &PixelBudget, &mut State<S>) -> Sample + Sync,
    lattices: &[&LazyCells<S>],
    control: &Control<'_>,
) -> Exposure {
    let RenderRegion { size, window, seed, stage, rays, needs, features } = sheet;
    let pixel = |pixel: Pixel<'_>, pass: Pass, run: &mut Run<'_, S>| {
        let Pixel { x, y, samples, mut features } = pixel;
        let budget = direct(x, y);
        let index = u64::from(y) * u64::from(size[0]) + u64::from(x);
        let begin = samples.given() as u32;
        let mut looks = true;
        for sample in begin..pass.end.min(budget.rays) {
            if run.halt.halts(looks || sample % LOOK == 0) {
                run.spent.rays += u64::from(sample - begin);
                return;
            }
            if sample >= budget.least && samples.has_converged(budget.tolerance) {
                break;
            }
            let state = &mut run.state;
            state.ctx.rng = Stream::new(seed, stage, index, u64::from(sample));
            let even = pattern(seed, index, sample);
            (state.ctx.lights, state.ctx.scattering) = (Some(even), Some(even));
            let [u, v, a, b] = even.place();
            let ray = camera(f64::from(x) + u, f64::from(y) + v, [a, b]);
            state.ctx.work.rays += 1;
            state.ctx.work.colored_paths += u64::from(S::CHANNELS > 1);
            state.shared = shared(sample, &budget);
            state.round = sample_pass(sample, rays);
            run.spent.gathers += u64::from(state.shared > 1.0);
            let (dropped, once) = (samples.dropped(), state.ctx.once);
            let sample = estimate(ray, &budget, state);
            samples.add(sample);
            if let (Some(mean), Some(seen)) = (features.as_deref_mut(), sample.features) {
                mean.add(&seen);
            }
            state.ctx.work.dropped_samples += samples.dropped() - dropped;
            // What is kept for rays to come may have taken long.
            looks = state.ctx.once > once;
        }
        // What settled in an earlier pass has been counted.
        let before = begin.max(pass.begin);
        run.spent.rays += u64::from(pass.end.min(budget.rays).saturating_sub(before));
    };
    let threads = rayon::current_num_threads() as u32;
    let mut plate = TiledFilm::new(window, features);
    let mut work = Work::default();
    if let Some(CheckpointState { work: known, samples, features, .. }) =
        control.checkpoints.and_then(Checkpoints::take)
    {
        work = known;
        plate.restore(samples, features);
    }
    let left = Remaining::count(&mut plate, &direct);
    let (mut units, mut spent) = (CostModel::default(), Timing::default());
    control.progress.stage("rays", units.count(left.rays, left.gathers));
    if let Some(stop) = control.stop {
        stop.begin_picture();
    }
    let mut keeping = CheckpointWriter::new(control.checkpoints);
    let mut ended = Ended::Complete;
    let mut passes = passes(left.most).peekable();
    while let Some(&pass) = passes.peek() {
        // However short the time, there is to be something to see.
        let untimed = Control { deadline: None, ..*control };
        let control = if pass.is_first() { &untimed } else { control };
        let halt = Halt::new(control, keeping.due());
        let tile = |tile: &mut Tile| {
            let ctx = PathContext::new(Stream::new(seed, stage, 0, 0), needs);
            let state = State::new(ctx, sample_pass(0, rays));
            let mut run = Run { state, halt: &halt, spent: Timing::default() };
            let start = Instant::now();
            for place in tile.all_pixels() {
                if place.x % pass.every == 0 && place.y % pass.every == 0 {
                    pixel(place, pass, &mut run);
                }
            }
            let Run { state, mut spent, .. } = run;
            (spent.time, spent.gathering) = (start.elapsed(), state.gathering);
            spent.once = state.ctx.once;
            control.progress.once(spent.once / threads);
            control.progress.advance(units.count(spent.rays, spent.gathers));
            (state.ctx.work, spent)
        };
        let tiles = plate.tiles.par_iter_mut().with_max_len(1);
        let (done, took) = tiles.map(tile).reduce(Default::default, sum);
        work += done;
        spent += took;
        if pass.every == 1 && units.learn(&spent) {
            let left = Remaining::count(&mut plate, &direct);
            let done = units.count(spent.rays, spent.gathers);
            control.progress.weigh(done, done + units.count(left.rays, left.gathers));
        }
        if !halt.has_halted() {
            passes.next();
            continue;
        }
        if control.is_stopped() {
            ended = Ended::Stopped;
        } else if control.is_late() {
            ended = Ended::OutOfTime;
        }
        keeping.write(&work, &plate, lattices, control.progress);
        if ended != Ended::Complete {
            break;
        }
    }
    control.progress.finish();
    let rays_left =
        if ended == Ended::Complete { 0 } else { Remaining::count(&mut plate, &direct).rays };
    let filled = (ended != Ended::Complete).then(|| has_rays(&mut plate, &direct));
    let mut film = plate.resolve(size, |x, y, samples| {
        let budget = direct(x, y);
        let PixelBudget { radius, step, saliency, xs, .. } = budget;
        let pixel = FilmPixel::from(samples);
        let radiance = pixel.radiance + unshared(samples, &budget);
        FilmPixel { radiance, saliency, xs, radius, step, ..pixel }
    });
    filled.iter().for_each(|known| film.fill(known));
    Exposure { film, work, ended, rays_left, checkpoint_error: keeping.problem() }
}

/// One thread's way through a tile.
struct Run<'a, S> {
    state: State<S>,
    halt: &'a Halt<'a>,
    spent: Timing,
}

/// Both sums.
fn sum(mut a: (Work, Timing), b: (Work, Timing)) -> (Work, Timing) {
    a.0 += b.0;
    a.1 += b.1;
    a
}

/// Whether each pixel has got a ray, or is to get none, row by row from the top.
fn has_rays(plate: &mut TiledFilm, direct: &impl Fn(u32, u32) -> PixelBudget) -> Vec<bool> {
    let Window { left, top, width, .. } = plate.window;
    let mut known = vec![false; plate.window.pixels() as usize];
    for (x, y, samples) in plate.tiles.iter_mut().flat_map(Tile::pixels) {
        let index = (y - top) as usize * width as usize + (x - left) as usize;
        known[index] = samples.given() > 0 || direct(x, y).rays == 0;
    }
    known
}

/// What light that varies little counts along a ray of a pixel, so that few rays, spread evenly,
/// stand in for all.
fn shared(sample: u32, budget: &PixelBudget) -> f64 {
    if budget.rays <= budget.gathers {
        1.0
    } else if budget.gathers_within(sample + 1) != budget.gathers_within(sample) {
        f64::from(budget.rays) / f64::from(budget.gathers)
    } else {
        0.0
    }
}

/// What the mean of a pixel that has not got all its rays wants, so that light for which one ray
/// stands in for others counts as if those had been there.
fn unshared(samples: &Accumulator, budget: &PixelBudget) -> Rgb {
    let given = samples.given() as u32;
    let groups = budget.gathers_within(given);
    if groups == 0 || given >= budget.rays {
        return Rgb::ZERO;
    }
    let counted = groups as f64 * f64::from(budget.rays) / f64::from(budget.gathers);
    samples.shared() * (f64::from(given) / counted - 1.0)
}

/// What is spread evenly over the samples of a pixel.
fn pattern(seed: u64, pixel: u64, sample: u32) -> SobolPoint {
    // The sequence is good for 2^16 points; further samples start another one.
    let (block, index) = (sample >> 16, sample & 0xffff);
    let mut key = Stream::new(seed, Stage::March, pixel, u64::from(block) | 1 << 63);
    SobolPoint { index, scramble: key.scramble() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_on_its_way_has_as_much_light_as_a_finished_one() {
        for (rays, gathers) in [(16, 4), (10, 4), (64, 3), (3, 4), (7, 7)] {
            let budget = PixelBudget { gathers, ..PixelBudget::fixed(rays, 0.0, 0.0) };
            let mut samples = Accumulator::default();
            for sample in 0..rays {
                let shared = Rgb::splat(2.0 * super::shared(sample, &budget));
                let shares = budget.rays > budget.gathers;
                samples.add(Sample {
                    radiance: Rgb::ONE + shared,
                    shared: if shares { shared } else { Rgb::ZERO },
                    calm: Rgb::ZERO,
                    alpha: 1.0,
                    transmittance: 1.0,
                    depth: 1.0,
                    features: None,
                });
                let told = samples.mean() + unshared(&samples, &budget);
                assert!((told - 3.0).abs().max_element() < 1e-5, "{told} after {sample} of {rays}");
            }
            assert_eq!(unshared(&samples, &budget), Rgb::ZERO);
        }
    }
}
