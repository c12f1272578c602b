//! Writing deep EXR files: one part of deep scanlines, ZIPS, rows from the top.
//!
//! By "OpenEXR File Layout", sections "Header" and "Deep Data", and "Interpreting OpenEXR Deep Pixels".

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use exr::meta::attribute::{self, AttributeValue::Chromaticities};
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::Window;
use super::exr_attribute::{REC_709, named};
use crate::error::{Error, Result};

/// First bytes of each EXR file.
const MAGIC: u32 = 20_000_630;

/// Version 2, with names above 31 bytes and deep data.
const VERSION: u32 = 2 | 0x400 | 0x800;

/// Compression of single rows by zlib.
const ZIPS: u8 = 2;

/// Channels in the order in which they are stored, which is that of their names.
const CHANNELS: [&str; 6] = ["A", "B", "G", "R", "Z", "ZBack"];

/// A sample of a deep pixel: what lies between two distances along its rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeepSample {
    /// Distances in metres at which it begins and ends; both are equal for a surface.
    pub z: [f32; 2],
    /// Radiance, W/(m² sr), premultiplied by its own alpha.
    pub radiance: [f32; 3],
    /// Opacity, 0 to 1.
    pub alpha: f32,
}

/// A picture of deep pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct DeepImage {
    /// Where it lies on the picture that it is part of.
    pub window: Window,
    /// Width and height of that.
    pub full: [u32; 2],
    /// The samples of each pixel from near to far, row by row from the top.
    pub pixels: Vec<Vec<DeepSample>>,
}

impl DeepImage {
    /// The file `path` that holds it, with `attributes` in its header, numbers among them as such.
    ///
    /// # Errors
    /// Where a value is not finite; `path` is named then.
    pub fn bytes(&self, path: &Path, attributes: &[(String, String)]) -> Result<Vec<u8>> {
        if let Some(index) = self.pixels.iter().position(|samples| !samples.iter().all(is_finite)) {
            let width = self.window.width as usize;
            let (x, y) = (index % width, index / width);
            let what = format!("a deep sample at pixel {x}, {y} is not finite");
            return Err(Error::file(path, what));
        }
        let mut file = self.header(attributes);
        let width = self.window.width as usize;
        let rows: Vec<Vec<u8>> = (self.window.top..)
            .zip(self.pixels.chunks(width))
            .map(|(y, row)| chunk(y, row))
            .collect();
        let mut at = (file.len() + 8 * rows.len()) as u64;
        for row in &rows {
            file.extend(at.to_le_bytes());
            at += row.len() as u64;
        }
        file.extend(rows.concat());
        Ok(file)
    }

    fn header(&self, attributes: &[(String, String)]) -> Vec<u8> {
        let Window { left, top, width, height } = self.window;
        let corners = |[left, top, width, height]: [u32; 4]| {
            let ends = [left, top, left + width - 1, top + height - 1];
            ends.map(|end| (end as i32).to_le_bytes()).concat()
        };
        let most = self.pixels.iter().map(Vec::len).max().unwrap_or(0);
        let own = [
            ("channels", "chlist", channel_list()),
            ("chunkCount", "int", (height as i32).to_le_bytes().to_vec()),
            ("compression", "compression", vec![ZIPS]),
            ("dataWindow", "box2i", corners([left, top, width, height])),
            ("displayWindow", "box2i", corners([0, 0, self.full[0], self.full[1]])),
            ("lineOrder", "lineOrder", vec![0]),
            ("maxSamplesPerPixel", "int", (most as i32).to_le_bytes().to_vec()),
            ("pixelAspectRatio", "float", 1.0_f32.to_le_bytes().to_vec()),
            ("screenWindowCenter", "v2f", vec![0; 8]),
            ("screenWindowWidth", "float", 1.0_f32.to_le_bytes().to_vec()),
            ("type", "string", b"deepscanline".to_vec()),
            ("version", "int", 1_i32.to_le_bytes().to_vec()),
        ];
        let mut all = BTreeMap::new();
        for (name, kind, value) in own {
            let words = [name, kind].map(|word| [word.as_bytes(), &[0]].concat()).concat();
            let size = (value.len() as i32).to_le_bytes();
            all.insert(name, [&words[..], &size, &value].concat());
        }
        let given = attributes.iter().map(|(name, text)| (name.as_str(), named(name, text)));
        for (name, value) in given.chain([("chromaticities", Chromaticities(REC_709))]) {
            let mut bytes = Vec::new();
            // Nothing that is written to memory fails.
            if attribute::write(name.as_bytes(), &value, &mut bytes).is_ok() {
                all.entry(name).or_insert(bytes);
            }
        }
        let begin = [MAGIC, VERSION].map(u32::to_le_bytes).concat();
        let attributes: Vec<u8> = all.into_values().flatten().collect();
        [&begin[..], &attributes, &[0]].concat()
    }
}

fn is_finite(sample: &DeepSample) -> bool {
    let DeepSample { z, radiance, alpha } = sample;
    z.iter().chain(radiance).chain([alpha]).all(|value| value.is_finite())
}

/// The value of the attribute `channels`: 32-bit floats, one a pixel.
fn channel_list() -> Vec<u8> {
    let mut list = Vec::new();
    for name in CHANNELS {
        list.extend(name.bytes());
        list.push(0);
        // Type float; not linear in perception, and three reserved bytes; sampling along x and y.
        list.extend([2_i32, 0, 1, 1].map(i32::to_le_bytes).concat());
    }
    list.push(0);
    list
}

/// The chunk of the row `y`.
fn chunk(y: u32, row: &[Vec<DeepSample>]) -> Vec<u8> {
    let mut count = 0_u32;
    let mut counts = Vec::new();
    for samples in row {
        count += samples.len() as u32;
        counts.extend(count.to_le_bytes());
    }
    let of: [fn(&DeepSample) -> f32; CHANNELS.len()] = [
        |sample| sample.alpha,
        |sample| sample.radiance[2],
        |sample| sample.radiance[1],
        |sample| sample.radiance[0],
        |sample| sample.z[0],
        |sample| sample.z[1],
    ];
    let values = of.iter().flat_map(|value| row.iter().flatten().map(value));
    let values: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    let [table, data] = [&counts, &values].map(|bytes| packed(bytes));
    let sizes = [table.len(), data.len(), values.len()].map(|size| (size as u64).to_le_bytes());
    [&(y as i32).to_le_bytes()[..], &sizes.concat(), &table, &data].concat()
}

/// `bytes` as ZIPS packs them, or as they are where that is not shorter.
fn packed(bytes: &[u8]) -> Vec<u8> {
    // Even bytes before odd ones, and of those the differences to the one before.
    let halves = bytes.iter().step_by(2).chain(bytes.iter().skip(1).step_by(2));
    let mut before = None;
    let predicted = halves.map(|&byte| {
        let difference = before.map_or(byte, |before| byte.wrapping_sub(before).wrapping_add(128));
        before = Some(byte);
        difference
    });
    let predicted: Vec<u8> = predicted.collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(4));
    // Nothing that is written to memory fails.
    let packed = encoder.write_all(&predicted).and_then(|()| encoder.finish());
    packed.ok().filter(|packed| packed.len() < bytes.len()).unwrap_or_else(|| bytes.to_vec())
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use proptest::prelude::*;

    use super::*;

    fn unpacked(packed: &[u8], size: usize) -> Vec<u8> {
        if packed.len() == size {
            return packed.to_vec();
        }
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(packed).read_to_end(&mut bytes).unwrap();
        for at in 1..bytes.len() {
            bytes[at] = bytes[at].wrapping_add(bytes[at - 1]).wrapping_sub(128);
        }
        let (even, odd) = bytes.split_at(size.div_ceil(2));
        (0..size).map(|at| if at % 2 == 0 { even[at / 2] } else { odd[at / 2] }).collect()
    }

    proptest! {
        #[test]
        fn packed_bytes_can_be_read(bytes in prop::collection::vec(0_u8..6, 0..300)) {
            let stored = packed(&bytes);
            prop_assert!(stored.len() <= bytes.len());
            prop_assert_eq!(unpacked(&stored, bytes.len()), bytes);
        }
    }

    #[test]
    fn values_must_be_finite() {
        let bad = DeepSample { alpha: f32::NAN, ..DeepSample::default() };
        let pixels = vec![vec![], vec![bad]];
        let image = DeepImage { window: Window::whole([1, 2]), full: [1, 2], pixels };
        let message = image.bytes(Path::new("a.exr"), &[]).unwrap_err().to_string();
        assert!(message.contains("a.exr") && message.contains("pixel 0, 1"), "{message}");
    }
}
