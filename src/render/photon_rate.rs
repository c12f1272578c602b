//! Time that photons take, and the number of them that a render has time for.

use std::time::{Duration, Instant};

use super::error_pilot::demanded_share;
use super::pass_settings::PassSettings;
use super::photon_pass::{PhotonPass, strategies};
use super::stage_settings::{
    pass_settings, sampled_pass_settings, specialised, specialised_for_film,
};
use crate::error::Result;
use crate::math::Spectrum;
use crate::photon::PhotonDirection;
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};
use crate::strategy::Assignment;

/// Photon paths below which their number is not reduced: so few are noise.
const MIN_PATHS: u64 = 1000;

/// Ratio of the paths of the two timed samples. The two times give the slope and the constant of a
/// line.
const SAMPLE_RATIO: u64 = 8;

/// Share of a sample's time that its paths take at least, so that noise of the clock cannot make
/// paths look free.
const MIN_PATH_SHARE: f64 = 0.02;

/// The number of photons that can be shot in about `time`, at most as many as `settings` ask for. It
/// is judged by a sample of the paths, which is not counted as work of the picture.
///
/// # Errors
/// As [`render`](super::render()).
pub fn photons_within(scene: &Scene, settings: &RenderSettings, time: Duration) -> Result<u64> {
    let wanted = settings.photons;
    let Some(PhotonRate { fixed, rate }) = PhotonRate::measure(scene, settings)? else {
        return Ok(wanted);
    };
    let left = time.saturating_sub(fixed).as_secs_f64();
    Ok(((left * rate) as u64).clamp(MIN_PATHS, wanted))
}

/// Time of a photon pass as a line over the number of its paths.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhotonRate {
    /// Time that does not depend on the number of paths.
    fixed: Duration,
    /// Paths a second, as settings count them: a directed picture shoots more or fewer for each.
    rate: f64,
}

impl PhotonRate {
    /// Measures it by two samples of the paths of `settings`; `None` where these are too few.
    fn measure(scene: &Scene, settings: &RenderSettings) -> Result<Option<Self>> {
        let needs = Needs::new(scene, settings);
        if settings.photons <= MIN_PATHS || !needs.photons() {
            return Ok(None);
        }
        let (shooting, _) = sampled_pass_settings(scene, settings);
        let assignment = specialised!(needs, strategies(scene, &pass_settings(scene, settings)))?;
        let start = Instant::now();
        specialised_for_film!(needs, shoot(scene, &shooting, &assignment))?;
        Self::from_sample(scene, settings, &assignment, start.elapsed())
    }

    /// Measures it where the larger sample, of
    /// [`sampled_pass_settings`], was shot before, in the time `long`.
    pub(super) fn from_sample(
        scene: &Scene,
        settings: &RenderSettings,
        assignment: &Assignment,
        long: Duration,
    ) -> Result<Option<Self>> {
        let needs = Needs::new(scene, settings);
        if settings.photons <= MIN_PATHS || !needs.photons() {
            return Ok(None);
        }
        let (shooting, many) = sampled_pass_settings(scene, settings);
        let few = many / SAMPLE_RATIO;
        let start = Instant::now();
        specialised_for_film!(needs, shoot(scene, &shooting.pilot(few), assignment))?;
        let (short, long) = (start.elapsed().as_secs_f64(), long.as_secs_f64());
        let path = (long - short) / (many - few) as f64;
        let path = path.max(MIN_PATH_SHARE * long / many as f64).max(f64::MIN_POSITIVE);
        let fixed = (long - path * many as f64).max(0.0);
        Ok(Some(Self {
            fixed: Duration::from_secs_f64(fixed),
            rate: 1.0 / (path * demanded_share(settings, assignment)),
        }))
    }

    /// Seconds that `photons` paths in so many `passes` take.
    pub(super) fn seconds(&self, photons: u64, passes: f64) -> f64 {
        passes * self.fixed.as_secs_f64() + photons as f64 / self.rate
    }
}

/// Shoots photons for the time it takes, and drops their maps.
fn shoot<S: Spectrum, H: PhotonDirection>(
    scene: &Scene,
    shooting: &PassSettings,
    assignment: &Assignment,
) -> Result<()> {
    PhotonPass::<S, H>::new(scene, shooting, assignment, &|_| ()).map(drop)
}
