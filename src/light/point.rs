//! A light that shines from one place in all directions.

use std::f64::consts::PI;

use glam::DVec3;

use super::aim::{Aim, Lobe};
use super::{EmissionTarget, LightSample, PhotonStart, checked_color, checked_place};
use crate::math::{Ray, Rgb, WorldPoint, luminance, warp};

/// A point light.
#[derive(Debug, Clone, Copy)]
pub struct PointLight {
    position: WorldPoint,
    intensity: Rgb,
}

impl PointLight {
    /// At `position`, of this intensity in W/sr.
    ///
    /// # Errors
    /// Says what would be right where a value is not finite or the intensity negative.
    pub fn new(position: WorldPoint, intensity: Rgb) -> Result<Self, String> {
        Ok(Self {
            position: checked_place("position", position)?,
            intensity: checked_color("intensity", intensity)?,
        })
    }

    /// At `position`, of this power in W over all directions.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_power(position: WorldPoint, power: Rgb) -> Result<Self, String> {
        Self::new(position, checked_color("power", power)? / (4.0 * PI))
    }

    /// Intensity in W/sr.
    pub(super) const fn intensity(&self) -> Rgb {
        self.intensity
    }

    /// Where it stands.
    pub(super) const fn position(&self) -> WorldPoint {
        self.position
    }

    pub(super) fn sample(&self, at: WorldPoint) -> Option<LightSample> {
        delta_sample(self.position, at, |_| self.intensity)
    }

    pub(super) fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        let (direction, pdf) = Aim::new(reach, self.position, &Everywhere).sample([u[0], u[1]])?;
        Some(PhotonStart { ray: Ray::new(self.position, direction), power: self.intensity / pdf })
    }

    pub(super) fn power_toward(&self, reach: &EmissionTarget) -> Rgb {
        self.intensity * (4.0 * PI * Aim::new(reach, self.position, &Everywhere).share())
    }

    pub(super) fn incident_estimate(&self, at: WorldPoint) -> f64 {
        delta_estimate(self.position, at, self.intensity)
    }
}

struct Everywhere;

impl Lobe for Everywhere {
    fn sample(&self, u: [f64; 2]) -> DVec3 {
        warp::uniform_sphere(u)
    }

    fn pdf(&self, _: DVec3) -> f64 {
        warp::uniform_sphere_pdf()
    }

    fn one_minus_cos(&self) -> f64 {
        2.0
    }

    fn shines(&self, _: DVec3) -> bool {
        true
    }
}

/// Light at `at` from one place, of the intensity in W/sr that `intensity` gives for the unit
/// vector from the light.
pub(super) fn delta_sample(
    position: WorldPoint,
    at: WorldPoint,
    intensity: impl Fn(DVec3) -> Rgb,
) -> Option<LightSample> {
    let toward = position - at;
    let distance = toward.length();
    if !(distance > 0.0 && distance.is_finite()) {
        return None;
    }
    let direction = toward / distance;
    let radiance = intensity(-direction) / (distance * distance);
    (radiance.max_element() > 0.0 && radiance.is_finite()).then_some(LightSample {
        direction,
        distance,
        radiance,
        pdf: 1.0,
        delta: true,
        normal: None,
    })
}

/// Luminance of the irradiance of [`delta_sample`].
pub(super) fn delta_estimate(position: WorldPoint, at: WorldPoint, intensity: Rgb) -> f64 {
    let squared = (position - at).length_squared();
    if squared > 0.0 { luminance(intensity) / squared } else { 0.0 }
}
