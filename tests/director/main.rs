//! The director and the saliency that it is led by.

#[path = "../common/skip.rs"]
mod skip;

mod maps;
mod saliency;
