//! What the photon maps say about the light along a ray and at a place.

use glam::DVec3;

use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::Phase;

use super::kernel::DiskKernel;
use super::{BeamMap, Octahedral, PhotonDirection, SurfaceMap};
use crate::cache::{DirectLightCache, FinalGatherCache, FluenceGrid, LazyCells};
use crate::strategy::{GatherTermination, PhaseSplit};

/// How many times fewer photons each level of the volume photons has.
pub(super) const THINNING: usize = 8;

/// Places along a ray at which lattices are asked.
const PLACES: u32 = 8;

/// Such places where cells are widest, or noise is taken off the picture: it takes grain off, and
/// each place may be a cell of direct light to fill.
const FEWEST_PLACES: u32 = 2;

/// Places along a ray at which the finest lattices are asked, by whether noise is taken off in the end.
pub(super) const fn places(denoise: bool) -> u32 {
    if denoise { FEWEST_PLACES } else { PLACES }
}

/// The photons of one render: in how many channels, and what is kept of their direction in media,
/// the plan decides.
#[derive(Debug)]
pub struct PhotonMaps<S: Spectrum = Rgb, H: PhotonDirection = Octahedral> {
    /// Photons in media: light that has been scattered, reflected or refracted before, and all
    /// light of emissive media. Light that comes straight from a light is not among them.
    /// Level l holds every 8^l-th of them, with radii 2^l times as wide: a wider gather takes fewer
    /// photons, not more.
    pub volume: Vec<BeamMap<S, H>>,
    /// For each medium the light that it scatters toward the camera, straight from the sky included
    /// where `direct` is not empty; empty where light is not kept so. Where phase functions are
    /// isotropic it holds for all directions.
    pub lattices: Vec<FluenceGrid<S>>,
    /// Where lattices hold moments: how far rays are followed before those are asked.
    pub gather: Option<GatherTermination>,
    /// For each medium the light that comes straight from lights and is scattered toward the
    /// camera; empty where it is not kept.
    pub direct: Vec<DirectLightCache<S>>,
    /// For each medium what final gathers find; empty where each ray makes its own.
    pub gathered: Vec<FinalGatherCache<S>>,
    /// At how many places along a ray the finest lattices are asked.
    pub places: u32,
    /// How each medium scatters the light of volume photons.
    pub scatterings: Vec<PhaseSplit>,
    /// Gather radius that suits the volume photons where the camera sees them, in metres; each has
    /// its own.
    pub volume_radius: f64,
    /// Photons on diffuse surfaces, of the same light. They are not thinned: light on surfaces has
    /// edges, which a wide gather would smear.
    pub surface: SurfaceMap<S>,
    /// W m that a volume photon of power 1 stands for.
    pub volume_unit: f64,
    /// W that a surface photon of power 1 stands for.
    pub surface_unit: f64,
}

impl<S: Spectrum, H: PhotonDirection> PhotonMaps<S, H> {
    /// No photons, to be gathered within `radius` metres.
    pub fn empty(radius: f64) -> Self {
        let origin = WorldPoint::new(0.0, 0.0, 0.0);
        Self {
            volume: vec![BeamMap::new(origin, &[], &[])],
            lattices: Vec::new(),
            gather: None,
            direct: Vec::new(),
            gathered: Vec::new(),
            places: 0,
            scatterings: Vec::new(),
            volume_radius: radius,
            surface: SurfaceMap::default(),
            volume_unit: 1.0,
            surface_unit: 1.0,
        }
    }

    /// All cells that are filled while rays are marched.
    pub fn filled(&self) -> Vec<&LazyCells<S>> {
        let direct = self.direct.iter().map(DirectLightCache::filled);
        direct.chain(self.gathered.iter().map(FinalGatherCache::filled)).collect()
    }

    /// The photons' light scattered along `ray` (unit direction) to its origin, W/(m² sr): the sum
    /// over the photons near the ray of power · phase · sigma_s · transmittance · kernel (Jarosz,
    /// Zwicker and Jensen 2008, equation 12, with photons that carry fluence in place of
    /// collisions). Each photon has its own radius, of which `radius` metres take the share that
    /// they are of [`volume_radius`](Self::volume_radius), at most all, in the level whose radii
    /// are nearest. `respond` is called with the distance along the ray
    /// and returns, for each phase function there, sigma_s times transmittance. `gathered` counts
    /// the photons.
    pub fn along<'p, R: AsRef<[(&'p Phase, S)]>>(
        &self,
        ray: &Ray<World>,
        span: Span,
        radius: f64,
        gathered: &mut u64,
        respond: impl Fn(f64) -> R,
    ) -> S {
        let level = self.level(radius);
        let scale = (radius / self.volume_radius / f64::from(1_u32 << level)).min(1.0);
        let (mut sum, mut count, toward) = (S::ZERO, 0, -ray.direction);
        self.volume[level].along(ray, span, scale, |beside| {
            count += 1;
            let mut spread = S::ZERO;
            for (phase, weight) in respond(beside.t).as_ref() {
                spread += *weight * beside.photon.heading().spread(phase, toward);
            }
            let kernel = DiskKernel::new(beside.radius);
            sum += beside.photon.power() * spread * kernel.at(beside.distance2);
        });
        *gathered += count;
        sum * (self.volume_unit * THINNING.pow(level as u32) as f64)
    }

    /// The photons' irradiance at `p` on the side of the unit `normal`, W/m². `gathered` counts
    /// the photons that it is made of.
    pub fn irradiance(&self, p: WorldPoint, normal: DVec3, gathered: &mut u64) -> S {
        self.surface.irradiance(p, normal, gathered) * self.surface_unit
    }

    /// The level whose radii are nearest to `radius` metres, of photons and of lattices alike.
    pub fn level(&self, radius: f64) -> usize {
        let octaves = (radius / self.volume_radius).max(1.0).log2().round();
        (octaves as usize).min(self.volume.len() - 1)
    }

    /// At how many places along a ray lattices of this level are asked.
    pub fn places_at(&self, level: usize) -> u32 {
        (self.places >> level).max(FEWEST_PLACES)
    }
}
