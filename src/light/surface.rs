//! What all surfaces of constant radiance share, whatever their shape.

use std::f64::consts::PI;

use glam::DVec3;

use super::aim::{Aim, Lobe};
use super::{EmissionTarget, EmitterHit, LightOrigin, LightSample, PhotonStart};
use crate::math::{Frame, Ray, Rgb, WorldPoint, warp};

/// A place on a shining surface, chosen uniformly by area.
#[derive(Debug, Clone, Copy)]
pub(super) struct SurfacePoint {
    pub(super) position: WorldPoint,
    /// Unit normal on the side that shines.
    pub(super) normal: DVec3,
}

impl SurfacePoint {
    /// This place, as a place on a light of any kind.
    pub(super) const fn origin(&self) -> LightOrigin {
        LightOrigin { position: self.position, normal: Some(self.normal) }
    }

    /// Light of `radiance` that arrives at `at` from here, this place being one of a surface of
    /// `area` m².
    pub(super) fn light(&self, at: WorldPoint, radiance: Rgb, area: f64) -> Option<LightSample> {
        let toward = self.position - at;
        let distance = toward.length();
        let direction = toward / distance;
        let pdf = area_pdf(direction, EmitterHit { distance, normal: self.normal }, area);
        (pdf > 0.0 && pdf.is_finite()).then_some(LightSample {
            direction,
            distance,
            radiance,
            pdf,
            delta: false,
            normal: Some(self.normal),
        })
    }

    /// A photon of light of `radiance` from here, as [`Self::light`].
    pub(super) fn emit(
        &self,
        radiance: Rgb,
        area: f64,
        reach: &EmissionTarget,
        u: [f64; 2],
    ) -> Option<PhotonStart> {
        let lobe = CosineLobe(Frame::around(self.normal));
        let (direction, pdf) = Aim::new(reach, self.position, &lobe).sample(u)?;
        let cos_theta = direction.dot(self.normal).max(0.0);
        if cos_theta == 0.0 {
            return None;
        }
        // Past the rounding of the place, so that the photon does not meet the surface it leaves;
        // along its own line, so that it meets what it would.
        let size = self.position.xyz.abs().max_element() + area.sqrt();
        let skip = 64.0 * f64::EPSILON * size / cos_theta;
        let origin = self.position + direction * skip;
        Some(PhotonStart {
            ray: Ray::new(origin, direction),
            power: radiance * (cos_theta * area / pdf),
        })
    }
}

/// A unit direction into the half space of the unit `normal` at `place`, after a cosine lobe but
/// aimed at `reach`, and its density, 1/sr. Nothing where the direction leads away from all that
/// is to be reached.
pub fn aim_from(
    place: WorldPoint,
    normal: DVec3,
    reach: &EmissionTarget,
    u: [f64; 2],
) -> Option<(DVec3, f64)> {
    let lobe = CosineLobe(Frame::around(normal));
    Aim::new(reach, place, &lobe).sample(u).filter(|(direction, _)| direction.dot(normal) > 0.0)
}

/// About the power in W toward `reach` of a surface of `area` m² round `place`.
pub(super) fn power_toward(
    place: &SurfacePoint,
    radiance: Rgb,
    area: f64,
    reach: &EmissionTarget,
) -> Rgb {
    let lobe = CosineLobe(Frame::around(place.normal));
    radiance * (PI * area * Aim::new(reach, place.position, &lobe).share())
}

/// Density, 1/sr, of seeing `hit` along the unit `direction` when places are chosen uniformly on
/// `area` m²; 0 from behind.
pub(super) fn area_pdf(direction: DVec3, hit: EmitterHit, area: f64) -> f64 {
    let cos_theta = -direction.dot(hit.normal);
    if cos_theta > 0.0 { hit.distance * hit.distance / (cos_theta * area) } else { 0.0 }
}

/// The light of a surface whose radiance is the same in all directions.
struct CosineLobe(Frame);

impl Lobe for CosineLobe {
    fn sample(&self, u: [f64; 2]) -> DVec3 {
        self.0.to_world(warp::cosine_hemisphere(u))
    }

    fn pdf(&self, direction: DVec3) -> f64 {
        warp::cosine_hemisphere_pdf(direction.dot(self.0.z))
    }

    /// The cone that holds as much solid angle as the lobe at its peak density holds power.
    fn one_minus_cos(&self) -> f64 {
        0.5
    }

    fn shines(&self, along: DVec3) -> bool {
        along.dot(self.0.z) > 0.0
    }
}
