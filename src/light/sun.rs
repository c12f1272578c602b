//! Light from very far in one direction.

use std::f64::consts::PI;

use glam::DVec3;

use super::{EmissionTarget, LightSample, PhotonStart, checked_color, checked_direction};
use super::{one_minus_cos, one_minus_cos_between};
use crate::math::{Frame, Ray, Rgb, luminance, warp};

/// The sun, or any light so far away that it looks the same from everywhere: a disk of constant
/// radiance, or a single direction.
#[derive(Debug, Clone, Copy)]
pub struct Sun {
    /// Unit vector toward the sun's centre.
    toward: DVec3,
    irradiance: Rgb,
    disk: Option<Disk>,
}

/// A sun of some size.
#[derive(Debug, Clone, Copy)]
struct Disk {
    /// 1 - cos of the half angle.
    one_minus_cos: f64,
    radiance: Rgb,
}

impl Sun {
    /// Shining along `direction` (away from the sun), with this irradiance in W/m² on a surface
    /// perpendicular to it, as a disk `angular_diameter` degrees across (the real one's 0.53) or
    /// 0 for exactly one direction.
    ///
    /// # Errors
    /// Says what would be right where the direction is 0, a value is not finite or negative, or
    /// the diameter not below 180.
    pub fn new(direction: DVec3, irradiance: Rgb, angular_diameter: f64) -> Result<Self, String> {
        if !(0.0..180.0).contains(&angular_diameter) {
            return Err(format!(
                "angular diameter is {angular_diameter}°: must lie from 0 to below 180"
            ));
        }
        let irradiance = checked_color("irradiance", irradiance)?;
        let half = 0.5 * angular_diameter.to_radians();
        let sin2 = half.sin().powi(2);
        // A disk too small for its radiance to be a number is a direction.
        let disk = (sin2 > 1e-24).then(|| Disk {
            one_minus_cos: one_minus_cos(half),
            radiance: irradiance / (PI * sin2),
        });
        Ok(Self { toward: -checked_direction("direction", direction)?, irradiance, disk })
    }

    /// Irradiance in W/m² on a surface perpendicular to its light.
    pub(super) const fn irradiance(&self) -> Rgb {
        self.irradiance
    }

    pub(super) const fn is_delta(&self) -> bool {
        self.disk.is_none()
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> Option<LightSample> {
        let (direction, pdf, radiance) = self.toward(u);
        (self.irradiance.max_element() > 0.0).then_some(LightSample {
            direction,
            distance: f64::INFINITY,
            radiance,
            pdf,
            delta: self.is_delta(),
            normal: None,
        })
    }

    /// A direction toward the sun, its density (1 where there is but one) and what comes from it.
    fn toward(&self, u: [f64; 2]) -> (DVec3, f64, Rgb) {
        match self.disk {
            None => (self.toward, 1.0, self.irradiance),
            Some(disk) => {
                let local = warp::uniform_cone(u, disk.one_minus_cos);
                let direction = Frame::around(self.toward).to_world(local).normalize();
                (direction, warp::uniform_cone_pdf(disk.one_minus_cos), disk.radiance)
            }
        }
    }

    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        self.disk_at(direction).map_or(0.0, |disk| warp::uniform_cone_pdf(disk.one_minus_cos))
    }

    pub(super) fn radiance(&self, direction: DVec3) -> Rgb {
        self.disk_at(direction).map_or(Rgb::ZERO, |disk| disk.radiance)
    }

    fn disk_at(&self, direction: DVec3) -> Option<Disk> {
        self.disk.filter(|d| one_minus_cos_between(direction, self.toward) <= d.one_minus_cos)
    }

    pub(super) fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        let (toward, pdf, radiance) = self.toward([u[0], u[1]]);
        let (origin, place_pdf) = reach.start(-toward, [u[2], u[3]]);
        Some(PhotonStart { ray: Ray::new(origin, -toward), power: radiance / (pdf * place_pdf) })
    }

    pub(super) fn power(&self, reach: &EmissionTarget) -> Rgb {
        self.irradiance * reach.disk_area()
    }

    pub(super) fn incident_estimate(&self) -> f64 {
        luminance(self.irradiance)
    }
}
