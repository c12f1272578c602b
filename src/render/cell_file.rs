//! Cells that rays fill, or in which gathers start, in the body of a [state file](super::state_file): a bit a cell, set
//! where it is filled, in words of 64; then the bits of the filled cells' channels.

use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use crate::cache::{CellOrigins, KeptOrigins, LazyCells, OriginWeights};
use crate::math::{MOST_NUMBERS, Spectrum};

use super::state_file::Hashing;

/// Cells for which memory is reserved before they are read, at most: a damaged file may tell any number.
const MAX_RESERVED: u64 = 1 << 20;

/// Words of the weights of a cell's origins.
const ORIGIN_WORDS: u64 = 3;

/// What the head of a file tells of the cells of one cache.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct CellsHead {
    /// Cells, filled or not.
    pub cells: u64,
    /// Those that are filled.
    pub known: u64,
    /// Numbers of a cell.
    pub channels: u64,
    /// Their width, in metres.
    pub width: f64,
}

impl CellsHead {
    /// That of `cache`.
    pub fn new<S: Spectrum>(cache: &LazyCells<S>) -> Self {
        let known = (0..cache.count()).filter(|&cell| cache.stored(cell).is_some());
        Self {
            cells: cache.count() as u64,
            known: known.count() as u64,
            channels: S::NUMBERS as u64,
            width: cache.width(),
        }
    }

    /// Whether the cells are those of `cache`.
    pub fn fits<S: Spectrum>(&self, cache: &LazyCells<S>) -> bool {
        let Self { cells, channels, width, .. } = *self;
        (cells, channels, width) == (cache.count() as u64, S::NUMBERS as u64, cache.width())
    }

    /// That of the `origins` of gathers that are kept.
    pub fn of_origins<S: Spectrum>(origins: &CellOrigins<S>) -> Self {
        let cells = origins.thickness().cells();
        let known = origins.kept().map_or(0, KeptOrigins::count) as u64;
        let (width, channels) = (cells.width(), ORIGIN_WORDS);
        Self { cells: cells.count() as u64, known, channels, width }
    }

    /// Bytes in the body; `None` where the number overflows.
    pub fn bytes(&self) -> Option<u64> {
        let bits = self.cells.div_ceil(64).checked_mul(8)?;
        bits.checked_add(self.known.checked_mul(self.channels.checked_mul(4)?)?)
    }

    /// Reads the cells, and calls `fill` with number and bits of each that is filled, as
    /// [`LazyCells::restore`] takes them.
    ///
    /// # Errors
    /// Where the input ends, or its bits and the number of filled cells disagree.
    pub fn read<R: Read>(
        &self,
        input: &mut Hashing<R>,
        mut fill: impl FnMut(usize, &[u32]),
    ) -> io::Result<()> {
        let wrong = || io::Error::new(io::ErrorKind::InvalidData, "other cells");
        let mut filled = Vec::with_capacity(self.known.min(MAX_RESERVED) as usize);
        for first in (0..self.cells).step_by(64) {
            let bits = u64::from_le_bytes(input.take()?);
            let set = (0..64).filter(|bit| bits >> bit & 1 == 1);
            filled.extend(set.map(|bit| first + bit));
        }
        let channels =
            usize::try_from(self.channels).ok().filter(|n| [1, 3, MOST_NUMBERS].contains(n));
        let channels = channels.ok_or_else(wrong)?;
        if filled.len() as u64 != self.known
            || filled.last().is_some_and(|cell| *cell >= self.cells)
        {
            return Err(wrong());
        }
        for cell in filled {
            let mut value = [[0; 4]; MOST_NUMBERS];
            input.fill(value[..channels].as_flattened_mut())?;
            fill(cell as usize, &value.map(u32::from_le_bytes)[..channels]);
        }
        Ok(())
    }
}

/// Writes the cells of `cache`.
///
/// # Errors
/// Where that fails.
pub(super) fn write<S: Spectrum, W: Write>(
    out: &mut Hashing<W>,
    cache: &LazyCells<S>,
) -> io::Result<()> {
    write_cells(out, cache.count(), |cell| cache.stored(cell))
}

/// Writes the `origins` of gathers that are kept.
///
/// # Errors
/// Where that fails.
pub(super) fn write_origins<S: Spectrum, W: Write>(
    out: &mut Hashing<W>,
    origins: &CellOrigins<S>,
) -> io::Result<()> {
    let count = origins.thickness().cells().count();
    let kept = |cell: usize| origins.kept()?.of(cell).map(OriginWeights::to_words);
    write_cells(out, count, kept)
}

/// Reads the origins of gathers that `head` tells of.
///
/// # Errors
/// As [`CellsHead::read`].
pub(super) fn read_origins<R: Read>(
    head: &CellsHead,
    input: &mut Hashing<R>,
) -> io::Result<KeptOrigins> {
    let mut weights = Vec::new();
    let mut is_right = true;
    head.read(input, |cell, words| match words.try_into() {
        Ok(words) => weights.push((cell, OriginWeights::from_words(words))),
        Err(_) => is_right = false,
    })?;
    let other = || io::Error::new(io::ErrorKind::InvalidData, "other cells");
    let cells = usize::try_from(head.cells).ok().filter(|_| is_right).ok_or_else(other)?;
    Ok(KeptOrigins::new(cells, weights.into_iter()))
}

/// Writes the cells of these numbers, of which those have words that are `stored`.
fn write_cells<W: Write, V: IntoIterator<Item = u32>>(
    out: &mut Hashing<W>,
    count: usize,
    stored: impl Fn(usize) -> Option<V>,
) -> io::Result<()> {
    for first in (0..count).step_by(64) {
        let cells = first..count.min(first + 64);
        let bit = |cell: usize| u64::from(stored(cell).is_some());
        let bits = cells.rev().fold(0_u64, |bits, cell| bits << 1 | bit(cell));
        out.put(&bits.to_le_bytes())?;
    }
    for value in (0..count).filter_map(stored) {
        let words = value.into_iter();
        let bytes: SmallVec<[[u8; 4]; MOST_NUMBERS]> = words.map(u32::to_le_bytes).collect();
        out.put(bytes.as_flattened())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::DirectLightCache;
    use crate::math::{GroupedRgb, Rgb, Stage, Stream, WorldPoint};
    use crate::medium::SparseCells;
    use crate::scene::Scene;
    use crate::scene::plan::Needs;
    use crate::transport::{PathContext, PixelFootprint};

    const SCENE: &str = "
        [camera]
        position = [0, 0, 8]
        target = [0, 0, 0]
        [[medium]]
        region = { sphere = { center = [0, 0, 0], radius = 1.0 } }
        sigma_t = 1.0
        albedo = [0.9, 0.8, 0.7]
        [[light]]
        type = 'point'
        position = [0, 5, 0]
        intensity = [9.0, 8.0, 7.0]
        ";

    fn cache<S: Spectrum>(scene: &Scene) -> DirectLightCache<S> {
        let cells = SparseCells::covering(&scene.media.get(0).density, 0.1, 1).unwrap();
        DirectLightCache::new(scene, 0, cells, true, 1)
    }

    fn check<S: Spectrum>() {
        let scene = Scene::of_text(SCENE);
        let [from, to] = [cache::<S>(&scene), cache::<S>(&scene)];
        let mut ctx = PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
        for x in [-0.5, -0.1, 0.3] {
            let found: Option<S> =
                from.interpolated(&scene, WorldPoint::new(x, 0.1, 0.2), &mut ctx);
            assert!(found.unwrap() != S::ZERO);
        }
        let (from, to) = (from.cells().unwrap(), to.cells().unwrap());
        let head = CellsHead::new(from);
        assert!(head.known >= 8 && head.known < head.cells && head.fits(to));
        let mut bytes = Vec::new();
        write(&mut Hashing::new(&mut bytes), from).unwrap();
        assert_eq!(head.bytes(), Some(bytes.len() as u64));
        let read = |head: CellsHead, bytes: &[u8]| {
            head.read(&mut Hashing::new(bytes), |cell, bits| to.restore(cell, bits))
        };
        read(head, &bytes).unwrap();
        let stored = |cells: &LazyCells<S>, cell| cells.stored(cell).map(Vec::from_iter);
        assert!((0..from.count()).all(|cell| stored(from, cell) == stored(to, cell)));
        for wrong in [
            CellsHead { known: head.known - 1, ..head },
            CellsHead { cells: head.cells + 64, ..head },
            CellsHead { channels: 4, ..head },
            CellsHead { channels: 0, ..head },
        ] {
            assert!(read(wrong, &bytes).is_err(), "{wrong:?}");
        }
        assert!(read(head, &bytes[..bytes.len() - 1]).is_err());
        assert!(!CellsHead { width: 0.2, ..head }.fits(to));
    }

    #[test]
    fn cells_are_read_as_they_were_written() {
        check::<f64>();
        check::<Rgb>();
        check::<GroupedRgb>();
    }

    #[test]
    fn origins_are_read_as_they_were_written() {
        let scene = Scene::of_text(SCENE);
        let cells = SparseCells::covering(&scene.media.get(0).density, 0.1, 1).unwrap();
        let origins = CellOrigins::<f64>::new(cells, 0, 1);
        let footprint = PixelFootprint::new(&scene, 1.0);
        let mut ctx = PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
        for x in [-0.5, -0.1, 0.3] {
            let p = WorldPoint::new(x, 0.1, 0.2);
            origins.thickness().fill(&scene, p, &footprint, &mut ctx);
        }
        let known = CellsHead::new(origins.thickness().cells()).known;
        origins.keep_known(&scene, &footprint, Needs::EVERYTHING);
        let head = CellsHead::of_origins(&origins);
        assert!(known >= 24 && head.known == known, "{known}");
        let mut bytes = Vec::new();
        write_origins(&mut Hashing::new(&mut bytes), &origins).unwrap();
        assert_eq!(head.bytes(), Some(bytes.len() as u64));
        let read = read_origins(&head, &mut Hashing::new(&bytes[..])).unwrap();
        assert_eq!(Some(&read), origins.kept());
        let wrong = CellsHead { channels: 1, ..head };
        assert!(read_origins(&wrong, &mut Hashing::new(&bytes[..])).is_err());
    }
}
