//! The beam radiance estimate: all photons along a camera ray at once.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;

use crate::math::{Ray, Rgb, Span, Spectrum, Stage, Stream, World, WorldPoint};

use super::{Octahedral, Photon, PhotonAt, PhotonDirection};

/// Volume photons as spheres in a bounding volume hierarchy, for gathers along rays
/// (Jarosz, Zwicker and Jensen 2008, "The Beam Radiance Estimate for Volumetric Photon Mapping").
pub struct BeamMap<S: Spectrum = Rgb, H = Octahedral> {
    /// In units of the widest radius: obvhs takes no hit nearer to a ray's start than 1e-4.
    bvh: Option<CwBvh>,
    /// In the order of the hierarchy's leaves, so that neighbours lie side by side.
    photons: Vec<Sphere<S, H>>,
    /// What positions are relative to, so that 32 bits suffice far from the world's origin.
    origin: WorldPoint,
    /// The largest radius, in metres.
    widest: f64,
    /// Distance from the origin within which all spheres lie, in metres.
    extent: f64,
}

/// A photon with its position and radius: 32 bytes in colour and with its direction, 20 without either.
#[derive(Debug, Clone, Copy)]
struct Sphere<S: Spectrum, H> {
    at: PhotonAt<S, H>,
    radius: f32,
}

/// A photon near a ray.
#[derive(Debug, Clone, Copy)]
pub struct BeamHit<'a, S: Spectrum = Rgb, H = Octahedral> {
    /// The photon.
    pub photon: &'a Photon<S, H>,
    /// Distance along the ray of the point closest to the photon, in metres.
    pub t: f64,
    /// Squared distance of the photon from that point, in m².
    pub distance2: f64,
    /// Radius of its sphere, in metres.
    pub radius: f64,
}

/// Stream index of the jitter against ties, which photon paths do not use.
///
/// Unit: none. Definition: an index.
const TIE_STREAM: u64 = 2;

/// Error of positions in the hierarchy, as a share of the photons' extent.
///
/// Unit: none. Derivation: sixteen roundings of 32 bits, 6e-8 each.
const POSITION_ROUNDING: f64 = 1e-6;

/// Margin of a photon's box over its sphere, as a share of the radius, within which boxes are jittered.
///
/// Unit: none. Derivation: thousands of roundings of 32 bits, so that jittered boxes differ; wider boxes
/// would be met in vain.
const BOX_MARGIN: f64 = 1e-3;

struct Ball {
    center: Vec3A,
    radius: f32,
}

impl Boundable for Ball {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.center - self.radius, self.center + self.radius)
    }
}

impl<S: Spectrum, H: PhotonDirection> BeamMap<S, H> {
    /// Bytes of a photon with its position and radius.
    ///
    /// Unit: bytes. Definition: the size of the type.
    pub(super) const SPHERE: usize = size_of::<Sphere<S, H>>();

    /// Builds the hierarchy over `photons`, whose positions are relative to `origin`, with a radius in
    /// metres for each.
    ///
    /// # Panics
    /// If there is not one radius a photon.
    pub fn new(origin: WorldPoint, photons: &[PhotonAt<S, H>], radii: &[f32]) -> Self {
        assert_eq!(photons.len(), radii.len(), "one radius a photon");
        let center = |p: &PhotonAt<S, H>| DVec3::from(p.place.map(f64::from));
        let extent = photons.iter().map(|p| center(p).length()).fold(0.0, f64::max);
        // Not below the rounding of positions: in units of a narrower sphere they would overflow the
        // precision of 32 bits.
        let widest =
            f64::from(radii.iter().copied().fold(0.0, f32::max)).max(POSITION_ROUNDING * extent);
        // A little more than the radius, for the hierarchy's rounding.
        let margin = |radius: f64| BOX_MARGIN * radius + POSITION_ROUNDING * extent;
        // Where photons coincide, as in media of very short free paths, ties would make the hierarchy a
        // chain: each box is jittered within the margin, along each axis by a quarter of it.
        let mut rng = Stream::new(0, Stage::Photons, 0, TIE_STREAM);
        let ball = |(p, radius): (&PhotonAt<S, H>, &f32)| {
            let radius = f64::from(*radius);
            let jitter = DVec3::from(std::array::from_fn(|_| 0.5 * (rng.uniform() - 0.5)));
            Ball {
                center: ((center(p) + jitter * margin(radius)) / widest).as_vec3a(),
                radius: ((radius + margin(radius)) / widest) as f32,
            }
        };
        let balls: Vec<Ball> = photons.iter().zip(radii).map(ball).collect();
        let build = || {
            let params = BvhBuildParams::very_fast_build();
            let mut time = Duration::ZERO;
            build_cwbvh(&balls, params, &mut time)
        };
        let bvh = (!balls.is_empty()).then(build);
        let order = bvh.as_ref().map_or(&[][..], |bvh| &bvh.primitive_indices);
        let sphere = |i: &u32| Sphere { at: photons[*i as usize], radius: radii[*i as usize] };
        let photons = order.par_iter().map(sphere).collect();
        Self { bvh, photons, origin, widest, extent: extent + widest + margin(widest) }
    }

    /// How many photons it holds.
    pub const fn len(&self) -> usize {
        self.photons.len()
    }

    /// Whether it holds none.
    pub const fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Position and radius, in metres, of each photon.
    pub fn kernels(&self) -> impl Iterator<Item = (WorldPoint, f64)> {
        let place = |sphere: &Sphere<S, H>| DVec3::from(sphere.at.place.map(f64::from));
        self.photons.iter().map(move |s| (self.origin + place(s), f64::from(s.radius)))
    }

    /// Calls `f` with each photon whose sphere, `scale` times as wide (at most 1), `ray` (unit
    /// direction) crosses and whose closest point on the ray lies in `span`, in a fixed order.
    pub fn along(
        &self,
        ray: &Ray<World>,
        span: Span,
        scale: f64,
        mut f: impl FnMut(BeamHit<'_, S, H>),
    ) {
        let Some(bvh) = &self.bvh else { return };
        // The ray is moved to where it passes the photons before it is rounded to 32 bits.
        let shift = (self.origin - ray.origin).dot(ray.direction);
        let local = ray.at(shift) - self.origin;
        let reach = self.extent;
        let near = (span.start - shift - 2.0 * self.widest).max(-reach);
        let far = (span.end - shift + 2.0 * self.widest).min(reach);
        if far <= near || local.length() > reach {
            return;
        }
        let entry = ((local + ray.direction * near) / self.widest).as_vec3a();
        // obvhs takes -0 for a negative direction in one place and not in another; 0 is safe.
        let direction = ray.direction.as_vec3a() + Vec3A::ZERO;
        let length = ((far - near) / self.widest) as f32;
        let query = obvhs::ray::Ray::new(entry, direction, 0.0, length);
        bvh.ray_traverse_anyhit(query, |_, index| {
            let Sphere { at: PhotonAt { place, photon }, radius } = &self.photons[index];
            let radius = f64::from(*radius) * scale;
            let to = DVec3::from(place.map(f64::from)) - local;
            let along = to.dot(ray.direction);
            let distance2 = (to - ray.direction * along).length_squared();
            let t = shift + along;
            if distance2 <= radius * radius && t >= span.start && t <= span.end {
                f(BeamHit { photon, t, distance2, radius });
            }
        });
    }
}

impl<S: Spectrum, H: PhotonDirection> std::fmt::Debug for BeamMap<S, H> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BeamMap")
            .field("photons", &self.photons.len())
            .field("widest", &self.widest)
            .finish_non_exhaustive()
    }
}
