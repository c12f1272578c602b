//! From rays to the film: pixels, their samples and their budget.

use rayon::prelude::*;

use crate::director::Budget;
use crate::image::{Accumulator, Film, FilmPixel, Sample};
use crate::math::{Ray, Stage, Stream, World, luminance};
use crate::medium::Profile;
use crate::scene::lighting::Draws;
use crate::scene::plan::Needs;
use crate::work::Work;

use super::Progress;

/// Edge of the square of pixels that is one piece of work.
const TILE: u32 = 16;

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
}

/// What is exposed.
#[derive(Debug, Clone, Copy)]
pub struct Sheet {
    /// Width and height of the film in pixels.
    pub size: [u32; 2],
    /// Seed of the random streams.
    pub seed: u64,
    /// What they are drawn for.
    pub stage: Stage,
    /// What rays need.
    pub needs: Needs,
}

/// Exposes the film of `sheet`: `camera` aims a ray through a place on it and on the lens, `direct`
/// says what the pixel (x, y) may spend, `estimate` what one ray brings. Pixels are sampled with an
/// Owen-scrambled Sobol sequence (Burley 2020) over a box filter; the samples of a pixel depend on
/// nothing but the seed, the pixel and their number.
pub fn expose(
    sheet: Sheet,
    camera: impl Fn(f64, f64, [f64; 2]) -> Ray<World> + Sync,
    direct: impl Fn(u32, u32) -> Direction + Sync,
    estimate: impl Fn(Ray<World>, &Budget, &mut State) -> Sample + Sync,
    progress: &dyn Progress,
) -> (Film, Work) {
    let Sheet { size: [width, height], seed, stage, needs } = sheet;
    let across = width.div_ceil(TILE);
    let tiles = u64::from(across) * u64::from(height.div_ceil(TILE));
    progress.stage("rays", u64::from(width) * u64::from(height));
    let pixel = |x: u32, y: u32, state: &mut State| {
        let Direction { budget, saliency, xs } = direct(x, y);
        let index = u64::from(y) * u64::from(width) + u64::from(x);
        let mut samples = Accumulator::default();
        for sample in 0..budget.rays {
            if sample >= budget.least && is_settled(&samples, budget.tolerance) {
                break;
            }
            state.draws.rng = Stream::new(seed, stage, index, u64::from(sample));
            let ([u, v, a, b], even) = pattern(seed, index, sample);
            state.draws.even = Some(even);
            let ray = camera(f64::from(x) + u, f64::from(y) + v, [a, b]);
            state.draws.work.rays += 1;
            state.shared = shared(sample, budget.rays, budget.gathers);
            samples.add(estimate(ray, &budget, state));
        }
        state.draws.work.dropped_samples += samples.dropped();
        let (radius, step) = (budget.radius, budget.step);
        FilmPixel { saliency, xs, radius, step, ..FilmPixel::from(&samples) }
    };
    let done: Vec<(Vec<FilmPixel>, Work)> = (0..tiles)
        .into_par_iter()
        .map(|tile| {
            let (left, top) = corner(tile, across);
            let (right, bottom) = ((left + TILE).min(width), (top + TILE).min(height));
            let mut state = State {
                draws: Draws::new(Stream::new(seed, stage, 0, 0), needs),
                profile: Profile::default(),
                shared: 1.0,
            };
            let places = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
            let pixels: Vec<_> = places.map(|(x, y)| pixel(x, y, &mut state)).collect();
            progress.advance(pixels.len() as u64);
            (pixels, state.draws.work)
        })
        .collect();
    progress.finish();
    let mut film = Film::new(width as usize, height as usize);
    let mut work = Work::default();
    for (tile, (pixels, tile_work)) in (0..).zip(done) {
        let (left, top) = corner(tile, across);
        let columns = (left + TILE).min(width) - left;
        film.set_tile(left as usize, top as usize, columns as usize, &pixels);
        work += tile_work;
    }
    (film, work)
}

/// What light that varies little counts along a ray of a pixel, so that `gathers` rays, spread
/// evenly, stand in for all.
fn shared(sample: u32, rays: u32, gathers: u32) -> f64 {
    if rays <= gathers {
        return 1.0;
    }
    let group = |i: u32| u64::from(i) * u64::from(gathers) / u64::from(rays);
    if sample == 0 || group(sample) != group(sample - 1) {
        f64::from(rays) / f64::from(gathers)
    } else {
        0.0
    }
}

/// Whether the standard error of a pixel is at most `tolerance` of its mean. A pixel without light
/// is not: a rare path may still bring some.
fn is_settled(samples: &Accumulator, tolerance: f64) -> bool {
    let mean = luminance(samples.mean());
    mean > 0.0 && samples.luminance_variance().sqrt() <= tolerance * mean
}

/// Upper left pixel of a tile.
fn corner(tile: u64, across: u32) -> (u32, u32) {
    let across = u64::from(across);
    ((tile % across) as u32 * TILE, (tile / across) as u32 * TILE)
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
