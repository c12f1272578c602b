//! Rough reflection: facets of the GGX distribution.
//!
//! The distribution is that of Walter et al. 2007 ("Microfacet Models for Refraction through Rough Surfaces"),
//! masking and shadowing that of Smith with correlated heights (Heitz 2014, "Understanding the Masking-Shadowing
//! Function in Microfacet-Based BRDFs", equations 86 and 99), and facets are sampled as they are seen (Heitz 2018,
//! "Sampling the GGX Distribution of Visible Normals"). Light that facets of metal reflect more than once is a diffuse
//! lobe (Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks").

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::albedo::Albedos;
use super::glass::dielectric_reflectance;
use super::scattered::{facing, reflects};
use super::{Scattered, SurfaceHit};
use crate::math::{Frame, Rgb, warp};

/// What facets reflect.
#[derive(Debug, Clone, Copy)]
pub(super) enum Fresnel {
    /// A dielectric of this index of refraction over that of air.
    Dielectric(f64),
    /// A metal of this reflectance at normal incidence, rising to 1 at grazing (Schlick 1994, "An Inexpensive BRDF
    /// Model for Physically-based Rendering").
    Metal(Rgb),
}

impl Fresnel {
    fn at(self, cosine: f64) -> Rgb {
        match self {
            Self::Dielectric(ior) => Rgb::splat(dielectric_reflectance(cosine, 1.0 / ior)),
            Self::Metal(normal) => {
                normal + (Rgb::ONE - normal) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
            }
        }
    }
}

/// Light that facets reflect more than once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Multiple<'a> {
    /// Of these facets where they reflect everything.
    pub(super) albedos: &'a Albedos,
    /// Share of what they do not reflect at once that leaves them after more reflections.
    pub(super) share: Rgb,
}

/// A rough surface at one place.
#[derive(Debug, Clone, Copy)]
pub struct Ggx<'a> {
    /// Width of the distribution of slopes.
    pub(super) alpha: f64,
    pub(super) fresnel: Fresnel,
    /// Light that its facets reflect more than once, where that counts.
    pub(super) multiple: Option<Multiple<'a>>,
}

impl Ggx<'_> {
    /// Samples a direction by the visible facets with two uniform numbers; `None` where it would lead into the surface.
    pub fn scatter(&self, incoming: DVec3, hit: &SurfaceHit<'_>, u: [f64; 2]) -> Option<Scattered> {
        let (_, ns) = facing(incoming, hit);
        let frame = Frame::around(ns);
        let wo = frame.to_local(-incoming);
        if wo.z <= 0.0 {
            return None;
        }
        let (wi, weight, pdf) = match self.multiple {
            None => self.sample(wo, u)?,
            Some(_) => self.sample_both(wo, u)?,
        };
        let direction = frame.to_world(wi).normalize();
        let scattered = Scattered { direction, weight, specular: false, pdf, crossing: 0 };
        reflects(incoming, direction, hit).then_some(scattered)
    }

    /// Value without the cosine, 1/sr.
    pub fn eval(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> Rgb {
        let Some([wo, wi]) = local(incoming, outgoing, hit) else { return Rgb::ZERO };
        self.value(wo, wi)
    }

    /// The same in the shading frame.
    fn value(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let half = (wo + wi).normalize();
        let together = 1.0 / (1.0 + self.lambda(wo.z) + self.lambda(wi.z));
        let value = self.density(half.z) * together / (4.0 * wo.z * wi.z);
        let once = self.fresnel.at(wo.dot(half)) * value;
        match self.multiple {
            Some(Multiple { albedos, share }) => once + share * albedos.diffuse([wi.z, wo.z]),
            None => once,
        }
    }

    /// Probability of sampling what is reflected once.
    fn share_of_once(&self, wo: DVec3) -> f64 {
        self.multiple.map_or(1.0, |Multiple { albedos, share }| {
            let once = albedos.at(wo.z);
            once / (once + share.max_element() * (1.0 - once))
        })
    }

    /// Density of [`scatter`](Self::scatter) in the shading frame.
    fn mixed_pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let share = self.share_of_once(wo);
        let once = self.pdf_of(wo, (wo + wi).normalize());
        share * once + (1.0 - share) * warp::uniform_cone_pdf(1.0)
    }

    /// Density of [`scatter`](Self::scatter) over solid angle, 1/sr.
    pub fn pdf(&self, incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> f64 {
        let Some([wo, wi]) = local(incoming, outgoing, hit) else { return 0.0 };
        self.mixed_pdf(wo, wi)
    }

    /// What is reflected once, in the shading frame: direction, value times cosine over density, and density.
    pub(super) fn sample(&self, wo: DVec3, u: [f64; 2]) -> Option<(DVec3, Rgb, f64)> {
        let half = self.visible_facet(wo, u);
        let cosine = wo.dot(half);
        let wi = 2.0 * cosine * half - wo;
        if cosine <= 0.0 || wi.z <= 0.0 {
            return None;
        }
        let (seen, lit) = (self.lambda(wo.z), self.lambda(wi.z));
        let weight = self.fresnel.at(cosine) * ((1.0 + seen) / (1.0 + seen + lit));
        Some((wi, weight, self.pdf_of(wo, half)))
    }

    /// The weight of [`sample`](Self::sample) in the first channel.
    pub(super) fn weight(&self, wo: DVec3, u: [f64; 2]) -> Option<f64> {
        self.sample(wo, u).map(|(_, weight, _)| weight.x)
    }

    /// As [`sample`](Self::sample), of all that is reflected.
    fn sample_both(&self, wo: DVec3, [a, b]: [f64; 2]) -> Option<(DVec3, Rgb, f64)> {
        let share = self.share_of_once(wo);
        let wi = if a < share {
            self.sample(wo, [a / share, b])?.0
        } else {
            // What is reflected more than once leaves at grazing angles above all.
            warp::uniform_cone([(a - share) / (1.0 - share), b], 1.0)
        };
        let pdf = self.mixed_pdf(wo, wi);
        (wi.z > 0.0).then(|| (wi, self.value(wo, wi) * (wi.z / pdf), pdf))
    }

    /// Density of reflecting `wo` at facets with the normal `half`.
    fn pdf_of(&self, wo: DVec3, half: DVec3) -> f64 {
        self.density(half.z) / ((1.0 + self.lambda(wo.z)) * 4.0 * wo.z)
    }

    /// Density of facets over their normals, 1/sr.
    fn density(&self, cosine: f64) -> f64 {
        let squared = self.alpha * self.alpha;
        let spread = cosine * cosine * (squared - 1.0) + 1.0;
        squared / (PI * spread * spread)
    }

    /// Smith's auxiliary function: 1 / (1 + it) of the facets are seen at this cosine.
    fn lambda(&self, cosine: f64) -> f64 {
        let squared_tangent = (1.0 - cosine * cosine).max(0.0) / (cosine * cosine);
        0.5 * ((1.0 + self.alpha * self.alpha * squared_tangent).sqrt() - 1.0)
    }

    /// The normal of a facet that is seen from `wo`: stretched to alpha = 1, facets are a hemisphere, of which a
    /// disk is seen.
    fn visible_facet(&self, wo: DVec3, [a, b]: [f64; 2]) -> DVec3 {
        let stretch = DVec3::new(self.alpha, self.alpha, 1.0);
        let view = (wo * stretch).normalize();
        let frame = Frame::around(view);
        // Axes of the disk: across the vertical plane of the view, and in it.
        let across = DVec3::Z.cross(view);
        let across = across.try_normalize().unwrap_or_else(|| frame.to_world(DVec3::X));
        let along = view.cross(across);
        let (radius, turn) = (a.sqrt(), TAU * b);
        let x = radius * turn.cos();
        let hidden = 0.5 * (1.0 + view.z);
        let y = (1.0 - hidden) * (1.0 - x * x).max(0.0).sqrt() + hidden * radius * turn.sin();
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let facet = x * across + y * along + z * view;
        (facet * stretch).normalize()
    }
}

/// Both directions away from the surface in the shading frame; `None` where nothing is reflected between them.
pub(super) fn local(incoming: DVec3, outgoing: DVec3, hit: &SurfaceHit<'_>) -> Option<[DVec3; 2]> {
    if !reflects(incoming, outgoing, hit) {
        return None;
    }
    let frame = Frame::around(facing(incoming, hit).1);
    Some([frame.to_local(-incoming), frame.to_local(outgoing)])
}
