//! Where it pays to be accurate: maps over the picture that are made before it is rendered.

mod saliency;

pub use saliency::Saliency;
