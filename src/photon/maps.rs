//! The photon maps of one render, and density estimates in them.

use glam::DVec3;

use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::Phase;

use super::kernel::{DiskKernel, is_too_wide, radius_within};
use super::{BeamMap, Octahedral, PhotonDirection, SurfaceMap};

/// Ratio of the numbers of photons of one level to the next of the volume photons: with radii twice as
/// wide, eight times as many photons lie in a sphere.
///
/// Unit: none. Derivation: the volume of a sphere of twice the radius.
pub(super) const THINNING: usize = 8;

/// Photons, immutable once shot. The plan decides how many channels they have, and whether volume
/// photons have a direction.
#[derive(Debug)]
pub struct PhotonMaps<S: Spectrum = Rgb, H: PhotonDirection = Octahedral> {
    /// Photons in media: light that was scattered, reflected or refracted before, and all light of
    /// emissive media. Light straight from lights is not among them. Level l holds every 8^l-th
    /// photon, with radii 2^l times as wide: a wider gather takes fewer photons, not more.
    pub volume: Vec<BeamMap<S, H>>,
    /// The gather radius, in metres, that stands for the photons' own radii: that of full quality.
    pub volume_radius: f64,
    /// Factor on the mean free paths that limit radii: the ratio of the radii to those of all photons that these
    /// stand for, so that their kernels hold as many photons. Infinite where the scene names the radius.
    pub free_paths: f64,
    /// Photons on diffuse surfaces, of the same light. They have one level: light on surfaces has
    /// edges, which a wide gather would smear.
    pub surface: SurfaceMap<S>,
    /// W m for which a volume photon of power 1 stands.
    pub volume_unit: f64,
    /// W for which a surface photon of power 1 stands.
    pub surface_unit: f64,
}

/// What media do to light at a point of a ray.
#[derive(Debug)]
pub struct Response<R> {
    /// Extinction coefficient, 1/m: the largest of all channels.
    pub sigma_t: f64,
    /// For each phase function, sigma_s times the transmittance to the ray's origin.
    pub scatterers: R,
}

impl<S: Spectrum, H: PhotonDirection> PhotonMaps<S, H> {
    /// No photons, with a gather radius in metres.
    pub fn empty(radius: f64) -> Self {
        let origin = WorldPoint::new(0.0, 0.0, 0.0);
        Self {
            volume: vec![BeamMap::new(origin, &[], &[])],
            volume_radius: radius,
            free_paths: f64::INFINITY,
            surface: SurfaceMap::default(),
            volume_unit: 1.0,
            surface_unit: 1.0,
        }
    }

    /// As `self`, where at most `radius` metres stand for the photons' own radii: the cells of a cache
    /// beside the maps are as narrow, and both are widened together.
    #[must_use]
    pub fn with_radius_at_most(self, radius: f64) -> Self {
        Self { volume_radius: self.volume_radius.min(radius), ..self }
    }

    /// Whether most volume photons lie where media have so short free paths that even the narrowest kernels of all
    /// photons that these stand for blur light across faces. `sigma_t` is the extinction coefficient at a place,
    /// 1/m.
    pub fn blur_faces(&self, sigma_t: impl Fn(WorldPoint) -> f64) -> bool {
        let is_blurred = |(place, radius): &(WorldPoint, f64)| {
            is_too_wide(*radius, sigma_t(*place) / self.free_paths)
        };
        2 * self.volume[0].kernels().filter(is_blurred).count() > self.volume[0].len()
    }

    /// The photons' light scattered along `ray` (unit direction) to its origin, W/(m² sr): the sum
    /// over the photons near the ray of power · phase · sigma_s · transmittance · kernel (the beam
    /// radiance estimate of Jarosz, Zwicker and Jensen 2008, with photons that carry fluence in place
    /// of collisions). Each photon has its own radius, of which `radius` metres take the share that
    /// they are of [`volume_radius`](Self::volume_radius), at most all, in the level whose radii
    /// are nearest. `respond` is called with the distance along the ray and returns what media do there.
    /// `gathered` counts the photons.
    pub fn along<'p, R: AsRef<[(&'p Phase, S)]>>(
        &self,
        ray: &Ray<World>,
        span: Span,
        radius: f64,
        gathered: &mut u64,
        respond: impl Fn(f64) -> Option<Response<R>>,
    ) -> S {
        let level = self.level(radius);
        let widening = radius / self.volume_radius;
        let scale = (widening / f64::from(1_u32 << level)).min(1.0);
        // Another radius is another one everywhere.
        let free_paths = self.free_paths * widening;
        let (mut sum, mut count, wo) = (S::ZERO, 0, -ray.direction);
        self.volume[level].along(ray, span, scale, |hit| {
            count += 1;
            let Some(Response { sigma_t, scatterers }) = respond(hit.t) else { return };
            let mut scattered = S::ZERO;
            for (phase, weight) in scatterers.as_ref() {
                scattered += *weight * hit.photon.stored_direction().scattered(phase, wo);
            }
            let radius = radius_within(hit.radius, sigma_t / free_paths);
            let kernel = DiskKernel::new(radius);
            sum += hit.photon.power() * scattered * kernel.at(hit.distance2);
        });
        *gathered += count;
        sum * (self.volume_unit * THINNING.pow(level as u32) as f64)
    }

    /// The photons' irradiance at `p` on the side of the unit `normal`, W/m². `gathered` counts
    /// the photons that it is made of.
    pub fn irradiance(&self, p: WorldPoint, normal: DVec3, gathered: &mut u64) -> S {
        self.surface.irradiance(p, normal, gathered) * self.surface_unit
    }

    /// The level whose radii are nearest to `radius` metres, of photons and of caches alike.
    pub fn level(&self, radius: f64) -> usize {
        let octaves = (radius / self.volume_radius).max(1.0).log2().round();
        (octaves as usize).min(self.volume.len() - 1)
    }
}
