//! The sparse tree a grid lives in.
//!
//! It has OpenVDB's levels: a sorted list of blocks of 4096³ cells, each divided into 32³ nodes of
//! 128³, each divided into 16³ bricks of 8³ cells. A block that is constant at any level is kept as
//! its value. A brick holds 9³ samples, the last plane of each axis being its neighbours' first, and
//! so every cell between eight samples lies in exactly one brick.

use glam::IVec3;
use rayon::prelude::*;

use super::voxel::Voxel;

/// Log2 of the edge of a brick, in cells.
pub(super) const BRICK: u32 = 3;
/// Log2 of the edge of a lower node.
pub(super) const LOWER: u32 = 7;
/// Log2 of the edge of an upper node.
pub(super) const UPPER: u32 = 12;
/// Log2 of the largest coordinate a grid may reach.
pub(super) const REACH: u32 = 30;

/// Samples along an edge of a brick.
pub(super) const SIDE: usize = 9;
/// Samples of a brick, z fastest.
pub(super) type Brick<V> = [V; SIDE * SIDE * SIDE];

/// A part of a node: constant, or stored elsewhere under its number.
#[derive(Debug, Clone, Copy)]
pub(super) enum Child<V> {
    Constant(V),
    Node(u32),
}

impl<V: Voxel> Child<V> {
    /// Whether it is constant with this value.
    pub(super) fn is(self, value: V) -> bool {
        matches!(self, Self::Constant(v) if v.bits() == value.bits())
    }
}

/// Children of a node, z fastest.
pub(super) type Node<V, const N: usize> = Box<[Child<V>; N]>;
pub(super) type LowerNode<V> = Node<V, 4096>;
pub(super) type UpperNode<V> = Node<V, 32768>;

/// For each child of a node the log2 of the edge, in children, of the largest aligned cube round it
/// that is constant: 0 where it is alone, and of bricks. Rays cross such a cube in one step.
type Merged<const N: usize> = Box<[u8; N]>;

/// A node of `N` equal children.
pub(super) fn uniform<V: Voxel, const N: usize>(value: V) -> Node<V, N> {
    vec![Child::Constant(value); N].try_into().expect("the length is N")
}

/// Slot of the child that holds `cell` in a node whose children have the edge 2^`child`, and which
/// has 2^`log2_side` of them along an edge.
pub(super) fn slot(cell: IVec3, child: u32, log2_side: u32) -> usize {
    let local = (cell >> child) & ((1 << log2_side) - 1);
    ((local.x << (2 * log2_side)) | (local.y << log2_side) | local.z) as usize
}

/// Place of the child in a slot, in children: the inverse of [`slot`].
pub(super) fn place(slot: usize, log2_side: u32) -> IVec3 {
    let (slot, mask) = (slot as i32, (1 << log2_side) - 1);
    IVec3::new(slot >> (2 * log2_side), (slot >> log2_side) & mask, slot & mask)
}

/// See the module's documentation.
#[derive(Debug)]
pub(super) struct Tree<V> {
    pub(super) background: V,
    /// Blocks of 4096³ that are not background, by their place in blocks, sorted.
    pub(super) roots: Vec<([i32; 3], Child<V>)>,
    /// For n = 0, 1, ...: places of the blocks of edge 2^(12 + n) that hold any root, sorted.
    pub(super) occupied: Vec<Vec<[i32; 3]>>,
    pub(super) upper: Vec<UpperNode<V>>,
    pub(super) lower: Vec<LowerNode<V>>,
    upper_merged: Vec<Merged<32768>>,
    lower_merged: Vec<Merged<4096>>,
    pub(super) bricks: Vec<Brick<V>>,
    /// Smallest and largest sample of each brick: bounds of everything inside.
    pub(super) ranges: Vec<[f32; 2]>,
}

/// A cube of cells that is one brick, or constant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region<V> {
    /// Smallest cell.
    pub(super) min: IVec3,
    /// Log2 of the edge.
    pub(super) log2_size: u32,
    /// The value, or the number of the brick.
    pub(super) content: Child<V>,
}

impl<V> Region<V> {
    /// The cell after the last along each axis.
    pub(super) fn end(&self) -> IVec3 {
        self.min + (1 << self.log2_size)
    }
}

/// A way into the tree that remembers the last nodes it came through.
#[derive(Debug, Clone)]
pub(super) struct Cursor<'a, V> {
    tree: &'a Tree<V>,
    upper: Option<(IVec3, Inner<'a, V, 32768>)>,
    lower: Option<(IVec3, Inner<'a, V, 4096>)>,
}

/// A node with what is merged in it.
type Inner<'a, V, const N: usize> = (&'a Node<V, N>, &'a Merged<N>);

impl<'a, V: Voxel> Cursor<'a, V> {
    pub(super) fn new(tree: &'a Tree<V>) -> Self {
        Self { tree, upper: None, lower: None }
    }

    /// The largest known region round `cell`, whose coordinates lie within ±2^[`REACH`].
    #[inline]
    pub(super) fn region(&mut self, cell: IVec3) -> Region<V> {
        if let Some((key, node)) = self.lower
            && key == cell >> LOWER
        {
            return child(cell, node, BRICK, LOWER - BRICK);
        }
        self.descend(cell)
    }

    fn descend(&mut self, cell: IVec3) -> Region<V> {
        let key = cell >> UPPER;
        let upper = match self.upper {
            Some((known, node)) if known == key => node,
            _ => match self.tree.root(key) {
                Some(Child::Node(i)) => {
                    let i = i as usize;
                    let node = (&self.tree.upper[i], &self.tree.upper_merged[i]);
                    self.upper = Some((key, node));
                    node
                }
                Some(constant) => return region(cell, UPPER, constant),
                None => {
                    return region(cell, self.tree.gap(key), Child::Constant(self.tree.background));
                }
            },
        };
        let constant = child(cell, upper, LOWER, UPPER - LOWER);
        let Child::Node(i) = constant.content else { return constant };
        let lower = (&self.tree.lower[i as usize], &self.tree.lower_merged[i as usize]);
        self.lower = Some((cell >> LOWER, lower));
        child(cell, lower, BRICK, LOWER - BRICK)
    }
}

/// The largest known region round `cell` in a node, whose children have the edge 2^`size`, and which
/// has 2^`log2_side` of them along an edge.
#[inline]
fn child<V: Copy, const N: usize>(
    cell: IVec3,
    (node, merged): Inner<'_, V, N>,
    size: u32,
    log2_side: u32,
) -> Region<V> {
    let slot = slot(cell, size, log2_side);
    region(cell, size + u32::from(merged[slot]), node[slot])
}

/// See [`Merged`].
fn merged<V: Voxel, const N: usize>(node: &Node<V, N>, log2_side: u32) -> Merged<N> {
    let mut merged: Merged<N> = vec![0; N].try_into().expect("the length is N");
    for level in 1..=log2_side {
        let bits = log2_side - level;
        for index in 0..1 << (3 * bits) {
            let first = place(index, bits) << level;
            let half = |i| slot(first + (place(i, 1) << (level - 1)), 0, log2_side);
            let Child::Constant(value) = node[half(0)] else { continue };
            let is_even =
                |slot: usize| node[slot].is(value) && u32::from(merged[slot]) == level - 1;
            if !(0..8).map(half).all(is_even) {
                continue;
            }
            for within in 0..1 << (3 * level) {
                merged[slot(first + place(within, level), 0, log2_side)] = level as u8;
            }
        }
    }
    merged
}

#[inline]
fn region<V>(cell: IVec3, log2_size: u32, content: Child<V>) -> Region<V> {
    Region { min: (cell >> log2_size) << log2_size, log2_size, content }
}

impl<V: Voxel> Tree<V> {
    /// Finishes a tree from its parts; `roots` sorted.
    pub(super) fn new(
        background: V,
        roots: Vec<([i32; 3], Child<V>)>,
        upper: Vec<UpperNode<V>>,
        lower: Vec<LowerNode<V>>,
        bricks: Vec<Brick<V>>,
    ) -> Self {
        let keys: Vec<[i32; 3]> = roots.iter().map(|&(key, _)| key).collect();
        let occupied = (0..=REACH - UPPER)
            .map(|n| {
                let mut blocks: Vec<_> = keys.iter().map(|key| key.map(|c| c >> n)).collect();
                blocks.sort_unstable();
                blocks.dedup();
                blocks
            })
            .collect();
        let ranges = bricks.iter().map(|b| range(b)).collect();
        let upper_merged = upper.par_iter().map(|node| merged(node, UPPER - LOWER)).collect();
        let lower_merged = lower.par_iter().map(|node| merged(node, LOWER - BRICK)).collect();
        Self {
            background,
            roots,
            occupied,
            upper,
            lower,
            upper_merged,
            lower_merged,
            bricks,
            ranges,
        }
    }

    fn root(&self, key: IVec3) -> Option<Child<V>> {
        let key = key.to_array();
        let i = self.roots.binary_search_by_key(&key, |&(key, _)| key).ok()?;
        Some(self.roots[i].1)
    }

    /// Log2 of the edge of the largest aligned empty cube round the empty block `key`.
    fn gap(&self, key: IVec3) -> u32 {
        let empty = |n: &u32| {
            let block = (key >> *n).to_array();
            self.occupied[*n as usize].binary_search(&block).is_err()
        };
        UPPER + (1..=REACH - UPPER).take_while(empty).last().unwrap_or(0)
    }

    /// Smallest and largest value in a region.
    pub(super) fn range_of(&self, content: Child<V>) -> [f32; 2] {
        match content {
            Child::Constant(v) => v.range(),
            Child::Node(i) => self.ranges[i as usize],
        }
    }

    /// Bytes on the heap.
    pub(super) fn bytes(&self) -> usize {
        let child = size_of::<Child<V>>();
        self.bricks.len() * (size_of::<Brick<V>>() + size_of::<[f32; 2]>())
            + self.lower.len() * 4096 * (child + 1)
            + self.upper.len() * 32768 * (child + 1)
    }
}

fn range<V: Voxel>(brick: &Brick<V>) -> [f32; 2] {
    brick.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], &v| {
        let [a, b] = v.range();
        [lo.min(a), hi.max(b)]
    })
}
