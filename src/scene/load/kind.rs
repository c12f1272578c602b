//! What kind of file a scene is.

use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};
use crate::sequence::Pattern;

/// The pattern of a sequence of bare VDB files that `path` is, if it is one.
pub(in crate::scene) fn bare_sequence(path: &Path) -> Option<Pattern> {
    Pattern::from_path(path).filter(|_| ends_in_vdb(path) && !path.exists())
}

fn ends_in_vdb(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("vdb"))
}

/// Whether the file begins like a VDB.
pub(in crate::scene) fn is_vdb(path: &Path) -> Result<bool> {
    let mut magic = [0; 4];
    let mut file = scene_file(path, crate::file::open(path))?;
    Ok(ends_in_vdb(path) || file.read_exact(&mut magic).is_ok_and(|()| &magic == b" BDV"))
}

/// `opened`, its error also saying what would be right.
fn scene_file<T>(path: &Path, opened: Result<T>) -> Result<T> {
    opened.map_err(|e| match e {
        Error::File { problem, .. } => {
            Error::file(path, format!("{problem}; give a scene (.toml), a VDB or a USD file"))
        }
        other => other,
    })
}
