//! What is in a grid, counted over its active voxels as they stand in the file.

use glam::IVec3;

use super::source::Source;
use super::voxel::Voxel;

/// Numbers that a density must not have. All of them are read as 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct BadValues {
    /// Active voxels that are not a number.
    pub nan: u64,
    /// Active voxels that are infinite, of either sign.
    pub infinite: u64,
    /// Active voxels below 0 and finite.
    pub negative: u64,
}

impl BadValues {
    /// All of them.
    pub const fn total(&self) -> u64 {
        self.nan + self.infinite + self.negative
    }
}

/// Counts and ranges over a grid's active voxels, before any are taken as 0. A vector counts by its
/// length; range and mean are over the finite values.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct Statistics {
    /// Active voxels, those in tiles among them.
    pub active: u64,
    /// Leaves of 8³ voxels.
    pub leaves: u64,
    /// Active tiles.
    pub active_tiles: u64,
    /// Voxels in active tiles.
    pub tile_voxels: u64,
    /// Smallest value; 0 where there is none.
    pub min: f64,
    /// Largest value; 0 where there is none.
    pub max: f64,
    /// Arithmetic mean; 0 where there is none.
    pub mean: f64,
    /// Active voxels that are exactly 0.
    pub zeros: u64,
    /// NaN, infinite and negative ones.
    pub bad: BadValues,
    /// Smallest and largest active voxel; nothing where none is active.
    pub bounds: Option<[[i32; 3]; 2]>,
}

impl Statistics {
    /// The statistics of the active voxels of `source`.
    pub(super) fn from_source<V: Voxel>(source: &Source<V>) -> Self {
        let mut all = Tally::default();
        for ((leaf, mask), &origin) in source.leaves.iter().zip(&source.masks).zip(&source.origins)
        {
            for (i, value) in leaf.iter().enumerate() {
                if mask[i / 64] >> (i % 64) & 1 == 1 {
                    all.add(value.magnitude(), 1);
                    let i = i as i32;
                    let voxel = origin + IVec3::new(i >> 6, i >> 3 & 7, i & 7);
                    all.grow(voxel, voxel);
                }
            }
        }
        let tiles = || source.tiles.iter().filter(|t| t.active);
        for tile in tiles() {
            all.add(tile.value.magnitude(), 1 << (3 * tile.log2_size));
            all.grow(tile.min, tile.min + ((1 << tile.log2_size) - 1));
        }
        Self {
            active: source.active_voxels,
            leaves: source.leaves.len() as u64,
            active_tiles: tiles().count() as u64,
            tile_voxels: tiles().map(|t| 1u64 << (3 * t.log2_size)).sum(),
            min: if all.finite == 0 { 0.0 } else { all.min },
            max: if all.finite == 0 { 0.0 } else { all.max },
            mean: if all.finite == 0 { 0.0 } else { all.sum / all.finite as f64 },
            zeros: all.zeros,
            bad: all.bad,
            bounds: (all.low.cmple(all.high).all())
                .then_some([all.low.to_array(), all.high.to_array()]),
        }
    }
}

struct Tally {
    finite: u64,
    min: f64,
    max: f64,
    sum: f64,
    zeros: u64,
    bad: BadValues,
    low: IVec3,
    high: IVec3,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            finite: 0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            sum: 0.0,
            zeros: 0,
            bad: BadValues::default(),
            low: IVec3::MAX,
            high: IVec3::MIN,
        }
    }
}

impl Tally {
    fn add(&mut self, value: f64, times: u64) {
        if value.is_nan() {
            self.bad.nan += times;
            return;
        }
        if value.is_infinite() {
            self.bad.infinite += times;
            return;
        }
        if value < 0.0 {
            self.bad.negative += times;
        }
        if value == 0.0 {
            self.zeros += times;
        }
        self.finite += times;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
        self.sum += value * times as f64;
    }

    fn grow(&mut self, low: IVec3, high: IVec3) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }
}
