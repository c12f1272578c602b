//! Points and rays in their spaces, transforms, colours, warps with their densities, discrete
//! distributions, quantiles, random streams.

mod cdf;
mod color;
mod cone;
mod equiangular;
mod frame;
mod group;
mod grouped;
mod grouped_f32;
mod quantile;
mod random;
mod space;
mod spectrum;
mod transform;
pub mod warp;

pub use cdf::Cdf;
pub use color::{Rgb, are_grey, is_grey, luminance};
pub use cone::Cone;
pub use equiangular::Equiangular;
pub use frame::Frame;
pub use group::{Group, GroupParts, MAX_GROUPS, ORDERS, RayParts};
pub use grouped::GroupedRgb;
pub use quantile::{WeightedValues, nth_smallest, quantile};
pub use random::{Stage, Stream};
pub use space::{Aabb, Index, IndexPoint, Point, Ray, Span, World, WorldPoint};
pub use spectrum::{MOST_NUMBERS, Spectrum};
pub use transform::Transform;

/// The golden ratio: the fractional parts of its multiples are evenly spread over [0, 1) (a Kronecker
/// sequence).
pub const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
