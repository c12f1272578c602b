//! The sums of an unfinished fluence grid, as bytes of a file.

use std::io;
use std::ops::Range;

use rayon::prelude::*;

use crate::file::{self, Fill, Put};
use crate::math::{Rgb, Spectrum};

use super::fluence_builder::FluenceBuilder;

impl<S: Spectrum> FluenceBuilder<'_, S> {
    /// Bytes of its sums in a file.
    pub fn state_bytes(&self) -> u64 {
        let wide = if self.totals.is_empty() { 4 } else { 8 };
        let own = self.sums.len() as u64 * S::CHANNELS as u64 * wide;
        own + self.second.as_ref().map_or(0, |second| second.state_bytes())
    }

    /// Writes its sums with `put`, those of second moments last.
    ///
    /// # Errors
    /// Where writing fails.
    pub fn write_state(&self, put: &mut Put<'_>) -> io::Result<()> {
        if self.totals.is_empty() {
            let channel = |sum: &S::F32, c: usize| S::channel_f32(*sum, c).to_le_bytes();
            write::<S, S::F32, 4>(&self.sums, channel, put)?;
        } else {
            let channel = |total: &S, c: usize| total.channel(c).to_le_bytes();
            write::<S, S, 8>(&self.totals, channel, put)?;
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
            let value =
                |channels: [[u8; 4]; 3]| S::from_channels(|c| f32::from_le_bytes(channels[c]));
            read::<S, S::F32, 4>(&mut self.sums, value, fill)?;
        } else {
            let value =
                |channels: [[u8; 8]; 3]| S::from_rgb(Rgb::from(channels.map(f64::from_le_bytes)));
            read::<S, S, 8>(&mut self.totals, value, fill)?;
        }
        self.second.as_mut().map_or(Ok(()), |second| second.read_state(fill))
    }
}

/// Writes `values` of `WIDE` bytes a `channel`.
fn write<S: Spectrum, T: Sync, const WIDE: usize>(
    values: &[T],
    channel: impl Fn(&T, usize) -> [u8; WIDE] + Sync,
    put: &mut Put<'_>,
) -> io::Result<()> {
    let write = |value: &T, bytes: &mut [u8]| {
        for (index, bytes) in bytes.chunks_exact_mut(WIDE).enumerate() {
            bytes.copy_from_slice(&channel(value, index));
        }
    };
    file::write_blocks(values, WIDE * S::CHANNELS, write, put)
}

/// Reads what [`write()`] wrote; `value` makes one of the bytes of its channels, of which a single one stands for three.
fn read<S: Spectrum, T: Send, const WIDE: usize>(
    values: &mut [T],
    value: impl Fn([[u8; WIDE]; 3]) -> T + Sync,
    fill: &mut Fill<'_>,
) -> io::Result<()> {
    let size = WIDE * S::CHANNELS;
    let value = |bytes: &[u8]| {
        let mut channels = [[0; WIDE]; 3];
        for (index, channel) in channels.iter_mut().enumerate() {
            let at = WIDE * index.min(S::CHANNELS - 1);
            channel.copy_from_slice(&bytes[at..at + WIDE]);
        }
        value(channels)
    };
    let count = values.len();
    let take = |block: Range<usize>, bytes: &[u8]| {
        let stored = values[block].par_iter_mut().zip(bytes.par_chunks_exact(size));
        stored.for_each(|(stored, bytes)| *stored = value(bytes));
    };
    file::read_blocks(count, size, take, fill)
}
