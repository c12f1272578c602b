//! From rays to the film: pixels, their samples and their budget.
//!
//! Pixels get their rays in passes, each over the whole film, so that at any time there is a picture.
//! Samples of a pixel are taken in one order whatever the passes, and each depends on nothing but
//! seed, pixel and number: wherever work is halted, the samples that a pixel has say how it goes on,
//! and the picture is the same in the end.

use std::iter::successors;

use rayon::prelude::*;

use crate::director::Budget;
use crate::image::{Accumulator, Film, FilmPixel, Sample, Window};
use crate::math::{Ray, Rgb, Stage, Stream, World, luminance};
use crate::medium::Profile;
use crate::photon::DirectLattice;
use crate::scene::lighting::Draws;
use crate::scene::plan::Needs;
use crate::work::Work;

use super::checkpoint::{Keeping, Moment};
use super::control::{Control, Halt};
use super::plate::{Plate, Tile};
use super::rendered::Ended;

/// How many times as many rays a pixel has after a pass as before it.
const GROWTH: u32 = 4;

/// Rays of a pixel after which the clock is looked at.
const LOOK: u32 = 16;

/// What the director says of a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Direction {
    /// What it may spend.
    pub budget: Budget,
    /// How much it catches the eye, 0 to 1.
    pub saliency: f64,
    /// Its importance, 0 to 1.
    pub xs: f64,
}

impl Direction {
    /// What holds for all pixels without a director: all matter alike.
    pub const fn fixed(budget: Budget) -> Self {
        Self { budget, saliency: 1.0, xs: 1.0 }
    }
}

/// What an estimator needs at hand for one ray: random numbers, counters, memory to reuse.
#[derive(Debug)]
pub struct State {
    /// Random numbers of this ray, the work done so far and what is needed.
    pub draws: Draws,
    /// Memory for the march.
    pub profile: Profile,
    /// What light that varies little within a pixel counts along this ray: 0 where another ray of
    /// the pixel stands in for it.
    pub shared: f64,
    /// What has been found so and not yet been told, W/(m² sr).
    pub stands_in: Rgb,
}

/// What is exposed.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    /// Width and height of the film in pixels.
    pub size: [u32; 2],
    /// The part of it that gets rays.
    pub window: Window,
    /// Seed of the random streams.
    pub seed: u64,
    /// What they are drawn for.
    pub stage: Stage,
    /// What rays need.
    pub needs: Needs,
}

/// What an exposure left.
#[derive(Debug)]
pub struct Exposed {
    /// The picture.
    pub film: Film,
    /// Work done for it, before it was taken up again too.
    pub work: Work,
    /// Why it ended.
    pub ended: Ended,
    /// Rays that it would still have got.
    pub rays_left: u64,
    /// Why its state could not be kept on disk.
    pub unkept: Option<String>,
}

/// Exposes the film of `sheet`: `camera` aims a ray through a place on it and on the lens, `direct`
/// says what the pixel (x, y) may spend, `estimate` what one ray brings. Pixels are sampled with an
/// Owen-scrambled Sobol sequence (Burley 2020) over a box filter; the samples of a pixel depend on
/// nothing but the seed, the pixel and their number. `lattices` are what `estimate` fills on its
/// way; they are kept with the picture where `control` keeps it.
pub fn expose(
    sheet: Sheet,
    camera: impl Fn(f64, f64, [f64; 2]) -> Ray<World> + Sync,
    direct: impl Fn(u32, u32) -> Direction + Sync,
    estimate: impl Fn(Ray<World>, &Budget, &mut State) -> Sample + Sync,
    lattices: &[DirectLattice],
    control: &Control<'_>,
) -> Exposed {
    let Sheet { size, window, seed, stage, needs } = sheet;
    let pixel = |x: u32, y: u32, samples: &mut Accumulator, end: u32, run: &mut Run<'_>| {
        let budget = direct(x, y).budget;
        let index = u64::from(y) * u64::from(size[0]) + u64::from(x);
        let begin = samples.given() as u32;
        for sample in begin..end.min(budget.rays) {
            if run.halt.halts(sample == begin || sample % LOOK == 0) {
                return;
            }
            if sample >= budget.least && is_settled(samples, budget.tolerance) {
                break;
            }
            let state = &mut run.state;
            state.draws.rng = Stream::new(seed, stage, index, u64::from(sample));
            let ([u, v, a, b], even) = pattern(seed, index, sample);
            state.draws.even = Some(even);
            let ray = camera(f64::from(x) + u, f64::from(y) + v, [a, b]);
            state.draws.work.rays += 1;
            state.shared = shared(sample, budget.rays, budget.gathers);
            let dropped = samples.dropped();
            samples.add(estimate(ray, &budget, state));
            state.draws.work.dropped_samples += samples.dropped() - dropped;
        }
        run.done += u64::from(end.min(budget.rays).saturating_sub(begin));
    };
    let mut plate = Plate::new(window);
    let mut work = Work::default();
    if let Some(Moment { work: known, samples, .. }) = control.checkpoints.and_then(|c| c.take()) {
        work = known;
        plate.restore(samples);
    }
    let (most, left) = rays(&mut plate, &direct);
    control.progress.stage("rays", left);
    if let Some(stop) = control.stop {
        stop.begin_picture();
    }
    let mut keeping = Keeping::new(control.checkpoints);
    let mut ended = Ended::Complete;
    let mut passes = passes(most).peekable();
    while let Some(&end) = passes.peek() {
        let halt = Halt::new(control, keeping.due());
        let tile = |tile: &mut Tile| {
            let draws = Draws::new(Stream::new(seed, stage, 0, 0), needs);
            let (profile, stands_in) = (Profile::default(), Rgb::ZERO);
            let state = State { draws, profile, shared: 1.0, stands_in };
            let mut run = Run { state, halt: &halt, done: 0 };
            for (x, y, samples) in tile.pixels() {
                pixel(x, y, samples, end, &mut run);
            }
            control.progress.advance(run.done);
            run.state.draws.work
        };
        work += plate.tiles.par_iter_mut().map(tile).sum::<Work>();
        if !halt.has_halted() {
            passes.next();
            continue;
        }
        if control.is_stopped() {
            ended = Ended::Stopped;
        } else if control.is_late() {
            ended = Ended::OutOfTime;
        }
        keeping.keep(&work, &plate, lattices, control.progress);
        if ended != Ended::Complete {
            break;
        }
    }
    control.progress.finish();
    let rays_left = if ended == Ended::Complete { 0 } else { rays(&mut plate, &direct).1 };
    let film = plate.develop(size, |x, y, samples| {
        let Direction { budget, saliency, xs } = direct(x, y);
        let Budget { radius, step, .. } = budget;
        let pixel = FilmPixel::from(samples);
        let radiance = pixel.radiance + unshared(samples, &budget);
        FilmPixel { radiance, saliency, xs, radius, step, ..pixel }
    });
    Exposed { film, work, ended, rays_left, unkept: keeping.problem() }
}

/// One thread's way through a tile.
struct Run<'a> {
    state: State,
    halt: &'a Halt<'a>,
    /// Rays that the tile no longer needs.
    done: u64,
}

/// How many rays pixels have after each pass, up to `most`.
fn passes(most: u32) -> impl Iterator<Item = u32> {
    let ends = successors(Some(1_u32), |end| end.checked_mul(GROWTH));
    ends.take_while(move |end| *end < most).chain((most > 0).then_some(most))
}

/// The most rays that a pixel may get, and the sum of what all have not got yet.
fn rays(plate: &mut Plate, direct: &(impl Fn(u32, u32) -> Direction + Sync)) -> (u32, u64) {
    let tile = |tile: &mut Tile| {
        let pixel = |(x, y, samples): (u32, u32, &mut Accumulator)| {
            let rays = direct(x, y).budget.rays;
            (rays, u64::from(rays).saturating_sub(samples.given()))
        };
        tile.pixels().map(pixel).fold((0, 0), both)
    };
    plate.tiles.par_iter_mut().map(tile).reduce(|| (0, 0), both)
}

/// The larger of the first and the sum of the second.
fn both(a: (u32, u64), b: (u32, u64)) -> (u32, u64) {
    (a.0.max(b.0), a.1 + b.1)
}

/// What light that varies little counts along a ray of a pixel, so that `gathers` rays, spread
/// evenly, stand in for all.
fn shared(sample: u32, rays: u32, gathers: u32) -> f64 {
    if rays <= gathers {
        return 1.0;
    }
    let group = |sample| group(sample, rays, gathers);
    if sample == 0 || group(sample) != group(sample - 1) {
        f64::from(rays) / f64::from(gathers)
    } else {
        0.0
    }
}

/// Which group a ray of a pixel belongs to, for all of which its first one gathers.
fn group(sample: u32, rays: u32, gathers: u32) -> u64 {
    u64::from(sample) * u64::from(gathers) / u64::from(rays)
}

/// What the mean of a pixel that has not got all its rays wants, so that light for which one ray
/// stands in for others counts as if those had been there.
fn unshared(samples: &Accumulator, budget: &Budget) -> Rgb {
    let (given, rays, gathers) = (samples.given() as u32, budget.rays, budget.gathers);
    if given == 0 || given >= rays || rays <= gathers {
        return Rgb::ZERO;
    }
    let groups = group(given - 1, rays, gathers) + 1;
    let counted = groups as f64 * f64::from(rays) / f64::from(gathers);
    samples.shared() * (f64::from(given) / counted - 1.0)
}

/// Whether the standard error of a pixel is at most `tolerance` of its mean. A pixel without light
/// is not: a rare path may still bring some.
fn is_settled(samples: &Accumulator, tolerance: f64) -> bool {
    let mean = luminance(samples.mean());
    mean > 0.0 && samples.luminance_variance().sqrt() <= tolerance * mean
}

/// The place of a sample in its pixel and on the lens, and numbers for places on lights.
fn pattern(seed: u64, pixel: u64, sample: u32) -> ([f64; 4], [f64; 2]) {
    // The sequence is good for 2^16 points; further samples start another one.
    let (block, index) = (sample >> 16, sample & 0xffff);
    let mut key = Stream::new(seed, Stage::March, pixel, u64::from(block) | 1 << 63);
    let scramble = (key.uniform() * f64::from(u32::MAX)) as u32;
    let place = sobol_burley::sample_4d(index, 0, scramble).map(f64::from);
    let light = [4, 5].map(|dimension| f64::from(sobol_burley::sample(index, dimension, scramble)));
    (place, light)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_grow_to_all_rays() {
        assert_eq!(passes(0).count(), 0);
        assert_eq!(passes(1).collect::<Vec<_>>(), [1]);
        assert_eq!(passes(16).collect::<Vec<_>>(), [1, 4, 16]);
        assert_eq!(passes(40).collect::<Vec<_>>(), [1, 4, 16, 40]);
        assert_eq!(passes(u32::MAX).last(), Some(u32::MAX));
    }
}
