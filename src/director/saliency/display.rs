//! Radiance as a viewer would see it on a display: saliency is about what is looked at.

use rayon::prelude::*;

use crate::image::{Image, srgb_encode};

/// Where the log-average of the light goes: middle grey.
const KEY: f64 = 0.18;

/// What is darker than this part of the mean is black and does not count in the log-average.
const BLACK: f64 = 1e-4;

/// Steps of the table of the transfer curve, so fine that it is exact to 1e-5.
const STEPS: usize = 1 << 14;

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
    pixels.par_iter().with_min_len(1 << 12).map(|p| p.map(code)).collect()
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
