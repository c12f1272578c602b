//! The bytes of a file, each number checked to be inside it.

use std::io::{BufReader, Read, Seek, SeekFrom};

/// What is wrong with a file, in words for the user.
pub(super) type Checked<T> = Result<T, String>;

/// Reads forward through a file; whatever is asked for beyond its end is a problem, not memory.
#[derive(Debug)]
pub(super) struct Bytes<R> {
    inner: BufReader<R>,
    at: u64,
    length: u64,
}

impl<R: Read + Seek> Bytes<R> {
    pub(super) fn new(mut inner: R) -> Checked<Self> {
        let length = inner.seek(SeekFrom::End(0)).map_err(unreadable)?;
        inner.rewind().map_err(unreadable)?;
        Ok(Self { inner: BufReader::with_capacity(1 << 16, inner), at: 0, length })
    }

    /// Offset of the next byte.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// Bytes in the file.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Checks that `count` more bytes are there.
    fn reserve(&self, count: u64, what: &str) -> Checked<()> {
        let left = self.length - self.at;
        if count <= left {
            return Ok(());
        }
        Err(format!(
            "is damaged or incomplete: {what} at byte {} takes {count} bytes, but the file has {left} \
             more; copy or download it again",
            self.at
        ))
    }

    /// The next `N` bytes.
    pub(super) fn take<const N: usize>(&mut self, what: &str) -> Checked<[u8; N]> {
        self.reserve(N as u64, what)?;
        let mut bytes = [0; N];
        self.inner.read_exact(&mut bytes).map_err(unreadable)?;
        self.at += N as u64;
        Ok(bytes)
    }

    pub(super) fn byte(&mut self, what: &str) -> Checked<u8> {
        self.take::<1>(what).map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self, what: &str) -> Checked<u32> {
        self.take(what).map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self, what: &str) -> Checked<i32> {
        self.take(what).map(i32::from_le_bytes)
    }

    pub(super) fn i64(&mut self, what: &str) -> Checked<i64> {
        self.take(what).map(i64::from_le_bytes)
    }

    /// Text behind its length of four bytes.
    pub(super) fn text(&mut self, what: &str) -> Checked<String> {
        let length = self.u32(what)?;
        self.reserve(length.into(), what)?;
        let mut bytes = vec![0; length as usize];
        self.inner.read_exact(&mut bytes).map_err(unreadable)?;
        self.at += u64::from(length);
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Goes on behind `count` bytes.
    pub(super) fn skip(&mut self, count: u64, what: &str) -> Checked<()> {
        self.reserve(count, what)?;
        self.inner.seek_relative(count as i64).map_err(unreadable)?;
        self.at += count;
        Ok(())
    }

    /// Goes to byte `offset`, which must lie in the file.
    pub(super) fn seek(&mut self, offset: u64) -> Checked<()> {
        self.inner.seek(SeekFrom::Start(offset)).map_err(unreadable)?;
        self.at = offset;
        Ok(())
    }
}

fn unreadable(e: std::io::Error) -> String {
    format!("cannot be read: {e}")
}

/// The problem that something at byte `at` cannot be.
pub(super) fn damaged(at: u64, what: impl std::fmt::Display) -> String {
    format!("is damaged: {what} at byte {at}; copy or download it again")
}
