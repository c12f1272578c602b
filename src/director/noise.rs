//! The scattering-aware X-map: how uncertain the light is that will be seen.

use super::quantile::quantile;
use crate::image::{Film, srgb_encode};
use crate::math::{Rgb, luminance};

/// Share of the pixels whose uncertainty is at most what counts as full.
const FULL: f64 = 0.95;

/// Share of the pixels that are darker than what counts as white.
const WHITE: f64 = 0.99;

/// Least importance of a pixel in which any light is seen.
const SEEN: f32 = 0.02;

/// Importance, 0 to 1, by how far the rays of a pixel of `pilot` scatter: the standard deviation of
/// a ray's luminance as a display shows it, mean over the neighbourhood. It holds the edges inside
/// a pixel and the noise of shadows and scattering alike, and is 0 where nothing is seen.
///
/// Rays in proportion to it make the sum of squared errors least for their number (Neyman 1934,
/// "On the Two Different Aspects of the Representative Method", optimum allocation).
pub fn uncertainty(pilot: &Film) -> Vec<f32> {
    let (width, height) = (pilot.width(), pilot.height());
    let image = pilot.image();
    let light = |pixel: &[f32; 3]| luminance(Rgb::from(pixel.map(f64::from)));
    let lights: Vec<f64> = image.pixels().iter().map(light).collect();
    let layer = |name: &str| pilot.layer(name).unwrap_or_default().iter().map(|v| f64::from(*v));
    let Some(white) = quantile(lights.iter().copied(), WHITE) else {
        return vec![0.0; lights.len()];
    };
    // The layer holds the variance of the mean of a pixel's rays.
    let deviations: Vec<f64> = layer("variance")
        .zip(layer("rays"))
        .zip(&lights)
        .map(|((variance, rays), light)| {
            let deviation = (variance * rays).sqrt();
            let shown = |light: f64| srgb_encode((light / white).clamp(0.0, 1.0));
            0.5 * (shown(light + deviation) - shown(light - deviation))
        })
        .collect();
    let around = |x: usize, side: usize| x.saturating_sub(1)..(x + 2).min(side);
    let smooth = |x: usize, y: usize| {
        let rows = around(y, height).flat_map(|row| &deviations[row * width..][around(x, width)]);
        let (sum, count) = rows.fold((0.0, 0.0), |(sum, count), d| (sum + d, count + 1.0));
        sum / count
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let map: Vec<f64> = places.map(|(x, y)| smooth(x, y)).collect();
    let full = quantile(map.iter().copied(), FULL);
    let importance = |(deviation, light): (&f64, &f64)| {
        let seen = if *light > 0.0 { SEEN } else { 0.0 };
        full.map_or(seen, |full| ((deviation / full) as f32).clamp(seen, 1.0))
    };
    map.iter().zip(&lights).map(importance).collect()
}
