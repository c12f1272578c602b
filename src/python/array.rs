//! Numbers that NumPy sees without a copy, by its array interface.

use std::fmt;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// What owns the numbers. They stay where they are as long as it lives.
type Owner = Arc<dyn AsRef<[f32]> + Send + Sync>;

/// An array of 32-bit numbers, of which NumPy makes a view that keeps it alive.
#[pyclass(frozen, module = "fogbow._fogbow")]
pub(super) struct Values {
    owner: Owner,
    /// The first number among those of the owner.
    first: usize,
    shape: Vec<usize>,
    /// From one number to the next along each axis, in numbers.
    strides: Vec<usize>,
}

impl Values {
    /// Those from `first` on of the `owner`, in rows.
    pub(super) fn new(owner: Owner, first: usize, shape: Vec<usize>) -> Self {
        let below = |axis: usize| shape[axis + 1..].iter().product();
        let strides = (0..shape.len()).map(below).collect();
        Self::with_strides(owner, first, shape, strides)
    }

    /// Those from `first` on of the `owner`, `strides` numbers apart along each axis.
    ///
    /// # Panics
    /// Where some of them are not the owner's.
    pub(super) fn with_strides(
        owner: Owner,
        first: usize,
        shape: Vec<usize>,
        strides: Vec<usize>,
    ) -> Self {
        let last: usize =
            shape.iter().zip(&strides).map(|(n, stride)| (n.max(&1) - 1) * stride).sum();
        let count = (*owner).as_ref().len();
        assert!(first + last < count.max(1), "number {first} + {last} of {count}");
        Self { owner, first, shape, strides }
    }
}

impl fmt::Debug for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Values").field("shape", &self.shape).finish_non_exhaustive()
    }
}

#[pymethods]
impl Values {
    /// NumPy's array interface, version 3: a read-only view.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let numbers = &(*self.owner).as_ref()[self.first..];
        let strides = self.strides.iter().map(|stride| stride * size_of::<f32>());
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", if cfg!(target_endian = "big") { ">f4" } else { "<f4" })?;
        interface.set_item("shape", PyTuple::new(py, &self.shape)?)?;
        interface.set_item("strides", PyTuple::new(py, strides)?)?;
        interface.set_item("data", (numbers.as_ptr() as usize, true))?;
        Ok(interface)
    }
}
