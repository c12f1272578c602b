//! Light on a lattice, found where it is first asked for.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use glam::IVec3;
use rayon::prelude::*;

use crate::math::{Rgb, Spectrum, Stage, Stream, WorldPoint};
use crate::transport::PathContext;

use super::sparse_cells::{BRICK, SparseCells, VOLUME, cell_index};

/// The lowest bits of a number, which tell the round of rays that it was found for.
const ROUND: u32 = 0x1f;

/// In place of a round: a cell that has not been asked for.
const UNKNOWN: u32 = ROUND;

/// Light at the centres of cubic cells: what a place costs is paid once in a round of rays, not for
/// each that comes by.
#[derive(Debug)]
pub struct LazyCells<S = Rgb> {
    cells: SparseCells,
    seed: u64,
    /// Its index, so that lattices of different media draw different numbers.
    medium: usize,
    /// Bits of one number a channel, cell by cell, with the round.
    values: Vec<AtomicU32>,
    channels: PhantomData<S>,
}

/// A cell whose light is to be found.
#[derive(Debug, Clone, Copy)]
pub(super) struct EmptyCell {
    /// Its place in cells.
    pub cell: IVec3,
    /// Its centre.
    pub center: WorldPoint,
}

impl<S: Spectrum> LazyCells<S> {
    /// A lattice of the medium of this index over `cells`, of which nothing is known.
    pub(super) fn new(cells: SparseCells, seed: u64, medium: usize) -> Self {
        let numbers = cells.bricks() * VOLUME * S::CHANNELS;
        let unknown = |_| AtomicU32::new(UNKNOWN);
        let values = (0..numbers).into_par_iter().map(unknown).collect();
        Self { cells, seed, medium, values, channels: PhantomData }
    }

    /// Edge of a cell, in metres.
    pub(super) const fn edge(&self) -> f64 {
        self.cells.edge
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        self.values.len() * size_of::<AtomicU32>() + self.cells.memory_bytes()
    }

    /// How many cells there are.
    pub const fn cells(&self) -> usize {
        self.values.len() / S::CHANNELS
    }

    fn channels_of(&self, cell: usize) -> &[AtomicU32] {
        &self.values[cell * S::CHANNELS..][..S::CHANNELS]
    }

    /// The bits of what is known of a cell, for storing; nothing where it has not been asked for.
    pub fn known(&self, cell: usize) -> Option<[u32; 3]> {
        let channels = self.channels_of(cell);
        let known = channels[0].load(Ordering::Acquire);
        let channel = |c: usize| channels.get(c).map_or(known, |v| v.load(Ordering::Relaxed));
        (known & ROUND != UNKNOWN).then(|| [known, channel(1), channel(2)])
    }

    /// Takes back what [`known`](Self::known) told of a cell of the same lattice; no work is counted
    /// for it again.
    pub fn restore(&self, cell: usize, value: [u32; 3]) {
        // The first channel last: it says that the others are there.
        for (channel, bits) in self.channels_of(cell).iter().zip(value).rev() {
            channel.store(bits, Ordering::Release);
        }
    }

    /// The light of one of the eight cells round `p`, drawn with the weight that it has in trilinear
    /// interpolation: that is what comes out on average, and of the cells that few rays ask for an
    /// eighth has to be found. 0 where there are none. In each `round` of rays `find` finds it anew;
    /// rounds follow one another. `ctx` counts the work, each cell's once.
    #[inline]
    pub(super) fn near(
        &self,
        p: WorldPoint,
        round: u32,
        ctx: &mut PathContext,
        find: impl FnOnce(&EmptyCell, &mut PathContext) -> S,
    ) -> S {
        let local = self.cells.local(p) - 0.5;
        let low = local.floor();
        let [x, y, z] = (local - low).to_array().map(|share| i32::from(ctx.rng.uniform() < share));
        let cell = low.as_ivec3() + IVec3::new(x, y, z);
        let Some(brick) = self.cells.brick_anywhere(cell >> BRICK) else { return S::ZERO };
        let index = brick * VOLUME + cell_index(cell & ((1 << BRICK) - 1));
        let channels = self.channels_of(index);
        if channels[0].load(Ordering::Acquire) & ROUND == round {
            let number = |c: usize| f32::from_bits(channels[c].load(Ordering::Relaxed) & !ROUND);
            return S::to_f64(S::from_channels(number));
        }
        S::to_f64(self.fill(cell, index, round, ctx, find))
    }

    /// Finds the light of a cell. Threads that do so at once find the same.
    fn fill(
        &self,
        cell: IVec3,
        index: usize,
        round: u32,
        ctx: &mut PathContext,
        find: impl FnOnce(&EmptyCell, &mut PathContext) -> S,
    ) -> S::F32 {
        let start = Instant::now();
        let sample = u64::MAX - u64::from(round);
        let key = (self.medium as u64) << 32 | index as u64;
        let stream = Stream::new(self.seed, Stage::March, key, sample);
        let mut own = PathContext::new(stream, ctx.needs);
        let center = self.cells.world(cell.as_dvec3() + 0.5);
        let light = find(&EmptyCell { cell, center }, &mut own).to_f32();
        let finite = S::to_f64(light).is_finite();
        own.work.dropped_samples += u64::from(!finite);
        let light = if finite { light } else { S::F32::default() };
        let bits = |c: usize| S::channel_f32(light, c).to_bits() & !ROUND;
        let channels = self.channels_of(index);
        for (c, stored) in channels.iter().enumerate().skip(1) {
            stored.store(bits(c) | round, Ordering::Relaxed);
        }
        if channels[0].swap(bits(0) | round, Ordering::AcqRel) & ROUND != round {
            ctx.work += own.work;
        }
        ctx.once += start.elapsed();
        S::from_channels(|c| f32::from_bits(bits(c)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Density;
    use crate::scene::plan::Needs;
    use crate::shape::{Cuboid, Region};
    use glam::{DAffine3, DVec3};

    fn filled<S: Spectrum>() -> LazyCells<S> {
        let region = Cuboid::new(DVec3::ZERO, DVec3::ONE, &DAffine3::IDENTITY).unwrap();
        let density = Density::Homogeneous(Region::Box(region));
        LazyCells::new(SparseCells::around(&density, 0.2, 1).unwrap(), 1, 0)
    }

    fn ctx() -> PathContext {
        PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING)
    }

    #[test]
    fn a_cell_is_found_once_a_round() {
        let (filled, mut ctx) = (filled::<Rgb>(), ctx());
        let p = filled.cells.world(DVec3::splat(3.5));
        for round in 0..ROUND {
            let light = Rgb::new(f64::from(round), 0.1, -1e30);
            for find in [true, false] {
                let found = filled.near(p, round, &mut ctx, |cell, own| {
                    assert!(find && cell.cell == IVec3::splat(3));
                    own.work.collisions += 1;
                    light
                });
                let off = (found - light).abs() / light.abs().max(Rgb::splat(1e-9));
                assert!(off.max_element() < 5e-6, "{found} for {light}");
            }
        }
        assert_eq!(ctx.work.collisions, u64::from(ROUND));
    }

    #[test]
    fn what_is_not_finite_is_dropped_and_counted() {
        let (filled, mut ctx) = (filled::<Rgb>(), ctx());
        let p = filled.cells.world(DVec3::splat(3.5));
        for (round, wrong) in [f64::NAN, f64::INFINITY, 1e300].into_iter().enumerate() {
            let found = filled.near(p, round as u32, &mut ctx, |_, _| Rgb::new(1.0, wrong, 1.0));
            assert_eq!((found, ctx.work.dropped_samples), (Rgb::ZERO, round as u64 + 1));
        }
    }

    #[test]
    fn what_is_known_is_recalled() {
        fn check<S: Spectrum>() {
            let ([from, to], mut ctx) = ([filled::<S>(), filled::<S>()], ctx());
            let center = |x: i32| from.cells.world(DVec3::new(f64::from(x) + 0.5, 2.5, 1.5));
            let of = |x: i32| S::from_rgb(Rgb::new(0.3, 0.2, 0.7) * f64::from(x));
            let mut ask = |lattice: &LazyCells<S>, x: i32, known: bool| {
                lattice.near(center(x), 2, &mut ctx, |_, _| {
                    assert!(!known);
                    of(x)
                })
            };
            let told: Vec<S> = (0..5).map(|x| ask(&from, x, false)).collect();
            let known = (0..from.cells()).filter_map(|cell| Some((cell, from.known(cell)?)));
            assert_eq!(known.clone().count(), 5);
            known.for_each(|(cell, value)| to.restore(cell, value));
            for (x, told) in (0..).zip(told) {
                assert_eq!(ask(&to, x, true), told);
            }
        }
        check::<Rgb>();
        check::<f64>();
    }
}
