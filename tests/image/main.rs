//! Pictures and textures.

mod film;
mod texture;
