//! How many photons a render has time for.

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
/// at a few of them.
///
/// # Errors
/// As [`render`](super::render()).
pub fn photons_within(scene: &Scene, settings: &RenderSettings, time: Duration) -> Result<u64> {
    let asked = settings.photons;
    if asked <= FEWEST || !Needs::of(scene, settings).photons() {
        return Ok(asked);
    }
    let (shooting, paths) = guide::look(scene, settings);
    let (start, first) = (Instant::now(), OnceLock::new());
    photon::shoot(scene, &shooting, &|_| {
        first.get_or_init(Instant::now);
    })?;
    // What comes before the first path is the same for any number of them.
    let first = first.into_inner().unwrap_or(start);
    let left = time.saturating_sub(first - start).as_secs_f64();
    let rate = paths as f64 / first.elapsed().as_secs_f64().max(1e-9);
    Ok(((left * rate) as u64).clamp(FEWEST, asked))
}
