//! Finds layers and makes them such as the crate reads without harm.

use std::io::{self, Cursor};

use openusd::ar::{
    Asset, AssetInfo, DefaultResolver, ResolvedPath, Resolver, split_package_relative_path_outer,
};

use super::{arcs, binary_layer, package, text_layer};

/// Finds and opens layers: binary ones are checked, text is in a form that the crate reads.
#[derive(Default)]
pub(super) struct Layers(DefaultResolver);

impl Resolver for Layers {
    fn create_identifier(&self, asset_path: &str, anchor: Option<&ResolvedPath>) -> String {
        self.0.create_identifier(asset_path, anchor)
    }

    fn resolve(&self, asset_path: &str) -> Option<ResolvedPath> {
        // The crate looks into the package of a path such as `a.usdz[b.usd]`.
        let package = split_package_relative_path_outer(asset_path).map(|(package, _)| package);
        if package.is_some_and(|package| {
            self.0.resolve(&package).is_some_and(|path| !package::has_directory(&path))
        }) {
            return None;
        }
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
        let tokens = binary_layer::check(&bytes)?;
        return arcs::check_binary(&bytes, &tokens).map(|()| bytes);
    }
    if !text_layer::is_text(&bytes) {
        return Ok(bytes);
    }
    let text = String::from_utf8(bytes).map_err(|_| "is not UTF-8")?;
    let text = text_layer::readable(&text)?;
    arcs::check_text(&text)?;
    Ok(text.into_owned().into_bytes())
}
