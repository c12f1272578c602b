//! What a film holds of each pixel: radiance, coverage, features.

use glam::DVec3;

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

/// One pixel of a [`Film`](super::Film).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmPixel {
    /// Mean radiance, W/(m² sr), premultiplied by coverage: `R`, `G`, `B`.
    pub radiance: Rgb,
    /// The part of it that surfaces and the environment emit, seen without a mirror between: it has
    /// hardly any noise, and denoising leaves it out.
    pub visible_emission: Rgb,
    /// Coverage, 0 to 1: `A`.
    pub alpha: f64,
    /// Distance in metres to the first surface, or to where media before it have passed an opacity of one half, of the nearest
    /// ray; anything beyond [`FAR`], and infinity where neither is, is stored as [`FAR`]: `Z`.
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
    /// Its values in the order of [`LAYERS`].
    pub(super) fn values(&self) -> [f64; LAYERS.len()] {
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
pub(super) const LAYERS: [&str; 12] = [
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
