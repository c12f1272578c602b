//! Noise taken off pictures by Open Image Denoise, a library that is found when it is needed.

mod ffi;
mod search;

use std::path::{Path, PathBuf};

use ffi::{Functions, Input};
use search::NAME;

use super::{Film, Image};
use crate::error::{Error, Result};

/// The major version whose functions are called.
const MAJOR: i32 = 2;

/// Names the library: a file, or a folder that holds it.
const VARIABLE: &str = "FOGBOW_OIDN";

/// Open Image Denoise, found and ready.
#[derive(Debug, Clone)]
pub struct Denoiser {
    functions: Functions,
    path: PathBuf,
    version: String,
}

impl Denoiser {
    /// Finds the library: the one that `FOGBOW_OIDN` names, else the loader's, else one in a Python
    /// environment (`VIRTUAL_ENV`, `CONDA_PREFIX`, that of the `python3` in `PATH`, the user's), where
    /// `pip install pyoidn` puts it.
    ///
    /// # Errors
    /// Where there is none of version 2 that works on this processor; the one that `FOGBOW_OIDN` names
    /// must.
    pub fn find() -> Result<Self> {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        if let Some(given) = variable(VARIABLE) {
            let given = Path::new(&given);
            let opened = search::given(given).and_then(|file| {
                Self::open(&file).map_err(|problem| format!("{VARIABLE}: {problem}"))
            });
            return opened.map_err(|problem| Error::file(given, problem));
        }
        let by_loader = Self::open(Path::new(NAME));
        if let Ok(found) = by_loader {
            return Ok(found);
        }
        // The loader says of what is not there that it cannot be opened.
        let absent = format!("{NAME}: cannot open shared object file");
        let mut unusable: Vec<String> =
            by_loader.err().filter(|problem| !problem.starts_with(&absent)).into_iter().collect();
        for file in search::in_python(&variable) {
            match Self::open(&file) {
                Ok(found) => return Ok(found),
                Err(problem) => unusable.push(format!("{}: {problem}", file.display())),
            }
        }
        Err(none(&unusable))
    }

    /// The library at `path`; a name without a folder is looked for by the loader.
    fn open(path: &Path) -> Result<Self, String> {
        let functions = Functions::open(path)?;
        let [major, minor, patch] = functions.device()?.version()?;
        let version = format!("{major}.{minor}.{patch}");
        if major != MAJOR {
            return Err(format!("is version {version} of Open Image Denoise, not {MAJOR}.x"));
        }
        let path = if path.is_absolute() { None } else { loaded(path) }.unwrap_or(path.into());
        Ok(Self { functions, path, version })
    }

    /// What `film` shows without its noise, by the library's filter for ray tracing in high dynamic
    /// range, on all cores unless `OIDN_NUM_THREADS` binds it: the same bytes each time. It works on
    /// what differs from ray to ray alone, so that it cannot blur the rest, and is shown albedo and
    /// normals where the film has them.
    ///
    /// # Errors
    /// Where the library fails; its message is handed on.
    pub fn denoised(&self, film: &Film) -> Result<Image> {
        let failed = |problem| Error::Failed(format!("{self}: {problem}"));
        let (noisy, visible_emission) = (film.image(), film.visible_emission());
        let apart = |(seen, visible_emission): (&[f32; 3], &[f32; 3])| -> [f32; 3] {
            std::array::from_fn(|channel| (seen[channel] - visible_emission[channel]).max(0.0))
        };
        let color: Vec<[f32; 3]> = noisy.pixels().iter().zip(visible_emission).map(apart).collect();
        let features = film.features();
        let albedo: Vec<[f32; 3]> =
            features.iter().map(|f| f.albedo.map(|share| share.clamp(0.0, 1.0))).collect();
        let normal: Vec<[f32; 3]> = features.iter().map(|f| f.normal).collect();
        let input = Input {
            size: [film.width(), film.height()],
            color: &color,
            features: (!features.is_empty()).then_some([&albedo, &normal]),
        };
        let device = self.functions.device().map_err(failed)?;
        let clean = device.filter(&input).map_err(failed)?;
        let sum = |(clean, visible_emission): (&[f32; 3], &[f32; 3])| {
            std::array::from_fn(|c| clean[c] + visible_emission[c])
        };
        let pixels = clean.iter().zip(visible_emission).map(sum).collect();
        Ok(Image::new(film.width(), film.height(), pixels))
    }

    /// The library's file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its version, such as 2.5.1.
    pub fn version(&self) -> &str {
        &self.version
    }
}

impl std::fmt::Display for Denoiser {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Open Image Denoise {}", self.version)
    }
}

/// The file of the library `name` that the loader found, where the system tells.
fn loaded(name: &Path) -> Option<PathBuf> {
    let name = name.to_str()?;
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    let path = |line: &str| line.find('/').map(|start| PathBuf::from(&line[start..]));
    let is_it = |file: &PathBuf| {
        file.file_name().is_some_and(|file| file.to_string_lossy().starts_with(name))
    };
    maps.lines().filter_map(path).find(is_it)
}

/// What was looked for, what of it could not be used, and what to do.
fn none(unusable: &[String]) -> Error {
    let found = match unusable {
        [] => String::new(),
        all => format!(" (found and not usable: {})", all.join("; ")),
    };
    Error::Failed(format!(
        "Open Image Denoise is needed to denoise: no {NAME} on the loader's path or in a Python \
         environment (VIRTUAL_ENV, CONDA_PREFIX, that of python3 in PATH, ~/.local){found}; run pip \
         install pyoidn, or set {VARIABLE} to the library or its folder"
    ))
}
