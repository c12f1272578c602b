//! The film while it is rendered: samples of a pixel, pixels in tiles, and the passes in which they get
//! their rays.

mod accumulator;
mod feature_mean;
mod passes;
mod tiled;

pub use accumulator::{Accumulator, Sample};
pub use feature_mean::FeatureMean;
pub use passes::{FIRST_RAYS, Pass, passes, sample_pass};
pub use tiled::{Pixel, Tile, TiledFilm};
