//! The native part of the Python module `fogbow`; what users see of it is in `fogbow/`.
//!
//! It holds scenes and pictures, and passes arguments on as words of the command line. Renders run on a thread of
//! their own without Python's lock, while the calling thread watches for Ctrl-C and reports progress.

mod array;
mod exception;
mod picture;
mod scene;
mod volume;
mod watched;

use pyo3::prelude::*;

#[pymodule]
mod _fogbow {
    use std::ffi::OsString;
    use std::path::PathBuf;

    use pyo3::prelude::*;

    #[pymodule_export]
    use super::array::Values;
    use super::exception::Failure;
    #[pymodule_export]
    use super::picture::Picture;
    #[pymodule_export]
    use super::scene::Scene;
    use super::scene::Side;
    #[pymodule_export]
    use super::volume::write_volume;
    use crate::cli::{self, calls};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        calls::prepare();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    /// Runs the program with these arguments, the first of which is its name, and returns its exit code.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| cli::main(arguments))
    }

    /// The flags that a command takes as settings: name, whether it has a value, and help.
    #[pyfunction]
    fn flags(command: &str) -> Vec<(String, bool, String)> {
        calls::flags(command).into_iter().map(|f| (f.name, f.has_value, f.help)).collect()
    }

    /// What `fogbow info` tells, as JSON.
    #[pyfunction]
    fn info(py: Python<'_>, path: PathBuf) -> PyResult<String> {
        py.detach(|| calls::info(&path)).map_err(|e| Failure(e).raised(py))
    }

    /// What `fogbow error` tells, as JSON.
    #[pyfunction]
    fn compare(
        py: Python<'_>,
        reference: Side<'_>,
        test: Side<'_>,
        words: Vec<String>,
    ) -> PyResult<String> {
        let [reference, test] = [reference.compared()?, test.compared()?];
        py.detach(|| calls::compare(&reference, &test, &words)).map_err(|e| Failure(e).raised(py))
    }
}
