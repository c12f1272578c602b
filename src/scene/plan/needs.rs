//! The work that a render of a scene needs, as plain facts.

use serde::Serialize;

use crate::light::Light;
use crate::math::{Rgb, WorldPoint};
use crate::medium::{Albedo, Emission, Medium};
use crate::scene::{Director, Planning, RenderSettings, Scene};
use crate::surface::Material;

/// The work that a render needs. A field is true where that work can change the picture. Stages take
/// these facts and inspect the scene no further.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Needs {
    /// The director's maps are made.
    pub maps: bool,
    /// Rays are intersected with surfaces.
    pub surfaces: bool,
    /// Rays are marched through media.
    pub media: bool,
    /// Light that media scatter is evaluated along rays.
    pub scattering: bool,
    /// Emission of media is integrated along rays.
    pub emission: bool,
    /// Photons are stored in media.
    pub volume_photons: bool,
    /// Photons are stored on surfaces.
    pub surface_photons: bool,
    /// Light is traced in three channels.
    pub colors: bool,
    /// Light is told apart by the group of its emitters, or by the order of its scattering.
    pub parts: bool,
    /// Photons in media store their direction, for a phase function that is not isotropic.
    pub directions: bool,
    /// Photons are shot that can reach neither a medium nor a surface.
    pub void: bool,
    /// Rays are followed through mirrors and glass.
    pub specular: bool,
    /// There are several lights to choose from.
    pub light_choice: bool,
    /// Rays that leave the scene may see a light infinitely far away.
    pub environment: bool,
}

impl Needs {
    /// All work, whatever the scene: for tests that leaving work out changes nothing. It makes no passes.
    pub const EVERYTHING: Self = Self {
        maps: true,
        surfaces: true,
        media: true,
        scattering: true,
        emission: true,
        volume_photons: true,
        surface_photons: true,
        colors: true,
        parts: false,
        directions: true,
        void: true,
        specular: true,
        light_choice: true,
        environment: true,
    };

    /// The work that rendering `scene` under `settings` needs; all work under
    /// [`Planning::Everything`].
    pub fn new(scene: &Scene, settings: &RenderSettings) -> Self {
        match settings.planning {
            Planning::Needed => Self::least(scene, settings),
            Planning::Everything => {
                Self { parts: scene.film.passes.has_parts(), ..Self::EVERYTHING }
            }
        }
    }

    /// As [`new`](Self::new) with [`Planning::Needed`].
    pub(super) fn least(scene: &Scene, settings: &RenderSettings) -> Self {
        let lights = &scene.lights.lights;
        let media = || scene.media.iter();
        let materials = || scene.surfaces.materials();
        let glows = media().any(emits);
        let lit = glows || lights.iter().any(shines);
        let orders = settings.max_scatter.unwrap_or(u32::MAX);
        let scattering = lit && orders > 0 && media().any(scatters);
        let reflects = scene.surfaces.has_specular() || materials().any(receives);
        Self {
            maps: !matches!(settings.director, Director::Fixed | Director::Variance),
            surfaces: !scene.surfaces.is_empty(),
            media: media().any(|m| attenuates(m) || emits(m)),
            scattering,
            emission: glows,
            // Light that is scattered once straight from a lamp is sampled, not mapped.
            volume_photons: scattering && (orders > 1 || glows || reflects),
            surface_photons: lit && materials().any(receives),
            colors: !(media().all(Medium::is_grey)
                && lights.iter().all(Light::is_grey)
                && materials().all(Material::is_grey)),
            parts: scene.film.passes.has_parts(),
            directions: scattering && media().any(|m| scatters(m) && !m.phase.is_isotropic()),
            void: false,
            specular: scene.surfaces.has_specular(),
            light_choice: lights.len() > 1,
            environment: lights.iter().any(is_seen_afar),
        }
    }

    /// Whether any photon is shot.
    pub const fn photons(&self) -> bool {
        self.volume_photons || self.surface_photons
    }
}

/// Whether `medium` weakens light that crosses it.
pub(super) fn attenuates(medium: &Medium) -> bool {
    medium.sigma_t != Rgb::ZERO && medium.density.maximum() > 0.0
}

/// Whether `medium` scatters light.
pub(super) fn scatters(medium: &Medium) -> bool {
    let scatters = match &medium.albedo {
        Albedo::Constant(albedo) => *albedo != Rgb::ZERO,
        Albedo::Color { grid, scale } => grid.max_value() > 0.0 && *scale != Rgb::ZERO,
        Albedo::Scalar { grid, scale } => grid.max_value() > 0.0 && *scale != Rgb::ZERO,
        Albedo::Ramped(ramped) => {
            let grid = ramped.grid();
            ramped.transfer().peak([grid.min_value(), grid.max_value()].map(f64::from)) > 0.0
        }
    };
    scatters && attenuates(medium)
}

/// Whether `medium` gives off light.
pub(super) fn emits(medium: &Medium) -> bool {
    match &medium.emission {
        None => false,
        Some(Emission::Density(color)) => *color != Rgb::ZERO && medium.density.maximum() > 0.0,
        Some(Emission::Grid { grid, color }) => *color != Rgb::ZERO && grid.max_inside() > 0.0,
        Some(Emission::Ramped(ramped)) => ramped.peak() > 0.0,
        Some(Emission::Blackbody { scale, .. }) => *scale > 0.0 && attenuates(medium),
    }
}

/// Whether a photon map on `material` shows.
fn receives(material: &Material) -> bool {
    material.is_diffuse()
}

/// Whether `light` gives any light.
fn shines(light: &Light) -> bool {
    !light.is_infinite() || is_bright(light)
}

/// Whether a ray that leaves the scene can see `light`.
pub(super) fn is_seen_afar(light: &Light) -> bool {
    light.is_infinite() && !light.is_delta() && is_bright(light)
}

/// Whether `light`, infinitely far away and so the same from everywhere, is not black.
fn is_bright(light: &Light) -> bool {
    light.incident_estimate(WorldPoint::new(0.0, 0.0, 0.0)) > 0.0
}
