//! Velocity grids, continued into the empty voxels around them.
//!
//! Simulations store velocities where there is smoke, and smoke moves to where there was none: a lookup there must find the
//! velocity of what arrives, and one at the border must not be half of it.

use std::collections::{BTreeMap, HashMap};

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::grid::Grid;
use super::regions::CellBox;
use super::source::{Leaf, Source, SourceTile};
use super::statistics::Statistics;
use super::tree::{BRICK, Child, SIDE, place};

/// A leaf's edge in voxels.
const EDGE: i32 = 1 << BRICK;

/// Leaves by their smallest voxels.
type Leaves = BTreeMap<[i32; 3], Leaf<[f32; 3]>>;

/// `grid`, whose values that are not finite are taken as 0, with values of `voxels` more around those that are not 0: the
/// mean of the neighbours along the axes, voxel after voxel. Large tiles keep their values and are not continued.
pub(super) fn continued(grid: &Grid<[f32; 3]>, voxels: u32) -> Grid<[f32; 3]> {
    let background = finite(grid.background());
    let (mut leaves, tiles) = parts(grid);
    if background == [0.0; 3] && voxels > 0 {
        let around = (voxels as i32 + EDGE - 1) / EDGE;
        let keys = dilated(leaves.keys().copied().collect(), around);
        let is_covered = |key: &[i32; 3]| tiles.iter().any(|tile| covers(tile, *key));
        let new: Vec<_> =
            keys.into_iter().filter(|key| !leaves.contains_key(key) && !is_covered(key)).collect();
        leaves.extend(new.into_iter().map(|key| (key, [[0.0; 3]; 512])));
        for _ in 0..voxels {
            grow(&mut leaves);
        }
        leaves.retain(|_, leaf| leaf.iter().any(|value| *value != [0.0; 3]));
    }
    let source = Source {
        background,
        active_voxels: 512 * leaves.len() as u64,
        origins: leaves.keys().map(|key| IVec3::from(*key)).collect(),
        masks: vec![[u64::MAX; 8]; leaves.len()],
        leaves: leaves.into_values().collect(),
        tiles,
    };
    Grid::new(&source, *grid.transform(), Statistics::from_source(&source), 0)
}

/// The leaves of `grid` and its larger tiles, without values that are not finite.
fn parts(grid: &Grid<[f32; 3]>) -> (Leaves, Vec<SourceTile<[f32; 3]>>) {
    let (mut leaves, mut tiles) = (Leaves::new(), Vec::new());
    let differs = |value: [f32; 3]| value != grid.background();
    grid.tree().for_each_region(CellBox::ALL, &differs, &mut |region| {
        let key = region.min.to_array();
        match region.content {
            Child::Node(brick) => {
                let brick = &grid.tree().bricks[brick as usize];
                let at = |slot: usize| {
                    let p = place(slot, BRICK);
                    brick[(p.x as usize * SIDE + p.y as usize) * SIDE + p.z as usize]
                };
                leaves.insert(key, std::array::from_fn(|slot| finite(at(slot))));
            }
            Child::Constant(value) if region.log2_size == BRICK => {
                leaves.insert(key, [finite(value); 512]);
            }
            Child::Constant(value) => tiles.push(SourceTile {
                min: region.min,
                log2_size: region.log2_size,
                value: finite(value),
                active: true,
            }),
        }
    });
    (leaves, tiles)
}

fn covers(tile: &SourceTile<[f32; 3]>, key: [i32; 3]) -> bool {
    (IVec3::from(key) >> tile.log2_size) == (tile.min >> tile.log2_size)
}

fn finite(value: [f32; 3]) -> [f32; 3] {
    value.map(|component| if component.is_finite() { component } else { 0.0 })
}

/// The leaves of `keys` and those that lie up to `around` leaves beside them along each axis, sorted.
pub(super) fn dilated(mut keys: Vec<[i32; 3]>, around: i32) -> Vec<[i32; 3]> {
    for axis in 0..3 {
        let beside = |key: &[i32; 3]| {
            let key = *key;
            (-around..=around).map(move |step| {
                let mut other = key;
                other[axis] += step * EDGE;
                other
            })
        };
        keys = keys.iter().flat_map(beside).collect();
        keys.sort_unstable();
        keys.dedup();
    }
    keys
}

/// Gives voxels of 0 the mean of their neighbours that are not.
fn grow(leaves: &mut Leaves) {
    let old: HashMap<[i32; 3], &Leaf<[f32; 3]>> =
        leaves.iter().map(|(key, leaf)| (*key, leaf)).collect();
    let list: Vec<_> = leaves.iter().collect();
    let grown = |(key, leaf): &(&[i32; 3], &Leaf<[f32; 3]>)| {
        let mut new: Option<Leaf<[f32; 3]>> = None;
        for slot in (0..512).filter(|slot| leaf[*slot] == [0.0; 3]) {
            let (mut sum, mut count) = (Vec3::ZERO, 0.0);
            for (axis, step) in [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)] {
                let mut at = place(slot, BRICK);
                at[axis] += step;
                let mut other = **key;
                other[axis] += at[axis].div_euclid(EDGE) * EDGE;
                at[axis] = at[axis].rem_euclid(EDGE);
                let Some(from) = old.get(&other) else { continue };
                let value = from[((at.x * EDGE + at.y) * EDGE + at.z) as usize];
                if value != [0.0; 3] {
                    sum += Vec3::from(value);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                new.get_or_insert(**leaf)[slot] = (sum / count).to_array();
            }
        }
        new.map(|new| (**key, new))
    };
    let new: Vec<_> = list.par_iter().filter_map(grown).collect();
    leaves.extend(new);
}
