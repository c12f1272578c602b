//! How long photons take, and how many a render has time for.

use std::time::{Duration, Instant};

use super::photon_pass::{PassSettings, PhotonPass};
use super::{director_pass, specialised};
use crate::error::Result;
use crate::math::Spectrum;
use crate::photon::PhotonDirection;
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};

/// Fewer photons show nothing.
const FEWEST: u64 = 1000;

/// How many times fewer paths a second look takes.
const FEWER: u64 = 8;

/// Share of a look's time that its paths take at least, lest chance makes them look free.
const LEAST: f64 = 0.02;

/// As many of the photons that `settings` ask for as can be shot in about `time`, judged by a look
/// at a few of them, whose work is not counted.
///
/// # Errors
/// As [`render`](super::render()).
pub fn photons_within(scene: &Scene, settings: &RenderSettings, time: Duration) -> Result<u64> {
    let asked = settings.photons;
    let Some(PhotonRate { fixed, rate }) = PhotonRate::of(scene, settings)? else {
        return Ok(asked);
    };
    let left = time.saturating_sub(fixed).as_secs_f64();
    Ok(((left * rate) as u64).clamp(FEWEST, asked))
}

/// How fast photons are shot.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhotonRate {
    /// Time before the first and after the last, the same for any number of them.
    fixed: Duration,
    /// Paths a second.
    rate: f64,
}

impl PhotonRate {
    /// Looks at a few of those that `settings` ask for; nothing where there are too few to look at.
    fn of(scene: &Scene, settings: &RenderSettings) -> Result<Option<Self>> {
        let needs = Needs::of(scene, settings);
        if settings.photons <= FEWEST || !needs.photons() {
            return Ok(None);
        }
        let (shooting, many) = director_pass::look(scene, settings);
        let start = Instant::now();
        specialised!(needs, shoot(scene, &shooting.pilot(many)))?;
        Self::beside(scene, settings, start.elapsed())
    }

    /// As [`of`](Self::of), where a look at few has been taken already, in the time `long`.
    pub(super) fn beside(
        scene: &Scene,
        settings: &RenderSettings,
        long: Duration,
    ) -> Result<Option<Self>> {
        let needs = Needs::of(scene, settings);
        if settings.photons <= FEWEST || !needs.photons() {
            return Ok(None);
        }
        let (shooting, many) = director_pass::look(scene, settings);
        let few = many / FEWER;
        let start = Instant::now();
        specialised!(needs, shoot(scene, &shooting.pilot(few)))?;
        let (short, long) = (start.elapsed().as_secs_f64(), long.as_secs_f64());
        let each = (long - short) / (many - few) as f64;
        let each = each.max(LEAST * long / many as f64).max(f64::MIN_POSITIVE);
        let fixed = (long - each * many as f64).max(0.0);
        Ok(Some(Self { fixed: Duration::from_secs_f64(fixed), rate: 1.0 / each }))
    }

    /// About how long `photons` take.
    pub(super) fn time(&self, photons: u64) -> Duration {
        let paths = Duration::try_from_secs_f64(photons as f64 / self.rate);
        self.fixed.saturating_add(paths.unwrap_or(Duration::MAX))
    }
}

/// Shoots photons for nothing but the time it takes.
fn shoot<S: Spectrum, H: PhotonDirection>(scene: &Scene, shooting: &PassSettings) -> Result<()> {
    PhotonPass::<S, H>::new(scene, shooting, &|_| ()).map(drop)
}
