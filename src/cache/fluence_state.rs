//! The sums of an unfinished fluence grid, as bytes of a file.

use std::io;
use std::ops::Range;

use rayon::prelude::*;

use crate::file::{self, Fill, Put};
use crate::math::{MOST_NUMBERS, Spectrum};

use super::fluence_builder::FluenceBuilder;

impl<S: Spectrum> FluenceBuilder<'_, S> {
    /// Bytes of its sums in a file.
    pub fn state_bytes(&self) -> u64 {
        let wide = if self.totals.is_empty() { 4 } else { 8 };
        let own = self.sums.len() as u64 * S::NUMBERS as u64 * wide;
        own + self.second.as_ref().map_or(0, |second| second.state_bytes())
    }

    /// Writes its sums with `put`, those of second moments last.
    ///
    /// # Errors
    /// Where writing fails.
    pub fn write_state(&self, put: &mut Put<'_>) -> io::Result<()> {
        if self.totals.is_empty() {
            let number = |sum: &S::F32, n: usize| S::number_f32(*sum, n).to_le_bytes();
            write::<S, S::F32, 4>(&self.sums, number, put)?;
        } else {
            let number = |total: &S, n: usize| total.number(n).to_le_bytes();
            write::<S, S, 8>(&self.totals, number, put)?;
        }
        self.second.as_ref().map_or(Ok(()), |second| second.write_state(put))
    }

    /// Sets its sums to those that [`write_state`](Self::write_state) wrote of a grid of the same cells and contents;
    /// `fill` reads the next bytes.
    ///
    /// # Errors
    /// Where reading fails.
    pub fn read_state(&mut self, fill: &mut Fill<'_>) -> io::Result<()> {
        if self.totals.is_empty() {
            let value = |numbers: [[u8; 4]; MOST_NUMBERS]| {
                S::from_numbers_f32(|n| f32::from_le_bytes(numbers[n]))
            };
            read::<S, S::F32, 4>(&mut self.sums, value, fill)?;
        } else {
            let value = |numbers: [[u8; 8]; MOST_NUMBERS]| {
                S::from_numbers(|n| f64::from_le_bytes(numbers[n]))
            };
            read::<S, S, 8>(&mut self.totals, value, fill)?;
        }
        self.second.as_mut().map_or(Ok(()), |second| second.read_state(fill))
    }
}

/// Writes `values` of `WIDE` bytes a `number`.
fn write<S: Spectrum, T: Sync, const WIDE: usize>(
    values: &[T],
    number: impl Fn(&T, usize) -> [u8; WIDE] + Sync,
    put: &mut Put<'_>,
) -> io::Result<()> {
    let write = |value: &T, bytes: &mut [u8]| {
        for (index, bytes) in bytes.chunks_exact_mut(WIDE).enumerate() {
            bytes.copy_from_slice(&number(value, index));
        }
    };
    file::write_blocks(values, WIDE * S::NUMBERS, write, put)
}

/// Reads what [`write()`] wrote; `value` makes one of the bytes of its numbers.
fn read<S: Spectrum, T: Send, const WIDE: usize>(
    values: &mut [T],
    value: impl Fn([[u8; WIDE]; MOST_NUMBERS]) -> T + Sync,
    fill: &mut Fill<'_>,
) -> io::Result<()> {
    let size = WIDE * S::NUMBERS;
    let value = |bytes: &[u8]| {
        let mut numbers = [[0; WIDE]; MOST_NUMBERS];
        for (number, bytes) in numbers.iter_mut().zip(bytes.chunks_exact(WIDE)) {
            number.copy_from_slice(bytes);
        }
        value(numbers)
    };
    let count = values.len();
    let take = |block: Range<usize>, bytes: &[u8]| {
        let stored = values[block].par_iter_mut().zip(bytes.par_chunks_exact(size));
        stored.for_each(|(stored, bytes)| *stored = value(bytes));
    };
    file::read_blocks(count, size, take, fill)
}
