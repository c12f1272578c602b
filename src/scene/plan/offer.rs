//! What could be left out at the price of a small error.

use crate::math::Rgb;
use crate::medium::{Albedo, Medium};
use crate::scene::{RenderSettings, Scene};
use crate::surface::{Material, Texture};

/// Largest bound at which an omission is offered.
const SMALL: f64 = 0.05;

/// Offers `max_scatter` = 1 where all light that is scattered more often is bounded by a small share
/// of the brightest light that is scattered once.
///
/// Let tau bound the optical thickness of any straight line and a the albedo. Light scattered n + 1
/// times is nowhere brighter than q = a (1 - exp(-tau)) times the brightest light scattered n
/// times; where surfaces reflect at most rho, any number of reflections in between raises that to
/// r = q / (1 - rho). The rest is a geometric series: at most r / (1 - r) of the brightest light
/// scattered once (the operator norms of Veach 1997, section 4.3).
pub(super) fn single_scattering(scene: &Scene, settings: &RenderSettings) -> Option<String> {
    if scene.media.is_empty() || settings.max_scatter.is_some_and(|orders| orders <= 1) {
        return None;
    }
    let thickness: f64 = scene.media.iter().map(thickness).sum();
    let albedo = scene.media.iter().map(albedo).fold(0.0, f64::max);
    let materials = scene.surfaces.materials();
    let reflectance = materials.map(reflectance).fold(0.0, f64::max);
    let ratio = albedo * -(-thickness).exp_m1() / (1.0 - reflectance);
    let rest = ratio / (1.0 - ratio);
    let offered = ratio > 0.0 && ratio < 1.0 && rest <= SMALL;
    offered.then(|| {
        format!(
            "max_scatter = 1 would leave out light scattered more than once: at most {:.2} % of the \
             brightest light scattered once (optical thickness at most {thickness:.4})",
            100.0 * rest
        )
    })
}

/// A bound of the optical thickness of any straight line through `medium`.
fn thickness(medium: &Medium) -> f64 {
    let length = medium.density.bounds().map_or(f64::INFINITY, |b| b.size().length());
    let most = medium.sigma_t_max(glam::BVec3::TRUE) * medium.density.maximum();
    if most > 0.0 { most * length } else { 0.0 }
}

/// A bound of the albedo.
fn albedo(medium: &Medium) -> f64 {
    match &medium.albedo {
        Albedo::Constant(albedo) => albedo.max_element(),
        Albedo::Color { .. } | Albedo::Scalar { .. } | Albedo::Ramped(_) => 1.0,
    }
}

/// A bound of the share of light that `material` reflects.
fn reflectance(material: &Material) -> f64 {
    match material {
        Material::Black => 0.0,
        Material::Diffuse { reflectance: Texture::Constant(reflectance) }
        | Material::Mirror { reflectance } => Rgb::max_element(*reflectance),
        Material::Diffuse { .. }
        | Material::Plastic(_)
        | Material::Metal(_)
        | Material::Glass(_) => 1.0,
    }
}
