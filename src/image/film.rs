//! The film: the layers and features of a picture.

use std::ops::AddAssign;

use glam::DVec3;

use super::{Image, Window, fill};
use crate::math::Rgb;

/// The depth, in metres, that stands for "nothing hit" in a stored Z layer: far behind everything,
/// yet finite. Blender writes the same value.
pub const FAR: f64 = 1e10;

/// Features of a ray or a pixel: properties of what it sees that do not depend on light, by which a
/// denoiser finds edges. Values are linear; directions lie in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features {
    /// Albedo of what is seen, in [0, 1] per channel; 0 where nothing is.
    pub albedo: [f32; 3],
    /// Shading normal of the surfaces seen, on the camera's side, each weighted by how much is seen of
    /// it: at most of length 1, and 0 where there is none.
    pub normal: [f32; 3],
}

impl Features {
    /// Features rounded to f32.
    pub fn new(albedo: Rgb, normal: DVec3) -> Self {
        Self { albedo: albedo.as_vec3().to_array(), normal: normal.as_vec3().to_array() }
    }

    /// Whether all values are finite.
    pub fn is_finite(&self) -> bool {
        self.albedo.iter().chain(&self.normal).all(|value| value.is_finite())
    }
}

/// One pixel of a [`Film`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmPixel {
    /// Mean radiance, W/(m² sr), premultiplied by coverage: `R`, `G`, `B`.
    pub radiance: Rgb,
    /// The part of it that surfaces and the environment emit, seen without a mirror between: it has
    /// hardly any noise, and denoising leaves it out.
    pub visible_emission: Rgb,
    /// Coverage, 0 to 1: `A`.
    pub alpha: f64,
    /// Distance to the first surface in metres; anything beyond [`FAR`], and infinity where nothing
    /// is hit, is stored as [`FAR`]: `Z`.
    pub depth: f64,
    /// Transmittance to the first surface, the X-map's: `transmittance`.
    pub transmittance: f64,
    /// Saliency, 0 to 1: `saliency`.
    pub saliency: f64,
    /// The XS-map, 0 to 1: `xs`.
    pub xs: f64,
    /// Camera rays shot: `rays`.
    pub rays: f64,
    /// Gather radius in metres: `radius`.
    pub radius: f64,
    /// March step in metres: `step`.
    pub step: f64,
    /// Variance of the mean luminance, radiance squared: `variance`.
    pub variance: f64,
}

impl Default for FilmPixel {
    /// Black, empty and nothing hit.
    fn default() -> Self {
        Self {
            radiance: Rgb::ZERO,
            visible_emission: Rgb::ZERO,
            alpha: 0.0,
            depth: f64::INFINITY,
            transmittance: 0.0,
            saliency: 0.0,
            xs: 0.0,
            rays: 0.0,
            radius: 0.0,
            step: 0.0,
            variance: 0.0,
        }
    }
}

impl FilmPixel {
    fn values(&self) -> [f64; LAYERS.len()] {
        let depth = if self.depth.is_nan() { self.depth } else { self.depth.min(FAR) };
        [
            self.radiance.x,
            self.radiance.y,
            self.radiance.z,
            self.alpha,
            depth,
            self.transmittance,
            self.saliency,
            self.xs,
            self.rays,
            self.radius,
            self.step,
            self.variance,
        ]
    }
}

/// The names of the film's layers, in the order of [`FilmPixel::values`].
const LAYERS: [&str; 12] = [
    "R",
    "G",
    "B",
    "A",
    "Z",
    "transmittance",
    "saliency",
    "xs",
    "rays",
    "radius",
    "step",
    "variance",
];

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

    /// Gives each pixel for which `known` is false, row by row from the top, what is seen in the
    /// nearest one for which it is true: `R`, `G`, `B`, `A`, `Z`, `transmittance` and features. Its
    /// other layers stay; so does all where nothing is known.
    ///
    /// # Panics
    /// Where there are not as many as pixels.
    pub fn fill(&mut self, known: &[bool]) {
        assert_eq!(known.len(), self.pixels(), "one a pixel");
        let Some(nearest) = fill::nearest(self.width(), known) else { return };
        let others = self.others.iter_mut().map(Vec::as_mut_slice);
        for layer in self.radiance.chunks_exact_mut(known.len()).chain(others).take(SEEN) {
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
        self.layers().find_map(|(known, values)| (known == name).then_some(values))
    }

    /// All layers with their names.
    pub fn layers(&self) -> impl Iterator<Item = (&'static str, &[f32])> {
        let kept = NOISY_LAYERS.into_iter().zip(self.noisy.chunks_exact(self.pixels()));
        let others = self.others.iter().map(Vec::as_slice);
        let all = self.radiance.chunks_exact(self.pixels()).chain(others);
        LAYERS.into_iter().zip(all).chain(kept)
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
