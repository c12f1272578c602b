//! What a shortcut costs in error.

pub mod metric;
