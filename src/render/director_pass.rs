//! Pass 0 of a render: the director's maps, and what they hand out.

use std::time::Instant;

use crate::director::{
    CachedSnapshot, PixelBudget, Saliency, Snapshot, false_medium, radius_level, resampled,
    uncertainty, x_map, xs_map,
};
use crate::error::Result;
use crate::image::{Film, Image, Window};
use crate::math::{Spectrum, Stage};
use crate::photon::{PhotonDirection, PhotonSettings};
use crate::scene::plan::Needs;
use crate::scene::{Director, Importance, RenderSettings, Scene};
use crate::work::Work;

use super::exposure::{RenderRegion, expose};
use super::integrator::Integrator;
use super::photon_pass::{PassSettings, PhotonPass};
use super::{Control, Directed, Stages, specialised};

/// Photon paths of a look at few of them, at most.
const PATHS: u64 = 1 << 14;

/// Share of the photons with which the light is first looked at.
const PILOT_PHOTONS: u64 = 64;

/// Pixels of the maps along each side of the squares of which that look takes one.
const PILOT_PIXELS: u32 = 8;

/// Distinguishes the photons of that look from those of the picture, so that what they happen to
/// show has no part in both.
const PILOT_SEED: u64 = 0x5851_f42d_4c95_7f2d;

/// Rays through each of those pixels.
const PILOT_RAYS: u32 = 4;

/// The director's maps, one value for each of `size` pixels, row by row from the top. What was not
/// asked for is empty.
#[derive(Debug, Default)]
pub struct Maps {
    /// Width and height.
    pub size: [u32; 2],
    /// First-hit distances and the snapshot.
    pub sight: Option<CachedSnapshot>,
    /// Transmittance to the first surface.
    pub transmittance: Vec<f32>,
    /// Work for those, without that of the pilot, as it is where no sight is kept.
    pub work: Work,
    /// The part of it that a kept sight made unnecessary.
    pub spared: Work,
    /// A coarse look at the picture, light scattered by media included.
    pub pilot: Option<Image>,
    /// Work done for it, few photons among it.
    pub pilot_work: Work,
    /// How uncertain the light in it is.
    pub uncertainty: Vec<f32>,
    /// What X says: transmittance or uncertainty, as asked.
    pub x: Vec<f32>,
    /// The snapshot seen through X with the inverted X over it.
    pub false_medium: Option<Image>,
    /// What catches the eye in it.
    pub saliency: Option<Saliency>,
    /// X and S in one.
    pub xs: Vec<f32>,
}

/// Which maps are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Those that the XS-map needs.
    Needed,
    /// All.
    All,
}

/// Makes the maps that `settings` ask for, those of the director `xs` where it asks for none.
/// Their size is that of the film times the resolution asked for. Where `kept` suits it is taken
/// for the first look.
///
/// # Errors
/// Where an emitter cannot be sampled.
pub fn maps(
    scene: &Scene,
    settings: &RenderSettings,
    kept: Option<CachedSnapshot>,
    extent: Extent,
    stages: &mut Stages,
) -> Result<Maps> {
    let asked = &settings.directing;
    let weights = match settings.director {
        Director::X => [1.0, 0.0],
        Director::S => [0.0, 1.0],
        Director::Fixed | Director::Xs | Director::Variance => asked.weights,
    };
    let all = extent == Extent::All;
    let needs = Needs::of(scene, settings);
    let needs_saliency = all || weights[1] > 0.0;
    let looks = all || (weights[0] > 0.0 && asked.x == Importance::Scattering);
    let size = asked.map_size(scene.film.size);
    let mut maps = Maps { size, ..Maps::default() };
    let needs_transmittance = needs_saliency || !looks;
    if needs_transmittance {
        let start = Instant::now();
        let kept = kept.filter(|kept| kept.suits(scene, settings));
        maps.spared = kept.as_ref().map_or(Work::default(), |kept| kept.work);
        let kept = kept.unwrap_or_else(|| {
            let (sight, work) = Snapshot::look(scene, size, settings.seed, needs);
            CachedSnapshot::new(sight, work, scene, settings)
        });
        stages.done("snapshot", start);
        let start = Instant::now();
        let (transmittance, marching) = x_map(scene, &kept.sight, needs);
        stages.done("x", start);
        maps.work += kept.work;
        maps.work += marching;
        maps.x.clone_from(&transmittance);
        if needs_saliency {
            let start = Instant::now();
            let veiled = false_medium(&kept.sight.snapshot, &transmittance);
            maps.saliency = Some(Saliency::of(&veiled));
            maps.false_medium = Some(veiled);
            stages.done("saliency", start);
        }
        maps.transmittance = transmittance;
        maps.sight = Some(kept);
    }
    if looks {
        let start = Instant::now();
        let (pilot, work) = specialised!(needs, pilot(scene, settings))?;
        maps.pilot_work = work;
        let coarse = [pilot.width(), pilot.height()].map(|side| side as u32);
        maps.uncertainty = resampled(&uncertainty(&pilot), coarse, size);
        if asked.x == Importance::Scattering {
            maps.x.clone_from(&maps.uncertainty);
        }
        maps.pilot = Some(pilot.image());
        stages.done("pilot", start);
    }
    let saliency = maps.saliency.as_ref().map_or(&[][..], |saliency| &saliency.map);
    maps.xs = xs_map(&maps.x, saliency, weights, asked.operator);
    maps.work.map_pixels += maps.xs.len() as u64;
    Ok(maps)
}

/// A coarse look at the picture: few photons in wide gathers, and rays for few pixels.
fn pilot<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    settings: &RenderSettings,
) -> Result<(Film, Work)> {
    let asked = &settings.directing;
    let look = Pilot {
        photons: (settings.photons / PILOT_PHOTONS).max(settings.photons.min(PILOT_PHOTONS)),
        pixels: f64::from(PILOT_PIXELS) / asked.resolution,
        size: asked.map_size(scene.film.size).map(|side| side.div_ceil(PILOT_PIXELS)),
        step: scene.media.detail().map_or(0.0, |voxel| voxel * asked.coarsest_step),
    };
    look.take::<S, H>(scene, settings)
}

/// A look at the whole film with few photons and rays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pilot {
    /// Photon paths.
    pub(super) photons: u64,
    /// Width and height of the look in its own pixels.
    pub(super) size: [u32; 2],
    /// Pixels of the film, along each side, for one of those.
    pub(super) pixels: f64,
    /// March step in metres; 0 is exact.
    pub(super) step: f64,
}

impl Pilot {
    fn take<S: Spectrum, H: PhotonDirection>(
        self,
        scene: &Scene,
        settings: &RenderSettings,
    ) -> Result<(Film, Work)> {
        let Self { photons, size, pixels, step } = self;
        let whole = shooting(scene, settings);
        let seed = settings.seed ^ PILOT_SEED;
        let shooting = PassSettings {
            photons: PhotonSettings { photons, seed, levels: 0, ..whole.photons },
            rays: PILOT_RAYS,
            film_pixels: pixels,
            denoise: false,
            ..whole
        };
        let needs = shooting.photons.needs;
        let (photons, mut work) = PhotonPass::<S, H>::new(scene, &shooting, &|_| ())?;
        let budget = PixelBudget::fixed(PILOT_RAYS, photons.maps.volume_radius, step);
        let integrator = Integrator::new(scene, &photons, needs);
        let scale = [0, 1].map(|axis| f64::from(scene.film.size[axis]) / f64::from(size[axis]));
        // All rays of one place lead through the same pixel, the middle one of its square.
        let within = |at: f64, scale: f64| ((at.floor() + 0.5) * scale).floor() + at.fract();
        let exposed = expose(
            RenderRegion {
                size,
                window: Window::whole(size),
                seed: settings.seed ^ PILOT_SEED,
                stage: Stage::Director,
                rays: PILOT_RAYS,
                needs,
                features: false,
            },
            |x, y, lens| scene.camera.ray(within(x, scale[0]), within(y, scale[1]), lens),
            |_, _| budget,
            |ray, workspace| integrator.radiance(ray, workspace),
            &[],
            &Control::silent(),
        );
        work += exposed.work;
        Ok((exposed.film, work))
    }
}

/// Looks at `scene` as `look` says, else as in `settings`.
pub(super) fn coarse_look(scene: &Scene, settings: &RenderSettings, look: Pilot) -> Result<Film> {
    fn taken<S: Spectrum, H: PhotonDirection>(
        scene: &Scene,
        settings: &RenderSettings,
        look: Pilot,
    ) -> Result<Film> {
        look.take::<S, H>(scene, settings).map(|(film, _)| film)
    }
    let needs = Needs::of(scene, settings);
    specialised!(needs, taken(scene, settings, look))
}

/// Photons shot where nothing thins them.
pub(super) fn shooting(scene: &Scene, settings: &RenderSettings) -> PassSettings {
    PassSettings {
        photons: PhotonSettings {
            photons: settings.photons,
            traced: None,
            seed: settings.seed,
            max_scatter: settings.max_scatter,
            radius: settings.radius,
            levels: 0,
            needs: Needs::of(scene, settings),
        },
        final_gather: settings.final_gather,
        denoise: settings.denoise,
        rays: settings.rays,
        film_pixels: 1.0,
    }
}

/// As [`shooting`], for a look at few of the paths, and how many those are.
pub(super) fn look(scene: &Scene, settings: &RenderSettings) -> (PassSettings, u64) {
    let paths = PATHS.min(settings.photons);
    (shooting(scene, settings).pilot(paths), paths)
}

impl Maps {
    /// What they took, without the coarse look at scattered light.
    pub(super) fn director(&self) -> Option<Directed> {
        let spared = self.spared;
        (!self.xs.is_empty()).then(|| Directed { work: self.work.less(&spared), spared })
    }

    /// How photons are shot: with the levels that the widest gathers need.
    pub(super) fn shooting(&self, scene: &Scene, settings: &RenderSettings) -> PassSettings {
        let asked = &settings.directing;
        let level = |xs: &f32| if asked.directed.radius { radius_level(asked, *xs) } else { 0 };
        let levels = self.xs.iter().map(level).max().unwrap_or(0);
        let whole = shooting(scene, settings);
        PassSettings { photons: PhotonSettings { levels, ..whole.photons }, ..whole }
    }

    /// What each pixel of the film may spend out of `gold`, which all would have had.
    pub(super) fn budgets(
        &self,
        scene: &Scene,
        settings: &RenderSettings,
        gold: PixelBudget,
    ) -> Vec<PixelBudget> {
        if self.xs.is_empty() {
            return Vec::new();
        }
        let voxel = scene.media.detail();
        let on_film = |map: &Vec<f32>| resampled(map, self.size, scene.film.size);
        let saliency = self.saliency.as_ref().map(|saliency| on_film(&saliency.map));
        let budget = |(index, xs): (usize, &f32)| PixelBudget {
            saliency: saliency.as_ref().map_or(1.0, |map| f64::from(map[index])),
            ..gold.for_importance(*xs, &settings.directing, voxel)
        };
        on_film(&self.xs).iter().enumerate().map(budget).collect()
    }
}
