//! What surfaces are made of.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::glass::Glass;
use super::{Scattered, SurfaceHit, Texture, TransportMode, diffuse, mirror};
use crate::math::{Rgb, is_grey};

/// A material. Directions are unit vectors; `incoming` runs toward the surface, as the ray that met
/// it does, and `outgoing` away from it.
#[derive(Debug, Clone)]
pub enum Material {
    /// Lambert's, on both sides.
    Diffuse {
        /// In [0, 1].
        reflectance: Texture,
    },
    /// A perfect mirror, on both sides.
    Mirror {
        /// In [0, 1].
        reflectance: Rgb,
    },
    /// A smooth dielectric solid; its outside is where the normal points.
    Glass(Glass),
    /// Absorbs everything.
    Black,
}

impl Material {
    /// Samples a direction with three uniform numbers, or nothing where the path ends.
    pub fn scatter(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
        u: [f64; 3],
        mode: TransportMode,
    ) -> Option<Scattered> {
        let scattered = match self {
            Self::Diffuse { reflectance } => diffuse::scatter(reflectance, incoming, hit, u)?,
            Self::Mirror { reflectance } => mirror::scatter(*reflectance, incoming, hit),
            Self::Glass(glass) => glass.scatter(incoming, hit, u[0], mode),
            Self::Black => return None,
        };
        let correction = correction(mode, incoming, scattered.direction, hit);
        Some(Scattered { weight: scattered.weight * correction, ..scattered })
    }

    /// All directions into which a specular material scatters radiance, each weighed by its value times cosine; none
    /// for other materials.
    pub fn specular_branches(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
    ) -> SmallVec<[Scattered; 2]> {
        match self {
            Self::Mirror { reflectance } => smallvec![mirror::scatter(*reflectance, incoming, hit)],
            Self::Glass(glass) => glass.branches(incoming, hit, TransportMode::Radiance),
            Self::Diffuse { .. } | Self::Black => SmallVec::new(),
        }
    }

    /// Value of the BSDF without the cosine, 1/sr; 0 for specular materials. The cosine that
    /// belongs to it is that with the shading normal.
    pub fn eval(
        &self,
        incoming: DVec3,
        outgoing: DVec3,
        hit: &SurfaceHit<'_>,
        mode: TransportMode,
    ) -> Rgb {
        match self {
            Self::Diffuse { reflectance } => {
                diffuse::eval(reflectance, incoming, outgoing, hit)
                    * correction(mode, incoming, outgoing, hit)
            }
            Self::Mirror { .. } | Self::Glass(_) | Self::Black => Rgb::ZERO,
        }
    }

    /// Density of [`scatter`](Self::scatter) over solid angle, 1/sr; 0 for specular materials.
    pub fn pdf(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        match self {
            Self::Diffuse { .. } => diffuse::pdf(incoming, outgoing, hit),
            Self::Mirror { .. } | Self::Glass(_) | Self::Black => 0.0,
        }
    }

    /// The directions of a specular material, each with its share of what is scattered: one of a mirror,
    /// of glass what is reflected and what is refracted, by Fresnel's equations. None of others.
    pub fn branches(
        &self,
        incoming: DVec3,
        hit: &SurfaceHit<'_>,
    ) -> SmallVec<[(f64, Scattered); 2]> {
        match self {
            Self::Mirror { reflectance } => {
                smallvec![(1.0, mirror::scatter(*reflectance, incoming, hit))]
            }
            Self::Glass(glass) => {
                let reflected = mirror::scatter(Rgb::ONE, incoming, hit);
                match glass.split(incoming, hit, TransportMode::Importance) {
                    (share, Some(refracted)) => {
                        smallvec![(share, reflected), (1.0 - share, refracted)]
                    }
                    (_, None) => smallvec![(1.0, reflected)],
                }
            }
            Self::Diffuse { .. } | Self::Black => SmallVec::new(),
        }
    }

    /// Share of the light that it scatters diffusely at `hit`, per channel.
    pub fn diffuse_albedo(&self, hit: &SurfaceHit<'_>) -> Rgb {
        match self {
            Self::Diffuse { reflectance } => reflectance.at(hit.uv),
            Self::Mirror { .. } | Self::Glass(_) | Self::Black => Rgb::ZERO,
        }
    }

    /// Whether it treats all channels alike.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Diffuse { reflectance } => reflectance.is_grey(),
            Self::Mirror { reflectance } => is_grey(*reflectance),
            Self::Glass(glass) => is_grey(glass.tint),
            Self::Black => true,
        }
    }

    /// Whether it scatters into finitely many directions alone.
    pub fn is_specular(&self) -> bool {
        matches!(self, Self::Mirror { .. } | Self::Glass(_))
    }
}

/// What keeps photons consistent with camera paths where the shading normal is not the geometric
/// one: |wi·ns| |wo·ng| / (|wi·ng| |wo·ns|), with wi on the light's side (Veach 1997, equation 5.19).
fn correction(mode: TransportMode, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> f64 {
    let (ng, ns) = (hit.normal, hit.shading_normal);
    if mode == TransportMode::Radiance || ng == ns {
        return 1.0;
    }
    let above = incoming.dot(ns) * outgoing.dot(ng);
    let below = incoming.dot(ng) * outgoing.dot(ns);
    if below == 0.0 { 0.0 } else { (above / below).abs() }
}
