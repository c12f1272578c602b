//! Triangles that shine on one side.

use std::f64::consts::PI;

use glam::DVec3;

use super::surface::{SurfacePoint, area_pdf, power_toward};
use super::{EmissionTarget, EmitterHit, LightBounds, LightSample, PhotonStart, checked_color};
use crate::math::{Aabb, Cdf, Rgb, WorldPoint, luminance, warp};

/// A mesh of constant radiance on the side from which its triangles run counter-clockwise.
#[derive(Debug, Clone)]
pub struct MeshLight {
    triangles: Vec<[DVec3; 3]>,
    by_area: Cdf,
    radiance: Rgb,
    bounds: LightBounds,
}

impl MeshLight {
    /// These triangles in world space, of this radiance in W/(m² sr). Those without area are
    /// allowed and don't shine.
    ///
    /// # Errors
    /// Says what would be right where a value is not finite, the radiance negative, or there is
    /// no area at all.
    pub fn new(triangles: Vec<[DVec3; 3]>, radiance: Rgb) -> Result<Self, String> {
        if let Some(i) = triangles.iter().position(|t| !t.iter().all(|p| p.is_finite())) {
            return Err(format!("triangle {i} is {:?}: must be finite", triangles[i]));
        }
        let by_area = Cdf::new(triangles.iter().map(|t| 0.5 * cross(t).length()))
            .ok_or_else(|| format!("{} triangles have no area: must have some", triangles.len()))?;
        let corners = triangles.iter().flatten().copied().map(WorldPoint::from_xyz);
        let bounds = Aabb::around(corners);
        Ok(Self {
            triangles,
            by_area,
            radiance: checked_color("radiance", radiance)?,
            bounds: LightBounds { center: bounds.center(), radius: 0.5 * bounds.size().length() },
        })
    }

    /// Radiance in W/(m² sr) of the side that shines.
    pub const fn radiance(&self) -> Rgb {
        self.radiance
    }

    /// Area in m².
    pub fn area(&self) -> f64 {
        self.by_area.total()
    }

    /// A sphere round it.
    pub(super) const fn bounds(&self) -> LightBounds {
        self.bounds
    }

    /// The place that `u` in the unit square maps to, uniformly by area.
    pub(super) fn point(&self, u: [f64; 2]) -> SurfacePoint {
        let (index, first) = self.by_area.sample(u[0]);
        let triangle = &self.triangles[index];
        let [a, b, c] = warp::uniform_triangle([first, u[1]]);
        SurfacePoint {
            position: WorldPoint::from_xyz(triangle[0] * a + triangle[1] * b + triangle[2] * c),
            normal: cross(triangle).normalize(),
        }
    }

    pub(super) fn sample(&self, at: WorldPoint, u: [f64; 2]) -> Option<LightSample> {
        if self.radiance == Rgb::ZERO {
            return None;
        }
        self.point(u).light(at, self.radiance, self.area())
    }

    pub(super) fn pdf(&self, direction: DVec3, hit: EmitterHit) -> f64 {
        area_pdf(direction, hit, self.area())
    }

    pub(super) fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        self.point([u[0], u[1]]).emit(self.radiance, self.area(), reach, [u[2], u[3]])
    }

    pub(super) fn power_toward(&self, reach: &EmissionTarget) -> Rgb {
        let toward = (reach.center() - self.bounds.center).normalize_or(DVec3::Z);
        let middle = SurfacePoint { position: self.bounds.center, normal: toward };
        power_toward(&middle, self.radiance, self.area(), reach)
    }

    /// Radiance times the solid angle of the area at its centre's distance, at least the mesh's
    /// own size away.
    pub(super) fn incident_estimate(&self, at: WorldPoint) -> f64 {
        let LightBounds { center, radius } = self.bounds;
        let squared = (at - center).length_squared().max(radius * radius);
        luminance(self.radiance) * (self.area() / squared).min(4.0 * PI)
    }
}

/// Twice the area, along the normal of the side that shines.
fn cross([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
