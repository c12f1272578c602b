//! The pilot of the director `variance`: a few rays a pixel, whose variance says how many the picture needs.

use super::control::Control;
use super::exposure::{RenderRegion, expose};
use super::integrator::Integrator;
use super::pilot::PILOT_SEED;
use super::pixel_sampling::FilmPlace;
use super::stage_settings::render_region;
use crate::director::{PixelBudget, variance_budgets};
use crate::film::{FIRST_RAYS, FilmContents};
use crate::image::Window;
use crate::math::{Spectrum, Stage};
use crate::photon::PhotonDirection;
use crate::scene::{RenderSettings, Scene};
use crate::work::Work;

/// The budget of each pixel of the film, row by row from the top, where `gold` is the gold standard's, and the
/// work of finding it. Pixels outside of the window have the gold standard's.
///
/// The pilot's rays are those of a first pass with numbers of their own: they read the cells of caches that the
/// picture's first pass reads.
pub(super) fn budgets_by_variance<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    integrator: &Integrator<'_, S, H>,
    gold: PixelBudget,
) -> (Vec<PixelBudget>, Work) {
    let rays = FIRST_RAYS.min(settings.rays);
    let region = render_region(scene, settings, Stage::Director);
    // Pixels at the border of a crop have the neighbours that they have in the whole picture.
    let window = region.window.grown(1, region.size);
    let budget = PixelBudget::fixed(rays, gold.radius, gold.step).each_gathering();
    let exposed = expose(
        RenderRegion {
            window,
            seed: settings.seed ^ PILOT_SEED,
            rays,
            times: 1,
            contents: FilmContents::default(),
            ..region
        },
        |FilmPlace { x, y, lens, .. }| scene.camera.ray(x, y, lens),
        |_, _| budget,
        |camera_ray, workspace| integrator.radiance(camera_ray, workspace),
        &[],
        &Control::silent(),
    );
    let [width, height] = region.size.map(|side| side as usize);
    let mut budgets = vec![gold; width * height];
    let Window { left, top, width: columns, .. } = window;
    let found = variance_budgets(&exposed.film, rays, gold, &settings.directing);
    for (row, found) in found.chunks_exact(columns as usize).enumerate() {
        let first = (top as usize + row) * width + left as usize;
        budgets[first..first + found.len()].copy_from_slice(found);
    }
    (budgets, exposed.work)
}
