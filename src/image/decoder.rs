//! What all decoders of picture files share: the thread they run on, and limits on what a file may
//! claim.

use std::fmt::Display;
use std::path::Path;

use super::MAX_PIXELS;
use crate::error::{Error, Result};

/// The largest picture file that is read, in bytes.
pub(super) const MAX_BYTES: u64 = 8 << 30;

/// The most values that a byte of a file may stand for: ZIP packs a thousand zeros into one.
const MAX_PACKING: usize = 4096;

/// The name of the thread that decodes picture files. A damaged file can make a decoder panic; that
/// ends this thread and is reported as an error, so that its message on stderr may be left out.
pub const PICTURE_DECODER: &str = "picture decoder";

/// Runs `decode` on a thread of its own; a panic there is damage. It must not decode in parallel, as
/// a panic in a thread pool ends the process.
pub(super) fn on_decoder<T: Send>(
    path: &Path,
    damaged: &dyn Fn(&dyn Display) -> Error,
    decode: impl FnOnce() -> Result<T> + Send,
) -> Result<T> {
    std::thread::scope(|scope| {
        let decoder = std::thread::Builder::new()
            .name(PICTURE_DECODER.into())
            .spawn_scoped(scope, decode)
            .map_err(|e| Error::file(path, format!("cannot be decoded: {e}")))?;
        decoder.join().unwrap_or_else(|_| Err(damaged(&"its blocks do not fit its header")))
    })
}

/// Refuses a picture of no pixel or of too many.
pub(super) fn check_size(width: usize, height: usize, path: &Path) -> Result<()> {
    match width.checked_mul(height) {
        Some(1..=MAX_PIXELS) => Ok(()),
        _ => Err(Error::file(
            path,
            format!("claims {width} x {height} pixels; from 1 to {MAX_PIXELS} can be read"),
        )),
    }
}

/// Refuses more values than a file of so many bytes can hold, before memory is taken for them.
pub(super) fn check_packing(values: usize, bytes: usize, path: &Path) -> Result<()> {
    if values / MAX_PACKING > bytes {
        return Err(Error::file(
            path,
            format!("claims {values} values in {bytes} bytes: it is damaged or incomplete"),
        ));
    }
    Ok(())
}
