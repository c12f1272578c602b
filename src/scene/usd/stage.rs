//! Opens USD stages.

use std::io::{self, Cursor, Read as _};
use std::path::{Path, PathBuf};

use openusd::ar::{Asset, AssetInfo, DefaultResolver, ResolvedPath, Resolver};
use openusd::usd::Stage;
use tempfile::TempDir;

use super::{binary_layer, package, text_layer};
use crate::error::{Error, Result};
use crate::scene::reader::one_line;

/// The name of the thread that reads USD files. A damaged file can make the crate panic; that ends this
/// thread and is reported as an error, so that its message on stderr may be left out.
pub const USD_READER: &str = "USD reader";

/// Stack of that thread, in bytes: composition calls itself for each arc and level.
const STACK: usize = 256 << 20;

/// Most characters of a message of the crate.
const MAX_MESSAGE: usize = 400;

/// A USD file; a package is unpacked into a folder that lasts as long as this.
#[derive(Debug)]
pub(super) struct Root {
    /// The file as the user named it.
    pub(super) path: PathBuf,
    /// The layer to open.
    layer: PathBuf,
    /// Where a package was unpacked.
    folder: Option<TempDir>,
}

impl Root {
    /// The file `path`.
    ///
    /// # Errors
    /// Where it cannot be read, or is a package that cannot be unpacked.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let mut file = crate::file::open(path)?;
        let mut magic = [0; 2];
        let is_package = file.read_exact(&mut magic).is_ok() && package::is_package(&magic);
        if !is_package {
            return Ok(Self { path: path.into(), layer: path.into(), folder: None });
        }
        let wrong = |problem: String| Error::file(path, one_line(&problem));
        let folder = TempDir::with_prefix("fogbow-usdz-")
            .map_err(|e| wrong(format!("cannot be unpacked: {e}")))?;
        let layer = package::unpack(path, folder.path()).map_err(wrong)?;
        Ok(Self { path: path.into(), layer, folder: Some(folder) })
    }

    /// The folder into which it was unpacked, where it is a package.
    pub(super) fn unpacked(&self) -> Option<&Path> {
        self.folder.as_ref().map(TempDir::path)
    }

    /// What `read` finds on the stage.
    ///
    /// # Errors
    /// Where the file or one that it asks for cannot be read, or `read` fails.
    pub(super) fn read<T: Send>(&self, read: impl FnOnce(&Stage) -> Result<T> + Send) -> Result<T> {
        let wrong = |problem: String| {
            Error::file(&self.path, shortened(&problem.replace(&self.shown_folder(), "")))
        };
        let opened = || {
            let layer = self.layer.to_str().ok_or_else(|| wrong("has no name in UTF-8".into()))?;
            let stage = Stage::builder().resolver(Layers::default()).open(layer);
            let stage = stage.map_err(|e| wrong(format!("{e:#}")))?;
            let found = read(&stage);
            // Files that prims refer to are opened where the prims are asked for.
            match stage.composition_errors().first() {
                Some(problem) => Err(wrong(problem.to_string())),
                None => found,
            }
        };
        std::thread::scope(|scope| {
            std::thread::Builder::new()
                .name(USD_READER.into())
                .stack_size(STACK)
                .spawn_scoped(scope, opened)
                .map_err(|e| wrong(format!("cannot be read: {e}")))?
                .join()
                .unwrap_or_else(|_| Err(wrong("is damaged: its numbers cannot be".into())))
        })
    }

    /// The beginning of paths in a package, as messages of the crate have it.
    fn shown_folder(&self) -> String {
        self.unpacked().map_or("\0".into(), |folder| format!("{}/", folder.display()))
    }
}

/// `message` in one line, cut where it is long.
fn shortened(message: &str) -> String {
    let line = one_line(message);
    match line.char_indices().nth(MAX_MESSAGE) {
        Some((end, _)) => format!("{}...", &line[..end]),
        None => line,
    }
}

/// Finds and opens layers: binary ones are checked, text is in a form that the crate reads.
#[derive(Default)]
struct Layers(DefaultResolver);

impl Resolver for Layers {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.0.create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.0.resolve(asset_path).filter(|path| !path.is_dir())
    }

    fn resolve_for_new_asset(&self, asset_path: &str) -> Option<ResolvedPath> {
        self.0.resolve_for_new_asset(asset_path)
    }

    fn open_asset(&self, resolved_path: &ResolvedPath) -> io::Result<Box<dyn Asset>> {
        let bytes = self.0.open_asset(resolved_path)?.read_all()?;
        let checked = if package::is_package(&bytes) {
            package::each_layer(&bytes, |layer| readable(layer).map(|_| ())).map(|()| bytes)
        } else {
            readable(bytes)
        };
        match checked {
            Ok(bytes) => Ok(Box::new(Cursor::new(bytes))),
            Err(problem) => {
                let name = resolved_path.file_name().unwrap_or_default();
                Err(io::Error::other(format!("{}: {problem}", name.display())))
            }
        }
    }

    fn get_asset_info(&self, asset_path: &str, resolved_path: &ResolvedPath) -> AssetInfo {
        self.0.get_asset_info(asset_path, resolved_path)
    }

    fn identity(&self) -> String {
        self.0.identity()
    }
}

/// The layer `bytes` in a form that the crate reads.
fn readable(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    if binary_layer::is_binary(&bytes) {
        return binary_layer::check(&bytes).map(|()| bytes);
    }
    if !text_layer::is_text(&bytes) {
        return Ok(bytes);
    }
    let text = String::from_utf8(bytes).map_err(|_| "is not UTF-8")?;
    Ok(text_layer::readable(&text)?.into_owned().into_bytes())
}
