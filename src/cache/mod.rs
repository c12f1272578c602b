//! Light in media, cached on sparse cubic cells.
//!
//! A fluence grid is built from the flights of photons. Every flight leaves its length in each cell that
//! it crosses, not only a point where it ends: the track-length estimator of fluence (Spanier and
//! Gelbard 1969, section 2.4; photon beams of Jarosz et al. 2011, "A Comprehensive Theory of Volumetric
//! Radiance Estimation using Photon Points and Beams", gathered by cells). A cell is crossed by many
//! more flights than end in it, so that few photons do, and a ray reads the light at a place by one
//! trilinear lookup. A cell holds the integral of radiance times phase function over directions,
//! W/(m² sr), toward the camera; or moments of radiance, which tell what is scattered into any direction.
//!
//! Direct light and final gathers are cached in cells that are filled where they are first sampled.
//! Caches know no integrator: what fills a cell is a closure of the caller.

mod bins;
mod caches;
mod camera_thickness;
mod cell_origins;
mod cell_walk;
mod direct_light;
mod directed_rays;
mod final_gather;
mod flight;
mod fluence_builder;
mod fluence_grid;
mod fluence_state;
mod gather_origin;
mod interpolation;
mod lazy_cells;
mod mip;
mod moments;
mod sample_pass;
mod seen_share;

pub use caches::Caches;
pub use cell_origins::{CellOrigins, KeptOrigins};
pub use direct_light::DirectLightCache;
pub use directed_rays::DirectedRays;
pub use final_gather::{FinalGatherCache, GATHERS_PER_RAY, GatherPoints, PLACES_PER_RAY};
pub use fluence_builder::{CellContents, FluenceBuilder};
pub use fluence_grid::FluenceGrid;
pub use gather_origin::{GatherOrigins, OriginWeights};
pub use lazy_cells::LazyCells;
pub use sample_pass::{ReadingRays, SamplePass};
pub use seen_share::SeenShares;
