//! Trees of OpenVDB's usual shape: a root, nodes of 32³ and 16³ children, leaves of 8³ voxels.

use std::collections::HashSet;
use std::io::{Read, Seek};

use super::bytes::{Bytes, Checked, damaged};
use super::metadata::blosc;

const ZIP: u32 = 1;
const ACTIVE_MASK: u32 = 2;
const BLOSC: u32 = 4;

/// Edge of what a child of the root covers, in voxels.
const ROOT_CHILD: i32 = 4096;

/// How the values of a grid stand in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Values {
    /// Bytes of a value on its own.
    size: u32,
    /// Bytes of a value among others.
    packed: u32,
    /// Whether leaves are bits.
    bits: bool,
    half: bool,
    compression: u32,
}

impl Values {
    /// For the type that OpenVDB calls `kind`; nothing where fogbow does not read it.
    pub(super) fn new(kind: &str, half: bool, compression: u32) -> Option<Self> {
        let value = kind.strip_prefix("Tree_")?.strip_suffix("_5_4_3")?;
        let (size, components, real) = match value {
            "bool" => (1, 1, false),
            "half" => (2, 1, false),
            "int32" => (4, 1, false),
            "int64" => (8, 1, false),
            "float" => (4, 1, true),
            "double" => (8, 1, true),
            "vec3i" => (12, 3, false),
            "vec3s" => (12, 3, true),
            "vec3d" => (24, 3, true),
            _ => return None,
        };
        let half = half && real;
        let packed = if half { 2 * components } else { size };
        Some(Self { size, packed, bits: value == "bool", half, compression })
    }
}

/// Walks over a tree: first its nodes, then the voxels of its leaves; how many leaves it has.
pub(super) fn walk<R: Read + Seek>(file: &mut Bytes<R>, values: Values) -> Checked<u64> {
    let at = file.at();
    if values.compression & !(ZIP | ACTIVE_MASK | BLOSC) != 0 {
        return Err(damaged(at, format_args!("a compression of {}", values.compression)));
    }
    if file.i32("a tree")? != 1 {
        return Err(damaged(at, "a tree with another number of buffers than one"));
    }
    let mut walk = Walk { file, values, leaves: 0 };
    walk.root()?;
    for _ in 0..walk.leaves {
        walk.voxels()?;
    }
    Ok(walk.leaves)
}

struct Walk<'f, R> {
    file: &'f mut Bytes<R>,
    values: Values,
    leaves: u64,
}

impl<R: Read + Seek> Walk<'_, R> {
    fn root(&mut self) -> Checked<()> {
        let size = u64::from(self.values.size);
        self.file.skip(size, "the background")?;
        let (tiles, children) =
            (self.file.u32("the number of tiles")?, self.file.u32("the number of nodes")?);
        let mut places = HashSet::new();
        for _ in 0..tiles {
            self.place(&mut places)?;
            self.file.skip(size, "a tile")?;
            let at = self.file.at();
            let active = self.file.byte("a tile")?;
            if active > 1 {
                return Err(damaged(at, format_args!("a tile's state of {active}")));
            }
        }
        for _ in 0..children {
            self.place(&mut places)?;
            self.upper()?;
        }
        Ok(())
    }

    /// The place of an entry of the root, which no other may have.
    fn place(&mut self, places: &mut HashSet<[i32; 3]>) -> Checked<()> {
        let (at, what) = (self.file.at(), "the place of a node");
        let place = [self.file.i32(what)?, self.file.i32(what)?, self.file.i32(what)?];
        if place.iter().any(|x| x % ROOT_CHILD != 0) {
            return Err(damaged(at, format_args!("a node off the lattice, {place:?},")));
        }
        if !places.insert(place) {
            return Err(damaged(at, format_args!("a second node in the place {place:?}")));
        }
        Ok(())
    }

    fn upper(&mut self) -> Checked<()> {
        let children = self.node::<512>()?;
        (0..children).try_for_each(|_| self.lower())
    }

    fn lower(&mut self) -> Checked<()> {
        let leaves = u64::from(self.node::<64>()?);
        self.leaves += leaves;
        self.file.skip(leaves * 64, "the masks of leaves")
    }

    /// An inner node with masks of `WORDS` words, but not its children; how many there are.
    fn node<const WORDS: usize>(&mut self) -> Checked<u32> {
        let (mut children, mut active) = (0, 0);
        for _ in 0..WORDS {
            children += self.word()?.count_ones();
        }
        for _ in 0..WORDS {
            active += self.word()?.count_ones();
        }
        self.values(64 * WORDS as u32, active)?;
        Ok(children)
    }

    fn word(&mut self) -> Checked<u64> {
        self.file.take("the mask of a node").map(u64::from_le_bytes)
    }

    /// The voxels of a leaf.
    fn voxels(&mut self) -> Checked<()> {
        let mut active = 0;
        for _ in 0..8 {
            active += self.word()?.count_ones();
        }
        if self.values.bits {
            return self.file.skip(3 * 4 + 64, "the voxels of a leaf");
        }
        self.values(512, active)
    }

    /// The values of a node of `count`, of which `active` are.
    fn values(&mut self, count: u32, active: u32) -> Checked<()> {
        let at = self.file.at();
        let kind = self.file.byte("the values of a node")?;
        // Which inactive values follow, and whether a mask says where.
        let (inactive, mask) = match kind {
            0 | 1 | 6 => (0, false),
            2 => (1, false),
            3 => (0, true),
            4 => (1, true),
            5 => (2, true),
            other => return Err(damaged(at, format_args!("a kind of values of {other}"))),
        };
        self.file.skip(inactive * u64::from(self.values.size), "an inactive value")?;
        if mask {
            self.file.skip(u64::from(count) / 8, "the mask of a node")?;
        }
        let masked = self.values.compression & ACTIVE_MASK != 0 && kind != 6;
        self.chunk(if masked { active } else { count })
    }

    /// `count` values as one chunk.
    fn chunk(&mut self, count: u32) -> Checked<()> {
        if self.values.half && count == 0 {
            return Ok(());
        }
        let content = u64::from(count * self.values.packed);
        if self.values.compression & (BLOSC | ZIP) == 0 {
            return self.file.skip(content, "the values of a node");
        }
        let at = self.file.at();
        let size = self.file.i64("the size of a chunk")?;
        let bytes = size.unsigned_abs();
        if size <= 0 {
            if bytes != content {
                return Err(damaged(
                    at,
                    format_args!("a raw chunk of {bytes} bytes instead of {content}"),
                ));
            }
            return self.file.skip(content, "a chunk");
        }
        if self.values.compression & BLOSC != 0 {
            return blosc(self.file, bytes, &[content]);
        }
        self.file.skip(bytes, "a chunk")
    }
}
