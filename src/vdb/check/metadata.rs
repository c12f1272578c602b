//! Metadata: a count, then name, type, size and value of each.

use std::io::{Read, Seek};

use super::bytes::{Bytes, Checked, damaged};

/// Key under which OpenVDB says that floating-point numbers are stored in 16 bits.
const HALF: &str = "is_saved_as_half_float";

/// What OpenVDB pads shorter tables of leaves to before it compresses them, in bytes.
const PADDED: u64 = 128;

/// Types whose size OpenVDB knows without looking at the one in the file, in bytes.
const FIXED: [(&str, u32); 19] = [
    ("bool", 1),
    ("half", 2),
    ("int32", 4),
    ("int64", 8),
    ("float", 4),
    ("double", 8),
    ("vec2i", 8),
    ("vec2s", 8),
    ("vec2d", 16),
    ("vec3i", 12),
    ("vec3s", 12),
    ("vec3d", 24),
    ("vec4i", 16),
    ("vec4s", 16),
    ("vec4d", 32),
    ("mat4s", 64),
    ("mat4d", 128),
    ("quats", 16),
    ("quatd", 32),
];

/// Walks over the metadata of a file or a grid; whether it says that floats are stored in 16 bits.
pub(super) fn read<R: Read + Seek>(file: &mut Bytes<R>) -> Checked<bool> {
    let mut half = false;
    for _ in 0..file.u32("the count of metadata")? {
        let name = file.text("the name of metadata")?;
        let kind = file.text("the type of metadata")?;
        let size = file.u32("the size of metadata")?;
        let at = file.at();
        if let Some((_, right)) = FIXED.iter().find(|(fixed, _)| *fixed == kind)
            && size != *right
        {
            return Err(damaged(at, format_args!("{kind} metadata of {size} bytes")));
        }
        match (name.as_str(), kind.as_str()) {
            (HALF, "bool") => match file.byte("metadata")? {
                flag @ (0 | 1) => half = flag == 1,
                other => return Err(damaged(at, format_args!("a bool of {other}"))),
            },
            (HALF, _) => return Err(damaged(at, format_args!("{HALF} of type {kind:?}"))),
            (_, "__delayedload") if size > 0 => delayed_load(file, size)?,
            _ => file.skip(size.into(), "a value of metadata")?,
        }
    }
    Ok(half)
}

/// OpenVDB's own table of leaves for reading them later: a count, a byte a leaf, and eight bytes a
/// leaf or `u32::MAX` for none; each list behind its size compressed by Blosc, or 0 and raw.
fn delayed_load<R: Read + Seek>(file: &mut Bytes<R>, size: u32) -> Checked<()> {
    let end = file.at() + u64::from(size);
    let count = file.u32("a count of leaves")?;
    // Every leaf has two masks of 64 bytes in the file.
    if u64::from(count) > file.length() / 128 {
        return Err(damaged(file.at(), format_args!("a table of {count} leaves")));
    }
    for (list, width) in [(0, 1), (1, 8)] {
        let compressed = file.u32("the size of a table of leaves")?;
        let bytes = u64::from(count) * width;
        match compressed {
            u32::MAX if list == 1 => {}
            0 => file.skip(bytes, "a table of leaves")?,
            compressed => blosc(file, compressed.into(), &[bytes, bytes.max(PADDED)])?,
        }
    }
    if file.at() != end {
        return Err(damaged(
            file.at(),
            format_args!("a table of leaves that should end at {end},"),
        ));
    }
    Ok(())
}

/// Walks over `size` bytes that Blosc is to turn into as many as one of `contents`: its header must
/// say the same.
pub(super) fn blosc<R: Read + Seek>(
    file: &mut Bytes<R>,
    size: u64,
    contents: &[u64],
) -> Checked<()> {
    const HEADER: u64 = 16;
    let at = file.at();
    if size < HEADER {
        return Err(damaged(at, format_args!("a Blosc chunk of {size} bytes")));
    }
    let header: [u8; HEADER as usize] = file.take("a Blosc chunk")?;
    let [_, says_content, _, says_size] =
        std::array::from_fn(|i| u32::from_le_bytes(std::array::from_fn(|j| header[4 * i + j])));
    if !contents.contains(&says_content.into()) || u64::from(says_size) != size {
        return Err(damaged(
            at,
            format_args!(
                "a Blosc chunk of {says_content} bytes in {says_size}, and not {} in {size},",
                contents[0]
            ),
        ));
    }
    file.skip(size - HEADER, "a Blosc chunk")
}
