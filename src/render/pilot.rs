//! Pilot renders: the whole film at a low resolution, with few photons and few rays.
//!
//! Two stages use one: the director, for the X-map of scattered light, and the metering of the
//! exposure.

use super::control::Control;
use super::exposure::{RenderRegion, expose};
use super::pass_settings::PassSettings;
use super::photon_pass::PhotonPass;
use super::pixel_sampling::FilmPlace;
use super::stage_settings::{pass_settings, specialised};
use crate::director::PixelBudget;
use crate::error::Result;
use crate::film::FilmContents;
use crate::image::{Film, Window, meter};
use crate::math::{Spectrum, Stage};
use crate::photon::{PhotonDirection, PhotonSettings};
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::strategy::{Assignment, Strategy};
use crate::work::Work;

/// Ratio of the picture's photon paths to the director's pilot's; also the fewest paths of the pilot,
/// where the picture has as many.
const DIRECTOR_PHOTONS: u64 = 64;

/// Pixels of the director's maps along each side of the square for which its pilot renders one.
const DIRECTOR_PIXELS: u32 = 8;

/// Rays of each pixel of a pilot.
const RAYS: u32 = 4;

/// Flips bits of the seed, so that the noise of a pilot is independent of the picture's. An odd number
/// without a pattern: the multiplier of Knuth's MMIX generator.
pub(super) const PILOT_SEED: u64 = 0x5851_f42d_4c95_7f2d;

/// Pixels of the metered pilot along the longer side.
const METERED_PIXELS: f64 = 96.0;

/// Photon paths of the metered pilot.
const METERED_PHOTONS: u64 = 40_000;

/// Size and budget of a pilot.
#[derive(Debug, Clone, Copy)]
struct Pilot {
    /// Photon paths.
    photons: u64,
    /// Width and height in pixels of the pilot.
    size: [u32; 2],
    /// Pixels of the film along each side of one of those.
    pixels: f64,
    /// March step in metres; 0 is exact.
    step: f64,
}

impl Pilot {
    fn render<S: Spectrum, H: PhotonDirection>(
        self,
        scene: &Scene,
        settings: &RenderSettings,
        assignment: &Assignment,
    ) -> Result<(Film, Work)> {
        let Self { photons, size, pixels, step } = self;
        let whole = pass_settings(scene, settings);
        let seed = settings.seed ^ PILOT_SEED;
        let pass = PassSettings {
            photons: PhotonSettings { photons, seed, levels: 0, ..whole.photons },
            rays: RAYS,
            film_pixels: pixels,
            ..whole
        };
        let needs = pass.photons.needs;
        let (photons, mut work) = PhotonPass::<S, H>::new(scene, &pass, assignment, &|_| ())?;
        let budget = PixelBudget::fixed(RAYS, photons.radius, step).each_gathering();
        let integrator = photons.integrator(scene, needs);
        let scale = [0, 1].map(|axis| f64::from(scene.film.size[axis]) / f64::from(size[axis]));
        // All rays of one pixel lead through one pixel of the film, the middle one of its square.
        let within = |at: f64, scale: f64| ((at.floor() + 0.5) * scale).floor() + at.fract();
        let exposed = expose(
            RenderRegion {
                pass: None,
                size,
                window: Window::whole(size),
                shown: Window::whole(size),
                seed,
                stage: Stage::Director,
                rays: RAYS,
                times: 1,
                needs,
                contents: FilmContents::default(),
            },
            |FilmPlace { x, y, lens, .. }| {
                scene.camera.ray(within(x, scale[0]), within(y, scale[1]), lens)
            },
            |_, _| budget,
            |camera_ray, workspace| integrator.radiance(camera_ray, workspace),
            &[],
            &Control::silent(),
        );
        work += exposed.work;
        Ok((exposed.film, work))
    }
}

/// Renders the director's pilot by the strategies of the picture: photons and pixels in proportion to the picture's, the coarsest step.
pub(super) fn director_pilot<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
    assignment: &Assignment,
) -> Result<(Film, Work)> {
    let directing = &settings.directing;
    let pilot = Pilot {
        photons: (settings.photons / DIRECTOR_PHOTONS).max(settings.photons.min(DIRECTOR_PHOTONS)),
        pixels: f64::from(DIRECTOR_PIXELS) / directing.resolution,
        size: directing.map_size(scene.film.size).map(|side| side.div_ceil(DIRECTOR_PIXELS)),
        step: scene.media.detail().map_or(0.0, |voxel| voxel * directing.coarsest_step),
    };
    pilot.render::<S, H>(scene, settings, assignment)
}

/// Exposure of the PNG of `scene`, in stops, metered in a pilot of the whole film: the same for any
/// crop, seed and number of rays or photons. See [`meter`].
///
/// # Errors
/// Where photons cannot be shot.
pub fn exposure(scene: &Scene) -> Result<f64> {
    metered_pilot(scene).map(|film| metered(scene, &film))
}

/// Exposure in stops that a light meter gives the media of `scene` in a `film` of it. See [`meter`].
pub fn metered(scene: &Scene, film: &Film) -> f64 {
    let image = film.image();
    let luminances: Vec<f32> = image.luminances().map(|luminance| luminance as f32).collect();
    let transmittance = film.layer("transmittance").unwrap_or_default();
    let alpha: Vec<f32> = transmittance.iter().map(|t| 1.0 - t).collect();
    let glows = scene.media.iter().any(|medium| medium.emission.is_some());
    let stops = meter(&luminances, &alpha, glows).unwrap_or(0.0);
    // A hundredth of a stop cannot be seen, and is a number that one can write down.
    (stops * 100.0).round() / 100.0
}

/// Renders the pilot that is metered, which depends on the scene alone.
fn metered_pilot(scene: &Scene) -> Result<Film> {
    fn rendered<S: Spectrum, H: PhotonDirection>(
        scene: &Scene,
        settings: &RenderSettings,
        pilot: Pilot,
    ) -> Result<Film> {
        let (strategy, media) = (Strategy::FluenceTowardEye, scene.media.iter().len());
        let assignment = Assignment::uniform(strategy, media, "a meter needs no better one");
        pilot.render::<S, H>(scene, settings, &assignment).map(|(film, _)| film)
    }
    let size = scene.film.size.map(f64::from);
    let pixels = (size[0].max(size[1]) / METERED_PIXELS).max(1.0);
    let size = size.map(|side| (side / pixels).ceil() as u32);
    let pilot = Pilot { photons: METERED_PHOTONS, size, pixels, step: 0.0 };
    let max_scatter = scene.render.max_scatter;
    let settings =
        RenderSettings { photons: METERED_PHOTONS, max_scatter, ..RenderSettings::default() };
    specialised!(Needs::new(scene, &settings), rendered(scene, &settings, pilot))
}
