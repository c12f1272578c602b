//! Pictures: pixel buffers and textures, the layers of a film, EXR and PNG, maps in false colours.
//!
//! Pixels are linear Rec.709 everywhere; row 0 is the top row. Bulk data are f32, arithmetic is f64.

mod agx;
pub mod cryptomatte;
mod decoded;
mod decoder;
mod denoise;
mod exr_attribute;
mod exr_deep;
mod exr_header;
mod exr_read;
mod exr_storage;
mod exr_write;
mod fill;
mod film;
mod film_pixel;
mod hdr_read;
pub mod merge;
mod meter;
mod neighborhood;
mod palette;
mod picture;
mod pixels;
mod png;
mod scalar;
mod srgb;
mod texture;
mod tiff_read;
mod view;
mod window;

pub use agx::AgxCurve;
pub use decoded::{DecodedTexture, Encoding};
pub use decoder::PICTURE_DECODER;
pub use denoise::Denoiser;
pub use exr_deep::{DeepImage, DeepSample};
pub use exr_read::{
    Channels, Layers, LayersHeader, read_attributes, read_exr, read_header, read_layers,
};
pub use exr_write::{exr_bytes, exr_picture_bytes, write_exr, write_exr_image, write_exr_layers};
pub use film::{Film, NOISY_LAYERS};
pub use film_pixel::{FAR, Features, FilmPixel};
pub use meter::meter;
pub use neighborhood::{averages, within};
pub use palette::{NOT_FINITE, viridis};
pub use picture::Picture;
pub use pixels::{Image, MAX_PIXELS};
pub use png::{png_bytes, png_path_beside, write_picture, write_png};
pub use scalar::{ScalarMap, contact_sheet, titled};
pub use srgb::{decode as srgb_decode, encode as srgb_encode};
pub use texture::{decode_texture, read_texture};
pub use view::{View, ViewTransform};
pub use window::Window;
