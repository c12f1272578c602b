//! How much of each object a camera ray shows, for Cryptomatte.
//!
//! Together it is the coverage of the ray: media have what they hide of the way to the first surface, and the surface has
//! the rest, unless it is a holdout or catches shadows. Media that overlap share the opacity of each piece of the way by their
//! extinction coefficients.

use smallvec::{SmallVec, smallvec};

use crate::film::Sample;
use crate::math::{Ray, Spectrum, World, luminance};
use crate::medium::Profile;
use crate::scene::Scene;
use crate::surface::SurfaceHit;

/// Transmittance behind which media count as hidden.
///
/// Unit: none. Limit: on the error of a medium's share.
const HIDDEN: f64 = 1e-6;

/// Puts the objects that `ray` sees into `objects`, each by its identifier and with its coverage, which together is that of its
/// `sample`: media along `profile`, then the surface at `hit`.
pub(super) fn objects_along<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    profile: Option<&Profile<S>>,
    hit: Option<&SurfaceHit<'_>>,
    sample: &Sample,
    objects: &mut Vec<(u32, f64)>,
) {
    objects.clear();
    let of_media = 1.0 - sample.transmittance;
    if of_media > 0.0 {
        let shares = shares_of_media(scene, ray, profile);
        let total: f64 = shares.iter().sum();
        let seen = shares.iter().enumerate().filter(|(_, share)| **share > 0.0);
        objects.extend(seen.filter_map(|(medium, share)| {
            Some((scene.objects.medium(medium)?, of_media * (share / total)))
        }));
    }
    let surface = hit.and_then(|hit| scene.objects.surface(hit.surface, hit.primitive));
    objects.extend(surface.map(|identifier| (identifier, sample.alpha - of_media)));
}

/// What each medium has of the opacity of all along `profile` of `ray`, which one alone has for itself.
fn shares_of_media<S: Spectrum>(
    scene: &Scene,
    ray: &Ray<World>,
    profile: Option<&Profile<S>>,
) -> SmallVec<[f64; 4]> {
    if scene.media.len() == 1 {
        return smallvec![1.0];
    }
    let mut shares: SmallVec<[f64; 4]> = smallvec![0.0; scene.media.len()];
    for piece in profile.map_or(&[][..], Profile::pieces) {
        let before = (-piece.before).exp();
        if luminance(before.rgb()) < HIDDEN {
            break;
        }
        let length = piece.span.length();
        let opacity = (piece.sigma_t * length).map(|tau| -(-tau).exp_m1());
        let opacity = luminance((before * opacity).rgb());
        if opacity.is_nan() || opacity <= 0.0 {
            continue;
        }
        // The middle of what is seen of it, be it endless.
        let seen = length.min(1.0 / luminance(piece.sigma_t.rgb()));
        let middle = ray.at(piece.span.start + 0.5 * seen);
        let sigma_t: SmallVec<[f64; 4]> =
            scene.media.iter().map(|medium| luminance(medium.sigma_t_at(middle))).collect();
        let sum: f64 = sigma_t.iter().sum();
        if sum > 0.0 {
            shares.iter_mut().zip(sigma_t).for_each(|(share, own)| *share += opacity * own / sum);
        }
    }
    shares
}
