//! Values of as many bytes each, turned into bytes of a file and back in blocks, by all threads.

use std::io;
use std::ops::Range;

use rayon::prelude::*;

/// Values in a block: some megabytes, of which each thread has a part that takes longer than handing it out.
const BLOCK: usize = 1 << 17;

/// Writes bytes of a file, in order.
pub type Put<'a> = dyn FnMut(&[u8]) -> io::Result<()> + 'a;

/// Fills a slice with the next bytes of a file.
pub type Fill<'a> = dyn FnMut(&mut [u8]) -> io::Result<()> + 'a;

/// Writes `values` of `size` bytes each, which `write` sets.
///
/// # Errors
/// Those of `put`.
pub fn write_blocks<T: Sync>(
    values: &[T],
    size: usize,
    write: impl Fn(&T, &mut [u8]) + Sync,
    put: &mut Put<'_>,
) -> io::Result<()> {
    let mut bytes = vec![0; size * BLOCK.min(values.len())];
    for block in values.chunks(BLOCK) {
        let bytes = &mut bytes[..size * block.len()];
        let each = bytes.par_chunks_exact_mut(size).zip(block);
        each.for_each(|(bytes, value)| write(value, bytes));
        put(bytes)?;
    }
    Ok(())
}

/// Reads the bytes of `count` values of `size` bytes each, and gives `take` those of some of them after the others, with
/// their indices.
///
/// # Errors
/// Those of `fill`.
pub fn read_blocks(
    count: usize,
    size: usize,
    mut take: impl FnMut(Range<usize>, &[u8]),
    fill: &mut Fill<'_>,
) -> io::Result<()> {
    let mut bytes = vec![0; size * BLOCK.min(count)];
    for start in (0..count).step_by(BLOCK) {
        let block = start..count.min(start + BLOCK);
        let bytes = &mut bytes[..size * block.len()];
        fill(bytes)?;
        take(block, bytes);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More than one block, and the last one not full.
    #[test]
    fn values_come_back_in_order() {
        let values: Vec<u32> = (0..BLOCK as u32 + 7).collect();
        let mut file = Vec::new();
        let write = |value: &u32, bytes: &mut [u8]| bytes.copy_from_slice(&value.to_le_bytes());
        write_blocks(&values, 4, write, &mut |bytes| {
            file.extend_from_slice(bytes);
            Ok(())
        })
        .unwrap();
        assert_eq!(file.len(), 4 * values.len());
        let (mut rest, mut read) = (&file[..], Vec::new());
        let take = |block: Range<usize>, bytes: &[u8]| {
            assert_eq!((block.start, 4 * block.len()), (read.len(), bytes.len()));
            let value = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            read.extend(bytes.chunks_exact(4).map(value));
        };
        read_blocks(values.len(), 4, take, &mut |bytes| io::Read::read_exact(&mut rest, bytes))
            .unwrap();
        assert_eq!((read, rest.len()), (values, 0));
    }
}
