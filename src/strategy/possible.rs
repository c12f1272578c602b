//! Which strategies the scene allows.

use crate::light::Light;
use crate::medium::Medium;
use crate::scene::Scene;

use super::kind::Conditions;

/// Whether final gathers are possible: not where orders of scattering are counted, and not where a
/// lamp is in a medium. Light sampling at the scatterings of a path has infinite variance there:
/// irradiance is as one over the squared distance, and the volume of places near the lamp only grows with
/// its cube.
pub(super) fn gathers(scene: &Scene, conditions: &Conditions) -> bool {
    let lights = &scene.lights.lights;
    let holds_lamp = |medium: &Medium| {
        let bounds = medium.density.bounds();
        let holds = |lamp| bounds.is_none_or(|bounds| bounds.contains(lamp));
        lights.iter().filter_map(Light::position).any(holds)
    };
    conditions.max_scatter.is_none() && !scene.media.iter().any(holds_lamp)
}

/// Whether gathers seldom find, or miss, light that mirrors and glass throw on media: they seldom meet a
/// lamp in a mirror, and never a point.
pub(super) fn misses_caustics(scene: &Scene) -> bool {
    scene.surfaces.has_specular() && !scene.lights.lights.iter().all(Light::is_environment)
}
