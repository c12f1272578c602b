//! Which grid of a file is meant.

use crate::error::{Error, Result};

use super::file::VdbFile;
use super::info::GridInfo;

impl VdbFile {
    /// The grid to take for density where none is named: the first called `density`, else the only
    /// scalar fog volume.
    ///
    /// # Errors
    /// Where neither is there; the message lists what is.
    pub fn default_density(&self) -> Result<usize> {
        if let Some(i) = self.grids().iter().position(|g| g.name == "density") {
            return Ok(i);
        }
        let fog: Vec<usize> = self
            .grids()
            .iter()
            .enumerate()
            .filter(|(_, g)| g.class == "fog volume" && g.is_scalar())
            .map(|(i, _)| i)
            .collect();
        match fog[..] {
            [only] => Ok(only),
            [] => Err(self.no_choice("has no grid called \"density\" and no fog volume")),
            _ => Err(self.no_choice(
                "has no grid called \"density\" and several fog volumes; name one of them",
            )),
        }
    }

    /// The grid of this name; where several share it, the one of this occurrence, counted from 0,
    /// or the first.
    ///
    /// # Errors
    /// Where there is none; the message lists what there is.
    pub fn find(&self, name: &str, occurrence: Option<usize>) -> Result<usize> {
        let wanted = occurrence.unwrap_or(0);
        let named: Vec<usize> =
            (0..self.grids().len()).filter(|&i| self.grids()[i].name == name).collect();
        match named.get(wanted) {
            Some(&i) => Ok(i),
            None if named.is_empty() => {
                Err(self.no_choice(&format!("has no grid called \"{name}\"")))
            }
            None => Err(self.no_choice(&format!(
                "has {} of the name \"{name}\", counted from 0, so none with index {wanted}",
                named.len()
            ))),
        }
    }

    fn no_choice(&self, problem: &str) -> Error {
        let describe = |g: &GridInfo| format!("\"{}\" ({}, {})", g.label(), g.value_type, g.class);
        let list: Vec<_> = self.grids().iter().map(describe).collect();
        let list = if list.is_empty() {
            "no grids at all; write it anew with a density".into()
        } else {
            list.join(", ")
        };
        Error::file(self.path(), format!("{problem}; it holds {list}"))
    }
}
