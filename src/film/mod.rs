//! The film while it is rendered: samples of a pixel, pixels in tiles, and the passes in which they get
//! their rays. Reconstruction takes noise off the finished picture.

mod accumulator;
mod aov_sums;
mod components;
mod deep;
mod feature_mean;
mod light_passes;
mod passes;
mod reconstruct;
mod sample;
mod tiled;

pub use accumulator::Accumulator;
pub use aov_sums::{AovRay, AovSums};
pub use components::{ComponentFilm, LightPart, PixelComponents};
pub use deep::{DEEP_BYTES, DeepPixel, FlatPixel};
pub use feature_mean::FeatureMean;
pub use light_passes::share_out;
pub use passes::{FIRST_RAYS, Pass, passes, sample_pass, sample_passes};
pub use reconstruct::{
    Antialiased, FilmNoise, PART_BYTES, PictureLight, PixelLight, RECONSTRUCTION_BYTES,
    RECONSTRUCTION_REACH, Reconstruction, VisibilityRay,
};
pub use sample::{CaughtShadow, Components, OpacityDepths, Sample, Seen, VisibleSurface};
pub use tiled::{FilmContents, FilmState, Importance, Pixel, Tile, TiledFilm};
