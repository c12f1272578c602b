//! Sparse cells that are filled where they are first sampled.

use std::iter;
use std::marker::PhantomData;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::math::{MOST_NUMBERS, Rgb, Spectrum, Stage, Stream, WorldPoint};
use crate::medium::{BRICK, SparseCells, VOLUME, cell_at, cell_index};
use crate::transport::PathContext;

/// The lowest bits of a stored value, which hold the pass that it was found in. They cost the value a
/// relative error of at most 4e-6.
///
/// Unit: none. Definition: five bits of a format.
const PASS_MASK: u32 = 0x1f;

/// In place of a pass: the cell is empty.
///
/// Unit: none. Definition: the largest value of those bits, which no pass has.
const EMPTY: u32 = PASS_MASK;

/// Light at the centres of cubic cells, found by the first ray of a pass that samples a cell and read by
/// all later ones. Threads may fill cells at once: the value depends on the cell and the pass alone.
#[derive(Debug)]
pub struct LazyCells<S = Rgb> {
    cells: SparseCells,
    seed: u64,
    /// Index of the medium, so that caches of different media draw different random numbers.
    medium: usize,
    /// Bits of one f32 a number of the spectrum with the pass in its lowest bits, cell by cell.
    values: Vec<AtomicU32>,
    channels: PhantomData<S>,
}

/// A cell to be filled, or that was.
#[derive(Debug, Clone, Copy)]
pub(super) struct EmptyCell {
    /// Index of its random streams: no other cell of any medium has it.
    pub key: u64,
    /// Its index among all cells.
    pub index: usize,
    /// Its cell coordinates.
    pub cell: IVec3,
    /// Its centre, in world space.
    pub center: WorldPoint,
}

impl<S: Spectrum> LazyCells<S> {
    /// Empty cells for the medium of this index.
    pub(super) fn new(cells: SparseCells, seed: u64, medium: usize) -> Self {
        let numbers = cells.bricks() * VOLUME * S::NUMBERS;
        let empty = |_| AtomicU32::new(EMPTY);
        let values = (0..numbers).into_par_iter().map(empty).collect();
        Self { cells, seed, medium, values, channels: PhantomData }
    }

    /// Width of a cell, in metres.
    pub const fn width(&self) -> f64 {
        self.cells.edge
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        self.values.len() * size_of::<AtomicU32>() + self.cells.memory_bytes()
    }

    /// Number of cells.
    pub const fn count(&self) -> usize {
        self.values.len() / S::NUMBERS
    }

    /// A place in cells: those have their centres at half numbers.
    pub(super) fn to_cells(&self, p: WorldPoint) -> DVec3 {
        self.cells.to_cells(p)
    }

    fn numbers_of(&self, cell: usize) -> &[AtomicU32] {
        &self.values[cell * S::NUMBERS..][..S::NUMBERS]
    }

    /// The stored bits of a cell, for a checkpoint; `None` where it is empty.
    pub fn stored(&self, cell: usize) -> Option<impl Iterator<Item = u32>> {
        let (first, others) = self.numbers_of(cell).split_first()?;
        let first = first.load(Ordering::Acquire);
        let others = others.iter().map(|number| number.load(Ordering::Relaxed));
        (first & PASS_MASK != EMPTY).then(|| iter::once(first).chain(others))
    }

    /// Sets a cell to what [`stored`](Self::stored) gave for the same cells; no work is counted for it
    /// again.
    pub fn restore(&self, cell: usize, bits: &[u32]) {
        // The first number last: its pass says that the others are there.
        for (number, bits) in self.numbers_of(cell).iter().zip(bits).rev() {
            number.store(*bits, Ordering::Release);
        }
    }

    /// The light of a cell, if there is one, which is filled if it is empty.
    #[inline]
    pub(super) fn light(
        &self,
        cell: IVec3,
        pass: u32,
        ctx: &mut PathContext,
        fill: impl FnOnce(&EmptyCell, &mut PathContext) -> S,
    ) -> Option<S> {
        let brick = self.cells.find_brick(cell >> BRICK)?;
        let index = brick * VOLUME + cell_index(cell & ((1 << BRICK) - 1));
        let numbers = self.numbers_of(index);
        if numbers[0].load(Ordering::Acquire) & PASS_MASK == pass {
            let value = |n: usize| f32::from_bits(numbers[n].load(Ordering::Relaxed) & !PASS_MASK);
            return Some(S::to_f64(S::from_numbers_f32(value)));
        }
        Some(S::to_f64(self.fill(cell, index, pass, ctx, fill)))
    }

    /// The cell of these coordinates and this index.
    fn cell(&self, cell: IVec3, index: usize) -> EmptyCell {
        let key = (self.medium as u64) << 32 | index as u64;
        let center = self.cells.to_world(cell.as_dvec3() + 0.5);
        EmptyCell { key, index, cell, center }
    }

    /// The cells that are filled, by index in ascending order.
    pub(super) fn known(&self) -> impl Iterator<Item = EmptyCell> {
        let bricks = self.cells.brick_positions().into_iter().enumerate();
        bricks.flat_map(move |(brick, at)| {
            (0..VOLUME).filter_map(move |within| {
                let index = brick * VOLUME + within;
                let cell = (at << BRICK) + cell_at(within);
                self.stored(index).is_some().then(|| self.cell(cell, index))
            })
        })
    }

    /// Finds and stores the light of a cell. Threads that do so at once find the same.
    fn fill(
        &self,
        cell: IVec3,
        index: usize,
        pass: u32,
        ctx: &mut PathContext,
        fill: impl FnOnce(&EmptyCell, &mut PathContext) -> S,
    ) -> S::F32 {
        let start = Instant::now();
        let empty = self.cell(cell, index);
        let (light, own) = self.found(&empty, pass, ctx, fill);
        let bits = |n: usize| S::number_f32(light, n).to_bits();
        let numbers = self.numbers_of(index);
        for (n, stored) in numbers.iter().enumerate().skip(1) {
            stored.store(bits(n) | pass, Ordering::Relaxed);
        }
        if numbers[0].swap(bits(0) | pass, Ordering::AcqRel) & PASS_MASK != pass {
            ctx.amortized.work += own.work;
        }
        // Cells of other caches that were filled on the way stay so, whoever fills this one.
        ctx.amortized.work += own.amortized.work;
        ctx.amortized.cells += start.elapsed();
        light
    }

    /// The light that `fill` finds for a cell in `pass`, as it is stored, and its context: that of the cell and the pass alone.
    fn found(
        &self,
        cell: &EmptyCell,
        pass: u32,
        ctx: &PathContext,
        fill: impl FnOnce(&EmptyCell, &mut PathContext) -> S,
    ) -> (S::F32, PathContext) {
        let sample = u64::MAX - u64::from(pass);
        let stream = Stream::new(self.seed, Stage::March, cell.key, sample);
        let mut own = PathContext::new(stream, ctx.needs);
        let light = fill(cell, &mut own).to_f32();
        let finite = S::to_f64(light).is_finite();
        own.work.dropped_samples += u64::from(!finite);
        let light = if finite { light } else { S::F32::default() };
        let stored = |n: usize| f32::from_bits(S::number_f32(light, n).to_bits() & !PASS_MASK);
        (S::from_numbers_f32(stored), own)
    }

    /// The light that a cell had, or would have had, in `pass`, while a later one fills it: what is stored, or else what `fill`
    /// finds.
    pub(super) fn in_earlier_pass(
        &self,
        cell: &EmptyCell,
        pass: u32,
        ctx: &mut PathContext,
        fill: impl FnOnce(&EmptyCell, &mut PathContext) -> S,
    ) -> S {
        let numbers = self.numbers_of(cell.index);
        let mut bits = [0; MOST_NUMBERS];
        for (bits, number) in bits.iter_mut().zip(numbers) {
            *bits = number.load(Ordering::Acquire);
        }
        if bits[..S::NUMBERS].iter().all(|bits| bits & PASS_MASK == pass) {
            let stored = |n: usize| f32::from_bits(bits[n] & !PASS_MASK);
            return S::to_f64(S::from_numbers_f32(stored));
        }
        let (light, own) = self.found(cell, pass, ctx, fill);
        // Where another thread is overwriting it, the cell had it, and its work was counted.
        let had = bits[0] & PASS_MASK;
        if had == EMPTY || had < pass {
            ctx.work += own.work;
        }
        ctx.amortized.work += own.amortized.work;
        S::to_f64(light)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Group, GroupedRgb};
    use crate::medium::Density;
    use crate::scene::plan::Needs;
    use crate::shape::{Cuboid, Region};
    use glam::DAffine3;

    fn empty<S: Spectrum>() -> LazyCells<S> {
        let region = Cuboid::new(DVec3::ZERO, DVec3::ONE, &DAffine3::IDENTITY).unwrap();
        let density = Density::Homogeneous(Region::Box(region));
        LazyCells::new(SparseCells::covering(&density, 0.2, 1).unwrap(), 1, 0)
    }

    fn ctx() -> PathContext {
        PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING)
    }

    #[test]
    fn a_cell_is_filled_once_a_pass() {
        let (cells, mut ctx) = (empty::<Rgb>(), ctx());
        let p = cells.cells.to_world(DVec3::splat(3.5));
        for pass in 0..PASS_MASK {
            let light = Rgb::new(f64::from(pass), 0.1, -1e30);
            for fills in [true, false] {
                let found = cells.at(p, Some(0.3), pass, &mut ctx, |cell, own| {
                    assert!(fills && cell.cell == IVec3::splat(3));
                    own.work.collisions += 1;
                    light
                });
                let off = (found - light).abs() / light.abs().max(Rgb::splat(1e-9));
                assert!(off.max_element() < 5e-6, "{found} for {light}");
            }
        }
        assert_eq!(ctx.amortized.work.collisions, u64::from(PASS_MASK));
    }

    /// A later pass gets the light of an earlier one to the bit, stored or found anew, and work is counted once.
    #[test]
    fn an_earlier_pass_is_stored_or_found_anew() {
        fn check<S: Spectrum>() {
            let light = |own: &mut PathContext| {
                own.work.collisions += 1;
                S::of_group(Rgb::splat(0.1 + own.rng.uniform()), Group(1))
            };
            let later = |fill_first: bool| {
                let (cells, mut ctx) = (empty::<S>(), ctx());
                let p = cells.cells.to_world(DVec3::splat(3.5));
                if fill_first {
                    cells.at(p, Some(0.3), 1, &mut ctx, |_, own| light(own));
                }
                let found = cells.at(p, Some(0.3), 2, &mut ctx, |cell, own| {
                    cells.in_earlier_pass(cell, 1, own, |_, own| light(own)) + light(own)
                });
                let bits: Vec<u64> = (0..S::NUMBERS).map(|n| found.number(n).to_bits()).collect();
                (bits, ctx.amortized.work.collisions)
            };
            let stored = later(true);
            assert_eq!((&stored, stored.1), (&later(false), 2), "work of each pass once");
        }
        check::<Rgb>();
        check::<f64>();
        check::<GroupedRgb>();
    }

    #[test]
    fn values_that_are_not_finite_are_dropped_and_counted() {
        let (cells, mut ctx) = (empty::<Rgb>(), ctx());
        let p = cells.cells.to_world(DVec3::splat(3.5));
        for (pass, wrong) in [f64::NAN, f64::INFINITY, 1e300].into_iter().enumerate() {
            let found =
                cells.at(p, Some(0.3), pass as u32, &mut ctx, |_, _| Rgb::new(1.0, wrong, 1.0));
            assert_eq!((found, ctx.amortized.work.dropped_samples), (Rgb::ZERO, pass as u64 + 1));
        }
    }

    #[test]
    fn stored_values_are_restored() {
        fn check<S: Spectrum>() {
            let ([from, to], mut ctx) = ([empty::<S>(), empty::<S>()], ctx());
            let center = |x: i32| from.cells.to_world(DVec3::new(f64::from(x) + 0.5, 2.5, 1.5));
            let of = |x: i32| S::of_group(Rgb::new(0.3, 0.2, 0.7) * f64::from(x), Group(x as u8));
            let mut sample = |cells: &LazyCells<S>, x: i32, known: bool| {
                cells.at(center(x), Some(0.7), 2, &mut ctx, |_, _| {
                    assert!(!known);
                    of(x)
                })
            };
            let values: Vec<S> = (0..5).map(|x| sample(&from, x, false)).collect();
            let stored = |cell: usize| Some((cell, from.stored(cell)?.collect::<Vec<_>>()));
            let known: Vec<_> = (0..from.count()).filter_map(stored).collect();
            assert_eq!(known.len(), 5);
            known.iter().for_each(|(cell, bits)| to.restore(*cell, bits));
            for (x, value) in (0..).zip(values) {
                let found = sample(&to, x, true);
                let numbers = |light: S| (0..S::NUMBERS).map(move |n| light.number(n));
                assert!(numbers(found).eq(numbers(value)));
            }
        }
        check::<Rgb>();
        check::<f64>();
        check::<GroupedRgb>();
    }
}
