//! The director pass: maps over the picture, and the budget of each pixel that follows from them.

use std::time::Instant;

use super::error_pilot::{ErrorMaps, error_maps};
use super::pass_settings::PassSettings;
use super::photon_file::SavedPhotons;
use super::photon_pass::strategies;
use super::pilot::director_pilot;
use super::progress::Stages;
use super::rendered::DirectorWork;
use super::stage_settings::{pass_settings, specialised};
use crate::director::{
    CachedSnapshot, PixelBudget, Saliency, Snapshot, false_medium, radius_level, resampled,
    scattering_x_map, x_map, xs_map,
};
use crate::error::Result;
use crate::image::Image;
use crate::photon::PhotonSettings;
use crate::scene::plan::Needs;
use crate::scene::{Director, Importance, RenderSettings, Scene};
use crate::strategy::Assignment;
use crate::work::Work;

/// The director's maps, one value for each of `size` pixels, row by row from the top. A map that was
/// not made is empty.
#[derive(Debug, Default)]
pub struct DirectorMaps {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// First-hit distances and the snapshot.
    pub snapshot: Option<CachedSnapshot>,
    /// Transmittance to the first surface.
    pub transmittance: Vec<f32>,
    /// Work for snapshot, X, S and XS, without the pilot's. A cached snapshot counts as if it had been
    /// rendered.
    pub work: Work,
    /// The part of `work` that a cached snapshot saved.
    pub spared: Work,
    /// The pilot's picture, light scattered by media included.
    pub pilot: Option<Image>,
    /// Work for the pilot, its photons included.
    pub pilot_work: Work,
    /// X of scattered light, measured in the pilot; see [`scattering_x_map`].
    pub scattering_x: Vec<f32>,
    /// X of measured error; see [`error_x_map`](crate::director::error_x_map).
    pub error_x: Vec<f32>,
    /// The X that enters XS: one of the three above.
    pub x: Vec<f32>,
    /// The snapshot seen through the medium that X describes.
    pub false_medium: Option<Image>,
    /// S, the saliency of that picture, or where X is measured error of the pilot's.
    pub saliency: Option<Saliency>,
    /// XS, the importance of each pixel.
    pub xs: Vec<f32>,
}

/// Which of the director's maps are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Those that XS is made of.
    Needed,
    /// All.
    All,
}

/// What a frame of a sequence takes over from earlier ones.
#[derive(Debug, Default)]
pub struct Earlier<'a> {
    /// The director's snapshot of the frame before. Where it matches the scene, no rays are traced for a
    /// new one; the picture and the work that it reports are the same.
    pub snapshot: Option<CachedSnapshot>,
    /// The strategies of the shot, of [`shot_strategies`](super::shot_strategies).
    pub strategies: Option<&'a Assignment>,
    /// Photons that were saved, with the strategies of their own.
    pub photons: Option<&'a SavedPhotons>,
}

/// Makes the maps of the director that `settings` name, or of `xs` where they name one without maps.
/// Their size is the film's times the resolution of `settings`. The snapshot of `earlier` is used in place of a
/// new one where it [matches](CachedSnapshot::matches).
///
/// # Errors
/// Where an emitter cannot be sampled.
pub fn maps(
    scene: &Scene,
    settings: &RenderSettings,
    earlier: Earlier<'_>,
    extent: Extent,
    stages: &mut Stages,
) -> Result<DirectorMaps> {
    let directing = &settings.effective_directing();
    let weights = directing.weights;
    let all = extent == Extent::All;
    let needs_saliency = all || weights[1] > 0.0;
    let needs_x = |x| weights[0] > 0.0 && directing.x == x;
    let needs_pilot = all || needs_x(Importance::Scattering);
    let needs_error = needs_x(Importance::Error);
    let size = directing.map_size(scene.film.size);
    let mut maps = DirectorMaps { size, ..DirectorMaps::default() };
    if all || (needs_saliency && !needs_error) || needs_x(Importance::Transmittance) {
        maps.make_transmittance(scene, settings, earlier.snapshot, stages);
    }
    if needs_saliency {
        maps.make_saliency(stages);
    }
    if needs_pilot || needs_error {
        let own;
        let assignment = match earlier.strategies {
            Some(assignment) => assignment,
            None => {
                let pass = pass_settings(scene, settings);
                own = specialised!(Needs::new(scene, settings), strategies(scene, &pass))?;
                &own
            }
        };
        if needs_pilot {
            maps.make_pilot(scene, settings, assignment, stages)?;
        }
        if needs_error {
            maps.measure_error(scene, settings, assignment, stages)?;
        }
    }
    let saliency = maps.saliency.as_ref().map_or(&[][..], |saliency| &saliency.map);
    maps.xs = xs_map(&maps.x, saliency, weights, directing.operator);
    maps.work.map_pixels += maps.xs.len() as u64;
    Ok(maps)
}

impl DirectorMaps {
    /// The maps that direct a render under `settings`: none where its director has none, and no XS
    /// where the maps are made only because the plan asks for all work.
    ///
    /// # Errors
    /// As [`maps`].
    pub(super) fn for_render(
        scene: &Scene,
        settings: &RenderSettings,
        earlier: Earlier<'_>,
        stages: &mut Stages,
    ) -> Result<Self> {
        if !Needs::new(scene, settings).maps || settings.measures_error() {
            return Ok(Self::default());
        }
        let mut made = maps(scene, settings, earlier, Extent::Needed, stages)?;
        if matches!(settings.director, Director::Fixed | Director::Variance) {
            made.xs.clear();
        }
        Ok(made)
    }

    /// Makes the snapshot and the transmittance to the first surface, which is X at first.
    fn make_transmittance(
        &mut self,
        scene: &Scene,
        settings: &RenderSettings,
        cached: Option<CachedSnapshot>,
        stages: &mut Stages,
    ) {
        let needs = Needs::new(scene, settings);
        let start = Instant::now();
        let cached = cached.filter(|cached| cached.matches(scene, settings));
        self.spared = cached.as_ref().map_or(Work::default(), |cached| cached.work);
        let cached = cached.unwrap_or_else(|| {
            let (snapshot, work) = Snapshot::look(scene, self.size, settings.seed, needs);
            CachedSnapshot::new(snapshot, work, scene, settings)
        });
        stages.done("snapshot", start);
        let start = Instant::now();
        let (transmittance, marching) = x_map(scene, &cached.snapshot, needs);
        stages.done("x", start);
        self.work += cached.work;
        self.work += marching;
        self.x.clone_from(&transmittance);
        self.transmittance = transmittance;
        self.snapshot = Some(cached);
    }

    /// Makes the false medium and its saliency, of snapshot and transmittance.
    fn make_saliency(&mut self, stages: &mut Stages) {
        let Some(cached) = &self.snapshot else { return };
        let start = Instant::now();
        let veiled = false_medium(&cached.snapshot.snapshot, &self.transmittance);
        self.saliency = Some(Saliency::from_image(&veiled));
        self.false_medium = Some(veiled);
        stages.done("saliency", start);
    }

    /// Renders the pilot and makes the X of scattered light.
    fn make_pilot(
        &mut self,
        scene: &Scene,
        settings: &RenderSettings,
        assignment: &Assignment,
        stages: &mut Stages,
    ) -> Result<()> {
        let start = Instant::now();
        let needs = Needs::new(scene, settings);
        let (pilot, work) = specialised!(needs, director_pilot(scene, settings, assignment))?;
        self.pilot_work += work;
        let coarse = [pilot.width(), pilot.height()].map(|side| side as u32);
        self.scattering_x = resampled(&scattering_x_map(&pilot), coarse, self.size);
        if settings.effective_directing().x == Importance::Scattering {
            self.x.clone_from(&self.scattering_x);
        }
        self.pilot = Some(pilot.image());
        stages.done("pilot", start);
        Ok(())
    }

    /// Renders the pilot of measured error and takes its maps: X, and S of its picture.
    fn measure_error(
        &mut self,
        scene: &Scene,
        settings: &RenderSettings,
        assignment: &Assignment,
        stages: &mut Stages,
    ) -> Result<()> {
        let start = Instant::now();
        let needs = Needs::new(scene, settings);
        let (maps, work) = specialised!(needs, error_maps(scene, settings, assignment))?;
        let ErrorMaps { pilot, x, saliency, .. } = maps;
        self.pilot_work += work;
        let in_size = |map: &[f32]| resampled(map, scene.film.size, self.size);
        self.error_x = in_size(&x);
        self.x.clone_from(&self.error_x);
        if let Some(saliency) = saliency {
            let [width, height] = self.size.map(|side| side as usize);
            let of = |map: fn(&Saliency) -> &Vec<f32>| in_size(map(&saliency));
            self.saliency = Some(Saliency {
                width,
                height,
                intensity: of(|s| &s.intensity),
                color: of(|s| &s.color),
                orientation: of(|s| &s.orientation),
                map: of(|s| &s.map),
            });
        }
        self.pilot = Some(pilot);
        stages.done("pilot", start);
        Ok(())
    }

    /// Work for the maps, without the pilot's; `None` where there is no XS.
    pub(super) fn director_work(&self) -> Option<DirectorWork> {
        let spared = self.spared;
        (!self.xs.is_empty()).then(|| DirectorWork { work: self.work.less(&spared), spared })
    }

    /// Settings of the photon pass, with the thinned photon maps that the widest gathers need.
    pub(super) fn pass_settings(&self, scene: &Scene, settings: &RenderSettings) -> PassSettings {
        let directing = &settings.effective_directing();
        let level =
            |xs: &f32| if directing.directed.radius { radius_level(directing, *xs) } else { 0 };
        // Error is measured by photons, so that importance is not known yet.
        let unknown = settings.measures_error().then_some(0.0);
        let levels = self.xs.iter().chain(&unknown).map(level).max().unwrap_or(0);
        let whole = pass_settings(scene, settings);
        let photons = PhotonSettings { levels, ..whole.photons };
        PassSettings { photons, pass: settings.pass, ..whole }
    }

    /// The budget of each pixel of the film, row by row from the top, where `gold` is the gold
    /// standard's; empty where there is no XS.
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
            ..gold.for_importance(*xs, &settings.effective_directing(), voxel)
        };
        on_film(&self.xs).iter().enumerate().map(budget).collect()
    }
}
