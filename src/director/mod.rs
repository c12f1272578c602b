//! Pass 0: where it pays to be accurate. Maps over the picture, and what each pixel may spend.
//!
//! After Anson, Sundstedt, Gutierrez and Chalmers 2006, "Efficient Selective Rendering of
//! Participating Media": the X-map says how much light survives the medium, the saliency map what
//! catches the eye, and both together how many rays a pixel gets. Beyond the paper they also decide
//! on gather radius and march step, and X may know the light that the medium scatters.

mod budget;
mod cached_snapshot;
mod extinction;
mod importance;
mod noise;
mod quantile;
mod resample;
mod saliency;
mod snapshot;

pub use budget::{PixelBudget, radius_level};
pub use cached_snapshot::CachedSnapshot;
pub use extinction::{false_medium, x_map};
pub use importance::xs_map;
pub use noise::uncertainty;
pub use resample::resampled;
pub use saliency::Saliency;
pub use snapshot::Snapshot;
