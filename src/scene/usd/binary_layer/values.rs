//! Values of a layer: what they say to hold, against the bytes there are.

use std::collections::HashMap;

use super::bytes::Bytes;

/// Deepest nesting of dictionaries and time samples: the reader calls itself for each.
const MAX_DEPTH: u32 = 256;

/// Most bytes that a value may take in memory: samples may share arrays in the file that they don't share there.
const MAX_VALUE: u64 = 8 << 30;

/// Bytes in memory of a string, a path or a small value, besides their text.
const SMALL: u64 = 64;

/// How elements of an array are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stored {
    /// By so many bytes each.
    Plain(u64),
    /// By so many bytes, or as compressed integers.
    Integers(u64),
    /// By so many bytes, or as compressed integers or indices to a table.
    Floats(u64),
    /// By 32-bit indices to tokens behind a length of the array.
    Tokens,
    /// By 32-bit indices to strings behind a 64-bit count.
    Strings,
}

/// How elements of an array of the type `number` are stored; nothing where it is no type of arrays.
const fn stored(number: u8) -> Option<Stored> {
    Some(match number {
        1 | 2 => Stored::Plain(1),
        3 | 4 => Stored::Integers(4),
        5 | 6 => Stored::Integers(8),
        7 => Stored::Floats(2),
        8 => Stored::Floats(4),
        9 | 56 => Stored::Floats(8),
        10 | 12 | 57 => Stored::Strings,
        11 => Stored::Tokens,
        // Matrices of 2, 3 and 4 rows.
        13 => Stored::Plain(32),
        14 => Stored::Plain(72),
        15 => Stored::Plain(128),
        // Quaternions, then vectors of 2, 3 and 4: double, float, half and, of vectors, int.
        16 | 27 => Stored::Plain(32),
        17 | 28 | 19 | 30 => Stored::Plain(16),
        18 | 29 | 20 | 22 => Stored::Plain(8),
        21 => Stored::Plain(4),
        23 => Stored::Plain(24),
        24 | 26 => Stored::Plain(12),
        25 => Stored::Plain(6),
        _ => return None,
    })
}

/// Tables that values refer to.
#[derive(Debug)]
pub(super) struct Tables {
    /// Minor version of the format.
    pub(super) version: u8,
    /// Lengths of tokens.
    pub(super) tokens: Vec<u32>,
    /// Tokens of strings.
    pub(super) strings: Vec<u32>,
    /// Lengths of paths.
    pub(super) paths: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
enum Table {
    Tokens,
    Strings,
    Paths,
}

impl Tables {
    /// Bytes that the entry `index` of `table` takes in memory.
    fn entry(&self, table: Table, index: u32) -> Result<u64, String> {
        let token = |index: u32| self.tokens.get(index as usize).copied();
        let (found, name, count) = match table {
            Table::Tokens => (token(index), "token", self.tokens.len()),
            Table::Strings => {
                let string = self.strings.get(index as usize);
                (string.and_then(|string| token(*string)), "string", self.strings.len())
            }
            Table::Paths => (self.paths.get(index as usize).copied(), "path", self.paths.len()),
        };
        let length = found.ok_or_else(|| format!("it refers to {name} {index} of {count}"))?;
        Ok(SMALL + u64::from(length))
    }
}

/// Checks values.
#[derive(Debug)]
pub(super) struct Values<'a> {
    bytes: &'a [u8],
    tables: &'a Tables,
    /// Bytes in memory of values that were checked.
    known: HashMap<u64, u64>,
    /// Elements that were looked at one by one.
    elements: u64,
}

impl<'a> Values<'a> {
    /// Those in `bytes`, none checked.
    pub(super) fn of(bytes: &'a [u8], tables: &'a Tables) -> Self {
        Self { bytes, tables, known: HashMap::new(), elements: 0 }
    }

    /// Checks the value that is written as `rep`, by its type and where it lies.
    ///
    /// # Errors
    /// Where the bytes cannot hold it.
    pub(super) fn check(&mut self, rep: u64) -> Result<(), String> {
        self.size(rep, 0).map(|_| ())
    }

    /// Bytes that it takes in memory, `depth` values below the first.
    fn size(&mut self, rep: u64, depth: u32) -> Result<u64, String> {
        if let Some(known) = self.known.get(&rep) {
            return Ok(*known);
        }
        if depth > MAX_DEPTH {
            return Err(format!("its values are nested more than {MAX_DEPTH} deep"));
        }
        let size = self.size_of_new(rep, depth)?;
        if size > MAX_VALUE {
            return Err(format!(
                "a value of it takes {size} bytes of memory, with what its samples share; up to {MAX_VALUE} are read"
            ));
        }
        self.known.insert(rep, size);
        Ok(size)
    }

    fn size_of_new(&mut self, rep: u64, depth: u32) -> Result<u64, String> {
        let [.., number, flags] = rep.to_le_bytes();
        let (is_array, is_inlined) = (flags & 0x80 != 0, flags & 0x40 != 0);
        let payload = rep & 0xffff_ffff_ffff;
        if is_array && let Some(stored) = stored(number) {
            return self.array(stored, flags & 0x20 != 0, payload);
        }
        // The reader asks list operations of payloads (55) alone not whether they are inlined.
        // Words (42 to 44, 51 to 53, 56, 57) are read by themselves, and unknown types not at all.
        let is_word = matches!(number, 0..=30 | 42..=44 | 51..=53 | 56 | 57 | 59..);
        if is_word || (is_inlined && number != 55) {
            return Ok(SMALL);
        }
        let at = &mut Bytes::from(self.bytes, payload)?;
        match number {
            31 => self.dictionary(at, depth),
            32 => self.list_operation(at, |own, at| own.indexed(Table::Tokens, at)),
            33 | 54 => self.list_operation(at, |own, at| own.indexed(Table::Strings, at)),
            34 => self.list_operation(at, |own, at| own.indexed(Table::Paths, at)),
            35 => self.list_operation(at, |own, at| own.references(at, depth)),
            36 | 38 => self.list_operation(at, |_, at| plain(at, 4)),
            37 | 39 => self.list_operation(at, |_, at| plain(at, 8)),
            40 => self.indexed(Table::Paths, at),
            41 => self.indexed(Table::Tokens, at),
            45 => {
                let pairs = at.u64()?;
                self.entries(Table::Strings, at, pairs.saturating_mul(2))
            }
            46 => self.time_samples(at, depth),
            47 => self.payload(at),
            49 => plain(at, 16),
            50 => self.indexed(Table::Strings, at),
            55 => self.list_operation(at, |own, at| {
                let count = at.u64()?;
                own.each(count, |own| own.payload(at))
            }),
            58 => {
                let pairs = at.u64()?;
                self.entries(Table::Paths, at, pairs.saturating_mul(2))
            }
            // 48: an array that is marked by its type alone.
            _ => self.array(Stored::Floats(8), flags & 0x20 != 0, payload),
        }
    }

    fn array(&mut self, stored: Stored, is_packed: bool, payload: u64) -> Result<u64, String> {
        let mut at = Bytes::from(self.bytes, payload)?;
        if stored == Stored::Strings {
            return self.indexed(Table::Strings, &mut at);
        }
        if payload == 0 {
            return Ok(SMALL);
        }
        let version = self.tables.version;
        if version < 5 {
            at.u32()?;
        }
        let count = if version < 7 { at.u32()?.into() } else { at.u64()? };
        let is_packed = is_packed && count >= 4;
        match stored {
            Stored::Integers(size) if is_packed && version >= 5 => {
                at.block()?.can_hold(count)?;
                Ok(SMALL + count * size)
            }
            Stored::Floats(size) if is_packed && version >= 6 => {
                match at.u8()? {
                    b'i' => {}
                    b't' => {
                        let table = at.u32()?;
                        at.take(table.into(), size)?;
                    }
                    code => return Err(format!("its code of an array of numbers is {code}")),
                }
                at.block()?.can_hold(count)?;
                Ok(SMALL + count * size)
            }
            Stored::Plain(size) | Stored::Integers(size) | Stored::Floats(size) => {
                Ok(SMALL + at.take(count, size)?.len() as u64)
            }
            Stored::Tokens | Stored::Strings => self.entries(Table::Tokens, &mut at, count),
        }
    }

    /// The sum over `count` elements, looked at one by one.
    fn each(
        &mut self,
        count: u64,
        mut element: impl FnMut(&mut Self) -> Result<u64, String>,
    ) -> Result<u64, String> {
        // An element has 4 bytes or more, and no two values share theirs.
        self.elements = self.elements.saturating_add(count);
        if self.elements > self.bytes.len() as u64 / 4 {
            return Err(format!(
                "its values say to have {} elements, more than its {} bytes can hold",
                self.elements,
                self.bytes.len()
            ));
        }
        let mut sum = SMALL;
        for _ in 0..count {
            sum = sum.saturating_add(element(self)?);
        }
        Ok(sum)
    }

    /// `count` indices to `table`.
    fn entries(&mut self, table: Table, at: &mut Bytes<'a>, count: u64) -> Result<u64, String> {
        self.each(count, |own| own.tables.entry(table, at.u32()?))
    }

    /// Indices to `table` behind their count.
    fn indexed(&mut self, table: Table, at: &mut Bytes<'a>) -> Result<u64, String> {
        let count = at.u64()?;
        self.entries(table, at, count)
    }

    /// A list operation, each of whose lists `list` checks.
    fn list_operation(
        &mut self,
        at: &mut Bytes<'a>,
        mut list: impl FnMut(&mut Self, &mut Bytes<'a>) -> Result<u64, String>,
    ) -> Result<u64, String> {
        // The lowest bit says that there is a list for all others to replace; the others, which lists follow.
        let lists = (at.u8()? >> 1 & 0x3f).count_ones();
        let mut sum = SMALL;
        for _ in 0..lists {
            sum = sum.saturating_add(list(self, at)?);
        }
        Ok(sum)
    }

    fn references(&mut self, at: &mut Bytes<'a>, depth: u32) -> Result<u64, String> {
        let count = at.u64()?;
        self.each(count, |own| {
            let asset = own.tables.entry(Table::Strings, at.u32()?)?;
            let prim = own.tables.entry(Table::Paths, at.u32()?)?;
            at.take(2, 8)?;
            Ok(asset.saturating_add(prim).saturating_add(own.dictionary(at, depth)?))
        })
    }

    fn payload(&mut self, at: &mut Bytes<'a>) -> Result<u64, String> {
        let asset = self.tables.entry(Table::Strings, at.u32()?)?;
        let prim = self.tables.entry(Table::Paths, at.u32()?)?;
        if self.tables.version >= 8 {
            at.take(2, 8)?;
        }
        Ok(asset + prim)
    }

    fn dictionary(&mut self, at: &mut Bytes<'a>, depth: u32) -> Result<u64, String> {
        let count = at.u64()?;
        self.each(count, |own| {
            let key = own.tables.entry(Table::Strings, at.u32()?)?;
            at.follow_offset()?;
            let value = own.size(at.u64()?, depth + 1)?;
            Ok(key.saturating_add(value))
        })
    }

    fn time_samples(&mut self, at: &mut Bytes<'a>, depth: u32) -> Result<u64, String> {
        at.follow_offset()?;
        let times = self.size(at.u64()?, depth + 1)?;
        at.follow_offset()?;
        let count = at.u64()?;
        let values = self.each(count, |own| own.size(at.u64()?, depth + 1))?;
        Ok(times.saturating_add(values))
    }
}

/// Elements of `size` bytes behind their count.
fn plain(at: &mut Bytes<'_>, size: u64) -> Result<u64, String> {
    let count = at.u64()?;
    Ok(SMALL + at.take(count, size)?.len() as u64)
}
