//! How long photons take, and how many a render has time for.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::guide;
use crate::error::Result;
use crate::photon;
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};

/// Fewer photons show nothing.
const FEWEST: u64 = 1000;

/// As many of the photons that `settings` ask for as can be shot in about `time`, judged by a look
/// at a few of them, whose work is not counted.
///
/// # Errors
/// As [`render`](super::render()).
pub fn photons_within(scene: &Scene, settings: &RenderSettings, time: Duration) -> Result<u64> {
    let asked = settings.photons;
    let Some(Pace { before, rate }) = Pace::of(scene, settings)? else { return Ok(asked) };
    let left = time.saturating_sub(before).as_secs_f64();
    Ok(((left * rate) as u64).clamp(FEWEST, asked))
}

/// About how long it takes to shoot the photons that `settings` ask for, judged by a look at a few
/// of them.
///
/// # Errors
/// As [`render`](super::render()).
pub fn photon_time(scene: &Scene, settings: &RenderSettings) -> Result<Duration> {
    let Some(Pace { before, rate }) = Pace::of(scene, settings)? else {
        return Ok(Duration::ZERO);
    };
    Ok(before.saturating_add(Duration::from_secs_f64(settings.photons as f64 / rate)))
}

/// How fast photons are shot.
struct Pace {
    /// Time before the first, the same for any number of them.
    before: Duration,
    /// Paths a second.
    rate: f64,
}

impl Pace {
    /// Looks at a few of those that `settings` ask for; nothing where there are too few to look at.
    fn of(scene: &Scene, settings: &RenderSettings) -> Result<Option<Self>> {
        if settings.photons <= FEWEST || !Needs::of(scene, settings).photons() {
            return Ok(None);
        }
        let (shooting, paths) = guide::look(scene, settings);
        let (start, first) = (Instant::now(), OnceLock::new());
        photon::shoot(scene, &shooting, &|_| {
            first.get_or_init(Instant::now);
        })?;
        let first = first.into_inner().unwrap_or(start);
        let rate = paths as f64 / first.elapsed().as_secs_f64().max(1e-9);
        Ok(Some(Self { before: first - start, rate }))
    }
}
