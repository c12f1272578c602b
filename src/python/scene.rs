//! Scenes that stay loaded, and what is done with them.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::array::Values;
use super::exception::Failure;
use super::picture::Picture;
use super::watched::Watched;
use crate::cli::SharedPhotons;
use crate::cli::calls::{self, Compared};
use crate::error::Result;
use crate::image::Image;
use crate::render::Stop;
use crate::scene::OpenScene;

/// A picture to compare: a path, or height, width and the bytes of 32-bit radiance.
#[derive(FromPyObject)]
pub(super) enum Side<'py> {
    File(PathBuf),
    Pixels(usize, usize, Bound<'py, PyBytes>),
}

impl Side<'_> {
    /// The picture.
    pub(super) fn compared(self) -> PyResult<Compared> {
        let (height, width, bytes) = match self {
            Self::File(path) => return Ok(Compared::File(path)),
            Self::Pixels(height, width, bytes) => (height, width, bytes),
        };
        let numbers: Vec<f32> = numbers(bytes.as_bytes());
        if numbers.is_empty() || numbers.len() != 3 * width * height {
            return Err(PyValueError::new_err("a picture has three numbers a pixel"));
        }
        let pixels = numbers.as_chunks().0.to_vec();
        Ok(Compared::Image(Image::new(width, height, pixels)))
    }
}

/// The 32-bit numbers of `bytes`, which are in the order of this machine.
pub(super) fn numbers(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks().0.iter().map(|bytes| f32::from_ne_bytes(*bytes)).collect()
}

/// A scene that stays loaded.
#[pyclass(frozen, module = "fogbow._fogbow")]
#[derive(Debug)]
pub(super) struct Scene(Mutex<OpenScene>);

impl Scene {
    fn open(&self) -> MutexGuard<'_, OpenScene> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Settings of one picture: the frame of a sequence, and words of the command line.
type Settings = (Option<f64>, Vec<String>);

/// Runs `work` where Ctrl-C and the callback `progress` are heard.
fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<Bound<'_, PyAny>>,
    work: impl FnOnce(&Watched, &Stop) -> Result<T> + Send,
) -> PyResult<T> {
    Watched::default().run(py, progress, work)?.map_err(|e| Failure(e).raised(py))
}

#[pymethods]
impl Scene {
    /// The scene of a file.
    #[staticmethod]
    fn of_file(path: PathBuf) -> Self {
        Self(Mutex::new(OpenScene::of_file(&path)))
    }

    /// The scene of a dictionary in JSON, which messages call `name`.
    #[staticmethod]
    fn of_json(name: PathBuf, json: &str) -> PyResult<Self> {
        let wrong = |e: &dyn std::fmt::Display| PyValueError::new_err(format!("{name:?}: {e}"));
        let scene: toml::Table = serde_json::from_str(json).map_err(|e| wrong(&e))?;
        let text = toml::to_string(&scene).map_err(|e| wrong(&e))?;
        Ok(Self(Mutex::new(OpenScene::of_text(&name, text))))
    }

    /// Reads all that it names.
    fn load(&self, py: Python<'_>, settings: Settings) -> PyResult<()> {
        let (frame, words) = settings;
        watched(py, None, |_, _| calls::load(&mut self.open(), frame, &words))
    }

    /// Renders one picture.
    #[pyo3(signature = (settings, progress))]
    fn render(
        &self,
        py: Python<'_>,
        settings: Settings,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Picture> {
        let (frame, words) = settings;
        let picture = watched(py, progress, |watched, stop| {
            let none = &mut SharedPhotons::default();
            calls::render(&mut self.open(), frame, &words, none, watched, stop)
        })?;
        Ok(Picture(Arc::new(picture)))
    }

    /// Finds which of these pictures have the same photons.
    fn share_photons(&self, py: Python<'_>, settings: Vec<Settings>) -> PyResult<Shared> {
        let shared = watched(py, None, |_, _| calls::share_photons(&mut self.open(), &settings))?;
        Ok(Shared(Mutex::new(shared)))
    }

    /// Renders one picture, with photons that are shared where it can.
    #[pyo3(signature = (settings, shared, progress))]
    fn render_sharing(
        &self,
        py: Python<'_>,
        settings: Settings,
        shared: &Shared,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Picture> {
        let (frame, words) = settings;
        let picture = watched(py, progress, |watched, stop| {
            let mut shared = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
            calls::render(&mut self.open(), frame, &words, &mut shared, watched, stop)
        })?;
        Ok(Picture(Arc::new(picture)))
    }

    /// What `fogbow plan` tells, as JSON.
    fn plan(&self, py: Python<'_>, words: Vec<String>) -> PyResult<String> {
        watched(py, None, |_, _| calls::plan(&mut self.open(), &words))
    }

    /// The director's maps by name.
    fn maps(&self, py: Python<'_>, words: Vec<String>) -> PyResult<Vec<(String, Values)>> {
        let maps = watched(py, None, |_, _| calls::maps(&mut self.open(), &words))?;
        let values =
            maps.into_iter().map(|map| (map.name, Values::new(Arc::new(map.values), 0, map.shape)));
        Ok(values.collect())
    }

    /// Studies it; what `fogbow study` tells, as JSON.
    #[pyo3(signature = (folder, words, progress))]
    fn study(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        words: Vec<String>,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        watched(py, progress, |watched, _| calls::study(&mut self.open(), &folder, &words, watched))
    }
}

/// Photons that pictures share.
#[pyclass(frozen, module = "fogbow._fogbow")]
#[derive(Debug)]
pub(super) struct Shared(Mutex<SharedPhotons>);
