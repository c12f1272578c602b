//! How many photons a render has time for.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::{guide, specialised};
use crate::error::Result;
use crate::math::Spectrum;
use crate::photon::{self, Heading, Shooting};
use crate::scene::plan::Needs;
use crate::scene::{RenderSettings, Scene};

/// Fewer photons show nothing.
const FEWEST: u64 = 1000;

/// As many of the photons that `settings` ask for as can be shot in about `time`, judged by a look
/// at a few of them.
///
/// # Errors
/// As [`render`](super::render()).
pub fn photons_within(scene: &Scene, settings: &RenderSettings, time: Duration) -> Result<u64> {
    let asked = settings.photons;
    let needs = Needs::of(scene, settings);
    if asked <= FEWEST || !needs.photons() {
        return Ok(asked);
    }
    let (shooting, paths) = guide::look(scene, settings);
    let (start, first) = (Instant::now(), OnceLock::new());
    let begins = |_| {
        first.get_or_init(Instant::now);
    };
    specialised!(needs, shoot(scene, &shooting, &begins))?;
    // What comes before the first path is the same for any number of them.
    let first = first.into_inner().unwrap_or(start);
    let left = time.saturating_sub(first - start).as_secs_f64();
    let rate = paths as f64 / first.elapsed().as_secs_f64().max(1e-9);
    Ok(((left * rate) as u64).clamp(FEWEST, asked))
}

/// Shoots photons for nothing but the time it takes.
fn shoot<S: Spectrum, H: Heading>(
    scene: &Scene,
    shooting: &Shooting,
    advance: &(dyn Fn(u64) + Sync),
) -> Result<()> {
    photon::shoot::<S, H>(scene, shooting, advance).map(drop)
}
