//! Binary layers (.usdc): whether their counts can be, before the crate reserves memory by them.
//!
//! The crate takes counts and offsets as they stand. A damaged layer would have it reserve more memory than
//! there is, follow values that hold themselves, or make paths without end, and none of that ends in an error.
//! What is wrong in other ways ends its thread, which [`Root`](super::stage::Root) reports.
//!
//! The format: <https://openusd.org/release/api/crate_file_8h.html>; a header points to a table of sections, which
//! are tokens, strings, fields (a token and a value each), sets of fields, paths, and specs (a path and a set of
//! fields each). Values lie before them.

mod bytes;
mod values;

use bytes::Bytes;
use values::{Tables, Values};

/// Beginning of binary layers.
const MAGIC: &[u8] = b"PXR-USDC";

/// Minor versions of the format that the crate reads, of major version 0.
const VERSIONS: std::ops::RangeInclusive<u8> = 4..=12;

/// Most sections.
const MAX_SECTIONS: u64 = 63;

/// Deepest nesting of prims: composition calls itself for each.
const MAX_DEPTH: u32 = 256;

/// Most bytes of all paths together.
const MAX_PATHS: u64 = 8 << 30;

/// Whether `bytes` begin like a binary layer.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Checks the binary layer `bytes`. Returns its tokens, each with a zero behind it.
///
/// # Errors
/// Where its sections or values cannot be.
pub(super) fn check(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let mut header = Bytes::from(bytes, MAGIC.len() as u64)?;
    let version = header.take(8, 1)?;
    let (major, minor) = (version[0], version[1]);
    if major != 0 || !VERSIONS.contains(&minor) {
        let (first, last) = (VERSIONS.start(), VERSIONS.end());
        return Err(format!("its format is {major}.{minor}; 0.{first} to 0.{last} are read"));
    }
    let contents = header.u64()?;
    let sections = Sections::read(bytes, contents)?;
    let (text, tokens) = sections.find("TOKENS", tokens)?;
    let strings = sections.find("STRINGS", |at| strings(at, tokens.len()))?;
    let fields = sections.find("FIELDS", |at| fields(at, tokens.len()))?;
    let sets = sections.find("FIELDSETS", |at| field_sets(at, fields.len()))?;
    let paths = sections.find("PATHS", |at| paths(at, &text, &tokens))?;
    sections.find("SPECS", |at| specs(at, paths.len(), sets.len()))?;
    let tables = Tables { version: minor, tokens, strings, paths };
    let mut values = Values::of(bytes, &tables);
    fields.into_iter().try_for_each(|value| values.check(value))?;
    Ok(text)
}

/// Sections by their names.
struct Sections<'a> {
    bytes: &'a [u8],
    /// Name, first byte and one past the last.
    known: Vec<(&'a [u8], u64, u64)>,
}

impl<'a> Sections<'a> {
    fn read(bytes: &'a [u8], contents: u64) -> Result<Self, String> {
        let mut at = Bytes::from(bytes, contents)?;
        let count = at.u64()?;
        if count > MAX_SECTIONS {
            return Err(format!("it says to have {count} sections; up to {MAX_SECTIONS} can be"));
        }
        let mut known = Vec::new();
        for _ in 0..count {
            let name = at.take(16, 1)?;
            let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
            let (start, size) = (at.u64()?, at.u64()?);
            known.push((&name[..end], start, start.saturating_add(size)));
        }
        Ok(Self { bytes, known })
    }

    /// What `read` finds in the section `name`.
    fn find<T>(
        &self,
        name: &str,
        read: impl FnOnce(&mut Bytes<'_>) -> Result<T, String>,
    ) -> Result<T, String> {
        let section = self.known.iter().find(|(known, ..)| *known == name.as_bytes());
        let (_, start, end) = section.ok_or_else(|| format!("it has no section {name}"))?;
        let whole = usize::try_from(*end).ok().and_then(|end| self.bytes.get(..end));
        let whole = whole.ok_or_else(|| {
            format!("its section {name} ends at byte {end} of {}", self.bytes.len())
        })?;
        let found = Bytes::from(whole, *start).and_then(|mut at| read(&mut at));
        found.map_err(|problem| format!("section {name}: {problem}"))
    }
}

/// Tokens, each with a zero behind it, and their lengths.
fn tokens(at: &mut Bytes<'_>) -> Result<(Vec<u8>, Vec<u32>), String> {
    let (count, size) = (at.u64()?, at.u64()?);
    let block = at.block()?;
    if block.size as u64 != size {
        return Err(format!("it says to have {size} bytes of text and has {}", block.size));
    }
    let text = block.decompressed()?;
    let lengths: Vec<_> = text
        .split(|byte| *byte == 0)
        .map(|token| u32::try_from(token.len()).unwrap_or(u32::MAX))
        .collect();
    // Behind the last one there is nothing.
    let lengths = &lengths[..lengths.len() - 1];
    if lengths.len() as u64 != count {
        return Err(format!("it says to have {count} tokens and has {}", lengths.len()));
    }
    let lengths = lengths.to_vec();
    Ok((text, lengths))
}

/// Tokens of strings.
fn strings(at: &mut Bytes<'_>, tokens: usize) -> Result<Vec<u32>, String> {
    let count = at.u64()?;
    let raw = at.take(count, 4)?;
    let strings =
        raw.chunks_exact(4).map(|raw| u32::from_le_bytes(raw.try_into().unwrap_or_default()));
    strings.map(|token| index(token, tokens, "token").map(|token| token as u32)).collect()
}

/// Values of fields.
fn fields(at: &mut Bytes<'_>, tokens: usize) -> Result<Vec<u64>, String> {
    let count = at.u64()?;
    for token in at.block()?.integers(count)? {
        index(token.cast_unsigned(), tokens, "token")?;
    }
    let block = at.block()?;
    if Some(block.size as u64) != count.checked_mul(8) {
        return Err(format!("it has {} bytes for {count} values", block.size));
    }
    let raw = block.decompressed()?;
    let values = raw.chunks_exact(8);
    Ok(values.map(|raw| u64::from_le_bytes(raw.try_into().unwrap_or_default())).collect())
}

/// Sets of fields one behind another, each with an end.
fn field_sets(at: &mut Bytes<'_>, fields: usize) -> Result<Vec<i32>, String> {
    let count = at.u64()?;
    let sets = at.block()?.integers(count)?;
    for field in sets.iter().filter(|field| **field != -1) {
        index(field.cast_unsigned(), fields, "field")?;
    }
    Ok(sets)
}

/// Lengths of paths.
fn paths(at: &mut Bytes<'_>, text: &[u8], tokens: &[u32]) -> Result<Vec<u32>, String> {
    let are_names: Vec<_> = text.split(|byte| *byte == 0).map(is_name).collect();
    let (count, encoded) = (at.u64()?, at.u64()?);
    let places = at.block()?.integers(encoded)?;
    let elements = at.block()?.integers(encoded)?;
    let jumps = at.block()?.integers(encoded)?;
    // The empty path has a place alone.
    if count > encoded.saturating_add(1) {
        return Err(format!("it says to have {count} paths, of which {encoded} are there"));
    }
    let mut lengths = vec![0_u32; count as usize];
    let mut is_met = vec![false; jumps.len()];
    let (mut total, mut pending) = (0_u64, Vec::new());
    if !jumps.is_empty() {
        pending.push((0, 0, 0));
    }
    while let Some((first, length_of_parent, depth)) = pending.pop() {
        let (mut at, mut parent, mut depth): (usize, u32, u32) = (first, length_of_parent, depth);
        loop {
            let is_new = is_met.get_mut(at).filter(|is_met| !**is_met);
            *is_new.ok_or_else(|| {
                format!("its paths lead to entry {at} twice, or behind the last")
            })? = true;
            let place = index(places[at].cast_unsigned(), lengths.len(), "path")?;
            let element = index(elements[at].unsigned_abs(), tokens.len(), "token")?;
            // The first is the root, which has no name.
            if at > 0 && !are_names[element] {
                return Err(format!(
                    "its path {place} has token {element} as a name, and it is none"
                ));
            }
            let length = parent.saturating_add(tokens[element]).saturating_add(1);
            lengths[place] = length;
            total += u64::from(length);
            let jump = jumps[at];
            let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
            if has_child {
                if has_sibling {
                    pending.push((at + jump as usize, parent, depth));
                }
                (parent, depth) = (length, depth + 1);
            }
            if depth > MAX_DEPTH || total > MAX_PATHS {
                return Err(format!(
                    "its paths are more than {MAX_DEPTH} deep, or have more than {MAX_PATHS} characters"
                ));
            }
            if !has_child && !has_sibling {
                break;
            }
            at += 1;
        }
    }
    Ok(lengths)
}

/// Whether a token can be an element of a path: a name, or the choice of a variant. The crate looks without end for
/// the prim of a path with a single brace.
fn is_name(token: &[u8]) -> bool {
    let inner = token.strip_prefix(b"{").and_then(|token| token.strip_suffix(b"}"));
    let is_odd = |byte: &u8| byte.is_ascii_control() || b"/{}[]<>".contains(byte);
    !token.is_empty() && !inner.unwrap_or(token).iter().any(is_odd)
}

/// Prims and properties: their paths and sets of fields.
fn specs(at: &mut Bytes<'_>, paths: usize, sets: usize) -> Result<(), String> {
    let count = at.u64()?;
    let (own_paths, own_sets) = (at.block()?.integers(count)?, at.block()?.integers(count)?);
    at.block()?.integers(count)?;
    for (path, set) in own_paths.into_iter().zip(own_sets) {
        index(path.cast_unsigned(), paths, "path")?;
        index(set.cast_unsigned(), sets, "entry of the sets of fields,")?;
    }
    Ok(())
}

/// `index`, which is below `count`.
fn index(index: u32, count: usize, name: &str) -> Result<usize, String> {
    let index = index as usize;
    let is_there = index < count;
    is_there.then_some(index).ok_or_else(|| format!("it refers to {name} {index} of {count}"))
}
