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

mod build;
mod cells;
mod direct;
mod edge;
mod filled;
mod gathered;
mod layered;
mod means;
mod moments;
mod shape;
mod start;
mod track;
mod walk;

pub(super) use build::{Builder, Holds};
pub(super) use edge::{edge_for_flights, thin_edge, thin_edge_for_moments};
pub(super) use shape::Cells;
pub(super) use track::Track;

pub use cells::Lattice;
pub use direct::DirectLattice;
pub use filled::Filled;
pub use gathered::{GatherLattice, Round};
