//! Importance of emission: how many photons each emitter gets (after Peter and Pietrek 1998,
//! "Importance Driven Construction of Photon Maps").

use glam::DVec3;
use rayon::prelude::*;

use crate::light::TargetSphere;
use crate::math::{Spectrum, WorldPoint};

use super::camera_importance::CameraImportance;
use super::path::{Deposits, PhotonTracer};
use super::pilot::PHOTONS_PER_PATH;
use super::{PhotonAt, PhotonDirection};
use crate::transport::FlightSegment;

/// Most paths of the pilot, of all emitters together.
///
/// Unit: count. Limit: on the time before any photon is stored, a fraction of a second.
const MAX_PATHS: u64 = 4096;

/// Fewest paths of the pilot from each emitter.
///
/// Unit: count. Derivation: a share that 64 independent paths estimate has a relative error of about
/// 1 / sqrt(64); half of the photons are shared out by power whatever it is.
const MIN_PATHS: u64 = 64;

/// Paths of the pilot that one task traces.
///
/// Unit: count. Derivation: the fewest paths of an emitter are a task for each of four threads.
const PATHS_PER_TASK: u64 = MIN_PATHS / 4;

/// Sets the probabilities of the emitters of `paths`: half by power, half by the light that
/// comes from each to what the camera sees, but for light that rays sample directly. By power alone a
/// moon that shines on all the land would take nearly every photon from the headlamps in view.
pub(super) fn choose_emitters<S: Spectrum, H: PhotonDirection>(
    paths: &mut PhotonTracer<'_>,
    importance: &CameraImportance,
) {
    let count = paths.emitters.len();
    if count < 2 {
        return;
    }
    let visible = Visible::new(importance, paths.origin);
    // Flights alone measure light in media with less noise than photons do.
    let store_probability = std::mem::replace(&mut paths.store_probability, 0.0);
    let photons = paths.settings.photons;
    let pilot = MAX_PATHS.min(photons / PHOTONS_PER_PATH);
    let each = (pilot / count as u64).max(MIN_PATHS).min(photons);
    let arriving: Vec<[f64; 2]> = (0..count)
        .map(|index| {
            paths.emitters.choose_by(|other| if other == index { 1.0 } else { 0.0 });
            arriving::<S, H>(paths, each, &visible)
        })
        .collect();
    paths.store_probability = store_probability;
    let total = |of: usize| arriving.iter().map(|light| light[of]).sum::<f64>();
    let totals = [total(0), total(1)].map(|sum| if sum > 0.0 { sum } else { f64::INFINITY });
    let arriving_share =
        |index: usize| arriving[index][0] / totals[0] + arriving[index][1] / totals[1];
    let all: f64 = (0..count).map(arriving_share).sum();
    let power: Vec<f64> = paths.emitters.powers().to_vec();
    let sum: f64 = power.iter().sum();
    let by_importance = |index| if all > 0.0 { arriving_share(index) / all } else { 0.0 };
    paths.emitters.choose_by(|index| power[index] / sum + by_importance(index));
}

/// Light that this many paths bring to visible media and to visible surfaces, in any unit.
fn arriving<S: Spectrum, H: PhotonDirection>(
    paths: &PhotonTracer<'_>,
    count: u64,
    visible: &Visible,
) -> [f64; 2] {
    let chunk = |chunk: u64| {
        let Deposits { tracks, surface, .. } =
            paths.trace::<S, H>(chunk * PATHS_PER_TASK..count.min((chunk + 1) * PATHS_PER_TASK));
        let media: f64 = tracks.iter().map(|track| visible.in_media(track)).sum();
        let surfaces: f64 = surface.iter().map(|photon| visible.on_surfaces(photon)).sum();
        [media, surfaces]
    };
    let chunks = (0..count.div_ceil(PATHS_PER_TASK)).into_par_iter().map(chunk);
    let chunks: Vec<[f64; 2]> = chunks.collect();
    [0, 1].map(|of| chunks.iter().map(|chunk| chunk[of]).sum())
}

/// What the camera sees, as balls.
struct Visible {
    /// Balls round the visible places in media, weighed by their contribution.
    media: Vec<TargetSphere>,
    /// Balls round the visible places on surfaces.
    surfaces: Vec<TargetSphere>,
    origin: WorldPoint,
}

impl Visible {
    fn new(importance: &CameraImportance, origin: WorldPoint) -> Self {
        Self { media: importance.foci(), surfaces: importance.surface_foci(), origin }
    }

    /// Light of a flight that the camera may see: power times length in each ball.
    fn in_media<S: Spectrum>(&self, track: &FlightSegment<S>) -> f64 {
        let (start, end) = (track.start(), track.end());
        let power = S::to_f64(track.power()).element_sum();
        let length = |ball: &TargetSphere| {
            ball.weight * chord(start - (ball.center - self.origin), end - start, ball.radius)
        };
        power * self.media.iter().map(length).sum::<f64>()
    }

    /// Light of a photon that the camera may see on surfaces: its power in each ball.
    fn on_surfaces<S: Spectrum>(&self, photon: &PhotonAt<S>) -> f64 {
        let p = photon.at(self.origin);
        let holds = |ball: &&TargetSphere| (p - ball.center).length() <= ball.radius;
        let weight: f64 = self.surfaces.iter().filter(holds).map(|ball| ball.weight).sum();
        weight * photon.photon.power().element_sum()
    }
}

/// Length, in metres, of the segment from `start` to `start + offset` inside the ball of this radius
/// round the origin.
fn chord(start: DVec3, offset: DVec3, radius: f64) -> f64 {
    let length = offset.length();
    if length == 0.0 {
        return 0.0;
    }
    let closest = -start.dot(offset) / length;
    let aside2 = (start + offset * (closest / length)).length_squared();
    let half = (radius * radius - aside2).max(0.0).sqrt();
    ((closest + half).min(length) - (closest - half).max(0.0)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_of_a_ball() {
        let chord = |from: [f64; 3], to: [f64; 3]| {
            let from = DVec3::from(from);
            chord(from, DVec3::from(to) - from, 2.0)
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(chord([-9.0, 0.0, 0.0], [9.0, 0.0, 0.0]), 4.0));
        assert!(near(chord([0.0, 1.0, 0.0], [9.0, 1.0, 0.0]), 3_f64.sqrt()));
        assert!(near(chord([-1.0, 0.0, 0.0], [0.5, 0.0, 0.0]), 1.5));
        assert!(near(chord([3.0, 0.0, 0.0], [9.0, 0.0, 0.0]), 0.0));
        assert!(near(chord([-9.0, 3.0, 0.0], [9.0, 3.0, 0.0]), 0.0));
        assert!(near(chord([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.0));
    }
}
