//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli 2004, "Image Quality Assessment: From
//! Error Visibility to Structural Similarity", equations 13 to 17.
//!
//! Taken on sRGB codes from 0 to 1 (data range 1), not rounded, per channel, and averaged over the
//! three. The window is a Gaussian of sigma 1.5 cut at 11 x 11; places where it would leave the
//! picture don't count. This is scikit-image's `structural_similarity` with `gaussian_weights=True,
//! sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=-1`.

use rayon::prelude::*;

use super::shown;
use crate::image::Image;

/// Pixels from the window's centre to its edge.
const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
/// (K1 L)² and (K2 L)² with K1 = 0.01, K2 = 0.03 and L = 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// SSIM, 1 for the same picture, at an exposure in stops. `None` where a picture is smaller than
/// the window.
pub fn ssim(reference: &Image, test: &Image, exposure: f64) -> Option<f64> {
    let window = 2 * RADIUS + 1;
    let (width, height) = (reference.width(), reference.height());
    if width < window || height < window {
        return None;
    }
    let [r, t] = [reference, test].map(|image| shown::encoded(image, exposure));
    let channels: Vec<f64> = (0..3)
        .into_par_iter()
        .map(|c| {
            let [r, t] = [&r, &t].map(|codes| codes.iter().map(|p| p[c]).collect::<Vec<_>>());
            channel(&r, &t, width)
        })
        .collect();
    Some(channels.iter().sum::<f64>() / 3.0)
}

/// Mean SSIM of one channel.
fn channel(r: &[f64], t: &[f64], width: usize) -> f64 {
    let moment = |of: fn(f64, f64) -> f64| {
        blurred(&r.iter().zip(t).map(|(&r, &t)| of(r, t)).collect::<Vec<_>>(), width)
    };
    let mean_r = moment(|r, _| r);
    let mean_t = moment(|_, t| t);
    let rr = moment(|r, _| r * r);
    let tt = moment(|_, t| t * t);
    let rt = moment(|r, t| r * t);
    let similarity = |i: usize| {
        let (a, b) = (mean_r[i], mean_t[i]);
        let covariance = rt[i] - a * b;
        let variances = (rr[i] - a * a) + (tt[i] - b * b);
        (2.0 * a * b + C1) * (2.0 * covariance + C2) / ((a * a + b * b + C1) * (variances + C2))
    };
    (0..mean_r.len()).map(similarity).sum::<f64>() / mean_r.len() as f64
}

/// The Gaussian mean wherever the window fits.
fn blurred(values: &[f64], width: usize) -> Vec<f64> {
    let kernel = gaussian();
    let across: Vec<f64> = values
        .chunks_exact(width)
        .flat_map(|row| row.windows(kernel.len()).map(|w| dot(w.iter(), &kernel)))
        .collect();
    let width = width - 2 * RADIUS;
    (0..across.len() - 2 * RADIUS * width)
        .map(|start| dot(across[start..].iter().step_by(width), &kernel))
        .collect()
}

fn dot<'a>(values: impl Iterator<Item = &'a f64>, kernel: &[f64]) -> f64 {
    kernel.iter().zip(values).map(|(k, v)| k * v).sum()
}

fn gaussian() -> [f64; 2 * RADIUS + 1] {
    let mut weights = [0.0; 2 * RADIUS + 1];
    for (i, weight) in weights.iter_mut().enumerate() {
        *weight = (-0.5 * ((i as f64 - RADIUS as f64) / SIGMA).powi(2)).exp();
    }
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}
