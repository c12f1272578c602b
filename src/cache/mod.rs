//! Light in a medium on a lattice of cubic cells, from the flights of photons.
//!
//! Every flight leaves its length in each cell it crosses, not only a point where it ends: the
//! track-length estimator of fluence (Spanier and Gelbard 1969, section 2.4; photon beams of
//! Jarosz et al. 2011, "A Comprehensive Theory of Volumetric Radiance Estimation using Photon
//! Points and Beams", gathered by cells). A cell is crossed by many more flights than end in it,
//! so that few photons do, and the march reads the light at a place at the price of one trilinear
//! sample.
//!
//! A cell holds the integral of radiance times phase function over directions, W/(m² sr): that of
//! light scattered toward the eye, which at one place leaves in one direction only. Where the
//! phase function is isotropic it holds for every direction. Where rays are followed until light has
//! forgotten which way it flew, a cell holds moments of radiance instead, which say what is scattered
//! into any direction by then. What those rays find is kept as well, as is direct light, on lattices that
//! are filled where they are first asked.

mod bins;
mod cell_size;
mod cell_walk;
mod direct_light;
mod final_gather;
mod fluence_builder;
mod fluence_grid;
mod gather_origin;
mod lazy_cells;
mod mip;
mod moments;
mod sparse_cells;

pub use cell_size::{edge_for_flights, thin_edge, thin_edge_for_moments};
pub use direct_light::DirectLightCache;
pub use final_gather::{FinalGatherCache, SamplePass};
pub use fluence_builder::{CellContents, FluenceBuilder};
pub use fluence_grid::FluenceGrid;
pub use lazy_cells::LazyCells;
pub use sparse_cells::SparseCells;
