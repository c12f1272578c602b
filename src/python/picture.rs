//! Pictures in memory.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::array::Values;
use super::exception::Failure;
use crate::cli::PictureInMemory;
use crate::scene::ErrorGoal;

/// A picture in memory.
#[pyclass(frozen, module = "fogbow._fogbow")]
#[derive(Debug)]
pub(super) struct Picture(pub(super) Arc<PictureInMemory>);

/// One layer of a picture, or its radiance, which three layers share.
struct Layer {
    picture: Arc<PictureInMemory>,
    /// The name; `None` for radiance.
    name: Option<String>,
}

impl AsRef<[f32]> for Layer {
    fn as_ref(&self) -> &[f32] {
        let film = &self.picture.film;
        self.name.as_ref().map_or(film.radiance(), |name| film.layer(name).unwrap_or_default())
    }
}

#[pymethods]
impl Picture {
    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        (self.0.film.width(), self.0.film.height())
    }

    /// Each layer by its name.
    fn layers(&self) -> Vec<(String, Values)> {
        let (width, height) = self.size();
        let layer = |(name, _): (&str, _)| {
            let layer = Layer { picture: self.0.clone(), name: Some(name.to_owned()) };
            (name.to_owned(), Values::new(Arc::new(layer), 0, vec![height, width]))
        };
        self.0.film.all_layers().map(layer).collect()
    }

    /// Radiance, one channel after another in memory and last among the axes.
    fn rgb(&self) -> Values {
        let (width, height) = self.size();
        let layer = Layer { picture: self.0.clone(), name: None };
        let strides = vec![width, 1, width * height];
        Values::with_strides(Arc::new(layer), 0, vec![height, width, 3], strides)
    }

    /// The error that was asked for and its uncertainty, and whether it is in visible differences.
    #[getter]
    fn error(&self) -> Option<(f64, f64, bool)> {
        let (goal, stated) = self.0.error?;
        Some((stated.value, stated.uncertainty, goal == ErrorGoal::Visible))
    }

    /// Settings, seconds, counters, warnings and notes as JSON.
    #[getter]
    fn report(&self) -> String {
        self.0.report.to_string()
    }

    /// Writes an EXR or a PNG.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.0.save(&path)).map_err(|e| Failure(e).raised(py))
    }

    /// The PNG's bytes.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.0.png()).map_err(|e| Failure(e).raised(py))?;
        Ok(PyBytes::new(py, &bytes))
    }
}
