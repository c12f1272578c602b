//! A light that shines from one place into a cone: a headlamp, a torch, a projector.

use std::f64::consts::PI;

use glam::DVec3;

use super::aim::{Aim, Lobe};
use super::point::{delta_estimate, delta_sample};
use super::{
    EmissionTarget, LightSample, PhotonStart, checked_color, checked_direction, checked_place,
};
use super::{one_minus_cos, one_minus_cos_between};
use crate::math::{Cone, Frame, Ray, Rgb, Span, World, WorldPoint, are_grey, is_grey, warp};

/// How the intensity falls from the axis of a spot light to the edge of its cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Falloff {
    /// Full up to `start` degrees off the axis, then a smooth step in the cosine down to 0 at the
    /// edge (as pbrt-v4's spot light). `start` at the edge is a hard edge.
    Smooth {
        /// Degrees off the axis, from 0 to the cone angle.
        start: f64,
    },
    /// The cosine of the angle off the axis to this power, cut at the edge.
    Cosine {
        /// The power, 0 or more.
        exponent: f64,
    },
}

/// A picture projected through the cone, multiplying the intensity: its inscribed circle fills
/// the cone.
#[derive(Debug, Clone)]
pub struct BeamPicture {
    /// Texels a row.
    pub width: usize,
    /// Rows; row 0 is the upper one.
    pub height: usize,
    /// Linear Rec.709 factors, row after row.
    pub texels: Vec<[f32; 3]>,
    /// World vector that the picture's upper edge looks to.
    pub up: DVec3,
}

/// A spot light.
#[derive(Debug, Clone)]
pub struct SpotLight {
    position: WorldPoint,
    /// z along the axis; with a picture x to its right and y up in it, seen along the beam.
    frame: Frame,
    intensity: Rgb,
    /// 1 - cos of the cone's half angle.
    edge: f64,
    /// 1 - cos of the angle where the smooth step begins.
    start: f64,
    exponent: Option<f64>,
    /// The picture and 1 / tan of the cone's half angle.
    picture: Option<(BeamPicture, f64)>,
    /// Power in W into the whole cone.
    power: Rgb,
}

impl SpotLight {
    /// At `position` along `direction`, of this intensity in W/sr on the axis, into a cone of the
    /// half angle `cone_angle` in degrees.
    ///
    /// # Errors
    /// Says what would be right where a value is not finite, the intensity negative, the cone
    /// angle not above 0 and at most 180, or the falloff not possible in it.
    pub fn new(
        position: WorldPoint,
        direction: DVec3,
        intensity: Rgb,
        cone_angle: f64,
        falloff: Falloff,
    ) -> Result<Self, String> {
        if !(cone_angle > 0.0 && cone_angle <= 180.0) {
            return Err(format!(
                "cone angle is {cone_angle}°: must lie above 0 and at most 180 (half the opening)"
            ));
        }
        let (start, exponent) = match falloff {
            Falloff::Smooth { start } if (0.0..=cone_angle).contains(&start) => (start, None),
            Falloff::Smooth { start } => {
                return Err(format!(
                    "falloff starts at {start}°: must lie from 0 to the cone angle {cone_angle}°"
                ));
            }
            Falloff::Cosine { exponent } if exponent >= 0.0 && exponent.is_finite() => {
                (cone_angle, Some(exponent))
            }
            Falloff::Cosine { exponent } => {
                return Err(format!("exponent is {exponent}: must be finite and not negative"));
            }
        };
        let mut light = Self {
            position: checked_place("position", position)?,
            frame: Frame::around(checked_direction("direction", direction)?),
            intensity: checked_color("intensity", intensity)?,
            edge: one_minus_cos(cone_angle.to_radians()),
            start: one_minus_cos(start.to_radians()),
            exponent,
            picture: None,
            power: Rgb::ZERO,
        };
        light.power = light.total_power();
        Ok(light)
    }

    /// The same light at the intensity for which the whole cone carries this power in W.
    ///
    /// # Errors
    /// Says what would be right where the power is negative or not finite, or has a channel that
    /// this light does not shine in at all.
    pub fn with_power(mut self, power: Rgb) -> Result<Self, String> {
        let power = checked_color("power", power)?;
        let unit = Self { intensity: Rgb::ONE, ..self.clone() }.total_power();
        for channel in 0..3 {
            if power[channel] > 0.0 && unit[channel] <= 0.0 {
                return Err(format!(
                    "power is {power}: must be 0 in channel {channel}, where the beam is black"
                ));
            }
            self.intensity[channel] =
                if power[channel] > 0.0 { power[channel] / unit[channel] } else { 0.0 };
        }
        self.power = power;
        Ok(self)
    }

    /// The same light with a picture in the beam.
    ///
    /// # Errors
    /// Says what would be right where the size does not match the texels, one is negative or not
    /// finite, `up` is along the beam, or the cone is not narrower than 90 degrees.
    pub fn with_picture(mut self, picture: BeamPicture) -> Result<Self, String> {
        let BeamPicture { width, height, ref texels, up } = picture;
        if texels.is_empty() || width.checked_mul(height) != Some(texels.len()) {
            return Err(format!(
                "beam picture has {} texels: must have {width} x {height}, at least one",
                texels.len()
            ));
        }
        if let Some(i) = texels.iter().position(|t| !t.iter().all(|v| v.is_finite() && *v >= 0.0)) {
            return Err(format!(
                "beam picture: texel {} of row {} is {:?}: must be finite and not negative",
                i % width,
                i / width,
                texels[i]
            ));
        }
        if self.edge >= 1.0 {
            return Err("cone angle is 90° or more: must be below 90 for a beam picture".into());
        }
        let z = self.frame.z;
        // Seen along the beam with y up, the picture's right is z x y.
        let x = checked_direction("up vector of the beam picture", z.cross(up)).map_err(|_| {
            format!("up vector of the beam picture is {up}: must be finite and not along the beam")
        })?;
        self.frame = Frame { x, y: x.cross(z), z };
        let sin = (self.edge * (2.0 - self.edge)).sqrt();
        self.picture = Some((picture, (1.0 - self.edge) / sin));
        self.power = self.total_power();
        Ok(self)
    }

    /// The span of `ray` that is in the light's cone; all of it where that is wider than a half space.
    pub(super) fn reach(&self, ray: &Ray<World>) -> Span {
        if self.edge > 1.0 {
            return Span::new(f64::NEG_INFINITY, f64::INFINITY);
        }
        Cone { apex: self.position, axis: self.frame.z, one_minus_cos: self.edge }.clip(ray)
    }

    /// Intensity in W/sr along the unit `direction` away from the light.
    fn intensity(&self, direction: DVec3) -> Rgb {
        let off_axis = one_minus_cos_between(direction, self.frame.z);
        if off_axis > self.edge {
            return Rgb::ZERO;
        }
        let falloff = match self.exponent {
            Some(exponent) => (1.0 - off_axis).max(0.0).powf(exponent),
            None if off_axis <= self.start => 1.0,
            None => {
                let t = (self.edge - off_axis) / (self.edge - self.start);
                t * t * (3.0 - 2.0 * t)
            }
        };
        let tint = self.picture.as_ref().map_or(Rgb::ONE, |(picture, scale)| {
            let local = self.frame.to_local(direction);
            picture.at(local.x / local.z * scale, local.y / local.z * scale)
        });
        self.intensity * falloff * tint
    }

    /// Whether it shines alike in all channels.
    pub(super) fn is_grey(&self) -> bool {
        is_grey(self.intensity) && self.picture.iter().all(|(p, _)| are_grey(&p.texels))
    }

    /// Where it stands.
    pub(super) const fn position(&self) -> WorldPoint {
        self.position
    }

    pub(super) fn sample(&self, at: WorldPoint) -> Option<LightSample> {
        delta_sample(self.position, at, |direction| self.intensity(direction))
    }

    pub(super) fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        let (direction, pdf) = Aim::new(reach, self.position, self).sample([u[0], u[1]])?;
        Some(PhotonStart {
            ray: Ray::new(self.position, direction),
            power: self.intensity(direction) / pdf,
        })
    }

    pub(super) fn power_toward(&self, reach: &EmissionTarget) -> Rgb {
        self.power * Aim::new(reach, self.position, self).share()
    }

    pub(super) fn incident_estimate(&self, at: WorldPoint) -> f64 {
        let away = (at - self.position).normalize_or_zero();
        delta_estimate(self.position, at, self.intensity(away))
    }

    /// The intensity summed over the cone by the midpoint rule.
    fn total_power(&self) -> Rgb {
        const RINGS: u32 = 256;
        const SPOKES: u32 = 128;
        let spokes = if self.picture.is_some() { SPOKES } else { 1 };
        let mut sum = Rgb::ZERO;
        for ring in 0..RINGS {
            for spoke in 0..spokes {
                let u = [
                    (f64::from(ring) + 0.5) / f64::from(RINGS),
                    (f64::from(spoke) + 0.5) / f64::from(spokes),
                ];
                sum += self.intensity(Lobe::sample(self, u));
            }
        }
        sum * (2.0 * PI * self.edge / f64::from(RINGS * spokes))
    }
}

/// Directions uniform in the cone.
impl Lobe for SpotLight {
    fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.frame.to_world(warp::uniform_cone(u, self.edge)).normalize()
    }

    fn pdf(&self, direction: DVec3) -> f64 {
        if one_minus_cos_between(direction, self.frame.z) <= self.edge {
            warp::uniform_cone_pdf(self.edge)
        } else {
            0.0
        }
    }

    fn one_minus_cos(&self) -> f64 {
        self.edge
    }

    fn shines(&self, along: DVec3) -> bool {
        one_minus_cos_between(along.normalize_or_zero(), self.frame.z) < self.edge
    }
}

impl BeamPicture {
    /// The factor at a place from -1 to 1 to the right and up, by the nearest texel.
    fn at(&self, right: f64, up: f64) -> Rgb {
        let index = |place: f64, count: usize| {
            ((0.5 * (place + 1.0) * count as f64).max(0.0) as usize).min(count - 1)
        };
        let texel = index(-up, self.height) * self.width + index(right, self.width);
        let [r, g, b] = self.texels[texel].map(f64::from);
        Rgb::new(r, g, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// In cones narrower and wider than a half space, and along vectors of any length.
        #[test]
        fn a_spot_shines_within_its_cone(
            angle in 0.01..180.0_f64,
            off in 0.0..PI,
            turn in 0.0..2.0 * PI,
            length in 1e-6..1e6_f64,
        ) {
            let origin = WorldPoint::new(0.0, 0.0, 0.0);
            let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
            let falloff = Falloff::Smooth { start: 0.0 };
            let spot = SpotLight::new(origin, axis, Rgb::ONE, angle, falloff).unwrap();
            let aside = off.sin() * DVec3::new(turn.cos(), turn.sin(), 0.0);
            let along = length * spot.frame.to_world(aside + off.cos() * DVec3::Z);
            let edge = angle.to_radians();
            prop_assume!((off - edge).abs() > 1e-7);
            prop_assert_eq!(spot.shines(along), off < edge);
        }
    }
}
