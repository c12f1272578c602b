//! Textures and environment maps: EXR, HDR, TIFF, PNG or JPEG.

use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;

use ::image::{DynamicImage, ImageDecoder, ImageReader, Limits};

use super::decoded::{DecodedTexture, Encoding, srgb_codes};
use super::decoder::{MAX_BYTES, check_size, on_decoder};
use super::exr_read::{decode_exr, is_exr};
use super::hdr_read::{decode_hdr, is_hdr};
use super::tiff_read::{decode_tiff, is_tiff};
use super::{Image, MAX_PIXELS};
use crate::error::{Error, Result};
use crate::file;

/// Reads an EXR, HDR, TIFF, PNG or JPEG file, told apart by content.
///
/// # Errors
/// As [`decode_texture`], and where the file cannot be read.
pub fn read_texture(path: &Path) -> Result<DecodedTexture> {
    decode_texture(&file::read(path, MAX_BYTES)?, path)
}

/// Decodes the bytes of an EXR, HDR, TIFF, PNG or JPEG file; messages name it `path`. Integers are
/// taken as sRGB whatever their gamma or profile says, floats as linear Rec.709. Alpha is left out.
///
/// # Errors
/// Where the bytes are in no known format, are damaged, hold more than [`MAX_PIXELS`] or a value
/// that is not finite.
pub fn decode_texture(bytes: &[u8], path: &Path) -> Result<DecodedTexture> {
    let damaged = |e: &dyn Display| Error::file(path, format!("cannot be decoded: {e}"));
    let texture = if is_exr(bytes) {
        DecodedTexture { image: decode_exr(bytes, path)?, encoding: Encoding::Linear }
    } else {
        on_decoder(path, &damaged, || match bytes {
            _ if is_hdr(bytes) => {
                Ok(DecodedTexture { image: decode_hdr(bytes, path)?, encoding: Encoding::Linear })
            }
            _ if is_tiff(bytes) => decode_tiff(bytes, path),
            _ => decode_codes(bytes, path),
        })?
    };
    texture.image.check_finite(path)?;
    Ok(texture)
}

/// Decodes PNG and JPEG.
fn decode_codes(bytes: &[u8], path: &Path) -> Result<DecodedTexture> {
    let damaged = |e: ::image::ImageError| Error::file(path, format!("cannot be decoded: {e}"));
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| Error::file(path, format!("cannot be read: {e}")))?;
    if reader.format().is_none() {
        return Err(Error::file(path, "is no picture known here; use EXR, HDR, TIFF, PNG or JPEG"));
    }
    let mut limits = Limits::default();
    limits.max_alloc = Some(8 * MAX_PIXELS as u64); // 16-bit RGBA
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    check_size(width, height, path)?;
    let color = decoder.color_type();
    let bits = 8 * color.bytes_per_pixel() / color.channel_count();
    let codes = DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb16();
    let linear = srgb_codes(u16::MAX);
    let pixels = codes.pixels().map(|p| p.0.map(|code| linear[usize::from(code)])).collect();
    Ok(DecodedTexture {
        image: Image::new(width, height, pixels),
        encoding: Encoding::Srgb { bits },
    })
}
