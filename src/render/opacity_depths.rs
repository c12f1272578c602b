//! Where along a camera ray its opacity lies.

use glam::DVec3;

use crate::film::OpacityDepths;
use crate::math::{Ray, Spectrum, World, WorldPoint};
use crate::medium::{Piece, Profile};
use crate::scene::Scene;
use crate::surface::SurfaceHit;

/// Share of a ray's opacity before the first depth, and behind the last one.
const TAIL: f64 = 0.01;

/// Opacity of media that hides what lies behind: where media count as a surface in `Z`.
const HALF: f64 = 0.5;

/// Optical thickness below which the mean distance is told by its series, to the accuracy of an f32.
const THIN: f64 = 1e-4;

/// Distance in metres to the first surface at `hit`, or to where the media before it, along `profile`, have passed an
/// opacity of one half; infinite where neither is.
pub(super) fn visible_depth<S: Spectrum>(profile: Option<&Profile<S>>, hit: Option<f64>) -> f64 {
    let first = hit.unwrap_or(f64::INFINITY);
    profile.and_then(|profile| profile.distance_at(HALF)).map_or(first, |t| t.min(first))
}

/// Where the opacity along `ray` lies: of the media along `profile`, which ends at the first surface, and of that at `hit`
/// metres. `None` where there is none.
pub(super) fn opacity_depths<S: Spectrum>(
    ray: &Ray<World>,
    profile: Option<&Profile<S>>,
    hit: Option<f64>,
) -> Option<OpacityDepths> {
    let of_media = profile.map_or(0.0, Profile::middle_opacity);
    let opacity = if hit.is_some() { 1.0 } else { of_media };
    if opacity <= 0.0 {
        return None;
    }
    let at = |share: f64| profile.and_then(|profile| profile.distance_at(share * opacity)).or(hit);
    let behind = hit.map_or(0.0, |t| (1.0 - of_media) * t);
    let mean = (profile.map_or(0.0, distance_sum) + behind) / opacity;
    // The last place of a profile stands for what rounding puts behind it.
    let end = || profile.map(|profile| profile.extent().end);
    let (first, last) = (at(TAIL).or_else(end)?, at(1.0 - TAIL).or_else(end)?);
    let position = ray.at(mean) - WorldPoint::from_xyz(DVec3::ZERO);
    Some(OpacityDepths { opacity, first, mean, last, position, motion: DVec3::ZERO })
}

/// How far what a ray sees of `scene` moves in the picture in a frame, where its opacity is in `depths`: media before a surface
/// that was `hit`, which has the rest of the opacity.
pub(super) fn motion(
    scene: &Scene,
    depths: &OpacityDepths,
    hit: Option<(&SurfaceHit<'_>, f64)>,
) -> DVec3 {
    let Some(motion) = &scene.motion else { return DVec3::ZERO };
    let p = WorldPoint::from_xyz(depths.position);
    let of_media = motion.of_media(&scene.media, p);
    let step = match hit {
        Some((hit, of_surface)) => {
            of_media.lerp(motion.of_surface(&scene.surfaces, hit), of_surface / depths.opacity)
        }
        None => of_media,
    };
    motion.vector(p, step)
}

/// The integral of distance, in metres, over the opacity of media along `profile`, whose extinction counts as even within a
/// piece.
fn distance_sum<S: Spectrum>(profile: &Profile<S>) -> f64 {
    let channel = S::CHANNELS / 2;
    let of_piece = |piece: &Piece<S>| {
        let (sigma_t, length) = (piece.sigma_t.channel(channel), piece.span.length());
        let tau = sigma_t * length;
        if tau.is_nan() || tau <= 0.0 {
            return 0.0;
        }
        let opacity = (-piece.before.channel(channel)).exp() * -(-tau).exp_m1();
        opacity * (piece.span.start + mean_reach(sigma_t, length))
    };
    profile.pieces().iter().map(of_piece).sum()
}

/// Mean of the distance, in metres, at which opacity of `sigma_t` (1/m) lies on a way of this `length`.
fn mean_reach(sigma_t: f64, length: f64) -> f64 {
    let tau = sigma_t * length;
    if tau < THIN {
        return length * (0.5 - tau / 12.0);
    }
    let end = tau.exp_m1();
    // So far beyond the opacity nothing counts, be the way endless.
    if end.is_finite() { 1.0 / sigma_t - length / end } else { 1.0 / sigma_t }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_an_exponential_is_that_of_a_sum() {
        for (sigma_t, length) in [(1e-9, 2.0), (9e-5, 1.0), (1.1e-4, 1.0), (0.3, 4.0), (7.0, 3.0)] {
            let steps = 100_000;
            let (mut sum, mut weight) = (0.0, 0.0);
            for step in 0..steps {
                let t = (f64::from(step) + 0.5) / f64::from(steps) * length;
                let density = (-sigma_t * t).exp();
                (sum, weight) = (sum + density * t, weight + density);
            }
            let found = mean_reach(sigma_t, length);
            assert!((found / (sum / weight) - 1.0).abs() < 1e-7, "{found} for {sigma_t}, {length}");
        }
        assert_eq!(mean_reach(2.0, f64::INFINITY), 0.5);
        assert_eq!(mean_reach(2.0, 1e6), 0.5);
    }
}
