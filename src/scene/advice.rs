//! Whether the step and radius that were asked for suit the scene.

use super::Scene;

/// Mean free paths that a step may span where it is longer than a voxel: beyond, what is in the step
/// is hidden behind its front.
const FREE_PATHS: f64 = 1.0;

/// Share of the smallest side of the media that a gather may be wide: beyond, it takes in light from
/// outside of them.
const WIDE: f64 = 0.125;

/// Photons that a gather along a ray through the media should find at least.
const FEW: f64 = 4.0;

/// Photons that it finds where the radius is chosen well.
const ENOUGH: f64 = 64.0;

/// Share of the media's size to which places of photons are rounded, being held in 32 bits.
const ROUNDING: f64 = 1e-6;

/// What is wrong with the march step, gather radius and photon count of `scene`'s settings, and what
/// to give instead, one sentence each; nothing where they are in the range that `fogbow verify`
/// holds against closed forms. Defaults are always in it.
pub fn advice(scene: &Scene) -> Vec<String> {
    let mut said = Vec::new();
    if scene.media.is_empty() {
        return said;
    }
    said.extend(scene.render.step.and_then(|step| of_step(scene, step)));
    said.extend(scene.render.radius.and_then(|radius| of_radius(scene, radius)));
    let scatters = scene.render.max_scatter.is_none_or(|most| most > 1);
    if scene.render.photons == 0 && scatters {
        said.push(
            "no photons: light that is scattered more than once is missing; give photons, or \
             max_scatter = 1 where that is meant"
                .into(),
        );
    }
    said
}

/// A step of one voxel is exact; longer ones sample the density once.
fn of_step(scene: &Scene, step: f64) -> Option<String> {
    let voxel = scene.media.detail().filter(|voxel| step > *voxel)?;
    let grids = scene.media.iter().filter(|m| m.density.is_voxel());
    let densest = grids.map(|m| m.sigma_t.max_element() * m.density.maximum()).fold(0.0, f64::max);
    let free_path = 1.0 / densest;
    let good = voxel.max(FREE_PATHS * free_path);
    (step > good).then(|| {
        format!(
            "step {step:.3e} m is {:.3e} voxels and {:.3e} mean free paths where the medium is \
             densest ({free_path:.3e} m), so that much of it is skipped; give at most {good:.3e} m, \
             or none for exact integration",
            step / voxel,
            step / free_path
        )
    })
}

fn of_radius(scene: &Scene, radius: f64) -> Option<String> {
    let bounds = scene.media.bounds();
    if bounds.is_empty() || scene.media.is_endless() {
        return None;
    }
    let size = bounds.size();
    let volume: f64 = scene.media.iter().filter_map(|m| m.density.volume()).sum();
    let volume = volume.min(size.element_product()).max(f64::MIN_POSITIVE);
    let photons = scene.render.photons as f64;
    // A beam through the media has the length of their size, by volume.
    let length = size.element_product().cbrt();
    let per_area = photons * length / volume * std::f64::consts::PI;
    let widest = WIDE * size.min_element();
    let good = (ENOUGH / per_area).sqrt().min(widest).max(ROUNDING * size.max_element());
    let instead = format!("give about {good:.1e} m, or none to let photons choose their own");
    if radius > widest {
        return Some(format!(
            "radius {radius:.3e} m is {:.3e} of the media's smallest side, so that light blurs \
             beyond their edge and they look too dark (no more than their size is taken); {instead}",
            radius / size.min_element()
        ));
    }
    let found = per_area * radius * radius;
    let spacing = (volume / photons).cbrt();
    (photons > 0.0 && (found < FEW || radius < ROUNDING * size.max_element())).then(|| {
        format!(
            "radius {radius:.3e} m is small for {photons} photons {spacing:.1e} m apart: a gather \
             finds about {found:.1e} of them, and most of the picture none; {instead}"
        )
    })
}
