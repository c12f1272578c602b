//! World space and index space as different types.
//!
//! A point of one space cannot be handed to a function that wants the other; directions are plain
//! [`DVec3`] and belong to the ray or point beside them.

use std::marker::PhantomData;
use std::ops::{Add, Sub};

use glam::DVec3;

/// World space: metres, y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum World {}

/// Index space of one grid: voxel (i, j, k) has its sample at (i, j, k).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Index {}

/// A place in the space `S`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<S> {
    /// Coordinates.
    pub xyz: DVec3,
    space: PhantomData<S>,
}

/// A place in the world, in metres.
pub type WorldPoint = Point<World>;

/// A place in a grid's index space, in voxels.
pub type IndexPoint = Point<Index>;

impl<S> Point<S> {
    /// The point at these coordinates.
    pub const fn from_xyz(xyz: DVec3) -> Self {
        Self { xyz, space: PhantomData }
    }

    /// The point at these coordinates.
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self::from_xyz(DVec3::new(x, y, z))
    }
}

impl<S> Add<DVec3> for Point<S> {
    type Output = Self;
    fn add(self, offset: DVec3) -> Self {
        Self::from_xyz(self.xyz + offset)
    }
}

impl<S> Sub<DVec3> for Point<S> {
    type Output = Self;
    fn sub(self, offset: DVec3) -> Self {
        Self::from_xyz(self.xyz - offset)
    }
}

impl<S> Sub for Point<S> {
    type Output = DVec3;
    fn sub(self, other: Self) -> DVec3 {
        self.xyz - other.xyz
    }
}

/// A ray; `t` counts multiples of `direction`, which need not have unit length. Because it does
/// not, `t` means the same before and after an affine transform.
#[derive(Debug, Clone, Copy)]
pub struct Ray<S> {
    /// Where t = 0.
    pub origin: Point<S>,
    /// Change of place per unit of t.
    pub direction: DVec3,
}

impl<S: Copy> Ray<S> {
    /// The ray from `origin` along `direction`.
    pub const fn new(origin: Point<S>, direction: DVec3) -> Self {
        Self { origin, direction }
    }

    /// The point at `t`.
    pub fn at(&self, t: f64) -> Point<S> {
        self.origin + self.direction * t
    }
}

/// An interval of ray parameters; empty where `start >= end`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Where it begins.
    pub start: f64,
    /// Where it ends; may be infinite.
    pub end: f64,
}

impl Span {
    /// Everything in front of a ray's origin.
    pub const AHEAD: Self = Self { start: 0.0, end: f64::INFINITY };

    /// The interval from `start` to `end`.
    pub const fn new(start: f64, end: f64) -> Self {
        Self { start, end }
    }

    /// What both share.
    pub const fn intersect(self, other: Self) -> Self {
        Self { start: self.start.max(other.start), end: self.end.min(other.end) }
    }

    /// Whether nothing is in it.
    pub fn is_empty(self) -> bool {
        self.start >= self.end || self.start.is_nan() || self.end.is_nan()
    }

    /// Its length, 0 where it is empty.
    pub const fn length(self) -> f64 {
        (self.end - self.start).max(0.0)
    }
}

/// A box with sides along the axes of the space `S`; empty where a `min` exceeds its `max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb<S> {
    /// Smallest coordinates.
    pub min: Point<S>,
    /// Largest coordinates.
    pub max: Point<S>,
}

impl<S: Copy> Aabb<S> {
    /// The box that holds nothing.
    pub const EMPTY: Self =
        Self { min: Point::from_xyz(DVec3::INFINITY), max: Point::from_xyz(DVec3::NEG_INFINITY) };

    /// The box between two corners.
    pub const fn new(min: Point<S>, max: Point<S>) -> Self {
        Self { min, max }
    }

    /// The smallest box round the points.
    pub fn around(points: impl IntoIterator<Item = Point<S>>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::including)
    }

    /// The box grown to hold `p`.
    pub fn including(self, p: Point<S>) -> Self {
        Self {
            min: Point::from_xyz(self.min.xyz.min(p.xyz)),
            max: Point::from_xyz(self.max.xyz.max(p.xyz)),
        }
    }

    /// The smallest box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: Point::from_xyz(self.min.xyz.min(other.min.xyz)),
            max: Point::from_xyz(self.max.xyz.max(other.max.xyz)),
        }
    }

    /// The box with every face moved outward by `by`.
    pub fn grown(self, by: f64) -> Self {
        Self { min: self.min - DVec3::splat(by), max: self.max + DVec3::splat(by) }
    }

    /// Whether nothing is in it.
    pub fn is_empty(&self) -> bool {
        self.min.xyz.cmpgt(self.max.xyz).any()
    }

    /// Whether it shares a point with `other`, be it of a face.
    pub fn overlaps(&self, other: &Self) -> bool {
        let (low, high) = (self.min.xyz.max(other.min.xyz), self.max.xyz.min(other.max.xyz));
        low.cmple(high).all()
    }

    /// Whether `p` lies in it or on its face.
    pub fn contains(&self, p: Point<S>) -> bool {
        p.xyz.cmpge(self.min.xyz).all() && p.xyz.cmple(self.max.xyz).all()
    }

    /// Centre; meaningless where it is empty.
    pub fn center(&self) -> Point<S> {
        Point::from_xyz((self.min.xyz + self.max.xyz) * 0.5)
    }

    /// Edge lengths, 0 where it is empty.
    pub fn size(&self) -> DVec3 {
        (self.max.xyz - self.min.xyz).max(DVec3::ZERO)
    }

    /// The eight corners.
    pub fn corners(&self) -> [Point<S>; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo, hi| if i & bit == 0 { lo } else { hi };
            Point::new(
                pick(1, self.min.xyz.x, self.max.xyz.x),
                pick(2, self.min.xyz.y, self.max.xyz.y),
                pick(4, self.min.xyz.z, self.max.xyz.z),
            )
        })
    }

    /// The part of `ray` inside the box, by slabs; empty where the ray misses. A ray that runs
    /// along a face counts as inside.
    pub fn clip(&self, ray: &Ray<S>) -> Span {
        let mut span = Span::new(f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (ray.origin.xyz[axis], ray.direction[axis]);
            let (lo, hi) = (self.min.xyz[axis], self.max.xyz[axis]);
            if d == 0.0 {
                if o < lo || o > hi {
                    return Span::new(0.0, 0.0);
                }
            } else {
                let (a, b) = ((lo - o) / d, (hi - o) / d);
                span = span.intersect(Span::new(a.min(b), a.max(b)));
            }
        }
        span
    }
}
