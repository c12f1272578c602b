//! From OpenVDB's tree of voxels to the tree of bricks.
//!
//! A block of cells needs the samples of the block itself and the first planes of its seven forward
//! neighbours, so every step works on eight source blocks at once, numbered 4 x + 2 y + z. Where all
//! eight are constant the result depends on their eight values alone and is made only once: the faces
//! of a tile of any size share a handful of nodes and bricks.

use std::collections::{BTreeSet, HashMap};

use glam::IVec3;
use rayon::prelude::*;

use super::source::{Leaf, Source, SourceTree};
use super::tree::{
    BRICK, Brick, Child, LOWER, LowerNode, SIDE, Tree, UPPER, UpperNode, place, uniform,
};
use super::voxel::Voxel;

/// A block and its seven forward neighbours.
type Eight<V> = [Child<V>; 8];
/// What eight constant blocks are told apart by.
type Key = [[u32; 3]; 8];

/// Builds the tree; the same source gives the same tree on any number of threads.
pub(super) fn build<V: Voxel>(source: &Source<V>) -> Tree<V> {
    let tree = SourceTree::new(source);
    let mut jobs = Jobs { list: Vec::new(), known: HashMap::new() };
    let mut upper: Vec<UpperNode<V>> = Vec::new();
    let mut known_upper: HashMap<Key, u32> = HashMap::new();
    let mut roots = Vec::new();
    for key in root_keys(&tree) {
        let eight: Eight<V> = std::array::from_fn(|i| {
            let neighbour = (IVec3::from(key) + corner(i)).to_array();
            tree.roots.get(&neighbour).copied().unwrap_or(Child::Constant(tree.background))
        });
        let root = match (constant(&eight), all_constant(&eight)) {
            (Some(value), _) => Child::Constant(value),
            (None, None) => {
                upper.push(split_upper(&eight, &tree, &mut jobs));
                Child::Node(upper.len() as u32 - 1)
            }
            (None, Some(key)) => Child::Node(*known_upper.entry(key).or_insert_with(|| {
                upper.push(split_upper(&eight, &tree, &mut jobs));
                upper.len() as u32 - 1
            })),
        };
        roots.push((key, root));
    }

    let built: Vec<Built<V>> =
        jobs.list.par_iter().map(|eight| build_lower(eight, &tree, &source.leaves)).collect();
    let (children, lower, bricks) = assemble(built);
    for child in upper.iter_mut().flat_map(|node| node.iter_mut()) {
        if let Child::Node(job) = *child {
            *child = children[job as usize];
        }
    }
    for (_, root) in &mut roots {
        if let Child::Node(i) = *root
            && let Some(value) = constant(&upper[i as usize][..])
        {
            *root = Child::Constant(value);
        }
    }
    roots.retain(|(_, root)| !root.is(tree.background));
    Tree::new(tree.background, roots, upper, lower, bricks)
}

/// Every block of 4096³ with a sample of a root in it or on its far faces.
fn root_keys<V: Voxel>(tree: &SourceTree<V>) -> BTreeSet<[i32; 3]> {
    let backward = |&key: &[i32; 3]| (0..8).map(move |i| (IVec3::from(key) - corner(i)).to_array());
    tree.roots.keys().flat_map(backward).collect()
}

/// Lower nodes to be built.
struct Jobs<V> {
    list: Vec<Eight<V>>,
    known: HashMap<Key, u32>,
}

impl<V: Voxel> Jobs<V> {
    fn add(&mut self, eight: Eight<V>) -> u32 {
        let next = self.list.len() as u32;
        if let Some(key) = all_constant(&eight) {
            let number = *self.known.entry(key).or_insert(next);
            if number != next {
                return number;
            }
        }
        self.list.push(eight);
        next
    }
}

/// An upper node whose children are constant or numbers of jobs.
fn split_upper<V: Voxel>(
    eight: &Eight<V>,
    tree: &SourceTree<V>,
    jobs: &mut Jobs<V>,
) -> UpperNode<V> {
    let mut node: UpperNode<V> = uniform(tree.background);
    for (slot, child) in node.iter_mut().enumerate() {
        let below = children_of(eight, &tree.upper, slot, UPPER - LOWER);
        *child = match constant(&below) {
            Some(value) => Child::Constant(value),
            None => Child::Node(jobs.add(below)),
        };
    }
    node
}

/// A lower node, its children numbered in its own list of bricks.
struct Built<V> {
    node: LowerNode<V>,
    bricks: Vec<Brick<V>>,
}

fn build_lower<V: Voxel>(eight: &Eight<V>, tree: &SourceTree<V>, leaves: &[Leaf<V>]) -> Built<V> {
    let mut node: LowerNode<V> = uniform(tree.background);
    let mut bricks: Vec<Brick<V>> = Vec::new();
    let mut known: HashMap<Key, u32> = HashMap::new();
    for (slot, child) in node.iter_mut().enumerate() {
        let below = children_of(eight, &tree.lower, slot, LOWER - BRICK);
        *child = if let Some(value) = constant(&below) {
            Child::Constant(value)
        } else if let Some(key) = all_constant(&below) {
            Child::Node(*known.entry(key).or_insert_with(|| {
                bricks.push(gather(&below, leaves));
                bricks.len() as u32 - 1
            }))
        } else {
            let brick = gather(&below, leaves);
            if brick.iter().all(|v| v.bits() == brick[0].bits()) {
                Child::Constant(brick[0])
            } else {
                bricks.push(brick);
                Child::Node(bricks.len() as u32 - 1)
            }
        };
    }
    Built { node, bricks }
}

/// What stands for each job, all lower nodes, all bricks.
type Assembled<V> = (Vec<Child<V>>, Vec<LowerNode<V>>, Vec<Brick<V>>);

/// Puts the jobs' results together, in their order.
fn assemble<V: Voxel>(built: Vec<Built<V>>) -> Assembled<V> {
    let mut bricks = Vec::with_capacity(built.iter().map(|b| b.bricks.len()).sum());
    let mut lower = Vec::new();
    let children = built
        .into_iter()
        .map(|mut job| {
            if let Some(value) = constant(&job.node[..]) {
                return Child::Constant(value);
            }
            let first = bricks.len() as u32;
            for child in job.node.iter_mut() {
                if let Child::Node(i) = child {
                    *i += first;
                }
            }
            bricks.append(&mut job.bricks);
            lower.push(job.node);
            Child::Node(lower.len() as u32 - 1)
        })
        .collect();
    (children, lower, bricks)
}

/// Which neighbour number `i` of eight is.
fn corner(i: usize) -> IVec3 {
    IVec3::new(i as i32 >> 2, i as i32 >> 1 & 1, i as i32 & 1)
}

/// The child in `slot` of the first block, with its seven forward neighbours, some of which may be
/// children of the other blocks.
fn children_of<V: Voxel, const N: usize>(
    eight: &Eight<V>,
    pool: &[Box<[Child<V>; N]>],
    slot: usize,
    log2_side: u32,
) -> Eight<V> {
    let here = place(slot, log2_side);
    let mask = (1 << log2_side) - 1;
    std::array::from_fn(|i| {
        let there = here + corner(i);
        let block = there >> log2_side;
        match eight[(block.x << 2 | block.y << 1 | block.z) as usize] {
            Child::Node(n) => {
                let local = there & mask;
                let slot = local.x << (2 * log2_side) | local.y << log2_side | local.z;
                pool[n as usize][slot as usize]
            }
            constant @ Child::Constant(_) => constant,
        }
    })
}

/// The samples of a brick from its leaf and the seven forward ones.
fn gather<V: Voxel>(eight: &Eight<V>, leaves: &[Leaf<V>]) -> Brick<V> {
    let mut brick = [V::default(); SIDE * SIDE * SIDE];
    for x in 0..SIDE {
        for y in 0..SIDE {
            let block = (x >> 3) << 2 | (y >> 3) << 1;
            let row = &mut brick[(x * SIDE + y) * SIDE..][..SIDE];
            let first = (x & 7) << 6 | (y & 7) << 3;
            match eight[block] {
                Child::Constant(v) => row[..8].fill(v),
                Child::Node(n) => row[..8].copy_from_slice(&leaves[n as usize][first..][..8]),
            }
            row[8] = match eight[block | 1] {
                Child::Constant(v) => v,
                Child::Node(n) => leaves[n as usize][first],
            };
        }
    }
    brick
}

/// The value all of them have, where they are constant and equal.
fn constant<V: Voxel>(children: &[Child<V>]) -> Option<V> {
    let Child::Constant(value) = children[0] else { return None };
    children.iter().all(|c| c.is(value)).then_some(value)
}

/// The eight values, where all are constant.
fn all_constant<V: Voxel>(eight: &Eight<V>) -> Option<Key> {
    let mut key = Key::default();
    for (bits, child) in key.iter_mut().zip(eight) {
        let Child::Constant(value) = child else { return None };
        *bits = value.bits();
    }
    Some(key)
}
