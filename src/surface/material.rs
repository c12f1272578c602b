//! What surfaces are made of.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::ggx::Ggx;
use super::glass::Glass;
use super::metal::Metal;
use super::plastic::Plastic;
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
    /// A diffuse base under a rough dielectric coat, on both sides.
    Plastic(Plastic),
    /// A rough metal, on both sides.
    Metal(Metal),
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
            Self::Plastic(plastic) => plastic.scatter(incoming, hit, u)?,
            Self::Metal(metal) => metal.rough(hit).scatter(incoming, hit, [u[0], u[1]])?,
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
            Self::Diffuse { .. } | Self::Plastic(_) | Self::Metal(_) | Self::Black => {
                SmallVec::new()
            }
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
        let value = match self {
            Self::Diffuse { reflectance } => diffuse::eval(reflectance, incoming, outgoing, hit),
            Self::Plastic(plastic) => plastic.eval(incoming, outgoing, hit),
            Self::Metal(metal) => metal.rough(hit).eval(incoming, outgoing, hit),
            Self::Mirror { .. } | Self::Glass(_) | Self::Black => return Rgb::ZERO,
        };
        value * correction(mode, incoming, outgoing, hit)
    }

    /// What of [`eval`](Self::eval) is diffuse, for radiance.
    pub fn diffuse_value(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        match self {
            Self::Diffuse { reflectance } => diffuse::eval(reflectance, incoming, outgoing, hit),
            Self::Plastic(plastic) => plastic.base(incoming, outgoing, hit),
            Self::Metal(_) | Self::Mirror { .. } | Self::Glass(_) | Self::Black => Rgb::ZERO,
        }
    }

    /// The rough metal, or the rough coat, at `hit`.
    pub fn rough(&self, hit: &SurfaceHit<'_>) -> Option<Ggx<'_>> {
        match self {
            Self::Plastic(plastic) => Some(plastic.coat()),
            Self::Metal(metal) => Some(metal.rough(hit)),
            Self::Diffuse { .. } | Self::Mirror { .. } | Self::Glass(_) | Self::Black => None,
        }
    }

    /// Density of [`scatter`](Self::scatter) over solid angle, 1/sr; 0 for specular materials.
    pub fn pdf(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        match self {
            Self::Diffuse { .. } => diffuse::pdf(incoming, outgoing, hit),
            Self::Plastic(plastic) => plastic.pdf(incoming, outgoing, hit),
            Self::Metal(metal) => metal.rough(hit).pdf(incoming, outgoing, hit),
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
            Self::Diffuse { .. } | Self::Plastic(_) | Self::Metal(_) | Self::Black => {
                SmallVec::new()
            }
        }
    }

    /// Share of even light that it reflects diffusely along the unit `incoming` reversed, per channel.
    pub fn diffuse_albedo(&self, incoming: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        match self {
            Self::Diffuse { reflectance } => reflectance.at(hit.uv),
            Self::Plastic(plastic) => plastic.base_albedo(incoming, hit),
            Self::Metal(_) | Self::Mirror { .. } | Self::Glass(_) | Self::Black => Rgb::ZERO,
        }
    }

    /// What of a photon that met the surface along the unit `incoming` its irradiance counts, for
    /// [`diffuse_albedo`](Self::diffuse_albedo) to reflect: a coat lets through more or less than of even light.
    pub fn irradiance_share(&self, incoming: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        match self {
            Self::Plastic(plastic) => plastic.base_share(incoming, hit),
            Self::Diffuse { .. }
            | Self::Metal(_)
            | Self::Mirror { .. }
            | Self::Glass(_)
            | Self::Black => 1.0,
        }
    }

    /// Its colour at `hit`, as a feature of what a pixel sees: of plastic and metal the reflectance, seen from anywhere.
    pub fn color(&self, hit: &SurfaceHit<'_>) -> Rgb {
        match self {
            Self::Diffuse { reflectance } => reflectance.at(hit.uv),
            Self::Metal(metal) => metal.reflectance().at(hit.uv),
            Self::Plastic(plastic) => plastic.reflectance().at(hit.uv),
            Self::Mirror { .. } | Self::Glass(_) | Self::Black => Rgb::ZERO,
        }
    }

    /// Whether it treats all channels alike.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Diffuse { reflectance } => reflectance.is_grey(),
            Self::Metal(metal) => metal.reflectance().is_grey(),
            Self::Plastic(plastic) => plastic.reflectance().is_grey(),
            Self::Mirror { reflectance } => is_grey(*reflectance),
            Self::Glass(glass) => is_grey(glass.tint),
            Self::Black => true,
        }
    }

    /// Whether photons on it show: it is diffuse, or its base is.
    pub const fn is_diffuse(&self) -> bool {
        matches!(self, Self::Diffuse { .. } | Self::Plastic(_))
    }

    /// Whether it has [rough](Self::rough) reflection, which a path of the camera follows.
    pub const fn is_rough(&self) -> bool {
        matches!(self, Self::Plastic(_) | Self::Metal(_))
    }

    /// Whether paths that meet it are followed and photons on it never show: it is specular, or a rough metal.
    pub const fn is_followed(&self) -> bool {
        matches!(self, Self::Mirror { .. } | Self::Glass(_) | Self::Metal(_))
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
