//! Shoots the photons of a picture and saves them with what of media the camera sees without them, without rendering it.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::error::{Error, Result};
use crate::math::Spectrum;
use crate::photon::PhotonDirection;
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::strategy::Summary;
use crate::work::Work;

use super::control::Control;
use super::error_pilot::photon_demand;
use super::photon_file::PhotonsToSave;
use super::photon_pass::{ShotPaths, ShotTime, aim, strategies_by};
use super::planned_pass::{Flights, PlannedPass};
use super::progress::Stages;
use super::stage_settings::{pass_settings, specialised};

/// What shooting and saving photons took.
#[derive(Debug)]
pub struct PhotonsReport {
    /// How light in media is estimated with them, and why.
    pub strategy: Summary,
    /// Work done.
    pub work: Work,
    /// Name and wall-clock time of each stage, in the order in which they ran.
    pub timings: Vec<(&'static str, Duration)>,
}

/// Shoots the photons of `scene` and saves them in the file `path`: for its camera, or for any. The file is the same on
/// any number of threads.
///
/// # Errors
/// Where there are no photons to shoot, an emitter cannot be sampled, photons for any camera cannot be aimed, or the
/// file cannot be written.
pub fn save_photons<'a>(
    scene: &Scene,
    path: &Path,
    any_camera: bool,
    control: impl Into<Control<'a>>,
) -> Result<PhotonsReport> {
    save_controlled(scene, path, any_camera, &control.into())
}

/// [`save_photons`] without a generic argument: other crates that call it do not compile what shoots again.
fn save_controlled(
    scene: &Scene,
    path: &Path,
    any_camera: bool,
    control: &Control<'_>,
) -> Result<PhotonsReport> {
    let needs = Needs::new(scene, &scene.render);
    if any_camera && scene.media.is_endless() {
        let problem = "a medium has no end: photons for any camera would be aimed at all of it; give it a region with \
                       an end, or leave out --any-camera";
        return Err(Error::file(&scene.path, problem));
    }
    specialised!(needs, save(scene, path, any_camera, control))
}

fn save<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    path: &Path,
    any_camera: bool,
    control: &Control<'_>,
) -> Result<PhotonsReport> {
    let mut stages = Stages::default();
    let mut settings = pass_settings(scene, &scene.render);
    settings.photons.any_camera = any_camera;
    // Strategies.
    let start = Instant::now();
    let aimed = aim::<S, H>(scene, &settings)?.filter(|aimed| aimed.count() > 0);
    let Some(mut aimed) = aimed else {
        return Err(Error::file(&scene.path, "needs no photons: there is nothing to save"));
    };
    let strategies = strategies_by::<S, H>(scene, &settings, Some(&mut aimed));
    stages.done("strategy", start);
    // Photons.
    let start = Instant::now();
    let flight_length = aimed.flight_length();
    let flights = Flights { length: flight_length, filled: None };
    let planned = PlannedPass::<S>::new(scene, &settings, &strategies, aimed.importance(), flights);
    let count = photon_demand(&scene.render, &strategies).paths;
    let shot = if scene.render.in_halves() { ShotPaths::Halves(count) } else { ShotPaths::Whole };
    control.progress.stage("photons", count);
    let mut work = aimed.importance().work;
    let mut recorded = Vec::new();
    for part in shot.parts(&aimed, &settings.photons, ShotTime::ONLY) {
        let advance = |done| control.progress.advance(done);
        recorded.push(planned.record::<H>(&mut aimed, &part, &advance));
    }
    recorded.iter().for_each(|part| work += *part.traced.work());
    control.progress.finish();
    stages.done("photons", start);
    // Direct light, which is scattered toward one camera, the optical thickness to it, and where gathers start.
    let start = Instant::now();
    let (mut cells, mut origins) = (Vec::new(), Vec::new());
    if !any_camera {
        work += planned.fill_seen(control.progress);
        (cells, origins) = (planned.camera_cells(), planned.origins().collect());
    }
    stages.done("cells", start);
    // The file.
    let start = Instant::now();
    let choice = &planned.choice;
    let strategies = &strategies;
    PhotonsToSave { scene, any_camera, strategies, choice, flight_length }.write(
        &recorded,
        (&cells, &origins),
        path,
    )?;
    stages.done("write", start);
    Ok(PhotonsReport { strategy: choice.summary(), work, timings: stages.timings })
}
