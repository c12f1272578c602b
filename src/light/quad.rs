//! A parallelogram that shines on one side.

use std::f64::consts::PI;

use glam::DVec3;
use smallvec::SmallVec;

use super::spherical_rectangle::SphericalRectangle;
use super::surface::{SurfacePoint, area_pdf, power_toward};
use super::{
    EmissionTarget, EmitterHit, LightBounds, LightOrigin, LightPart, LightSample, PhotonStart,
    checked_color, checked_place,
};
use crate::math::{Rgb, WorldPoint, luminance};

/// Radii of the light within which places see it sampled by solid angle. Farther away, places that are uniform by area
/// differ in solid angle by less than half.
const NEAR: f64 = 6.0;

/// Solid angle in sr below which places are sampled by area, as rounding would show.
const MIN_SOLID_ANGLE: f64 = 1e-7;

/// Largest cotangent of the angle between the edges of a rectangle.
const MAX_COTANGENT: f64 = 1e-9;

/// Most parts along the longer edge.
const MAX_PARTS: f64 = 8.0;

/// A parallelogram of constant radiance on the side that u x v points to.
#[derive(Debug, Clone, Copy)]
pub struct QuadLight {
    center: WorldPoint,
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    area: f64,
    radiance: Rgb,
    /// Whether the edges are at right angles.
    is_rectangle: bool,
}

impl QuadLight {
    /// Round `center`, with edges `u` and `v` (whole edges, in metres), of this radiance in
    /// W/(m² sr).
    ///
    /// # Errors
    /// Says what would be right where a value is not finite, the radiance negative, or the edges
    /// span no area.
    pub fn new(center: WorldPoint, u: DVec3, v: DVec3, radiance: Rgb) -> Result<Self, String> {
        let cross = u.cross(v);
        let area = cross.length();
        if !(area > 0.0 && area.is_finite()) {
            return Err(format!("edges are {u} and {v}: must be finite and span an area"));
        }
        Ok(Self {
            center: checked_place("centre", center)?,
            u,
            v,
            normal: cross / area,
            area,
            radiance: checked_color("radiance", radiance)?,
            is_rectangle: u.dot(v).abs() <= MAX_COTANGENT * area,
        })
    }

    /// The four corners, counter-clockwise seen from the side that shines.
    pub fn corners(&self) -> [WorldPoint; 4] {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            .map(|(a, b)| self.center + self.u * a + self.v * b)
    }

    /// Radiance in W/(m² sr) of the side that shines.
    pub const fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// Unit normal of the side that shines.
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }

    /// A sphere round it.
    pub(super) fn bounds(&self) -> LightBounds {
        let radius = 0.5 * (self.u + self.v).length().max((self.u - self.v).length());
        LightBounds { center: self.center, radius }
    }

    /// The place that `u` in the unit square maps to, uniformly by area.
    pub(super) fn point(&self, u: [f64; 2]) -> SurfacePoint {
        SurfacePoint {
            position: self.center + self.u * (u[0] - 0.5) + self.v * (u[1] - 0.5),
            normal: self.normal,
        }
    }

    /// Parts along the longer edge, each about as long as wide.
    pub(super) fn parts(&self) -> SmallVec<[LightPart; 1]> {
        let (long, short) = if self.u.length_squared() > self.v.length_squared() {
            (self.u, self.v)
        } else {
            (self.v, self.u)
        };
        let count = (long.length() / short.length()).round().clamp(1.0, MAX_PARTS);
        let edge = long / count;
        // Places that are uniform along an edge have a variance of a twelfth of its square.
        let spread = ((edge.length_squared() + short.length_squared()) / 12.0).sqrt();
        let part = |number: u32| {
            let position = self.center + edge * (f64::from(number) + 0.5 - 0.5 * count);
            LightPart { origin: LightOrigin { position, normal: Some(self.normal) }, spread }
        };
        (0..count as u32).map(part).collect()
    }

    /// Uniformly by solid angle where the light is near, else by area.
    pub(super) fn sample(&self, at: WorldPoint, u: [f64; 2]) -> Option<LightSample> {
        if self.radiance == Rgb::ZERO {
            return None;
        }
        let Some(rectangle) = self.seen_nearby(at) else {
            return self.point(u).light(at, self.radiance, self.area);
        };
        let toward = rectangle.sample(u);
        let distance = toward.length();
        (distance > 0.0).then(|| LightSample {
            direction: toward / distance,
            distance,
            radiance: self.radiance,
            pdf: rectangle.solid_angle().recip(),
            delta: false,
            normal: Some(self.normal),
        })
    }

    pub(super) fn pdf(&self, at: WorldPoint, direction: DVec3, hit: EmitterHit) -> f64 {
        match self.seen_nearby(at) {
            Some(rectangle) if direction.dot(hit.normal) < 0.0 => rectangle.solid_angle().recip(),
            Some(_) => 0.0,
            None => area_pdf(direction, hit, self.area),
        }
    }

    /// What `at` sees of the side that shines, where that is sampled by solid angle.
    fn seen_nearby(&self, at: WorldPoint) -> Option<SphericalRectangle> {
        let center = self.center - at;
        let is_seen = self.is_rectangle && center.dot(self.normal) < 0.0;
        if !is_seen || center.length() >= NEAR * self.bounds().radius {
            return None;
        }
        let rectangle = SphericalRectangle::new(center, self.u, self.v);
        (rectangle.solid_angle() > MIN_SOLID_ANGLE).then_some(rectangle)
    }

    pub(super) fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        self.point([u[0], u[1]]).emit(self.radiance, self.area, reach, [u[2], u[3]])
    }

    pub(super) fn power_toward(&self, reach: &EmissionTarget) -> Rgb {
        power_toward(&self.point([0.5, 0.5]), self.radiance, self.area, reach)
    }

    /// Radiance times solid angle, which is exact but for rounding at grazing places.
    pub(super) fn incident_estimate(&self, at: WorldPoint) -> f64 {
        let height = (at - self.center).dot(self.normal);
        if height <= 0.0 {
            return 0.0;
        }
        let [a, b, c, d] = self.corners().map(|corner| (corner - at).normalize_or_zero());
        let exact = solid_angle(a, b, c) + solid_angle(a, c, d);
        let far = self.area * height / (at - self.center).length().powi(3);
        let least = 1e-9 * far.min(2.0 * PI);
        luminance(self.radiance) * exact.max(least)
    }
}

/// Solid angle in sr between three unit vectors (Van Oosterom and Strackee 1983, eq. 8).
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let volume = a.dot(b.cross(c)).abs();
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}
