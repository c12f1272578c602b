//! The film: the layers and features of a picture.

use std::ops::AddAssign;

use super::film_pixel::{Features, FilmPixel, LAYERS};
use super::{Image, Window, fill};

/// How many of them are radiance.
const RADIANCE: usize = 3;

/// The names of the layers that hold the noisy picture of a denoised film.
pub const NOISY_LAYERS: [&str; 3] = ["noisy.R", "noisy.G", "noisy.B"];

/// How many of [`LAYERS`], from the first on, show what is seen.
const SEEN: usize = 6;

/// Layers of f32, one value per pixel each, all of them finite. A film may be a part of a larger one:
/// its pixels are then counted from its own corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    window: Window,
    full: [u32; 2],
    /// The first [`RADIANCE`] layers, one plane of pixels after another.
    radiance: Vec<f32>,
    /// The others, in the order of [`LAYERS`].
    others: Vec<Vec<f32>>,
    /// The part of each pixel's radiance that is emission seen directly.
    visible_emission: Vec<[f32; 3]>,
    /// Planes of what was seen before noise was taken off; empty where it is still there.
    noisy: Vec<f32>,
    /// Features of each pixel; empty where none were gathered.
    features: Vec<Features>,
    /// Passes that were asked for, each layer with its name.
    passes: Vec<(String, Vec<f32>)>,
    /// The denoiser, where the film is denoised.
    denoiser: Option<String>,
    /// Whether it was reconstructed from its components.
    reconstructed: bool,
    repaired: u64,
}

impl Film {
    /// Bytes of a pixel in its layers.
    pub const LAYER_BYTES: usize = size_of::<[f32; LAYERS.len()]>();

    /// Bytes of a pixel in memory, without features and the layers of a denoised film.
    pub const PIXEL_BYTES: usize = Self::LAYER_BYTES + size_of::<[f32; 3]>();

    /// A film of default pixels.
    ///
    /// # Panics
    /// Where it would have no pixel.
    pub fn new(width: usize, height: usize) -> Self {
        let full = [width as u32, height as u32];
        Self::part(full, Window::whole(full))
    }

    /// The `window` of a film of the size `full`, of default pixels.
    ///
    /// # Panics
    /// Where it would have no pixel or reach beyond the film.
    pub fn part(full: [u32; 2], window: Window) -> Self {
        assert!(window.fits(full), "{window} of a film of {full:?} pixels");
        let pixels = window.width as usize * window.height as usize;
        let values = FilmPixel::default().values();
        let (radiance, others) = values.split_at(RADIANCE);
        let plane = |value: &f64| vec![*value as f32; pixels];
        Self {
            window,
            full,
            radiance: radiance.iter().map(plane).collect::<Vec<_>>().concat(),
            others: others.iter().map(plane).collect(),
            visible_emission: vec![[0.0; 3]; pixels],
            noisy: Vec::new(),
            features: Vec::new(),
            passes: Vec::new(),
            denoiser: None,
            reconstructed: false,
            repaired: 0,
        }
    }

    /// Where the film lies on the one that it is part of; all of it where it is whole.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Width and height of the film that it is part of.
    pub fn full_size(&self) -> [u32; 2] {
        self.full
    }

    /// The part of it that lies in `window` of the film that it is part of.
    ///
    /// # Panics
    /// Where that has pixels which it has not.
    #[must_use]
    pub fn cut(self, window: Window) -> Self {
        if window == self.window {
            return self;
        }
        let own = self.window;
        let planes = |layers: &[f32]| -> Vec<f32> {
            let planes = layers.chunks_exact(self.pixels());
            planes.flat_map(|plane| window.cut(plane, own)).collect()
        };
        let has_features = !self.features.is_empty();
        Self {
            window,
            radiance: planes(&self.radiance),
            others: self.others.iter().map(|plane| window.cut(plane, own)).collect(),
            visible_emission: window.cut(&self.visible_emission, own),
            noisy: planes(&self.noisy),
            features: if has_features { window.cut(&self.features, own) } else { Vec::new() },
            passes: self
                .passes
                .iter()
                .map(|(name, plane)| (name.clone(), window.cut(plane, own)))
                .collect(),
            ..self
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.window.width as usize
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.window.height as usize
    }

    fn pixels(&self) -> usize {
        self.visible_emission.len()
    }

    /// Sets the pixel in column `x` from the left and row `y` from the top. A NaN becomes 0 and an
    /// infinity the nearest f32, and [`repaired`](Self::repaired) counts them.
    ///
    /// # Panics
    /// Where the pixel lies outside the film.
    pub fn set(&mut self, x: usize, y: usize, pixel: &FilmPixel) {
        assert!(x < self.width() && y < self.height(), "pixel {x}, {y}");
        let (index, pixels) = (y * self.width() + x, self.pixels());
        for (layer, value) in pixel.values().into_iter().enumerate() {
            let value = finite(value, &mut self.repaired);
            match layer.checked_sub(RADIANCE) {
                None => self.radiance[layer * pixels + index] = value,
                Some(other) => self.others[other][index] = value,
            }
        }
        self.visible_emission[index] =
            pixel.visible_emission.to_array().map(|value| finite(value, &mut self.repaired));
    }

    /// Sets a block of pixels, row by row, whose upper left corner is at `x`, `y`.
    ///
    /// # Panics
    /// Where the block does not lie inside the film or `pixels` is not whole rows of `width`.
    pub fn set_tile(&mut self, x: usize, y: usize, width: usize, pixels: &[FilmPixel]) {
        assert!(width > 0 && pixels.len().is_multiple_of(width), "whole rows of {width} pixels");
        for (row, line) in pixels.chunks_exact(width).enumerate() {
            for (column, pixel) in line.iter().enumerate() {
                self.set(x + column, y + row, pixel);
            }
        }
    }

    /// Sets the features of each pixel, row by row from the top.
    ///
    /// # Panics
    /// Where there are not as many as pixels.
    pub fn set_features(&mut self, features: Vec<Features>) {
        assert_eq!(features.len(), self.visible_emission.len(), "one a pixel");
        self.features = features;
    }

    /// Features of each pixel, row by row from the top; empty where none were gathered.
    pub fn features(&self) -> &[Features] {
        &self.features
    }

    /// Sets the layers of passes, each with its name and values row by row from the top. Values that are not finite are
    /// replaced as by [`set`](Self::set).
    ///
    /// # Panics
    /// Where a layer has not one value a pixel.
    pub fn set_passes(&mut self, mut passes: Vec<(String, Vec<f32>)>) {
        for (name, plane) in &mut passes {
            assert_eq!(plane.len(), self.pixels(), "{name}: one a pixel");
            plane.iter_mut().for_each(|value| *value = finite((*value).into(), &mut self.repaired));
        }
        self.passes = passes;
    }

    /// Replaces the layer of a pass of this name, where there is one, by the `value` of each pixel, row by row from the top;
    /// pixels without a value keep theirs. Values that are not finite are replaced as by [`set`](Self::set).
    pub fn replace_pass(&mut self, name: &str, value: impl Fn(usize) -> Option<f64>) {
        let planes = self.passes.iter_mut().filter(|(known, _)| known == name);
        for (index, pixel) in planes.flat_map(|(_, plane)| plane.iter_mut().enumerate()) {
            if let Some(value) = value(index) {
                *pixel = finite(value, &mut self.repaired);
            }
        }
    }

    /// The layers of passes with their names.
    pub fn passes(&self) -> impl Iterator<Item = (&str, &[f32])> {
        self.passes.iter().map(|(name, plane)| (name.as_str(), plane.as_slice()))
    }

    /// Gives each pixel for which `known` is false, row by row from the top, what is seen in the
    /// nearest one for which it is true: `R`, `G`, `B`, `A`, `Z`, `transmittance`, features and passes. Its
    /// other layers stay; so does all where nothing is known.
    ///
    /// # Panics
    /// Where there are not as many as pixels.
    pub fn fill(&mut self, known: &[bool]) {
        assert_eq!(known.len(), self.pixels(), "one a pixel");
        let Some(nearest) = fill::nearest(self.width(), known) else { return };
        let others = self.others.iter_mut().map(Vec::as_mut_slice);
        let seen = self.radiance.chunks_exact_mut(known.len()).chain(others).take(SEEN);
        for layer in seen.chain(self.passes.iter_mut().map(|(_, plane)| plane.as_mut_slice())) {
            // What is known is its own nearest, and stays.
            for (index, &from) in nearest.iter().enumerate() {
                layer[index] = layer[from as usize];
            }
        }
        for (index, &from) in nearest.iter().enumerate() {
            self.visible_emission[index] = self.visible_emission[from as usize];
            if !self.features.is_empty() {
                self.features[index] = self.features[from as usize];
            }
        }
    }

    /// Replaces the picture by `image`, which `denoiser` made; the noisy one stays in `noisy.R`, `noisy.G`
    /// and `noisy.B`.
    ///
    /// # Panics
    /// Where it has another size.
    pub fn set_denoised(&mut self, image: &Image, denoiser: &str) {
        self.replace(image);
        self.denoiser = Some(denoiser.into());
    }

    /// As [`set_denoised`](Self::set_denoised), by an `image` that was reconstructed from components.
    ///
    /// # Panics
    /// Where it has another size.
    pub fn set_reconstructed(&mut self, image: &Image) {
        self.replace(image);
        self.reconstructed = true;
    }

    fn replace(&mut self, image: &Image) {
        assert_eq!([image.width(), image.height()], [self.width(), self.height()], "its size");
        let clean = image.channels();
        let radiance = self.radiance.iter_mut();
        let clean = clean.iter().flat_map(|channel| channel.iter());
        let repaired = &mut self.repaired;
        let replace =
            |(old, new): (&mut f32, &f32)| std::mem::replace(old, finite((*new).into(), repaired));
        self.noisy = radiance.zip(clean).map(replace).collect();
    }

    /// Whether it was reconstructed from its components.
    pub const fn is_reconstructed(&self) -> bool {
        self.reconstructed
    }

    /// The denoiser with its version, where the film is denoised.
    pub fn denoiser(&self) -> Option<&str> {
        self.denoiser.as_deref()
    }

    /// How many values were not finite and had to be replaced. 0 in a sound render.
    pub fn repaired(&self) -> u64 {
        self.repaired
    }

    /// The layer of that name, row by row from the top.
    pub fn layer(&self, name: &str) -> Option<&[f32]> {
        self.all_layers().find_map(|(known, values)| (known == name).then_some(values))
    }

    /// All layers but those of passes, with their names.
    pub fn layers(&self) -> impl Iterator<Item = (&'static str, &[f32])> {
        let kept = NOISY_LAYERS.into_iter().zip(self.noisy.chunks_exact(self.pixels()));
        let others = self.others.iter().map(Vec::as_slice);
        let all = self.radiance.chunks_exact(self.pixels()).chain(others);
        LAYERS.into_iter().zip(all).chain(kept)
    }

    /// All layers with their names, those of passes last.
    pub fn all_layers(&self) -> impl Iterator<Item = (&str, &[f32])> {
        let own = self.layers().map(|(name, values): (&str, &[f32])| (name, values));
        own.chain(self.passes())
    }

    /// `R`, `G` and `B`, one plane of rows from the top after another.
    pub fn radiance(&self) -> &[f32] {
        &self.radiance
    }

    /// [`FilmPixel::visible_emission`] of each pixel, row by row from the top.
    pub fn visible_emission(&self) -> &[[f32; 3]] {
        &self.visible_emission
    }

    /// The picture: `R`, `G`, `B` as they are, that is before black.
    pub fn image(&self) -> Image {
        let mut planes = self.radiance.chunks_exact(self.pixels());
        let [r, g, b] = std::array::from_fn(|_| planes.next().unwrap_or_default());
        let pixels = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]).collect();
        Image::new(self.width(), self.height(), pixels)
    }
}

fn finite(value: f64, repaired: &mut u64) -> f32 {
    repaired.add_assign(u64::from(!value.is_finite()));
    if value.is_nan() { 0.0 } else { value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32 }
}
