//! A grid as OpenVDB hands it over: leaves and tiles in OpenVDB's own tree.

use std::collections::BTreeMap;

use glam::IVec3;

use crate::math::{Aabb, Index, Point};

use super::ffi::bridge;
use super::tree::{BRICK, Child, LOWER, LowerNode, REACH, UPPER, UpperNode, slot, uniform};
use super::voxel::Voxel;

/// Values of a leaf, z fastest.
pub(super) type Leaf<V> = [V; 512];

/// A constant block.
#[derive(Debug, Clone, Copy)]
pub(super) struct SourceTile<V> {
    pub(super) min: IVec3,
    pub(super) log2_size: u32,
    pub(super) value: V,
    pub(super) active: bool,
}

/// Leaves and tiles in no order, as they came over the bridge.
#[derive(Debug)]
pub(super) struct Source<V> {
    pub(super) background: V,
    pub(super) active_voxels: u64,
    pub(super) origins: Vec<IVec3>,
    pub(super) leaves: Vec<Leaf<V>>,
    /// Active voxels of each leaf.
    pub(super) masks: Vec<[u64; 8]>,
    pub(super) tiles: Vec<SourceTile<V>>,
}

impl<V: Voxel> Source<V> {
    /// Copies the numbers out of OpenVDB's grid.
    ///
    /// # Errors
    /// Where the grid holds another number of components, or reaches too far.
    pub(super) fn new(voxels: &bridge::Voxels) -> Result<Self, String> {
        if voxels.components() != V::COMPONENTS {
            let kind = |n| if n == 1 { "scalars" } else { "three-vectors" };
            return Err(format!(
                "holds {}, but {} are wanted here; name another grid",
                kind(voxels.components()),
                kind(V::COMPONENTS)
            ));
        }
        let point = |&[x, y, z]: &[i32; 3]| IVec3::new(x, y, z);
        let source = Self {
            background: V::from_numbers(&voxels.background()),
            active_voxels: voxels.active_voxels(),
            origins: voxels.origins().as_chunks().0.iter().map(point).collect(),
            leaves: voxels.values().chunks_exact(512 * V::COMPONENTS).map(leaf).collect(),
            masks: voxels.masks().as_chunks().0.to_vec(),
            tiles: voxels
                .tiles()
                .iter()
                .map(|t| SourceTile {
                    min: point(&t.origin),
                    log2_size: t.log2_size,
                    value: V::from_numbers(&t.value),
                    active: t.active,
                })
                .collect(),
        };
        let reach = (1 << REACH) - (2 << UPPER);
        let far =
            |p: IVec3| p.cmplt(IVec3::splat(-reach)).any() || p.cmpgt(IVec3::splat(reach)).any();
        let places = source.origins.iter().copied().chain(source.tiles.iter().map(|t| t.min));
        match places.into_iter().find(|&p| far(p)) {
            Some(p) => Err(format!("has voxels at {p}; coordinates up to ±{reach} are supported")),
            None => Ok(source),
        }
    }

    /// How many active voxels those leaves have of which `wanted` is false of the box into which
    /// their voxels reach; with `leaves_out` those are dropped, and the background is in their
    /// place.
    pub(super) fn keep(&mut self, wanted: &dyn Fn(&Aabb<Index>) -> bool, leaves_out: bool) -> u64 {
        let kept: Vec<bool> = self.origins.iter().map(|at| wanted(&leaf_reach(*at))).collect();
        let mut unwanted = 0;
        for (mask, _) in self.masks.iter().zip(&kept).filter(|(_, kept)| !**kept) {
            unwanted += mask.iter().map(|bits| u64::from(bits.count_ones())).sum::<u64>();
        }
        if leaves_out && unwanted > 0 {
            retain(&mut self.origins, &kept);
            retain(&mut self.leaves, &kept);
            retain(&mut self.masks, &kept);
        }
        unwanted
    }

    /// Takes every NaN, infinite and negative number as 0.
    pub(super) fn make_density(&mut self) {
        self.background = self.background.as_density();
        self.leaves.iter_mut().flatten().for_each(|v| *v = v.as_density());
        self.tiles.iter_mut().for_each(|t| t.value = t.value.as_density());
    }
}

/// The box into which the voxels of the leaf that begins at `origin` reach: between voxels values are trilinear, so that each
/// reaches as far as its neighbours.
pub(super) fn leaf_reach(origin: IVec3) -> Aabb<Index> {
    let corner = |p: IVec3| Point::from_xyz(p.as_dvec3());
    Aabb::new(corner(origin - 1), corner(origin + (1 << BRICK)))
}

/// Keeps the items of which `kept` is true.
fn retain<T>(items: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    items.retain(|_| kept.next().is_some_and(|kept| *kept));
    items.shrink_to_fit();
}

fn leaf<V: Voxel>(numbers: &[f32]) -> Leaf<V> {
    std::array::from_fn(|i| V::from_numbers(&numbers[i * V::COMPONENTS..]))
}

/// OpenVDB's tree over a source; a lower node's children are numbers of leaves.
#[derive(Debug)]
pub(super) struct SourceTree<V> {
    pub(super) background: V,
    pub(super) roots: BTreeMap<[i32; 3], Child<V>>,
    pub(super) upper: Vec<UpperNode<V>>,
    pub(super) lower: Vec<LowerNode<V>>,
}

impl<V: Voxel> SourceTree<V> {
    pub(super) fn new(source: &Source<V>) -> Self {
        let mut tree = Self {
            background: source.background,
            roots: BTreeMap::new(),
            upper: Vec::new(),
            lower: Vec::new(),
        };
        let mut tiles: Vec<_> = source.tiles.iter().collect();
        tiles.sort_by_key(|t| std::cmp::Reverse(t.log2_size)); // large ones first: small ones split them
        for tile in tiles {
            tree.insert(tile.min, tile.log2_size, Child::Constant(tile.value));
        }
        for (i, &origin) in source.origins.iter().enumerate() {
            tree.insert(origin, BRICK, Child::Node(i as u32));
        }
        tree
    }

    fn insert(&mut self, min: IVec3, log2_size: u32, child: Child<V>) {
        let root = self.roots.entry((min >> UPPER).to_array());
        let root = root.or_insert(Child::Constant(self.background));
        if log2_size >= UPPER {
            *root = child;
            return;
        }
        let upper = node_of(root, &mut self.upper);
        let entry = &mut upper[slot(min, LOWER, UPPER - LOWER)];
        if log2_size >= LOWER {
            *entry = child;
            return;
        }
        let lower = node_of(entry, &mut self.lower);
        lower[slot(min, BRICK, LOWER - BRICK)] = child;
    }
}

/// The node behind `child`, made from its constant where there is none yet.
fn node_of<'a, V: Voxel, const N: usize>(
    child: &mut Child<V>,
    pool: &'a mut Vec<Box<[Child<V>; N]>>,
) -> &'a mut [Child<V>; N] {
    let number = match *child {
        Child::Node(i) => i as usize,
        Child::Constant(value) => {
            pool.push(uniform(value));
            *child = Child::Node(pool.len() as u32 - 1);
            pool.len() - 1
        }
    };
    &mut pool[number]
}
