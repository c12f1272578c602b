//! Textures and environment maps: PNG, JPEG or EXR.

use std::io::Cursor;
use std::path::Path;

use ::image::{ImageDecoder, ImageReader, Limits};

use super::exr_read::MAX_BYTES;
use super::{Image, MAX_PIXELS, exr_read, srgb};
use crate::error::{Error, Result};
use crate::file;

/// Reads a PNG, JPEG or EXR file, told apart by content.
///
/// # Errors
/// As [`decode_texture`], and where the file cannot be read.
pub fn read_texture(path: &Path) -> Result<Image> {
    decode_texture(&file::read(path, MAX_BYTES)?, path)
}

/// Decodes the bytes of a PNG, JPEG or EXR file; messages name it `path`. PNG and JPEG are taken as
/// sRGB whatever their gamma or profile says, EXR as linear Rec.709. Alpha is left out.
///
/// # Errors
/// Where the bytes are in no known format, are damaged, hold more than [`MAX_PIXELS`] or a value
/// that is not finite.
pub fn decode_texture(bytes: &[u8], path: &Path) -> Result<Image> {
    if exr_read::is_exr(bytes) {
        let image = exr_read::decode_exr(bytes, path)?;
        image.check_finite(path)?;
        return Ok(image);
    }
    let damaged = |e: ::image::ImageError| Error::file(path, format!("cannot be decoded: {e}"));
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    if reader.format().is_none() {
        return Err(Error::file(path, "is no picture known here; use PNG, JPEG or EXR"));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(8 * MAX_PIXELS as u64); // 16-bit RGBA
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    exr_read::check_size(width, height, path)?;
    let codes = ::image::DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb16();
    let linear: Vec<f32> =
        (0..=u16::MAX).map(|code| srgb::decode(f64::from(code) / 65535.0) as f32).collect();
    let pixels = codes.pixels().map(|p| p.0.map(|code| linear[usize::from(code)])).collect();
    Ok(Image::new(width, height, pixels))
}
