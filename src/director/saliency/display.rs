//! Radiance as a viewer would see it on a display: saliency is about what is looked at.

use rayon::prelude::*;

use crate::image::{Image, srgb_encode};

/// Display value that the log-average of the light gets: middle grey.
///
/// Unit: none. Source: Reinhard et al. 2002, section 3.1.
const KEY: f64 = 0.18;

/// Part of the mean below which a pixel is black and does not count in the log-average.
///
/// Unit: none. Derivation: where the mean is at middle grey, a tenth of an 8-bit code value.
const BLACK: f64 = 1e-4;

/// Steps of the table of the transfer curve.
///
/// Unit: count. Derivation: linear interpolation errs by less than 1e-6, by the curvature 26 at black
/// 26 / 8 / 2^28 and at the curve's kink 0.025 / 4 / 2^14.
const STEPS: usize = 1 << 14;

/// Fewest pixels that a task encodes.
///
/// Unit: count. Derivation: tens of microseconds of work, far more than handing out a task takes.
const PIXELS_PER_TASK: usize = 1 << 12;

/// Display code values from 0 to 1 of linear radiance, the same for any multiple of the radiance.
///
/// The photographic operator of Reinhard et al. 2002, "Photographic Tone Reproduction for Digital
/// Images": equations 1 and 2 expose by the log-average, equation 4 with L_white the greatest value
/// bends highlights so that none clips and a lamp stays brighter than a lit wall. Two departures:
/// black pixels do not count in the average, lest an empty background set the exposure; and each
/// channel goes through the curve by itself, as on film. A picture that does not exceed white once
/// it is exposed is not bent at all. Then the sRGB curve. What is negative or not finite counts as
/// 0.
pub fn encode(image: &Image) -> Vec<[f32; 3]> {
    let light = |v: f32| if v.is_finite() && v > 0.0 { f64::from(v) } else { 0.0 };
    let pixels = image.pixels();
    let mean = |p: &[f32; 3]| p.iter().map(|&v| light(v)).sum::<f64>() / 3.0;

    let black = BLACK * pixels.iter().map(mean).sum::<f64>() / pixels.len() as f64;
    let (sum, count) = pixels
        .iter()
        .map(mean)
        .filter(|&m| m > black)
        .fold((0.0, 0.0), |(sum, count), m| (sum + m.ln(), count + 1.0));
    if count == 0.0 {
        return vec![[0.0; 3]; pixels.len()];
    }
    let brightest = pixels.iter().flatten().map(|&v| light(v)).fold(0.0, f64::max);
    let average = (sum / count).exp();
    let white = (KEY * brightest / average).max(1.0);

    let table: Vec<f32> =
        (0..=STEPS).map(|i| srgb_encode(square(i as f64 / STEPS as f64)) as f32).collect();
    let code = |v: f32| {
        let exposed = KEY * light(v) / average;
        let shown = exposed * (1.0 + exposed / square(white)) / (1.0 + exposed);
        look_up(&table, shown.min(1.0))
    };
    pixels.par_iter().with_min_len(PIXELS_PER_TASK).map(|p| p.map(code)).collect()
}

/// The table runs over the square root of its argument: the curve is steep near black.
fn look_up(table: &[f32], linear: f64) -> f32 {
    let at = linear.sqrt() * STEPS as f64;
    let below = (at as usize).min(STEPS - 1);
    let mix = (at - below as f64) as f32;
    table[below] + mix * (table[below + 1] - table[below])
}

fn square(x: f64) -> f64 {
    x * x
}
