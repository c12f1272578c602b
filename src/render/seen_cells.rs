//! Fills the cells of direct light and of optical thickness that the camera sees, and finds where gathers start in them,
//! before there are rays: what saved photons keep for all crops and passes of a picture.

use std::sync::Arc;

use rayon::prelude::*;

use crate::cache::{CellOrigins, DirectLightCache};
use crate::math::{Rgb, Spectrum, Stage, Stream};
use crate::medium::Profile;
use crate::scene::Scene;
use crate::transport::{PathContext, PixelFootprint, camera_view};
use crate::work::Work;

use super::pass_settings::PassSettings;
use super::progress::Progress;

/// Places along the ray through the middle of each pixel whose cells are filled. Rays that sample others fill what is
/// left.
const PLACES: u32 = 64;

/// Fills the cells of `direct` light and of optical thickness to the camera around the places that camera rays sample, finds
/// the `origins` of gathers in those, and counts the work. It does not depend on the number of threads.
pub(super) fn fill<S: Spectrum>(
    scene: &Scene,
    settings: &PassSettings,
    direct: &[Option<DirectLightCache<S>>],
    origins: &[Option<Arc<CellOrigins<S>>>],
    progress: &dyn Progress,
) -> Work {
    let with_cells = |cache: &Option<DirectLightCache<S>>| {
        cache.as_ref().is_some_and(|cache| cache.cells().is_some())
    };
    if !direct.iter().any(with_cells) && origins.iter().all(Option::is_none) {
        return Work::default();
    }
    let footprint = PixelFootprint::new(scene, settings.film_pixels);
    let [width, height] = scene.film.size;
    progress.stage("cells", height.into());
    let row = |y: u32| {
        let start = Stream::new(settings.photons.seed, Stage::March, 0, 0);
        let mut ctx = PathContext::new(start, settings.photons.needs);
        let mut profile = Profile::<S>::default();
        for x in 0..width {
            let ray = scene.camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5, [0.5; 2]);
            profile.trace(&scene.media, &ray, camera_view::clear_span(scene, &ray), 0.0, 0.5);
            profile.count(&mut ctx.work);
            for stratum in 0..PLACES {
                // Denser toward the end, where cells are deep in the medium and rays sample few of them.
                let left = 1.0 - (f64::from(stratum) + 0.5) / f64::from(PLACES);
                let Some(place) = profile.sample([1.0 - left * left, 0.5]) else { break };
                let p = ray.at(place.t);
                for ((medium, direct), origins) in scene.media.iter().zip(direct).zip(origins) {
                    if medium.sigma_t_at(p) == Rgb::ZERO {
                        continue;
                    }
                    let _ = direct.as_ref().and_then(|of| of.interpolated(scene, p, &mut ctx));
                    let origins = origins.iter();
                    origins.for_each(|of| of.thickness().fill(scene, p, &footprint, &mut ctx));
                }
            }
        }
        progress.advance(1);
        let mut work = ctx.work;
        work += ctx.amortized.work;
        work
    };
    let mut work: Work = (0..height).into_par_iter().map(row).sum();
    let needs = settings.photons.needs;
    work += origins.iter().flatten().map(|of| of.keep_known(scene, &footprint, needs)).sum();
    progress.finish();
    work
}
