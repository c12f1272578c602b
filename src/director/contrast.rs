//! The scattering-aware X-map: contrast of the light that will be seen.

use crate::image::{Image, srgb_encode};
use crate::math::{Rgb, luminance};

/// Edge of the square of pixels in which contrast is measured, halved.
const REACH: usize = 1;

/// Share of pixels whose contrast counts as full.
const FULL: f64 = 0.98;

/// Least importance of a pixel in which light is seen at all.
const SEEN: f32 = 0.02;

/// Importance by visible contrast, 0 to 1: the standard deviation of the display-encoded luminance
/// in the neighbourhood of each pixel of `pilot`, an estimate of the picture by a ray a pixel.
///
/// A pixel's neighbours are drawn independently, so their deviation holds both what a pixel misses
/// of the detail in it and the noise of its samples; rays in proportion to it give the least sum of
/// squared errors for their number (Neyman 1934, optimal allocation).
pub fn contrast(pilot: &Image) -> Vec<f32> {
    let (width, height) = (pilot.width(), pilot.height());
    let levels = levels(pilot);
    let around = |x: usize, side: usize| x.saturating_sub(REACH)..(x + REACH + 1).min(side);
    let deviation = |x: usize, y: usize| {
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for row in around(y, height) {
            for level in &levels[row * width..][around(x, width)] {
                count += 1.0;
                sum += f64::from(*level);
                squares += f64::from(*level).powi(2);
            }
        }
        let mean = sum / count;
        (squares / count - mean * mean).max(0.0).sqrt() as f32
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut map: Vec<f32> = places.map(|(x, y)| deviation(x, y)).collect();
    let full = quantile(map.iter().copied().filter(|v| *v > 0.0), FULL);
    for (importance, level) in map.iter_mut().zip(&levels) {
        let seen = if *level > 0.0 { SEEN } else { 0.0 };
        *importance = if full > 0.0 { (*importance / full).clamp(seen, 1.0) } else { seen };
    }
    map
}

/// Luminance as a display shows it, 0 to 1, exposed so that the brightest hundredth is white.
fn levels(image: &Image) -> Vec<f32> {
    let light = |pixel: &[f32; 3]| luminance(Rgb::from(pixel.map(f64::from)));
    let lights: Vec<f64> = image.pixels().iter().map(light).collect();
    let white = quantile(lights.iter().map(|v| *v as f32).filter(|v| *v > 0.0), 0.99);
    let exposure = if white > 0.0 { 1.0 / f64::from(white) } else { 0.0 };
    lights.iter().map(|v| srgb_encode((v * exposure).clamp(0.0, 1.0)) as f32).collect()
}

fn quantile(values: impl Iterator<Item = f32>, share: f64) -> f32 {
    let mut values: Vec<f32> = values.collect();
    let rank = (values.len().saturating_sub(1) as f64 * share) as usize;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(rank, f32::total_cmp).1 }
}
