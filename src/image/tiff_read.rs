//! Reading TIFF pictures.

use std::fmt::Display;
use std::io::Cursor;
use std::path::Path;

use ::tiff::ColorType;
use ::tiff::decoder::{Decoder, DecodingResult, Limits};

use super::decoded::{DecodedTexture, Encoding, srgb_codes};
use super::decoder::{check_packing, check_size};
use super::{Image, MAX_PIXELS};
use crate::error::{Error, Result};

/// The most bytes of a decoded picture: 16-bit RGBA, or RGB of 32-bit floats, of the largest size.
const MAX_DECODED: usize = 12 * MAX_PIXELS;

/// The most bytes of one tag: the offsets of all strips of a high picture, or a colour profile.
const MAX_TAG: usize = 1 << 24;

/// Whether the bytes begin as those of a TIFF or BigTIFF file.
pub(super) fn is_tiff(bytes: &[u8]) -> bool {
    [b"II*\0", b"II+\0", b"MM\0*", b"MM\0+"].iter().any(|magic| bytes.starts_with(*magic))
}

/// Decodes the first picture of a TIFF file: grey or RGB, of 8 or 16 bits as sRGB, of 16-, 32- or
/// 64-bit floats as linear Rec.709. Alpha and other channels are left out.
pub(super) fn decode_tiff(bytes: &[u8], path: &Path) -> Result<DecodedTexture> {
    let damaged = |e: ::tiff::TiffError| {
        Error::file(path, format!("is damaged or of a kind of TIFF that cannot be read: {e}"))
    };
    let limits = {
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MAX_DECODED;
        limits.intermediate_buffer_size = MAX_DECODED;
        limits.ifd_value_size = MAX_TAG;
        limits
    };
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(damaged)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(damaged)?;
    let size = [width as usize, height as usize];
    check_size(size[0], size[1], path)?;
    let color = decoder.colortype().map_err(damaged)?;
    let is_rgb =
        is_rgb(color).ok_or_else(|| refused(path, format!("has pixels of the kind {color:?}")))?;
    check_packing(size[0] * size[1] * usize::from(color.num_samples()), bytes.len(), path)?;
    let mut samples = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut samples).map_err(damaged)?;
    let planes = Planes { size, is_rgb, is_planar: layout.planes > 1 };
    let (pixels, encoding) = match (samples, color.bit_depth()) {
        (DecodingResult::U8(codes), 8) => {
            let linear = srgb_codes(u8::MAX.into());
            (planes.pixels(&codes, |c| linear[usize::from(c)]), Encoding::Srgb { bits: 8 })
        }
        (DecodingResult::U16(codes), 16) => {
            let linear = srgb_codes(u16::MAX);
            (planes.pixels(&codes, |c| linear[usize::from(c)]), Encoding::Srgb { bits: 16 })
        }
        (DecodingResult::F16(values), _) => {
            (planes.pixels(&values, half::f16::to_f32), Encoding::Linear)
        }
        (DecodingResult::F32(values), _) => (planes.pixels(&values, |v| v), Encoding::Linear),
        (DecodingResult::F64(values), _) => {
            (planes.pixels(&values, |v| v as f32), Encoding::Linear)
        }
        (_, bits) => return Err(refused(path, format!("has samples of {bits} bits"))),
    };
    let pixels = pixels.ok_or_else(|| refused(path, "has pixels of no even number of samples"))?;
    Ok(DecodedTexture { image: Image::new(size[0], size[1], pixels), encoding })
}

fn refused(path: &Path, found: impl Display) -> Error {
    Error::file(
        path,
        format!("{found}; grey or RGB of 8 or 16 bits or of floats can be read from TIFF"),
    )
}

/// Whether pixels of this kind begin with red, green and blue, or else with a grey; `None` for other
/// kinds.
fn is_rgb(color: ColorType) -> Option<bool> {
    match color {
        ColorType::RGB(_) | ColorType::RGBA(_) => Some(true),
        // What the crate calls bands are a grey with alpha or more.
        ColorType::Gray(_) | ColorType::GrayA(_) | ColorType::Multiband { .. } => Some(false),
        _ => None,
    }
}

/// How samples lie in a decoded picture.
struct Planes {
    size: [usize; 2],
    is_rgb: bool,
    /// Whether all samples of a channel come before those of the next.
    is_planar: bool,
}

impl Planes {
    /// The pixels of `samples`, or nothing where those are too few or of no even number a pixel.
    fn pixels<T: Copy>(&self, samples: &[T], linear: impl Fn(T) -> f32) -> Option<Vec<[f32; 3]>> {
        let count = self.size[0] * self.size[1];
        let channels = samples.len() / count;
        let needed = if self.is_rgb { 3 } else { 1 };
        if channels < needed || channels * count != samples.len() {
            return None;
        }
        let [across, along] = if self.is_planar { [1, count] } else { [channels, 1] };
        let sample =
            |pixel: usize, channel: usize| linear(samples[pixel * across + channel * along]);
        let pixel = |i| {
            if self.is_rgb {
                [0, 1, 2].map(|channel| sample(i, channel))
            } else {
                [sample(i, 0); 3]
            }
        };
        Some((0..count).map(pixel).collect())
    }
}
