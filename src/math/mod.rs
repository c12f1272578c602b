//! Points and rays in their spaces, transforms, colours, warps with their pdfs, random streams.

mod color;
mod frame;
mod random;
mod space;
mod transform;
pub mod warp;

pub use color::{Rgb, luminance};
pub use frame::Frame;
pub use random::{Stage, Stream};
pub use space::{Aabb, Index, IndexPoint, Point, Ray, Span, World, WorldPoint};
pub use transform::Transform;
