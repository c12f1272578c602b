//! What the settings of a render mean for each of its stages: photons, march step, film.

use std::ops::Range;

use super::exposure::RenderRegion;
use super::pass_settings::PassSettings;
use crate::cache::SamplePass;
use crate::director::PixelBudget;
use crate::film::{AovSums, FilmContents, RECONSTRUCTION_REACH};
use crate::image::Window;
use crate::math::Stage;
use crate::photon::PhotonSettings;
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};

/// Photon paths, at most, that are traced to estimate what all of them take.
const SAMPLED_PATHS: u64 = 1 << 14;

/// Calls a generic function with the types that a scene needs: `specialised!(needs, f(arguments))`
/// is `f::<S, H>(arguments)`, with `S` the [`Spectrum`](crate::math::Spectrum) of one or three
/// channels and `H` the [`PhotonDirection`](crate::photon::PhotonDirection) that photons in media
/// store. The `match` stands here, outside of all loops, and lists the four instances that are
/// compiled; a function pointer or trait object could not carry the types.
macro_rules! specialised {
    ($needs:expr, $f:ident($($argument:expr),* $(,)?)) => {
        match ($needs.colors, $needs.directions) {
            (true, true) => $f::<crate::math::Rgb, crate::photon::Octahedral>($($argument),*),
            (true, false) => $f::<crate::math::Rgb, crate::photon::NoDirection>($($argument),*),
            (false, true) => $f::<f64, crate::photon::Octahedral>($($argument),*),
            (false, false) => $f::<f64, crate::photon::NoDirection>($($argument),*),
        }
    };
}
pub(super) use specialised;

/// As [`specialised`], with a spectrum that tells parts of light apart where a pass asks for that: for all that makes the
/// film of a picture. Photons then have directions, needed or not, which saves an instance.
macro_rules! specialised_for_film {
    ($needs:expr, $f:ident($($argument:expr),* $(,)?)) => {
        if $needs.parts {
            $f::<crate::math::GroupedRgb, crate::photon::Octahedral>($($argument),*)
        } else {
            specialised!($needs, $f($($argument),*))
        }
    };
}
pub(super) use specialised_for_film;

/// Settings of a photon pass with all paths of `settings`, and with the full photon map alone.
pub(super) fn pass_settings(scene: &Scene, settings: &RenderSettings) -> PassSettings {
    PassSettings {
        photons: PhotonSettings {
            photons: settings.photons,
            traced: None,
            seed: settings.seed,
            max_scatter: settings.max_scatter,
            radius: settings.radius,
            levels: 0,
            needs: Needs::new(scene, settings),
            any_camera: false,
        },
        pass: None,
        strategy: settings.strategy,
        measures_one: settings.measures_error() || settings.error.is_some(),
        final_gather: settings.final_gather,
        rays: settings.rays,
        film_pixels: 1.0,
        gather_share: 1.0,
    }
}

/// As [`pass_settings`], but only the first few of the paths are traced. Returns how many as well.
pub(super) fn sampled_pass_settings(
    scene: &Scene,
    settings: &RenderSettings,
) -> (PassSettings, u64) {
    let paths = SAMPLED_PATHS.min(settings.photons);
    (pass_settings(scene, settings).pilot(paths), paths)
}

/// March step of the gold standard, in metres: the one that `settings` give, or else the shortest voxel
/// edge of all media, at which cells are integrated exactly; 0 where there is no grid.
pub(super) fn finest_step(scene: &Scene, settings: &RenderSettings) -> f64 {
    settings.step.unwrap_or_else(|| scene.media.detail().unwrap_or(0.0))
}

/// The part of the film that the picture under `settings` shows.
pub(super) fn shown_window(scene: &Scene, settings: &RenderSettings) -> Window {
    settings.crop.unwrap_or(Window::whole(scene.film.size))
}

/// The part of the film that gets rays under `settings`: what the picture shows, and the pixels around it that its
/// reconstruction reads.
pub(super) fn exposed_window(scene: &Scene, settings: &RenderSettings) -> Window {
    let reach = if settings.reconstructs() { RECONSTRUCTION_REACH as u32 } else { 0 };
    shown_window(scene, settings).grown(reach, scene.film.size)
}

/// The region of the film that is rendered, with random streams of `stage`.
pub(super) fn render_region(
    scene: &Scene,
    settings: &RenderSettings,
    stage: Stage,
) -> RenderRegion {
    let size = scene.film.size;
    RenderRegion {
        size,
        window: exposed_window(scene, settings),
        shown: shown_window(scene, settings),
        seed: settings.seed,
        stage,
        rays: PixelBudget::fixed(settings.rays, 0.0, 0.0).of_pass(settings).rays,
        pass: settings.pass.filter(|pass| pass.count > 1).map(|pass| {
            let Range { start, end } = pass.share(settings.rays.into(), settings.rays);
            let [first, shot] = [start, end - start].map(|rays| rays as u32);
            SamplePass { index: 0, rays: settings.rays, first, shot }
        }),
        times: scene.moments().len() as u32,
        needs: Needs::new(scene, settings),
        contents: film_contents(scene, settings),
    }
}

/// What pixels gather beside their samples under `settings`.
pub(super) fn film_contents(scene: &Scene, settings: &RenderSettings) -> FilmContents {
    let passes = scene.film.passes;
    FilmContents {
        features: settings.denoise || passes.has_features(),
        components: settings.in_halves(),
        aovs: AovSums { passes, groups: scene.groups.names, in_halves: settings.reconstructs() },
    }
}
