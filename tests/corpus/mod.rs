//! Damaged and hostile OpenVDB files, the same ones every time.
//!
//! They are made from the volumes that ship and from tiny ones written here: cut, changed, filled
//! with sizes that cannot be, or sound files that hold nothing fogbow could take for a density.

mod craft;
mod odd;

use std::path::Path;

use fogbow::vdb::{Block, GridToWrite, Tile, ValueType, write};
use glam::{DVec3, IVec3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::SplitMix64;

/// A file with what was done to it.
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
}

/// A sound file to be damaged.
struct Source {
    name: &'static str,
    bytes: Vec<u8>,
    /// How many of each kind of damage.
    share: usize,
}

/// Files that are no VDB, hold no density, or lie in one place.
pub(crate) fn odd() -> Vec<Case> {
    odd::cases()
}

/// Every case. Few but one of each kind where `quick`.
pub(crate) fn cases(quick: bool) -> Vec<Case> {
    let mut cases = odd::cases();
    for (seed, source) in sources(quick).iter().enumerate() {
        let mut random = SplitMix64::seed_from_u64(seed as u64);
        let kinds: [(&str, Damage); 7] = [
            ("cut", cut),
            ("byte", byte),
            ("head byte", head_byte),
            ("size", size),
            ("head size", head_size),
            ("hole", hole),
            ("splice", splice),
        ];
        for (kind, damage) in kinds {
            for n in 0..source.share {
                let bytes = damage(&source.bytes, n, source.share, &mut random);
                cases.push(Case { name: format!("{} {kind} {n}", source.name), bytes });
            }
        }
        cases.extend(craft::chunks(source.name, &source.bytes, source.share));
    }
    cases
}

fn sources(quick: bool) -> Vec<Source> {
    let tiny = [
        ("float", tiny(|_| {})),
        ("half", tiny(|g| g.half = true)),
        ("double", tiny(|g| g.value_type = ValueType::Double)),
        ("int32", tiny(|g| g.value_type = ValueType::Int32)),
        ("bool", tiny(|g| g.value_type = ValueType::Bool)),
        ("background", tiny(|g| g.background = [0.25; 3])),
    ];
    let share = if quick { 10 } else { 14 };
    let mut sources: Vec<_> =
        tiny.into_iter().map(|(name, bytes)| Source { name, bytes, share }).collect();
    let shipped: &[&str] =
        if quick { &[] } else { &["wisps.vdb", "smoke.vdb", "fire.vdb", "fog.vdb", "cloud.vdb"] };
    for name in shipped {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("volumes").join(name);
        sources.push(Source { name, bytes: std::fs::read(path).unwrap(), share: 10 });
    }
    sources
}

/// A small fog of blocks and tiles, changed by `change`.
pub(crate) fn tiny(change: impl Fn(&mut GridToWrite)) -> Vec<u8> {
    let mut grid = GridToWrite::fog("density", 0.25, DVec3::new(1.0, 2.0, 3.0));
    grid.tiles.push(Tile { origin: IVec3::splat(8), edge: 8, value: [0.5; 3], active: true });
    grid.tiles.push(Tile { origin: IVec3::splat(-128), edge: 128, value: [0.1; 3], active: true });
    change(&mut grid);
    let components = if grid.value_type == ValueType::Vec3 { 3 } else { 1 };
    for origin in [IVec3::ZERO, IVec3::new(16, 0, 8)] {
        let value = |i: usize| if i.is_multiple_of(3) { 0.0 } else { (i % 7 + 1) as f32 };
        let values = (0..512 * components).map(value).collect();
        grid.blocks.push(Block { origin, values, active: None });
    }
    written(&[grid])
}

/// The bytes of a file with `grids`.
pub(crate) fn written(grids: &[GridToWrite]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.vdb");
    write(&path, grids).unwrap();
    std::fs::read(path).unwrap()
}

/// `bytes` as a file of the format `version`.
pub(crate) fn format(bytes: &[u8], version: u32) -> Vec<u8> {
    with(bytes, 8, &version.to_le_bytes())
}

/// A file that OpenVDB 13.0.0 wrote: the grids `half` and `density` of the same voxels, of true 16-bit
/// floats and of floats.
pub(crate) const HALF_GRID: &[u8] = include_bytes!("half_grid.vdb");

/// Damage number `n` of `of` to a file.
type Damage = fn(&[u8], usize, usize, &mut SplitMix64) -> Vec<u8>;

/// Bytes in which headers, metadata and the root of the tree lie.
const HEAD: usize = 1500;

fn below(random: &mut SplitMix64, limit: usize) -> usize {
    (random.next_u64() % limit as u64) as usize
}

/// Ends early, half of the time within the header.
fn cut(bytes: &[u8], n: usize, of: usize, _: &mut SplitMix64) -> Vec<u8> {
    let span = if n.is_multiple_of(2) { HEAD.min(bytes.len()) } else { bytes.len() };
    bytes[..span * n / of].to_vec()
}

fn byte(bytes: &[u8], _: usize, _: usize, random: &mut SplitMix64) -> Vec<u8> {
    with(bytes, below(random, bytes.len()), &[random.next_u64() as u8])
}

fn head_byte(bytes: &[u8], _: usize, _: usize, random: &mut SplitMix64) -> Vec<u8> {
    let value = [0, 1, 0x7f, 0x80, 0xff][below(random, 5)];
    with(bytes, below(random, HEAD.min(bytes.len())), &[value])
}

/// Numbers that no size should be.
const SIZES: [i64; 10] = [
    -1,
    i64::MIN,
    i64::MAX,
    u32::MAX as i64,
    i32::MAX as i64,
    -(1 << 20),
    1 << 20,
    1 << 32,
    1 << 40,
    0,
];

fn size(bytes: &[u8], n: usize, _: usize, random: &mut SplitMix64) -> Vec<u8> {
    with(bytes, below(random, bytes.len()), &SIZES[n % SIZES.len()].to_le_bytes())
}

fn head_size(bytes: &[u8], n: usize, _: usize, random: &mut SplitMix64) -> Vec<u8> {
    let size = SIZES[n % SIZES.len()].to_le_bytes();
    let width = if n.is_multiple_of(2) { 4 } else { 8 };
    with(bytes, below(random, HEAD.min(bytes.len())), &size[..width])
}

/// Zeros from some place on, as of a download that was allocated and not finished, or in the middle.
fn hole(bytes: &[u8], n: usize, of: usize, random: &mut SplitMix64) -> Vec<u8> {
    let from = bytes.len() * n / of;
    let length = if n.is_multiple_of(2) {
        bytes.len() - from
    } else {
        below(random, 4096).min(bytes.len() - from)
    };
    with(bytes, from, &vec![0; length])
}

/// A piece left out or put in twice.
fn splice(bytes: &[u8], n: usize, _: usize, random: &mut SplitMix64) -> Vec<u8> {
    let (a, b) = (below(random, bytes.len()), below(random, bytes.len()));
    let (a, b) = (a.min(b), a.max(b));
    let (head, tail) = if n.is_multiple_of(2) { (a, b) } else { (b, a) };
    [&bytes[..head], &bytes[tail..]].concat()
}

/// `bytes` with `other` written over them at `offset`, as far as they reach.
pub(crate) fn with(bytes: &[u8], offset: usize, other: &[u8]) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    let end = (offset + other.len()).min(changed.len());
    changed[offset..end].copy_from_slice(&other[..end - offset]);
    changed
}
