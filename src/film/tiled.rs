//! The film in tiles: samples, features and components of each pixel, until they are resolved into layers.

use std::iter;

use super::accumulator::Accumulator;
use super::aov_sums::{AovPixel, AovSums};
use super::components::{ComponentFilm, PixelComponents};
use super::feature_mean::FeatureMean;
use crate::image::{Features, Film, FilmPixel, Window};
use crate::math::GOLDEN_RATIO;

/// Edge of a tile in pixels. A tile is what one thread works on at a time.
///
/// Unit: pixels. Derivation: 256 rays are about a millisecond of work, a thousand times what handing out
/// a task takes.
const TILE: u32 = 16;

/// What is gathered for each pixel beside its samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct FilmContents {
    /// Features for a denoiser.
    pub features: bool,
    /// Components in halves, for reconstruction.
    pub components: bool,
    /// What passes follow from. Those of features need these as well.
    pub aovs: AovSums,
}

impl FilmContents {
    /// The same of pixels that are not in halves.
    #[must_use]
    pub fn undivided(self) -> Self {
        Self { components: false, aovs: AovSums { in_halves: false, ..self.aovs }, ..self }
    }
}

/// What pixels have gathered, in the order of [`TiledFilm::samples`].
#[derive(Debug, Default, PartialEq)]
pub struct FilmState {
    /// Samples.
    pub samples: Vec<Accumulator>,
    /// Features; empty where none are gathered.
    pub features: Vec<FeatureMean>,
    /// Components; empty where none are gathered.
    pub components: Vec<PixelComponents>,
    /// Sums of passes, as many numbers a pixel as [`TiledFilm::aovs`] tells.
    pub aovs: Vec<f64>,
    /// As [`TiledFilm::importance`].
    pub importance: Vec<Importance>,
}

/// How important a pixel is by a director that measures it while the film is exposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Importance {
    /// The XS-map, 0 to 1.
    pub xs: f32,
    /// Saliency, 0 to 1.
    pub saliency: f32,
}

/// A square of pixels, cut where the window ends.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Its pixels on the whole film.
    pub place: Window,
    /// Samples of its pixels, row by row.
    pub samples: Vec<Accumulator>,
    /// Features of its pixels, row by row; empty where none are gathered.
    pub features: Vec<FeatureMean>,
    /// Components of its pixels, row by row; empty where none are gathered.
    pub components: Vec<PixelComponents>,
    /// Sums of the passes of its pixels, row by row; empty where none are gathered.
    pub aovs: Vec<f64>,
}

/// A pixel of a tile.
#[derive(Debug)]
pub struct Pixel<'a> {
    /// Column on the whole film.
    pub x: u32,
    /// Row on the whole film, from the top.
    pub y: u32,
    /// Its samples.
    pub samples: &'a mut Accumulator,
    /// Its features, where they are gathered.
    pub features: Option<&'a mut FeatureMean>,
    /// Its components, where they are gathered.
    pub components: Option<&'a mut PixelComponents>,
    /// Sums of its passes; empty where none are gathered.
    pub aovs: &'a mut [f64],
}

impl Tile {
    /// Column and row on the whole film, and samples, of each pixel.
    pub fn pixels(&mut self) -> impl Iterator<Item = (u32, u32, &mut Accumulator)> {
        let Window { left, top, width, .. } = self.place;
        let place = move |index: u32| (left + index % width, top + index / width);
        (0..).map(place).zip(&mut self.samples).map(|((x, y), samples)| (x, y, samples))
    }

    /// Its pixels, with all that they gather.
    pub fn all_pixels(&mut self) -> impl Iterator<Item = Pixel<'_>> {
        let Window { left, top, width, .. } = self.place;
        let features = self.features.iter_mut().map(Some).chain(iter::repeat_with(|| None));
        let components = self.components.iter_mut().map(Some).chain(iter::repeat_with(|| None));
        let numbers = (self.aovs.len() / self.samples.len().max(1)).max(1);
        let aovs = self.aovs.chunks_exact_mut(numbers).chain(iter::repeat_with(Default::default));
        let pixels = (0..).zip(&mut self.samples).zip(features).zip(components).zip(aovs);
        pixels.map(move |((((index, samples), features), components), aovs)| Pixel {
            x: left + index % width,
            y: top + index / width,
            samples,
            features,
            components,
            aovs,
        })
    }
}

/// The pixels of a window, in tiles. Their order is scattered over the window, so that any run of tiles
/// costs about as much as any other: the time that is left follows from the time that went by.
#[derive(Clone, Debug)]
pub struct TiledFilm {
    /// The part of the film that is rendered.
    pub window: Window,
    /// The tiles in the order in which they are worked on.
    pub tiles: Vec<Tile>,
    /// Importance of each pixel of the whole film, row by row from the top; empty where it has not been measured.
    pub importance: Vec<Importance>,
    /// What its pixels gather for passes.
    pub aovs: AovSums,
}

impl TiledFilm {
    /// A film without samples, whose pixels gather `contents`.
    pub fn new(window: Window, contents: FilmContents) -> Self {
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
            let features = vec![FeatureMean::default(); if contents.features { pixels } else { 0 }];
            let components =
                vec![PixelComponents::default(); if contents.components { pixels } else { 0 }];
            let aovs = vec![0.0; pixels * contents.aovs.len()];
            Tile { place, samples, features, components, aovs }
        };
        let (tiles, aovs) = ((0..count).map(tile).collect(), contents.aovs);
        Self { window, tiles, importance: Vec::new(), aovs }
    }

    /// What the pixels in `window`, a part of its own, have gathered of `contents`.
    ///
    /// # Panics
    /// Where `window` has pixels that it has not.
    #[must_use]
    pub fn cut(self, window: Window, contents: FilmContents) -> Self {
        if window == self.window {
            return self;
        }
        let Window { left, top, width, .. } = self.window;
        let index = |x: u32, y: u32| ((y - top) * width + x - left) as usize;
        let mut places = vec![(0, 0); self.window.pixels() as usize];
        for (number, Tile { place, samples, .. }) in self.tiles.iter().enumerate() {
            for pixel in 0..samples.len() {
                let [across, down] = [pixel as u32 % place.width, pixel as u32 / place.width];
                places[index(place.left + across, place.top + down)] = (number, pixel);
            }
        }
        let mut part = Self::new(window, contents);
        for Pixel { x, y, samples, features, components, aovs } in
            part.tiles.iter_mut().flat_map(Tile::all_pixels)
        {
            let (number, pixel) = places[index(x, y)];
            let tile = &self.tiles[number];
            samples.clone_from(&tile.samples[pixel]);
            features.into_iter().for_each(|own| *own = tile.features[pixel]);
            components.into_iter().for_each(|own| *own = tile.components[pixel]);
            let numbers = pixel * aovs.len()..(pixel + 1) * aovs.len();
            aovs.copy_from_slice(&tile.aovs[numbers]);
        }
        Self { importance: self.importance, ..part }
    }

    /// Samples of each pixel, tile by tile.
    pub fn samples(&self) -> impl Iterator<Item = &Accumulator> {
        self.tiles.iter().flat_map(|tile| &tile.samples)
    }

    /// Features of each pixel, in the order of [`samples`](Self::samples).
    pub fn features(&self) -> impl Iterator<Item = &FeatureMean> {
        self.tiles.iter().flat_map(|tile| &tile.features)
    }

    /// Components of each pixel, in the order of [`samples`](Self::samples).
    pub fn components(&self) -> impl Iterator<Item = &PixelComponents> {
        self.tiles.iter().flat_map(|tile| &tile.components)
    }

    /// Sums of the passes of each pixel, in the order of [`samples`](Self::samples).
    pub fn aov_sums(&self) -> impl Iterator<Item = &f64> {
        self.tiles.iter().flat_map(|tile| &tile.aovs)
    }

    /// A copy without passes.
    #[must_use]
    pub fn without_aovs(&self) -> Self {
        let tile = |tile: &Tile| {
            let Tile { place, samples, features, components, .. } = tile;
            let (samples, features) = (samples.clone(), features.clone());
            Tile {
                place: *place,
                samples,
                features,
                components: components.clone(),
                aovs: Vec::new(),
            }
        };
        Self {
            window: self.window,
            tiles: self.tiles.iter().map(tile).collect(),
            importance: self.importance.clone(),
            aovs: AovSums::default(),
        }
    }

    /// Replaces all that pixels have gathered.
    pub fn restore(&mut self, state: FilmState) {
        let FilmState { samples, features, components, aovs, importance } = state;
        self.importance = importance;
        let (mut samples, mut features) = (samples.into_iter(), features.into_iter());
        let (mut components, mut aovs) = (components.into_iter(), aovs.into_iter());
        for tile in &mut self.tiles {
            tile.samples.iter_mut().zip(&mut samples).for_each(|(pixel, known)| *pixel = known);
            tile.features.iter_mut().zip(&mut features).for_each(|(pixel, known)| *pixel = known);
            let pixels = tile.components.iter_mut().zip(&mut components);
            pixels.for_each(|(pixel, known)| *pixel = known);
            tile.aovs.iter_mut().zip(&mut aovs).for_each(|(sum, known)| *sum = known);
        }
    }

    /// The components of all pixels, row by row from the top, where they are gathered.
    pub fn component_film(&self) -> ComponentFilm {
        let Window { left, top, width, .. } = self.window;
        let mut pixels = vec![PixelComponents::default(); self.window.pixels() as usize];
        for Tile { place, components, .. } in &self.tiles {
            for (index, of_pixel) in (0..).zip(components) {
                let [x, y] = [place.left + index % place.width, place.top + index / place.width];
                pixels[((y - top) * width + x - left) as usize] = *of_pixel;
            }
        }
        ComponentFilm { width: width as usize, pixels, parts: Vec::new() }
    }

    /// Resolves the samples into layers of a film that is a part of one of the size `full` (width, height):
    /// `pixel` makes a pixel of its column, row and samples. Returns the components as well, where they are gathered.
    pub fn resolve(
        mut self,
        full: [u32; 2],
        pixel: impl Fn(u32, u32, &Accumulator) -> FilmPixel,
    ) -> (Film, Option<ComponentFilm>) {
        let mut film = Film::part(full, self.window);
        let Window { left, top, width, .. } = self.window;
        let width = width as usize;
        let mut means = vec![Features::default(); self.features().count()];
        let mut pixels = vec![PixelComponents::default(); self.components().count()];
        let layout = self.aovs;
        let mut parts = layout.light_parts(self.window.pixels() as usize);
        let mut passes: Vec<_> = layout
            .layers()
            .into_iter()
            .map(|name| (name, vec![0.0; self.window.pixels() as usize]))
            .collect();
        for tile in &mut self.tiles {
            for Pixel { x, y, samples, features, components, aovs } in tile.all_pixels() {
                let (column, row) = ((x - left) as usize, (y - top) as usize);
                let resolved = pixel(x, y, samples);
                film.set(column, row, &resolved);
                let features = features.map(|features| features.mean());
                if let Some(features) = features {
                    means[row * width + column] = features;
                }
                let of_pixel = AovPixel {
                    sums: aovs,
                    rays: samples.count(),
                    mean: samples.mean(),
                    shown: resolved.radiance,
                    features: features.unwrap_or_default(),
                };
                for ((_, plane), value) in passes.iter_mut().zip(layout.values(&of_pixel)) {
                    plane[row * width + column] = value as f32;
                }
                if !parts.is_empty() {
                    let (index, rays) = (row * width + column, samples.count());
                    layout.set_light_parts(&mut parts, index, aovs, rays);
                }
                if let Some(components) = components {
                    pixels[row * width + column] = *components;
                }
            }
            (tile.samples, tile.features, tile.components) = (Vec::new(), Vec::new(), Vec::new());
            tile.aovs = Vec::new();
        }
        film.set_passes(passes);
        if !means.is_empty() {
            film.set_features(means);
        }
        let components = (!pixels.is_empty()).then_some(ComponentFilm { width, pixels, parts });
        (film, components)
    }
}

/// A stride that visits each of `count` tiles once: near the golden section of `count`, whose multiples are
/// spread evenly, and without a common divisor.
fn stride(count: u64) -> u64 {
    let near = ((count as f64 * (GOLDEN_RATIO - 1.0)) as u64).max(1);
    (near..).find(|&stride| gcd(stride, count) == 1).unwrap_or(1)
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Sample;
    use crate::math::Rgb;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tiles_cover_the_window_once(
            left in 0_u32..40, top in 0_u32..40, width in 1_u32..90, height in 1_u32..90,
        ) {
            let window = Window { left, top, width, height };
            let mut seen = vec![0; window.pixels() as usize];
            for tile in &mut TiledFilm::new(window, FilmContents::default()).tiles {
                for (x, y, _) in tile.pixels() {
                    seen[((y - top) * width + x - left) as usize] += 1;
                }
            }
            prop_assert!(seen.iter().all(|count| *count == 1));
        }
    }

    #[test]
    fn a_part_has_the_samples_of_its_pixels() {
        let contents = FilmContents { components: true, ..FilmContents::default() };
        let mut whole = TiledFilm::new(Window { left: 3, top: 2, width: 50, height: 40 }, contents);
        let light = |x: u32, y: u32| Rgb::splat(f64::from(100 * x + y));
        for pixel in whole.tiles.iter_mut().flat_map(Tile::all_pixels) {
            let sample = Sample { radiance: light(pixel.x, pixel.y), ..Sample::default() };
            pixel.samples.add(sample);
            pixel.components.unwrap().add(0, &sample);
        }
        let window = Window { left: 7, top: 9, width: 37, height: 20 };
        let mut part = whole.cut(window, contents);
        assert_eq!(part.window, window);
        for pixel in part.tiles.iter_mut().flat_map(Tile::all_pixels) {
            assert_eq!(pixel.samples.mean(), light(pixel.x, pixel.y));
            assert_eq!(
                f64::from(pixel.components.unwrap().halves[0].radiance.x),
                light(pixel.x, pixel.y).x
            );
        }
    }

    #[test]
    fn any_run_of_tiles_is_spread_over_the_film() {
        let tiles = TiledFilm::new(Window::whole([640, 480]), FilmContents::default()).tiles;
        let mean = |run: &[Tile]| {
            run.iter().map(|t| f64::from(t.place.top)).sum::<f64>() / run.len() as f64
        };
        for run in tiles.chunks_exact(60) {
            assert!((mean(run) - mean(&tiles)).abs() < 48.0, "{}", mean(run));
        }
    }
}
