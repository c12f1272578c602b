//! Exposure of a picture that nobody has chosen one for.

use crate::error::Result;
use crate::image::meter;
use crate::math::{Rgb, luminance};
use crate::scene::{RenderSettings, Scene};

use super::director_pass::{Pilot, coarse_look};

/// Pixels of the look that is metered, along the longer side.
const PIXELS: f64 = 96.0;
/// Photon paths of that look.
const PHOTONS: u64 = 40_000;

/// The exposure of the PNG of `scene`, in stops, metered in a coarse look at the whole film: the same for
/// any crop, seed and number of rays or photons.
///
/// # Errors
/// Where photons cannot be shot.
pub fn exposure(scene: &Scene) -> Result<f64> {
    let size = scene.film.size.map(f64::from);
    let pixels = (size[0].max(size[1]) / PIXELS).max(1.0);
    let look = Pilot {
        photons: PHOTONS,
        size: size.map(|side| (side / pixels).ceil() as u32),
        pixels,
        step: 0.0,
    };
    let max_scatter = scene.render.max_scatter;
    let settings = RenderSettings { photons: PHOTONS, max_scatter, ..RenderSettings::default() };
    let film = coarse_look(scene, &settings, look)?;
    let image = film.image();
    let luminances: Vec<f32> =
        image.pixels().iter().map(|p| luminance(Rgb::from(p.map(f64::from))) as f32).collect();
    let transmittance = film.layer("transmittance").unwrap_or_default();
    let alpha: Vec<f32> = transmittance.iter().map(|t| 1.0 - t).collect();
    let glows = scene.media.iter().any(|medium| medium.emission.is_some());
    let stops = meter(&luminances, &alpha, glows).unwrap_or(0.0);
    // A hundredth of a stop is more than anybody sees, and a number to write down.
    Ok((stops * 100.0).round() / 100.0)
}
