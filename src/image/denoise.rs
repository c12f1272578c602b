//! Noise taken off pictures by Open Image Denoise.

use oidn::{Device, RayTracing};

use super::{Film, Image};
use crate::error::{Error, Result};

/// Whether pictures can be denoised here.
///
/// # Errors
/// Where the library finds no module for this processor.
pub fn can_denoise() -> Result<()> {
    device().map(drop)
}

/// What `film` shows without its noise, by Open Image Denoise's filter for ray tracing in high dynamic
/// range. It works on what differs from ray to ray alone, so that it cannot blur the rest, and is
/// shown the opacity of the media as the albedo, whose edges are those of the smoke.
///
/// # Errors
/// Where the library fails; its message is handed on.
pub fn denoised(film: &Film) -> Result<Image> {
    let device = device()?;
    let noisy = film.image();
    let apart = |(seen, calm): (&[f32; 3], &[f32; 3])| -> [f32; 3] {
        std::array::from_fn(|channel| (seen[channel] - calm[channel]).max(0.0))
    };
    let color: Vec<[f32; 3]> = noisy.pixels().iter().zip(film.calm()).map(apart).collect();
    let transmittance = film.layer("transmittance").expect("every film has the layer");
    let opacity: Vec<[f32; 3]> =
        transmittance.iter().map(|t| [(1.0 - t).clamp(0.0, 1.0); 3]).collect();
    let mut clean = vec![[0.0; 3]; color.len()];
    RayTracing::try_new(&device)
        .map_err(failed)?
        .image_dimensions(film.width(), film.height())
        .hdr(true)
        .albedo(opacity.as_flattened())
        .clean_aux(true)
        .filter(color.as_flattened(), clean.as_flattened_mut())
        .map_err(failed)?;
    let sum = |(clean, calm): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| clean[c] + calm[c]);
    let pixels = clean.iter().zip(film.calm()).map(sum).collect();
    Ok(Image::new(film.width(), film.height(), pixels))
}

fn device() -> Result<Device> {
    Device::cpu().map_err(failed)
}

fn failed(error: oidn::Error) -> Error {
    Error::Failed(format!("Open Image Denoise: {}", error.message()))
}
