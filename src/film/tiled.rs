//! What rays have left so far, pixel by pixel, before it becomes a film.

use std::iter;

use crate::image::{Accumulator, FeatureMean, Features, Film, FilmPixel, Window};

/// Edge of the square of pixels that is one piece of work.
const TILE: u32 = 16;

/// A square of pixels, cut where the window ends.
#[derive(Debug)]
pub struct Tile {
    /// Its place on the whole film.
    pub place: Window,
    /// What its pixels have, row by row.
    pub samples: Vec<Accumulator>,
    /// What the rays of each see; empty where that is not asked for.
    pub features: Vec<FeatureMean>,
}

/// A pixel with its place on the whole film.
#[derive(Debug)]
pub struct Pixel<'a> {
    /// Column on the whole film.
    pub x: u32,
    /// Row on the whole film, from the top.
    pub y: u32,
    /// What its rays brought.
    pub samples: &'a mut Accumulator,
    /// What they see, where that is asked for.
    pub features: Option<&'a mut FeatureMean>,
}

impl Tile {
    /// Its pixels with their places on the whole film.
    pub fn pixels(&mut self) -> impl Iterator<Item = (u32, u32, &mut Accumulator)> {
        let Window { left, top, width, .. } = self.place;
        let place = move |index: u32| (left + index % width, top + index / width);
        (0..).map(place).zip(&mut self.samples).map(|((x, y), samples)| (x, y, samples))
    }

    /// All that its pixels have.
    pub fn all_pixels(&mut self) -> impl Iterator<Item = Pixel<'_>> {
        let Window { left, top, width, .. } = self.place;
        let features = self.features.iter_mut().map(Some).chain(iter::repeat_with(|| None));
        let pixels = (0..).zip(&mut self.samples).zip(features);
        pixels.map(move |((index, samples), features)| Pixel {
            x: left + index % width,
            y: top + index / width,
            samples,
            features,
        })
    }
}

/// The pixels of a window, in tiles. Their order scatters neighbours, so that any run of tiles looks
/// like all of them: how long it took tells how long the rest will.
#[derive(Debug)]
pub struct TiledFilm {
    /// What part of the film they are of.
    pub window: Window,
    /// The tiles in the order in which they are worked on.
    pub tiles: Vec<Tile>,
}

impl TiledFilm {
    /// Nothing yet for the pixels of `window`; `features` says whether they take in what rays see.
    pub fn new(window: Window, features: bool) -> Self {
        let [across, down] = [window.width, window.height].map(|side| side.div_ceil(TILE));
        let count = u64::from(across) * u64::from(down);
        let stride = stride(count);
        let tile = |index: u64| {
            let number = (u128::from(index) * u128::from(stride) % u128::from(count)) as u64;
            let [x, y] = [number % u64::from(across), number / u64::from(across)]
                .map(|tiles| tiles as u32 * TILE);
            let (width, height) = (TILE.min(window.width - x), TILE.min(window.height - y));
            let place = Window { left: window.left + x, top: window.top + y, width, height };
            let pixels = place.pixels() as usize;
            let samples = vec![Accumulator::default(); pixels];
            let features = vec![FeatureMean::default(); if features { pixels } else { 0 }];
            Tile { place, samples, features }
        };
        Self { window, tiles: (0..count).map(tile).collect() }
    }

    /// What each pixel has, tile by tile.
    pub fn samples(&self) -> impl Iterator<Item = &Accumulator> {
        self.tiles.iter().flat_map(|tile| &tile.samples)
    }

    /// What the rays of each pixel see, in the order of [`samples`](Self::samples).
    pub fn features(&self) -> impl Iterator<Item = &FeatureMean> {
        self.tiles.iter().flat_map(|tile| &tile.features)
    }

    /// Replaces what each pixel has, in the order of [`samples`](Self::samples), and what its rays see.
    pub fn restore(
        &mut self,
        samples: impl IntoIterator<Item = Accumulator>,
        features: impl IntoIterator<Item = FeatureMean>,
    ) {
        let (mut samples, mut features) = (samples.into_iter(), features.into_iter());
        for tile in &mut self.tiles {
            tile.samples.iter_mut().zip(&mut samples).for_each(|(pixel, known)| *pixel = known);
            tile.features.iter_mut().zip(&mut features).for_each(|(pixel, known)| *pixel = known);
        }
    }

    /// The film, a part of one of the size `full`; `pixel` makes a pixel of its place and samples.
    pub fn resolve(
        mut self,
        full: [u32; 2],
        pixel: impl Fn(u32, u32, &Accumulator) -> FilmPixel,
    ) -> Film {
        let mut film = Film::part(full, self.window);
        let Window { left, top, width, .. } = self.window;
        let told = self.features().count();
        let mut shown = vec![Features::default(); told];
        for tile in &mut self.tiles {
            for Pixel { x, y, samples, features } in tile.all_pixels() {
                let pixel = pixel(x, y, samples);
                let (column, row) = ((x - left) as usize, (y - top) as usize);
                film.set(column, row, &pixel);
                if let Some(features) = features {
                    shown[row * width as usize + column] = features.mean();
                }
            }
            (tile.samples, tile.features) = (Vec::new(), Vec::new());
        }
        if told > 0 {
            film.set_features(shown);
        }
        film
    }
}

/// A number near the golden section of `count` that has no divisor in common with it.
fn stride(count: u64) -> u64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let near = ((count as f64 * GOLDEN) as u64).max(1);
    (near..).find(|&stride| gcd(stride, count) == 1).unwrap_or(1)
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tiles_cover_the_window_once(
            left in 0_u32..40, top in 0_u32..40, width in 1_u32..90, height in 1_u32..90,
        ) {
            let window = Window { left, top, width, height };
            let mut seen = vec![0; window.pixels() as usize];
            for tile in &mut TiledFilm::new(window, false).tiles {
                for (x, y, _) in tile.pixels() {
                    seen[((y - top) * width + x - left) as usize] += 1;
                }
            }
            prop_assert!(seen.iter().all(|count| *count == 1));
        }
    }

    #[test]
    fn any_run_of_tiles_is_spread_over_the_film() {
        let tiles = TiledFilm::new(Window::whole([640, 480]), false).tiles;
        let mean = |run: &[Tile]| {
            run.iter().map(|t| f64::from(t.place.top)).sum::<f64>() / run.len() as f64
        };
        for run in tiles.chunks_exact(60) {
            assert!((mean(run) - mean(&tiles)).abs() < 48.0, "{}", mean(run));
        }
    }
}
