//! The film of a picture on its way: pixels in tiles, and the passes in which they get their rays.

mod passes;
mod tiled;

pub use passes::{Pass, passes, sample_pass};
pub use tiled::{Pixel, Tile, TiledFilm};
