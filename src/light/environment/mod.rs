//! Light from very far all round.

mod gradient;
mod picture;

use std::f64::consts::PI;

use glam::DVec3;

use super::{EmissionTarget, LightSample, PhotonStart, checked_color};
use crate::math::{Ray, Rgb, is_grey, luminance, warp};

use gradient::Gradient;
use picture::Picture;

/// An environment: one radiance for all directions, a gradient over the elevation, or a
/// latitude-longitude picture, constant over each texel.
///
/// Row 0 of a picture is straight up (+y) and its rows are equal steps of the angle from there.
/// The middle of a row looks to +z, a quarter from the left to +x, its ends to -z, as in
/// Mitsuba's `envmap`: seen from inside, the picture is not mirrored. A rotation turns the
/// environment about +y, from +z toward +x.
#[derive(Debug, Clone)]
pub struct Environment(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Constant(Rgb),
    Gradient(Gradient),
    Picture(Picture),
}

impl Environment {
    /// The same `radiance`, in W/(m² sr), from all directions.
    ///
    /// # Errors
    /// Says what would be right where it is negative or not finite.
    pub fn constant(radiance: Rgb) -> Result<Self, String> {
        Ok(Self(Kind::Constant(checked_color("radiance", radiance)?)))
    }

    /// Radiance, in W/(m² sr), that goes with the elevation from stop to stop. A stop is an elevation in
    /// degrees, from -90, straight down, to 90, straight up (+y), and the radiance there. Stops go
    /// upward; two at one elevation make an edge. Beyond the first and the last one the radiance stays.
    ///
    /// Between stops the radiance is linear in the sine of the elevation, which is the y of a direction:
    /// it has no cusp straight up and down, where what is linear in the angle has one, and both the
    /// integral and the density of samples have closed forms.
    ///
    /// # Errors
    /// Says what would be right where there are fewer than two stops, an elevation is out of range or
    /// below the one before it, or a radiance is negative or not finite.
    pub fn gradient(stops: &[(f64, Rgb)]) -> Result<Self, String> {
        Gradient::new(stops).map(|gradient| Self(Kind::Gradient(gradient)))
    }

    /// The picture of `width` times `height` linear texels, row after row, times `scale` to give
    /// W/(m² sr), turned by `rotation` degrees. Negative values, which filtered pictures have,
    /// count as 0.
    ///
    /// # Errors
    /// Says what would be right where the size does not match, or a value is not finite.
    pub fn picture(
        width: usize,
        height: usize,
        texels: Vec<[f32; 3]>,
        scale: Rgb,
        rotation: f64,
    ) -> Result<Self, String> {
        Picture::new(width, height, texels, scale, rotation).map(|p| Self(Kind::Picture(p)))
    }

    /// Whether it shines alike from all sides.
    pub(super) const fn is_even(&self) -> bool {
        matches!(self.0, Kind::Constant(_))
    }

    /// Whether it shines alike in all channels.
    pub(super) fn is_grey(&self) -> bool {
        match &self.0 {
            Kind::Constant(radiance) => is_grey(*radiance),
            Kind::Gradient(gradient) => gradient.is_grey(),
            Kind::Picture(picture) => picture.is_grey(),
        }
    }

    /// Radiance in W/(m² sr) from the unit `direction` (from the viewer).
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        match &self.0 {
            Kind::Constant(radiance) => *radiance,
            Kind::Gradient(gradient) => gradient.radiance(direction.y),
            Kind::Picture(picture) => picture.radiance(direction),
        }
    }

    /// Irradiance in W/m² on a horizontal plane from above: the integral over the upper hemisphere
    /// of the radiance times the cosine from +y, exact for what [`radiance`](Self::radiance) gives.
    pub fn irradiance_up(&self) -> Rgb {
        match &self.0 {
            Kind::Constant(radiance) => *radiance * PI,
            Kind::Gradient(gradient) => gradient.irradiance_up(),
            Kind::Picture(picture) => picture.irradiance_up(),
        }
    }

    /// Integral of the radiance over all directions, W/m².
    fn integral(&self) -> Rgb {
        match &self.0 {
            Kind::Constant(radiance) => *radiance * (4.0 * PI),
            Kind::Gradient(gradient) => gradient.integral(),
            Kind::Picture(picture) => picture.integral(),
        }
    }

    /// A direction, its density and the radiance from there; nothing where all is black.
    fn toward(&self, u: [f64; 2]) -> Option<(DVec3, f64, Rgb)> {
        match &self.0 {
            Kind::Constant(radiance) => (*radiance != Rgb::ZERO)
                .then(|| (warp::uniform_sphere(u), warp::uniform_sphere_pdf(), *radiance)),
            Kind::Gradient(gradient) => gradient.toward(u),
            Kind::Picture(picture) => picture.toward(u),
        }
    }

    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        match &self.0 {
            Kind::Constant(radiance) if *radiance == Rgb::ZERO => 0.0,
            Kind::Constant(_) => warp::uniform_sphere_pdf(),
            Kind::Gradient(gradient) => gradient.pdf(direction.y),
            Kind::Picture(picture) => picture.pdf(direction),
        }
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> Option<LightSample> {
        let (direction, pdf, radiance) = self.toward(u)?;
        let distance = f64::INFINITY;
        Some(LightSample { direction, distance, radiance, pdf, delta: false, normal: None })
    }

    pub(super) fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        let (toward, pdf, radiance) = self.toward([u[0], u[1]])?;
        let (origin, place_pdf) = reach.start(-toward, [u[2], u[3]]);
        Some(PhotonStart { ray: Ray::new(origin, -toward), power: radiance / (pdf * place_pdf) })
    }

    pub(super) fn power(&self, reach: &EmissionTarget) -> Rgb {
        self.integral() * reach.disk_area()
    }

    pub(super) fn incident_estimate(&self) -> f64 {
        luminance(self.integral())
    }
}
