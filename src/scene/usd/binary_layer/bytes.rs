//! Numbers and compressed blocks in the bytes of a layer.

/// Bytes of a layer from a position on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// Those of `all` from `position`.
    ///
    /// # Errors
    /// Where it lies behind the end.
    pub(super) fn from(all: &'a [u8], position: u64) -> Result<Self, String> {
        let at = usize::try_from(position).ok().filter(|at| *at <= all.len());
        let at =
            at.ok_or_else(|| format!("it points to byte {position}, and has {} bytes", all.len()))?;
        Ok(Self { all, at })
    }

    /// Where the next byte stands.
    pub(super) const fn position(&self) -> u64 {
        self.at as u64
    }

    /// The next `count` elements of `size` bytes each.
    ///
    /// # Errors
    /// Where there are fewer.
    pub(super) fn take(&mut self, count: u64, size: u64) -> Result<&'a [u8], String> {
        let left = &self.all[self.at..];
        let wanted = count.checked_mul(size).and_then(|wanted| usize::try_from(wanted).ok());
        let taken = wanted.and_then(|wanted| left.get(..wanted)).ok_or_else(|| {
            format!(
                "at byte {} it says to have {count} elements of {size} bytes, and {} bytes follow",
                self.at,
                left.len()
            )
        })?;
        self.at += taken.len();
        Ok(taken)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut number = [0; N];
        number.copy_from_slice(self.take(1, N as u64)?);
        Ok(number)
    }

    pub(super) fn u8(&mut self) -> Result<u8, String> {
        self.number().map(u8::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.number().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, String> {
        self.number().map(u64::from_le_bytes)
    }

    /// Moves by the offset that stands here, relative to its own position.
    ///
    /// # Errors
    /// Where it leads out of the bytes.
    pub(super) fn follow_offset(&mut self) -> Result<(), String> {
        let from = self.position();
        let offset = self.u64()?.cast_signed();
        let target = from.checked_add_signed(offset);
        let target = target.ok_or_else(|| format!("at byte {from} it points before its start"))?;
        *self = Self::from(self.all, target)?;
        Ok(())
    }

    /// The block of LZ4 that stands here behind its size.
    ///
    /// # Errors
    /// Where it is not whole.
    pub(super) fn block(&mut self) -> Result<Block<'a>, String> {
        let start = self.at;
        let size = self.u64()?;
        let (chunks, block) = match self.take(size, 1)? {
            [chunks, block @ ..] => (*chunks, block),
            [] => (0, &[][..]),
        };
        if chunks != 0 {
            return Err("it has compressed blocks of more than 2 GB, which are not read".into());
        }
        let size = decompressed_size(block);
        let size =
            size.ok_or_else(|| format!("its compressed block at byte {start} is damaged"))?;
        Ok(Block { block, size, start })
    }
}

/// A block of LZ4.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    block: &'a [u8],
    /// Bytes of what is compressed.
    pub(super) size: usize,
    start: usize,
}

impl Block<'_> {
    /// What is compressed.
    ///
    /// # Errors
    /// Where it refers to bytes before its beginning.
    pub(super) fn decompressed(&self) -> Result<Vec<u8>, String> {
        lz4_flex::block::decompress(self.block, self.size)
            .map_err(|e| format!("its compressed block at byte {} is damaged: {e}", self.start))
    }

    /// Whether it can hold `count` numbers in the format's code for integers: four have two bits each in a
    /// byte, behind the most frequent difference of two neighbours.
    ///
    /// # Errors
    /// Where it cannot.
    pub(super) fn can_hold(&self, count: u64) -> Result<(), String> {
        if count == 0 || count.div_ceil(4) <= (self.size as u64).saturating_sub(4) {
            return Ok(());
        }
        let (start, size) = (self.start, self.size);
        Err(format!("its block at byte {start} has {size} bytes for {count} numbers"))
    }

    /// The `count` numbers of 32 bits in it.
    ///
    /// # Errors
    /// Where it does not hold them.
    pub(super) fn integers(&self, count: u64) -> Result<Vec<i32>, String> {
        self.can_hold(count)?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let raw = self.decompressed()?;
        let mut codes = Bytes { all: &raw, at: 0 };
        let common = codes.u32()?.cast_signed();
        let codes = codes.take(count.div_ceil(4), 1)?;
        let mut differences = Bytes { all: &raw, at: 4 + codes.len() };
        let mut last = 0_i32;
        let mut numbers = Vec::with_capacity(4 * codes.len());
        for code in codes.iter().flat_map(|byte| (0..4).map(move |i| byte >> (2 * i) & 3)) {
            let difference = match code {
                0 => common,
                1 => i32::from(differences.u8()?.cast_signed()),
                2 => i32::from(differences.number().map(i16::from_le_bytes)?),
                _ => differences.number().map(i32::from_le_bytes)?,
            };
            last = last.wrapping_add(difference);
            numbers.push(last);
        }
        numbers.truncate(usize::try_from(count).unwrap_or(usize::MAX));
        Ok(numbers)
    }
}

/// Bytes that a block of LZ4 decompresses to, by its tokens alone, so that nothing is reserved for a damaged one.
fn decompressed_size(mut block: &[u8]) -> Option<usize> {
    let mut size = 0_usize;
    while let Some((token, rest)) = block.split_first() {
        block = rest;
        let literals = length(token >> 4, &mut block)?;
        size = size.checked_add(literals)?;
        block = block.get(literals..)?;
        if block.is_empty() {
            return Some(size);
        }
        // The distance of a match, whose length is at least 4.
        block = block.get(2..)?;
        size = size.checked_add(length(token & 15, &mut block)? + 4)?;
    }
    (size == 0).then_some(0)
}

/// A length of LZ4: that of its token, and what follows on the largest one.
fn length(token: u8, block: &mut &[u8]) -> Option<usize> {
    let mut length = usize::from(token);
    let mut goes_on = token == 15;
    while goes_on {
        let (more, rest) = block.split_first()?;
        *block = rest;
        length = length.checked_add(usize::from(*more))?;
        goes_on = *more == u8::MAX;
    }
    Some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_blocks_are_those_of_the_compressor() {
        for size in [0, 1, 4, 15, 16, 255, 270, 271, 4096, 100_000] {
            let varied = (0..size).map(|i| (i * i / 7) as u8).collect();
            for raw in [vec![7; size], varied] {
                let packed = lz4_flex::block::compress(&raw);
                assert_eq!(decompressed_size(&packed), Some(size));
                let block = Block { block: &packed, size, start: 0 };
                assert_eq!(block.decompressed().unwrap(), raw);
            }
        }
    }

    #[test]
    fn integers_are_those_of_the_format() {
        // The example of its source: differences 123, 1, 1, 100000, 0, 1, 0.
        let mut raw = vec![1, 0, 0, 0, 0b11_00_00_01, 0b00_01_00_01];
        raw.push(123);
        raw.extend(100_000_i32.to_le_bytes());
        raw.extend([0, 0]);
        let packed = lz4_flex::block::compress(&raw);
        let block = Block { block: &packed, size: raw.len(), start: 0 };
        let right = [123, 124, 125, 100_125, 100_125, 100_126, 100_126];
        assert_eq!(block.integers(7).unwrap(), right);
        assert!(block.integers(37).is_err() && block.integers(u64::MAX).is_err());
    }
}
