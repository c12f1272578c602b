//! Damage that knows the format: sizes of compressed chunks, names, the root of the tree.

use super::{Case, with};

/// Lies about the size of compressed chunks, before them and in Blosc's own header.
pub(super) fn chunks(source: &str, bytes: &[u8], count: usize) -> Vec<Case> {
    let found = find_chunks(bytes);
    let lies: [(&str, usize, i64); 12] = [
        ("raw, too long", 0, -(1 << 16)),
        ("raw, far too long", 0, -(1 << 30)),
        ("raw, endless", 0, i64::MIN),
        ("raw, empty", 0, 0),
        ("one byte", 0, 1),
        ("a header", 0, 16),
        ("longer than memory", 0, 1 << 50),
        ("compressed bytes", 8 + 12, i64::from(i32::MAX)),
        ("block size", 8 + 8, 1),
        ("content", 8 + 4, i64::from(i32::MAX)),
        ("flags", 8 + 2, 0xff),
        ("stream", 8 + 20, -1),
    ];
    (0..count.min(found.len() * lies.len()))
        .map(|n| {
            let (what, at, value) = lies[n % lies.len()];
            let chunk = found[n / lies.len() * 7 % found.len()];
            let width = if at == 0 || at > 20 {
                8
            } else if what == "flags" {
                1
            } else {
                4
            };
            let bytes = with(bytes, chunk + at, &value.to_le_bytes()[..width]);
            Case { name: format!("{source} chunk {n}: {what}"), bytes }
        })
        .collect()
}

/// Offsets of 8-byte sizes that stand before Blosc's header, whose last four bytes say the same.
fn find_chunks(bytes: &[u8]) -> Vec<usize> {
    let number = |at: usize, width: usize| {
        bytes[at..at + width].iter().rev().fold(0u64, |n, b| n << 8 | u64::from(*b))
    };
    (0..bytes.len().saturating_sub(24))
        .filter(|&at| {
            let size = number(at, 8);
            (17..1 << 20).contains(&size) && bytes[at + 8] == 2 && number(at + 20, 4) == size
        })
        .collect()
}

/// Offset of `text` behind its length, which is where its length stands.
pub(super) fn text_at(bytes: &[u8], text: &str) -> usize {
    let with_length = [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let found = bytes.windows(with_length.len()).position(|w| w == with_length);
    found.unwrap_or_else(|| panic!("no {text} in it"))
}

/// Gives the first grid another type, its offsets moved along.
pub(super) fn retyped(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = text_at(bytes, from);
    let behind = at + 4 + from.len();
    let mut out = bytes[..at].to_vec();
    out.extend((to.len() as u32).to_le_bytes());
    out.extend(to.as_bytes());
    out.extend(&bytes[behind..behind + 4]); // no instance parent
    for offset in bytes[behind + 4..][..24].as_chunks::<8>().0 {
        let moved = i64::from_le_bytes(*offset) + to.len() as i64 - from.len() as i64;
        out.extend(moved.to_le_bytes());
    }
    out.extend(&bytes[behind + 28..]);
    out
}

/// Offset of the tree of a tiny file: its buffer count of 1, background 0, then tiles and children.
pub(super) fn tree_at(bytes: &[u8]) -> usize {
    let map = text_at(bytes, "UniformScaleTranslateMap") + 4 + "UniformScaleTranslateMap".len();
    map + 144
}
