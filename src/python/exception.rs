//! Errors become exceptions.

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::error::Error;

/// An error on its way to Python.
pub(super) struct Failure(pub(super) Error);

impl Failure {
    /// The exception: of `fogbow`, by what is at fault.
    pub(super) fn raised(self, py: Python<'_>) -> PyErr {
        let message = self.0.to_string();
        let name = match self.0 {
            Error::Interrupted { .. } => return PyKeyboardInterrupt::new_err(message),
            Error::Key { .. } | Error::Usage(_) => "SettingError",
            Error::File { .. } | Error::Grid { .. } | Error::Frame { .. } => "FileError",
            _ => "Error",
        };
        let class = py.import("fogbow._errors").and_then(|module| module.getattr(name));
        class.and_then(|class| class.call1((message,))).map_or_else(|e| e, PyErr::from_value)
    }
}
