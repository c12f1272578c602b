//! Exposure from a picture, as a light meter gives it.

use super::agx;
use crate::math::WeightedValues;

/// Share of a pixel that the medium must cover for the pixel to count.
const COVERED: f64 = 0.02;

/// The least that must be covered, in whole pixels: fewer are stray voxels.
const MIN_PIXELS: f64 = 4.0;

/// The most stops by which a picture is darkened.
const MAX_DARKER: f64 = 24.0;

/// Where lit media are put: this percentile of their luminance, on this display level.
const LIT: Anchor = Anchor { percentile: 0.95, level: 0.8 };

/// The most stops by which lit media are brightened: soot stays dark.
const LIT_MAX_BRIGHTER: f64 = 1.5;

/// Where the body of a glow is put. At 0.66 flames of `volumes/fire.toml` are orange with yellow tongues;
/// one stop more and AgX takes their colour, one less and they light nothing around.
const BODY: Anchor = Anchor { percentile: 0.5, level: 0.66 };

/// The most that the core of a glow may reach: nearly white.
const CORE: Anchor = Anchor { percentile: 0.9, level: 0.85 };

/// The most stops by which a bright core darkens a glow: a few samples of great light do no more.
const CORE_MAX_DARKER: f64 = 2.0;

/// The most stops by which a glow is brightened: its unit is often arbitrary.
const GLOW_MAX_BRIGHTER: f64 = 12.0;

/// How many times brighter than the backdrop a glow is that covers nothing.
const GLOW_OVER_BACKDROP: f64 = 4.0;

/// The backdrop: this percentile of the pixels that nothing covers.
const BACKDROP: f64 = 0.25;

/// The most that brightening a glow may make of the backdrop: surroundings of a fire stay dark.
const SURROUNDINGS: f64 = 0.3;

/// A percentile of luminance, in [0, 1], and the display level it is put on: the sRGB code value, from 0
/// to 1, that AgX gives a grey of that luminance.
struct Anchor {
    percentile: f64,
    level: f64,
}

/// The exposure in stops at which AgX shows the media of a picture well, or nothing where there is nothing
/// to see of them. `luminance` is that of the pixels, linear, in any unit; `alpha` is the share of each that
/// media cover: 1 less their transmittance, without surfaces behind them. Both are in the same order, and
/// pixels that are not finite count for nothing.
///
/// Of lit media the 95th percentile of luminance over what they cover is put on the display level 0.8.
/// Where they `glow` by themselves each pixel counts by its light, so that dark smoke around a small flame
/// does not: half of the light then comes from below the level 0.66, where flames keep their hue, and nine
/// tenths from below 0.85; the backdrop stays below 0.3 where a glow is brightened. Pixels that shine out of the backdrop count for a glow though nothing is covered.
/// Percentiles do not follow single bright pixels.
pub fn meter(luminance: &[f32], alpha: &[f32], glow: bool) -> Option<f64> {
    let pixels: Vec<[f64; 2]> = luminance
        .iter()
        .zip(alpha)
        .map(|(&luminance, &alpha)| [f64::from(luminance), f64::from(alpha)])
        .filter(|[luminance, alpha]| luminance.is_finite() && *luminance >= 0.0 && !alpha.is_nan())
        .collect();
    if glow { meter_glow(&pixels) } else { meter_lit(&pixels) }
}

fn meter_lit(pixels: &[[f64; 2]]) -> Option<f64> {
    let covered = pixels.iter().copied().filter(|[_, alpha]| *alpha > COVERED);
    let covered =
        WeightedValues::new(covered.map(|[luminance, alpha]| (luminance, alpha.min(1.0))));
    if covered.total() < MIN_PIXELS {
        return None;
    }
    let stops = stops_to(&covered, &LIT)?;
    Some(stops.clamp(-MAX_DARKER, LIT_MAX_BRIGHTER))
}

fn meter_glow(pixels: &[[f64; 2]]) -> Option<f64> {
    let uncovered = pixels.iter().filter(|[_, alpha]| *alpha <= COVERED);
    let backdrop = WeightedValues::new(uncovered.map(|[luminance, _]| (*luminance, 1.0)));
    let dark = GLOW_OVER_BACKDROP * backdrop.quantile(BACKDROP).unwrap_or(0.0);
    let glows = |[luminance, alpha]: &&[f64; 2]| *alpha > COVERED || *luminance > dark;
    let glow: Vec<f64> = pixels.iter().filter(glows).map(|[luminance, _]| *luminance).collect();
    if (glow.len() as f64) < MIN_PIXELS {
        return None;
    }
    let glow = WeightedValues::new(glow.into_iter().map(|luminance| (luminance, luminance)));
    let (body, core) = (stops_to(&glow, &BODY)?, stops_to(&glow, &CORE)?);
    let stops = core.clamp(body - CORE_MAX_DARKER, body).clamp(-MAX_DARKER, GLOW_MAX_BRIGHTER);
    let surroundings = Anchor { percentile: BACKDROP, level: SURROUNDINGS };
    let brightest = stops_to(&backdrop, &surroundings).unwrap_or(GLOW_MAX_BRIGHTER);
    Some(stops.min(brightest.max(0.0)))
}

/// Stops that put a percentile of `luminance` on its level; `None` where that is black.
fn stops_to(luminance: &WeightedValues, anchor: &Anchor) -> Option<f64> {
    let value = luminance.quantile(anchor.percentile).filter(|value| *value > 0.0)?;
    Some((agx::scene_grey(anchor.level) / value).log2())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::image::{View, ViewTransform};
    use crate::math::Rgb;

    /// The 8-bit code at which AgX shows a grey.
    fn code(luminance: f64, exposure: f64) -> u8 {
        View { exposure, transform: ViewTransform::Agx }.develop(Rgb::splat(luminance))[1]
    }

    /// Values from 1/1000 to 1, each once.
    fn ramp() -> Vec<f32> {
        (1..=1000).map(|i| i as f32 / 1000.0).collect()
    }

    #[test]
    fn lit_media_reach_their_level() {
        let exposure = meter(&ramp(), &[1.0; 1000], false).unwrap();
        assert_eq!(code(0.95, exposure), (LIT.level * 255.0).round() as u8);
    }

    #[test]
    fn coverage_is_the_weight() {
        // One pixel in forty is covered, which is a fifth of all that is.
        let (mut luminance, mut alpha) = (vec![0.2; 40 * 60], vec![0.1; 40 * 60]);
        luminance.extend([0.6; 60]);
        alpha.extend([1.0; 60]);
        let exposure = meter(&luminance, &alpha, false).unwrap();
        assert_eq!(exposure, meter(&[0.6; 10], &[1.0; 10], false).unwrap());
        // Bright sky behind nothing does not count.
        luminance.extend([50.0; 1000]);
        alpha.extend([0.0; 1000]);
        assert_eq!(meter(&luminance, &alpha, false), Some(exposure));
    }

    #[test]
    fn nothing_to_see_is_nothing() {
        for glow in [false, true] {
            assert_eq!(meter(&[], &[], glow), None);
            assert_eq!(meter(&[0.5; 3], &[1.0; 3], glow), None, "stray pixels");
            assert_eq!(meter(&[0.5; 100], &[0.01; 100], glow), None, "an even backdrop");
            assert_eq!(meter(&[0.0; 100], &[1.0; 100], glow), None, "black");
            assert_eq!(meter(&[f32::NAN; 100], &[1.0; 100], glow), None);
            assert_eq!(meter(&[0.5; 100], &[f32::NAN; 100], glow), None);
        }
    }

    #[test]
    fn soot_stays_dark() {
        assert_eq!(meter(&[1e-3; 100], &[1.0; 100], false), Some(LIT_MAX_BRIGHTER));
    }

    #[test]
    fn single_bright_pixels_do_not_matter() {
        for glow in [false, true] {
            let clean = meter(&ramp(), &[1.0; 1000], glow).unwrap();
            let mut luminance = ramp();
            for pixel in luminance.iter_mut().step_by(200) {
                *pixel = 10.0; // five, together a tenth of all light
            }
            let noisy = meter(&luminance, &[1.0; 1000], glow).unwrap();
            assert!((noisy - clean).abs() < 0.2, "{noisy} beside {clean}");
            luminance[500] = 1e6;
            let noisy = meter(&luminance, &[1.0; 1000], false).unwrap();
            assert!((meter(&ramp(), &[1.0; 1000], false).unwrap() - noisy).abs() < 0.2, "{noisy}");
        }
    }

    #[test]
    fn surroundings_of_a_dim_glow_stay_dark() {
        let (mut luminance, mut alpha) = (vec![0.02_f32; 1000], vec![0.0_f32; 1000]);
        luminance.extend([0.05; 200]);
        alpha.extend([1.0; 200]);
        let exposure = meter(&luminance, &alpha, true).unwrap();
        assert_eq!(code(0.02, exposure), (SURROUNDINGS * 255.0).round() as u8);
        // A bright backdrop darkens nothing.
        luminance[..1000].fill(0.5);
        assert!(meter(&luminance, &alpha, true).unwrap() >= 0.0);
    }

    #[test]
    fn a_small_flame_in_dark_smoke_counts_and_not_the_smoke() {
        let (mut luminance, mut alpha) = (vec![0.001_f32; 20_000], vec![0.8_f32; 20_000]);
        let flame = [0.5, 1.0, 1.0, 1.0, 1.5].repeat(30);
        alpha.extend(vec![0.3; flame.len()]);
        luminance.extend(&flame);
        let exposure = meter(&luminance, &alpha, true).unwrap();
        assert_eq!(code(1.0, exposure), (BODY.level * 255.0).round() as u8);
        // The same where it covers nothing of a dark backdrop.
        alpha.fill(0.0);
        assert_eq!(meter(&luminance, &alpha, true), Some(exposure));
    }

    #[test]
    fn a_bright_core_stays_below_white() {
        // Half of the light at 0.1, half at 10: by the body alone the core would come out at 35.
        let mut luminance = vec![0.1_f32; 1100];
        luminance.extend([10.0; 10]);
        let alpha = vec![1.0; luminance.len()];
        let exposure = meter(&luminance, &alpha, true).unwrap();
        let body = meter(&[0.1; 10], &[1.0; 10], true).unwrap();
        assert!((exposure - (body - CORE_MAX_DARKER)).abs() < 1e-12, "{exposure} of {body}");
    }

    proptest! {
        #[test]
        fn stops_follow_the_light(
            luminance in prop::collection::vec(0.01_f32..1.0, 8..60),
            stops in -3_i32..3,
            glow: bool,
        ) {
            let alpha = vec![1.0; luminance.len()];
            let brighter: Vec<f32> = luminance.iter().map(|v| v * (stops as f32).exp2()).collect();
            let (a, b) = (meter(&luminance, &alpha, glow), meter(&brighter, &alpha, glow));
            let (a, b) = (a.unwrap(), b.unwrap());
            let limit = if glow { GLOW_MAX_BRIGHTER } else { LIT_MAX_BRIGHTER };
            let clamped = a == limit || b == limit;
            prop_assert!(clamped || (a - b - f64::from(stops)).abs() < 1e-6, "{} {}", a, b);
        }
    }
}
