//! Writing grids.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use glam::{DAffine3, DVec3, IVec3};

use crate::error::{Error, Result};
use crate::file::PendingFile;

use super::ffi::bridge;

/// Where the header of a file has its unique identifier, as text: after the magic number, three
/// versions of four bytes, and a flag.
const UUID_AT: u64 = 8 + 3 * 4 + 1;

/// What a written grid holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ValueType {
    /// 32-bit floating point.
    #[default]
    Float,
    /// 64-bit floating point.
    Double,
    /// 32-bit integers; fractions are cut off.
    Int32,
    /// 64-bit integers; fractions are cut off.
    Int64,
    /// True where a number is not 0.
    Bool,
    /// Vectors of three 32-bit numbers.
    Vec3,
}

impl ValueType {
    const fn name(self) -> &'static str {
        match self {
            Self::Float => "float",
            Self::Double => "double",
            Self::Int32 => "int32",
            Self::Int64 => "int64",
            Self::Bool => "bool",
            Self::Vec3 => "vec3s",
        }
    }
}

/// 8³ voxels.
#[derive(Debug, Clone)]
pub struct Block {
    /// Smallest voxel; a multiple of 8 along each axis.
    pub origin: IVec3,
    /// 512 values, z fastest; three numbers each for vectors.
    pub values: Vec<f32>,
    /// Active voxels, a bit each; all that differ from the background where not given.
    pub active: Option<[u64; 8]>,
}

/// A constant cube of voxels.
#[derive(Debug, Clone, Copy)]
pub struct Tile {
    /// Smallest voxel; a multiple of the edge along each axis.
    pub origin: IVec3,
    /// Edge in voxels: 8, 128 or 4096.
    pub edge: u32,
    /// The value; a scalar in the first place.
    pub value: [f32; 3],
    /// Whether its voxels are active.
    pub active: bool,
}

/// A grid to be written.
#[derive(Debug, Clone)]
pub struct GridToWrite {
    /// The name.
    pub name: String,
    /// What it holds.
    pub value_type: ValueType,
    /// OpenVDB's class: `fog volume`, `level set` or `unknown`.
    pub class: String,
    /// Whether to store floating-point numbers in 16 bits.
    pub half: bool,
    /// From index space to the world, in metres.
    pub transform: DAffine3,
    /// Value everywhere else; a scalar in the first place.
    pub background: [f32; 3],
    /// Blocks of voxels.
    pub blocks: Vec<Block>,
    /// Constant cubes; a block inside a tile replaces that part.
    pub tiles: Vec<Tile>,
}

impl GridToWrite {
    /// An empty fog volume of 32-bit numbers with background 0, whose voxel (0, 0, 0) has its sample
    /// at `origin`; voxel size and origin in metres.
    pub fn fog(name: impl Into<String>, voxel_size: f64, origin: DVec3) -> Self {
        Self {
            name: name.into(),
            value_type: ValueType::Float,
            class: "fog volume".into(),
            half: false,
            transform: DAffine3::from_scale_rotation_translation(
                DVec3::splat(voxel_size),
                glam::DQuat::IDENTITY,
                origin,
            ),
            background: [0.0; 3],
            blocks: Vec::new(),
            tiles: Vec::new(),
        }
    }

    fn components(&self) -> usize {
        if self.value_type == ValueType::Vec3 { 3 } else { 1 }
    }

    /// What is wrong with it; nothing where it can be written.
    fn problem(&self) -> Option<String> {
        let per_block = 512 * self.components();
        for block in &self.blocks {
            if block.values.len() != per_block {
                return Some(format!(
                    "a block has {} numbers, and needs {per_block}",
                    block.values.len()
                ));
            }
            if block.origin & 7 != IVec3::ZERO {
                return Some(format!("a block at {} is not at multiples of 8", block.origin));
            }
        }
        for tile in &self.tiles {
            if ![8, 128, 4096].contains(&tile.edge) {
                return Some(format!("a tile has the edge {}; 8, 128 or 4096 can be", tile.edge));
            }
            if tile.origin & (tile.edge as i32 - 1) != IVec3::ZERO {
                return Some(format!("a tile at {} is not at multiples of its edge", tile.origin));
            }
        }
        None
    }

    fn lower(&self) -> bridge::WriteGrid {
        let m = self.transform;
        let row = |v: DVec3, w: f64| [v.x, v.y, v.z, w];
        let rows = [
            row(m.matrix3.x_axis, 0.0),
            row(m.matrix3.y_axis, 0.0),
            row(m.matrix3.z_axis, 0.0),
            row(m.translation, 1.0),
        ];
        bridge::WriteGrid {
            name: self.name.clone(),
            value_type: self.value_type.name().into(),
            grid_class: self.class.clone(),
            half: self.half,
            frustum: false,
            affine: std::array::from_fn(|i| rows[i / 4][i % 4]),
            background: self.background,
            origins: self.blocks.iter().flat_map(|b| b.origin.to_array()).collect(),
            values: self.blocks.iter().flat_map(|b| b.values.iter().copied()).collect(),
            masks: self.blocks.iter().flat_map(|b| self.active(b)).collect(),
            tiles: self
                .tiles
                .iter()
                .map(|t| bridge::Tile {
                    origin: t.origin.to_array(),
                    log2_size: t.edge.ilog2(),
                    value: t.value,
                    active: t.active,
                })
                .collect(),
        }
    }

    fn active(&self, block: &Block) -> [u64; 8] {
        block.active.unwrap_or_else(|| {
            let n = self.components();
            let mut mask = [0; 8];
            for (i, value) in block.values.chunks_exact(n).enumerate() {
                if value != &self.background[..n] {
                    mask[i / 64] |= 1 << (i % 64);
                }
            }
            mask
        })
    }
}

/// Writes an OpenVDB file, whole or not at all. The same grids give the same bytes: the identifier
/// that OpenVDB draws at random for every file is replaced by one made from the contents.
///
/// # Errors
/// Where a grid is not sound, or the file cannot be written.
pub fn write(path: &Path, grids: &[GridToWrite]) -> Result<()> {
    for grid in grids {
        if let Some(problem) = grid.problem() {
            return Err(Error::grid(path, &grid.name, problem));
        }
    }
    let lowered: Vec<_> = grids.iter().map(GridToWrite::lower).collect();
    write_lowered(path, &lowered)
}

fn write_lowered(path: &Path, grids: &[bridge::WriteGrid]) -> Result<()> {
    let fail = |e: &dyn std::fmt::Display| Error::file(path, format!("cannot be written: {e}"));
    let pending = PendingFile::new(path)?;
    let Some(temporary) = pending.path().to_str() else {
        return Err(Error::file(path, "the name is not UTF-8, which OpenVDB needs"));
    };
    bridge::write_file(temporary, grids).map_err(|e| fail(&e))?;
    let mut bytes = fs::read(temporary).map_err(|e| fail(&e))?;
    let uuid = identifier(&mut bytes);
    // Opened anew: the library may have replaced the file behind the open handle.
    fs::OpenOptions::new()
        .write(true)
        .open(pending.path())
        .and_then(|mut file| {
            file.seek(SeekFrom::Start(UUID_AT))?;
            file.write_all(uuid.as_bytes())
        })
        .map_err(|e| fail(&e))?;
    pending.finish()
}

/// A UUID (RFC 9562, version 8): the first 16 bytes of the file's BLAKE3 hash, taken with zeros
/// for the random identifier.
fn identifier(bytes: &mut [u8]) -> String {
    if let Some(old) = bytes.get_mut(UUID_AT as usize..UUID_AT as usize + 36) {
        old.fill(b'0');
    }
    let hash = blake3::hash(bytes);
    let (high, low) = hash.as_bytes()[..16].split_at(8);
    let number = |half: &[u8]| half.iter().fold(0, |n: u64, &byte| n << 8 | u64::from(byte));
    let (a, b) = (number(high), number(low));
    format!(
        "{:08x}-{:04x}-8{:03x}-{:04x}-{:012x}",
        a >> 32,
        a >> 16 & 0xffff,
        a & 0xfff,
        b >> 48 & 0x3fff | 0x8000,
        b & 0xffff_ffff_ffff
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vdb::{ReadAs, VdbFile};

    #[test]
    fn frustum_transforms_are_refused_by_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("frustum.vdb");
        let mut grid = GridToWrite::fog("density", 0.1, DVec3::ZERO).lower();
        grid.frustum = true;
        write_lowered(&path, &[grid]).expect("written");
        let file = VdbFile::open(&path).expect("opened");
        assert_eq!(file.grids()[0].matrix, None);
        let message = file.read_scalar(0, ReadAs::Density).expect_err("refused").to_string();
        assert!(
            message.contains("grid \"density\": has a frustum transform (Nonlinear"),
            "{message}"
        );
    }
}
