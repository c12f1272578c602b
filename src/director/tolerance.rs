//! What error a pixel may have, and the rays that its measured noise asks for.
//!
//! A difference is visible where it exceeds a threshold that rises with the luminance that the eye is adapted to, and
//! with the contrast of a texture that masks it (Bolin and Meyer 1998, "A Perceptually Based Adaptive Sampling
//! Algorithm"; Ramasubramanian, Pattanaik and Greenberg 1999, "A Perceptually Based Physical Error Metric for Realistic
//! Image Synthesis").

use std::f64::consts::LN_10;

use rayon::prelude::*;

use super::importance::white;
use crate::image::{Image, averages, within};
use crate::math::nth_smallest;

/// Luminance of the display's white, and what its black reflects.
///
/// Unit: cd/m². Source: IEC 61966-2-1:1999, the reference display of sRGB.
const DISPLAY: [f64; 2] = [80.0, 0.2];

/// Power by which the threshold of a contrast rises with that of what masks it.
///
/// Unit: none. Source: Legge and Foley 1980, "Contrast Masking in Human Vision".
const MASKING_POWER: f64 = 0.62;

/// Pixels on each side over which the contrast is least that masks: an edge has a side that masks nothing.
///
/// Unit: pixels. Derivation: beside an edge of a surface lie pixels whose square of 3 x 3 does not reach it.
const EDGE_REACH: usize = 2;

/// Halvings of the range, in logarithms, in which the factor on all rays is looked for.
///
/// Unit: count. Derivation: of a range of ten decades a ten-thousandth of one is left.
const HALVINGS: u32 = 24;

/// The least visible difference of the luminance of each pixel of `picture`, W/(m² sr), of which noise has
/// these variances.
pub fn visible_differences(picture: &Image, noise: &[f32]) -> Vec<f32> {
    let lights: Vec<f64> = picture.luminances().collect();
    let Some(white) = white(lights.iter().copied()) else { return vec![0.0; lights.len()] };
    let size = [picture.width(), picture.height()];
    let contrasts = contrasts(size, &lights, noise);
    let [brightest, black] = DISPLAY;
    let least = |pixel: usize| {
        // What is brighter than the display's white is not cut off: viewers may choose another exposure.
        let shown = black + (brightest - black) * (lights[pixel] / white).max(0.0);
        let threshold = detection_threshold(shown);
        let masking = within(size, pixel, EDGE_REACH).map(|near| contrasts[near]);
        let masking = masking.fold(f64::INFINITY, f64::min) * shown / threshold;
        let elevation = masking.max(1.0).powf(MASKING_POWER);
        (threshold * elevation * white / (brightest - black)) as f32
    };
    (0..lights.len()).into_par_iter().map(least).collect()
}

/// Deviation of luminance over mean luminance in 3 x 3 pixels, without the noise.
fn contrasts(size: [usize; 2], lights: &[f64], noise: &[f32]) -> Vec<f64> {
    let contrast = |pixel: usize| {
        let (mut count, mut sum, mut squares, mut noisy) = (0.0, 0.0, 0.0, 0.0);
        for near in within(size, pixel, 1) {
            count += 1.0;
            sum += lights[near];
            squares += lights[near] * lights[near];
            noisy += f64::from(noise[near]);
        }
        let mean = sum / count;
        let variance = squares / count - mean * mean - noisy / count;
        if variance > 0.0 && mean > 0.0 { variance.sqrt() / mean } else { 0.0 }
    };
    (0..lights.len()).into_par_iter().map(contrast).collect()
}

/// Logarithms of luminance at which one part of the threshold's curve ends and the next begins.
///
/// Unit: none. Source: Larson, Rushmeier and Piatko 1997, table 1.
const CURVE_ENDS: [f64; 4] = [-3.94, -1.44, -0.0184, 1.9];

/// Factor, offset and power in the logarithm of luminance, and what is taken off, where rods begin to see.
///
/// Unit: none. Source: Larson, Rushmeier and Piatko 1997, table 1.
const ROD_CURVE: [f64; 4] = [0.405, 1.6, 2.18, 2.86];

/// The same where cones begin to see.
///
/// Unit: none. Source: Larson, Rushmeier and Piatko 1997, table 1.
const CONE_CURVE: [f64; 4] = [0.249, 0.65, 2.7, 0.72];

/// What rods and cones take off the logarithm of luminance where their thresholds are in proportion to it.
///
/// Unit: none. Source: Larson, Rushmeier and Piatko 1997, table 1.
const WEBER: [f64; 2] = [0.395, 1.255];

/// The difference in cd/m² that is just seen by an eye adapted to `adaptation` cd/m² (Larson, Rushmeier and Piatko 1997,
/// "A Visibility Matching Tone Reproduction Operator for High Dynamic Range Scenes", table 1).
fn detection_threshold(adaptation: f64) -> f64 {
    let log = adaptation.max(f64::MIN_POSITIVE).log10();
    let curve =
        |[factor, offset, power, less]: [f64; 4]| (factor * log + offset).powf(power) - less;
    let [dark, rods, dusk, cones] = CURVE_ENDS;
    let threshold = match log {
        log if log < dark => -ROD_CURVE[3],
        log if log < rods => curve(ROD_CURVE),
        log if log < dusk => log - WEBER[0],
        log if log < cones => curve(CONE_CURVE),
        log => log - WEBER[1],
    };
    (threshold * LN_10).exp()
}

/// Pixels on each side over which variances are averaged, once they are in visible differences.
///
/// Unit: pixels. Derivation: 25 differences tell their variance to a quarter, and the deviation to an eighth.
const VARIANCE_RADIUS: usize = 2;

/// Pixels of which the one with the most noise is left out of the sum of errors.
///
/// Unit: count. Definition: as in the pilot of strategies.
const PIXELS_PER_OUTLIER: usize = 32;

/// Halves of the rays of a pixel.
///
/// Unit: count. Definition: of halves.
const HALVES: f64 = 2.0;

/// Error of a picture that is to be directed, row by row from the top; variances in radiance squared.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredError<'a> {
    /// Pixels of a row.
    pub width: usize,
    /// Variance of rays after reconstruction.
    pub reconstructed: &'a [f32],
    /// Variance of rays before it.
    pub rendered: &'a [f32],
    /// Squared bias of the reconstruction, which pixels tell together.
    pub squared_bias: &'a [f32],
    /// Variance that pixels around share, before and after reconstruction, which pixels tell together.
    pub shared: [&'a [f32]; 2],
    /// The share of photons in all variance before reconstruction, 0 to 1.
    pub photon_part: f64,
    /// Least visible differences, radiance.
    pub visible: &'a [f32],
    /// Rays of each pixel.
    pub rays: u32,
    /// Power of their number by which their variance falls.
    pub ray_power: f64,
}

/// The X-map of measured `error`: rays that each pixel needs over those of the gold standard, 0 to 1.
///
/// The variance v of r stratified rays is taken to fall as r^-p: p is 1 where light is noise, 3/2 where an edge crosses the pixel
/// (Mitchell 1996, "Consequences of Stratified Sampling in Graphics") and 3 where light is smooth. The squared bias of the
/// reconstruction falls with it, which chooses its scales by the noise. The sum of squared errors, in visible differences,
/// falls most for the number of rays where each pixel gets rays in proportion to v^(1/(1 + p)) (Neyman 1934, optimum allocation,
/// by the method of Lagrange). There are as many as bring that sum to the share `allowed` of the gold standard's, which has
/// `gold` rays in each pixel and is not reconstructed. Its rays are stratified all together, those of `error` in each half by
/// itself: two halves of r rays have half of the variance of r rays of gold.
///
/// What pixels share is seen as blotches, for which less noise of single pixels does not make up: it is brought to that of
/// the gold standard by itself. No ray mends that of photons; that of gathers in cells, of which there are as many as all rays
/// together ask for, falls as one over the mean number of rays.
pub fn error_x_map(error: &MeasuredError<'_>, gold: u32, allowed: f64) -> Vec<f32> {
    let MeasuredError { width, visible, .. } = *error;
    let size = [width, visible.len() / width];
    let [reconstructed, rendered] = [error.reconstructed, error.rendered]
        .map(|variances| averages(size, &in_visible(variances, visible), VARIANCE_RADIUS));
    // Where lights are seen in mirrors a few pixels hold most of the noise, also gold's.
    let kept = rendered.len() - rendered.len() / PIXELS_PER_OUTLIER;
    let most = kept.checked_sub(1).and_then(|rank| nth_smallest(rendered.clone(), rank));
    let counted: Vec<usize> =
        (0..rendered.len()).filter(|pixel| Some(rendered[*pixel]) <= most).collect();
    let sum = |of: &dyn Fn(usize) -> f64| -> f64 { counted.iter().map(|pixel| of(*pixel)).sum() };
    let [rays, gold] = [error.rays.min(gold), gold].map(f64::from);
    let squared_bias = in_visible(error.squared_bias, visible);
    let bias = sum(&|pixel| squared_bias[pixel]).max(0.0);
    let left = |times: f64| times.powf(-error.ray_power);
    // Gold's rays are stratified all together: as those of one half, and so many more.
    let left_of_gold = HALVES * left(HALVES * gold / rays);
    let own_of_gold = sum(&|pixel| rendered[pixel]);
    let of_gold = allowed * own_of_gold * left_of_gold;
    let shared = error.shared.map(|variances| in_visible(variances, visible));
    let [before, after] = shared.each_ref().map(|shared| sum(&|pixel| shared[pixel]).max(0.0));
    let of_photons = (error.photon_part * (own_of_gold + before) / before).min(1.0);
    let least_mean = least_mean_times([before, after], of_photons, allowed * rays / gold);
    // Rays count where pixels share noise.
    let weights = averages(size, &shared[0], VARIANCE_RADIUS);
    let weight = |pixel: usize| weights[pixel].max(0.0);
    let share = |variance: &f64| variance.powf(1.0 / (1.0 + error.ray_power));
    let shares: Vec<f64> = reconstructed.iter().map(share).collect();
    // Bias is where noise is.
    let biased = 1.0 + bias / sum(&|pixel| reconstructed[pixel]).max(f64::MIN_POSITIVE);
    let is_enough = |factor: f64| -> bool {
        let times = |pixel: usize| (factor * shares[pixel]).clamp(rays, gold) / rays;
        let own = sum(&|pixel| biased * reconstructed[pixel] * left(times(pixel)));
        own <= of_gold && sum(&|pixel| weight(pixel) * (times(pixel) - least_mean)) >= 0.0
    };
    // The error falls as the factor rises, from all pixels at the floor to all at the ceiling.
    let noisy = || shares.iter().copied().filter(|share| *share > 0.0);
    let (least, most) = (noisy().fold(f64::INFINITY, f64::min), noisy().fold(0.0, f64::max));
    if most == 0.0 {
        return vec![0.0; visible.len()];
    }
    let (mut low, mut high) = (rays / most, gold / least);
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if is_enough(middle) { high = middle } else { low = middle }
    }
    shares.iter().map(|share| (high * share / gold).min(1.0) as f32).collect()
}

/// How many times the rays there must be in the mean, for the noise that pixels share to be that of the gold standard. It has
/// these variances before and after reconstruction, with the share `of_photons` in it. The gold standard is not reconstructed
/// and has the share `gathers_of_gold` of the variance of gathers.
fn least_mean_times([before, after]: [f64; 2], of_photons: f64, gathers_of_gold: f64) -> f64 {
    if before == 0.0 || of_photons == 1.0 {
        return 0.0;
    }
    let kept = (after / before).min(1.0);
    let of_gathers = 1.0 - of_photons;
    // Gathers may have as much more as the filter takes off the noise of photons.
    of_gathers * kept / (of_gathers * gathers_of_gold + of_photons * (1.0 - kept))
}

/// Variances of pixels in squares of their visible differences.
fn in_visible(variances: &[f32], visible: &[f32]) -> Vec<f64> {
    let relative = |(variance, visible): (&f32, &f32)| {
        let relative = f64::from(*variance) / f64::from(*visible).powi(2);
        // Where nothing is seen no difference is visible.
        if relative.is_finite() { relative } else { 0.0 }
    };
    variances.iter().zip(visible).map(relative).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategy::EDGE_POWER;
    use proptest::prelude::*;

    const SIZE: [usize; 2] = [40, 30];

    fn picture(light: impl Fn(usize, usize) -> f32) -> Image {
        let [width, height] = SIZE;
        let pixels = (0..width * height).map(|i| [light(i % width, i / width); 3]).collect();
        Image::new(width, height, pixels)
    }

    const QUIET: [f32; 1200] = [0.0; 1200];

    /// Where variances of 1 before reconstruction leave these, by two rays, and differences of 1 are visible.
    fn measured(reconstructed: &[f32]) -> MeasuredError<'_> {
        MeasuredError {
            width: SIZE[0],
            reconstructed,
            rendered: &[1.0; 1200],
            squared_bias: &QUIET,
            shared: [&QUIET; 2],
            photon_part: 0.0,
            visible: &[1.0; 1200],
            rays: 2,
            ray_power: EDGE_POWER,
        }
    }

    fn x_map(reconstructed: &[f32], gold: u32) -> Vec<f32> {
        error_x_map(&measured(reconstructed), gold, 1.0)
    }

    /// Bias that is three times the variance asks for as many rays as a fourfold variance, and so does a quarter of the
    /// error.
    #[test]
    fn bias_and_a_smaller_error_ask_for_rays() {
        let variances = [1.0 / 64.0; 1200];
        let unbiased = measured(&variances);
        let fourfold = x_map(&[4.0 / 64.0; 1200], 32);
        let biased = MeasuredError { squared_bias: &[3.0 / 64.0; 1200], ..unbiased };
        for (found, right) in error_x_map(&biased, 32, 1.0).iter().zip(&fourfold) {
            assert!((found / right - 1.0).abs() < 0.01, "{found} for {right}");
        }
        for (found, right) in error_x_map(&unbiased, 32, 0.25).iter().zip(&fourfold) {
            assert!((found / right - 1.0).abs() < 0.01, "{found} for {right}");
        }
        // What is below nothing by chance is no bias.
        let chance = MeasuredError { squared_bias: &[-3.0 / 64.0; 1200], ..unbiased };
        assert_eq!(error_x_map(&chance, 32, 1.0), x_map(&variances, 32));
    }

    /// The table's own values: Weber's law in the light, a floor in the dark, and no jump between its five parts.
    #[test]
    fn thresholds_are_those_of_the_table() {
        for (adaptation, threshold) in
            [(1000.0, 55.6), (0.1, 0.0403), (1e-5, 0.00138), (1e-3, 0.00184), (10.0, 1.07)]
        {
            let found: f64 = detection_threshold(adaptation);
            assert!((found / threshold - 1.0).abs() < 0.01, "{found} for {threshold}");
        }
        for end in [-3.94, -1.44, -0.0184, 1.9_f64] {
            let at = |log: f64| detection_threshold(10.0_f64.powf(log));
            assert!((at(end - 1e-6) / at(end + 1e-6) - 1.0).abs() < 0.03, "{end}");
        }
    }

    #[test]
    fn textures_mask_and_edges_do_not() {
        let at = |picture: &Image| visible_differences(picture, &QUIET)[15 * SIZE[0] + 20];
        let even = at(&picture(|_, _| 0.5));
        let texture = at(&picture(|x, y| if (x + y) % 2 == 0 { 0.25 } else { 0.75 }));
        let edge = at(&picture(|x, _| if x <= 20 { 0.5 } else { 0.1 }));
        assert!(texture > 3.0 * even, "{texture} over {even}");
        assert!((edge / even - 1.0).abs() < 0.05, "{edge} over {even}");
        // What noise makes of an even picture masks nothing.
        let noisy = picture(|x, y| if (x + y) % 2 == 0 { 0.25 } else { 0.75 });
        let noisy = visible_differences(&noisy, &[0.0625; 1200])[15 * SIZE[0] + 20];
        assert!(noisy < 0.8 * texture, "{noisy} under {texture}");
    }

    #[test]
    fn darkness_has_no_visible_difference() {
        assert_eq!(visible_differences(&picture(|_, _| 0.0), &QUIET), [0.0; 1200]);
        let dark = MeasuredError { rendered: &QUIET, visible: &[0.0; 1200], ..measured(&QUIET) };
        let x = error_x_map(&dark, 16, 1.0);
        assert_eq!(x, [0.0; 1200]);
    }

    /// Pixels that reconstruction does not help get gold's rays. As many in two halves have the root of 2 times gold's variance:
    /// where reconstruction takes so much and a 27th of the variance, a ninth of the rays has gold's error.
    #[test]
    fn rays_bring_the_error_to_that_of_gold() {
        let of_halves = std::f64::consts::FRAC_1_SQRT_2 as f32;
        for (left, share) in
            [(1.0, 1.0), (of_halves / 8.0, 1.0 / 4.0), (of_halves / 27.0, 1.0 / 9.0)]
        {
            let x = x_map(&[left; 1200], 64);
            assert!(x.iter().all(|x| (x - share).abs() < 1e-3), "{} for {share}", x[0]);
        }
    }

    /// Of the noise that pixels share the filter leaves a half, so that half of gold's rays have gold's. Where photons make 3 of
    /// 10 parts of it, of which a half is taken off, 2.9 rays do: gathers may have 7 / 8 + 1.5 parts, and have 3.5 by 2 rays. Where
    /// photons make all, the 2 rays there are.
    #[test]
    fn gathers_that_pixels_share_ask_for_rays() {
        let x = |photon_part: f64| {
            let shared: [&[f32]; 2] = [&[2.0; 1200], &[1.0; 1200]];
            let variances = [1e-3; 1200];
            let error = MeasuredError { shared, photon_part, ..measured(&variances) };
            error_x_map(&error, 16, 1.0)[0]
        };
        for (photon_part, rays) in [(0.0, 8.0), (0.2, 2.0 * 3.5 / (7.0 / 8.0 + 1.5)), (0.7, 2.0)] {
            let found = 16.0 * f64::from(x(photon_part));
            assert!((found - rays).abs() < 0.1, "{found} for {rays} at {photon_part}");
        }
    }

    /// Noise in a corner: the ceiling there, next to nothing elsewhere.
    #[test]
    fn rays_go_where_the_error_is() {
        let [width, height] = SIZE;
        let places = (0..width * height).map(|i| [i % width, i / width]);
        let noise: Vec<f32> =
            places.map(|[x, y]| if x < 12 && y < 12 { 1.0 } else { 1e-6 }).collect();
        let x = x_map(&noise, 16);
        assert!(x[5 * SIZE[0] + 5] > 0.25 && x[25 * SIZE[0] + 30] < 0.01, "{} {}", x[205], x[1030]);
        let mean = x.iter().sum::<f32>() / 1200.0;
        assert!(mean < 0.125, "{mean}");
    }

    proptest! {
        #[test]
        fn more_noise_never_means_fewer_rays(
            variances in prop::collection::vec(0.0_f32..1.0, 1200), at in 0_usize..1200,
        ) {
            let before = x_map(&variances, 16);
            let mut more = variances.clone();
            more[at] += 1.0;
            prop_assert!(before.iter().all(|x| (0.0..=1.0).contains(x)));
            prop_assert!(x_map(&more, 16)[at] >= before[at] - 1e-4);
        }
    }
}
