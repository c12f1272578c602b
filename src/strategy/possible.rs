//! Which strategies the scene allows.

use crate::light::Light;
use crate::medium::Medium;
use crate::scene::{FinalGather, Scene, Strategy};

use super::kind::Conditions;

/// Strategies that a render may choose among: one for all media that can have it. The first that is allowed
/// is taken where a pilot tells nothing.
pub fn assignments(scene: &Scene, conditions: &Conditions) -> Vec<Vec<Strategy>> {
    use Strategy::{Beams, FluenceTowardEye, Moments, Traced};
    let always = conditions.final_gather == FinalGather::Always;
    let gathers = gathers(scene, conditions) && (always || !misses_caustics(scene));
    let strategies = match gathers && conditions.final_gather != FinalGather::Never {
        false => &[FluenceTowardEye, Beams][..],
        true => &[FluenceTowardEye, Beams, Moments, Traced],
    };
    let media = scene.media.iter().len();
    strategies.iter().map(|strategy| vec![*strategy; media]).collect()
}

/// The strategy that is taken where a pilot tells nothing.
pub fn first_allowed(scene: &Scene, conditions: &Conditions) -> Strategy {
    let all = assignments(scene, conditions).into_iter();
    let mut allowed = all.filter(|assignment| is_allowed(assignment, conditions));
    allowed.find_map(|assignment| assignment.first().copied()).unwrap_or_default()
}

/// Whether an assignment may be chosen: where final gathers must be, one with those.
pub fn is_allowed(assignment: &[Strategy], conditions: &Conditions) -> bool {
    conditions.final_gather != FinalGather::Always
        || assignment.iter().any(|strategy| strategy.holds_moments())
}

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

/// Whether rays behind mirrors and glass read light that a cache toward the camera does not hold.
pub(super) fn needs_beams(scene: &Scene) -> bool {
    let isotropic = scene.media.iter().all(|m| m.phase.is_isotropic());
    !isotropic && scene.surfaces.has_specular()
}
