//! Three scalar grids become one vector grid, leaf by leaf.

use std::collections::{BTreeSet, HashMap};

use glam::IVec3;

use crate::error::Result;
use crate::math::{Index, Transform};

use super::file::VdbFile;
use super::grid::Grid;
use super::source::{Source, SourceTile};
use super::statistics::Statistics;
use super::tree::{BRICK, LOWER, UPPER};

/// Density up to which a voxel has no colour of its own, as in Cycles.
const NO_DENSITY: f32 = 1e-6;
/// Edges of tiles as powers of two, small ones first.
const TILE_SIZES: [u32; 3] = [BRICK, LOWER, UPPER];

impl VdbFile {
    /// Reads three scalar grids as the components of one vector grid, with the transform of the
    /// first.
    pub(super) fn read_combined(&self, indices: &[usize; 3]) -> Result<Grid<[f32; 3]>> {
        self.check_combined(indices)?;
        let [x, y, z] = *indices;
        self.vector(&combined(&[self.source(x)?, self.source(y)?, self.source(z)?]), x)
    }

    /// The grid of those voxels with the transform of grid `index`.
    fn vector(&self, source: &Source<[f32; 3]>, index: usize) -> Result<Grid<[f32; 3]>> {
        let info = self.info(index)?;
        let transform = info.affine().and_then(Transform::<Index>::new).ok_or_else(|| {
            self.grid_error(info, "its transform is singular; it must map voxels to a volume")
        })?;
        Ok(Grid::new(source, transform, Statistics::from_source(source), 0))
    }

    /// As [`read_combined`](Self::read_combined), of colours that are multiplied by grid `density`.
    pub(super) fn read_unpremultiplied(
        &self,
        indices: &[usize; 3],
        density: usize,
    ) -> Result<Grid<[f32; 3]>> {
        self.check_combined(indices)?;
        let [x, y, z] = *indices;
        let mut source = combined(&[self.source(x)?, self.source(y)?, self.source(z)?]);
        unpremultiply(&mut source, &self.source(density)?);
        self.vector(&source, x)
    }

    fn source(&self, index: usize) -> Result<Source<f32>> {
        let info = self.info(index)?;
        if let Some(problem) = info.unreadable() {
            return Err(self.grid_error(info, problem));
        }
        let voxels = self.voxels(index, false)?;
        Source::new(&voxels).map_err(|e| self.grid_error(info, e))
    }
}

/// The vector grid with those components. Its leaves and tiles are all that any of them has; where a
/// component has neither, its tile around or its background counts. A voxel is active where any
/// component's is.
fn combined(parts: &[Source<f32>; 3]) -> Source<[f32; 3]> {
    let lookups = parts.each_ref().map(Lookup::new);
    let leaf_places: BTreeSet<[i32; 3]> =
        parts.iter().flat_map(|part| &part.origins).map(IVec3::to_array).collect();
    let origins: Vec<IVec3> = leaf_places.iter().copied().map(IVec3::from).collect();
    let (mut leaves, mut masks) = (Vec::new(), Vec::new());
    for &origin in &origins {
        let (leaf, mask) = leaf(&lookups, origin);
        leaves.push(leaf);
        masks.push(mask);
    }
    let places: BTreeSet<(u32, [i32; 3])> =
        parts.iter().flat_map(|p| &p.tiles).map(|t| (t.log2_size, t.min.to_array())).collect();
    let tiles: Vec<_> = places
        .iter()
        .filter(|(log2_size, min)| *log2_size > BRICK || !leaf_places.contains(min))
        .map(|&(log2_size, min)| {
            let min = IVec3::from(min);
            let covers = lookups.each_ref().map(|lookup| lookup.cover(min, log2_size));
            SourceTile {
                min,
                log2_size,
                value: covers.map(|(value, _)| value),
                active: covers.iter().any(|(_, active)| *active),
            }
        })
        .collect();
    let mut source = Source {
        background: parts.each_ref().map(|part| part.background),
        active_voxels: 0,
        origins,
        leaves,
        masks,
        tiles,
    };
    source.active_voxels = active_voxels(&source);
    source
}

type VectorLeaf = ([[f32; 3]; 512], [u64; 8]);

fn leaf(lookups: &[Lookup<'_>; 3], origin: IVec3) -> VectorLeaf {
    let mut values = [[0.0; 3]; 512];
    let mut mask = [0; 8];
    for (axis, lookup) in lookups.iter().enumerate() {
        match lookup.leaves.get(&origin.to_array()) {
            Some(&i) => {
                let leaf = &lookup.source.leaves[i];
                values.iter_mut().zip(leaf).for_each(|(value, &component)| value[axis] = component);
                mask.iter_mut().zip(&lookup.source.masks[i]).for_each(|(all, bits)| *all |= bits);
            }
            None => {
                let (component, active) = lookup.cover(origin, BRICK);
                values.iter_mut().for_each(|value| value[axis] = component);
                if active {
                    mask = [u64::MAX; 8];
                }
            }
        }
    }
    (values, mask)
}

/// Divides colours by the density they are multiplied by. Where there is no density they become the
/// mean colour of the smoke, so that values between a voxel of smoke and an empty one are no darker.
fn unpremultiply(colors: &mut Source<[f32; 3]>, density: &Source<f32>) {
    let lookup = Lookup::new(density);
    let mut sum = [0.0; 3];
    let mut mass = 0.0;
    colors.for_each_with(&lookup, |color, density| {
        if density > NO_DENSITY && color.iter().all(|c| c.is_finite()) {
            sum = std::array::from_fn(|i| sum[i] + f64::from(color[i]));
            mass += f64::from(density);
        }
    });
    let mean = sum.map(|sum| if mass > 0.0 { (sum / mass) as f32 } else { 0.0 });
    colors.for_each_with(&lookup, |color, density| {
        *color = if density > NO_DENSITY { color.map(|c| c / density) } else { mean };
    });
    colors.background = mean;
}

impl Source<[f32; 3]> {
    /// Calls `f` with each value and the scalar that `lookup` has there.
    fn for_each_with(&mut self, lookup: &Lookup<'_>, mut f: impl FnMut(&mut [f32; 3], f32)) {
        for (origin, leaf) in self.origins.iter().zip(&mut self.leaves) {
            let scalars = lookup.leaves.get(&origin.to_array()).map(|&i| &lookup.source.leaves[i]);
            let around = lookup.cover(*origin, BRICK).0;
            for (i, value) in leaf.iter_mut().enumerate() {
                f(value, scalars.map_or(around, |scalars| scalars[i]));
            }
        }
        for tile in &mut self.tiles {
            f(&mut tile.value, lookup.cover(tile.min, tile.log2_size).0);
        }
    }
}

/// Leaves and tiles of a source by their place.
struct Lookup<'s> {
    source: &'s Source<f32>,
    leaves: HashMap<[i32; 3], usize>,
    tiles: HashMap<(u32, [i32; 3]), &'s SourceTile<f32>>,
}

impl<'s> Lookup<'s> {
    fn new(source: &'s Source<f32>) -> Self {
        let leaves = source.origins.iter().enumerate().map(|(i, o)| (o.to_array(), i)).collect();
        let key = |tile: &SourceTile<f32>| (tile.log2_size, tile.min.to_array());
        let tiles = source.tiles.iter().map(|tile| (key(tile), tile)).collect();
        Self { source, leaves, tiles }
    }

    /// Value and activity of the smallest tile that covers a block, else of the background.
    fn cover(&self, min: IVec3, log2_size: u32) -> (f32, bool) {
        TILE_SIZES
            .into_iter()
            .filter(|size| *size >= log2_size)
            .find_map(|size| self.tiles.get(&(size, ((min >> size) << size).to_array())))
            .map_or((self.source.background, false), |tile| (tile.value, tile.active))
    }
}

/// Active voxels, where leaves and small tiles take the place of the tiles around them.
fn active_voxels(source: &Source<[f32; 3]>) -> u64 {
    let ones = |mask: &[u64; 8]| mask.iter().map(|bits| u64::from(bits.count_ones())).sum::<u64>();
    let of_leaves: u64 = source.masks.iter().map(ones).sum();
    let mut taken: HashMap<(u32, [i32; 3]), u64> = HashMap::new();
    for origin in &source.origins {
        around(*origin, BRICK, |place| *taken.entry(place).or_default() += 512);
    }
    let mut tiles: Vec<_> = source.tiles.iter().collect();
    tiles.sort_by_key(|tile| tile.log2_size); // small ones first: large ones lose their voxels
    let mut of_tiles = 0;
    for tile in tiles {
        let inside = taken.get(&(tile.log2_size, tile.min.to_array())).copied().unwrap_or(0);
        let own = (1u64 << (3 * tile.log2_size)).saturating_sub(inside);
        of_tiles += if tile.active { own } else { 0 };
        around(tile.min, tile.log2_size, |place| *taken.entry(place).or_default() += own);
    }
    of_leaves + of_tiles
}

/// Calls `f` with the size and place of each tile that could lie around a block.
fn around(min: IVec3, log2_size: u32, mut f: impl FnMut((u32, [i32; 3]))) {
    for size in TILE_SIZES.into_iter().filter(|size| *size > log2_size) {
        f((size, ((min >> size) << size).to_array()));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::math::IndexPoint;
    use crate::vdb::{Block, GridToWrite, ReadAs, Tile, VdbFile, write};

    fn tile(origin: IVec3, edge: u32, value: f32) -> Tile {
        Tile { origin, edge, value: [value, 0.0, 0.0], active: true }
    }

    use super::*;

    /// Grids that have leaves, tiles of three sizes and backgrounds at different places.
    fn parts() -> [GridToWrite; 3] {
        let grid = |name: &str, background| GridToWrite {
            background: [background, 0.0, 0.0],
            ..GridToWrite::fog(name, 0.5, DVec3::ONE)
        };
        let block = |x: i32, factor: f32| Block {
            origin: IVec3::new(x, 0, 0),
            values: (0..512).map(|i| factor * i as f32).collect(),
            active: None,
        };
        let mut x = grid("v.x", 0.0);
        x.blocks = vec![block(0, 1.0), block(-8, 2.0)];
        x.tiles = vec![tile(IVec3::new(128, 0, 0), 128, 7.0)];
        let mut y = grid("v.y", 0.25);
        y.blocks = vec![block(136, 3.0), block(8, 0.5)];
        y.tiles = vec![tile(IVec3::new(144, 0, 0), 8, 5.0)];
        let mut z = grid("v.z", 0.0);
        z.tiles = vec![tile(IVec3::ZERO, 4096, 9.0), tile(IVec3::new(-8, 0, 0), 8, -1.0)];
        [x, y, z]
    }

    #[test]
    fn every_voxel_has_the_values_of_the_three_grids() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("parts.vdb");
        write(&path, &parts()).expect("written");
        let file = VdbFile::open(&path).expect("opened");
        let vector = file.read_combined(&[0, 1, 2]).expect("combined");
        let scalars = [0, 1, 2].map(|i| file.read_scalar(i, ReadAs::Raw).expect("read"));
        let places = (-20..170).flat_map(|x| (-3..12).map(move |y| (x, y)));
        for (x, y) in places {
            for z in [-9, -1, 0, 3, 7, 8, 130, 4095, 4096] {
                let p = IndexPoint::new(f64::from(x) + 0.25, f64::from(y), f64::from(z));
                let wanted = scalars.each_ref().map(|grid| grid.value(p));
                let got = vector.value(p);
                let near =
                    (0..3).all(|i| (got[i] - wanted[i]).abs() <= 1e-6 * (1.0 + wanted[i].abs()));
                assert!(near, "{p:?}: {got:?}, {wanted:?}");
            }
        }
        // All of the large tile, and left of it one block that is a leaf and a tile.
        assert_eq!(vector.active_voxels(), 4096u64.pow(3) + 512);
    }
}
