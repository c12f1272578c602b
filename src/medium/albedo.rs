//! Single-scattering albedo.

use crate::math::{Rgb, WorldPoint, is_grey};
use crate::vdb::Grid;

use super::ramped::Ramped;

/// Share of the extinction that scatters, per channel, in [0, 1].
#[derive(Debug)]
pub enum Albedo {
    /// The same everywhere.
    Constant(Rgb),
    /// A colour grid times a scale; clamped to [0, 1] after interpolation.
    Color {
        /// The colours.
        grid: Grid<[f32; 3]>,
        /// Factor per channel.
        scale: Rgb,
    },
    /// A scalar grid times a colour; clamped to [0, 1] after interpolation.
    Scalar {
        /// The values.
        grid: Grid<f32>,
        /// Factor per channel.
        scale: Rgb,
    },
    /// The colours that a scalar grid's values stand for; clamped to [0, 1].
    Ramped(Ramped<Rgb>),
}

impl Albedo {
    /// Whether it is the same everywhere, so that no grid is looked up.
    pub const fn is_constant(&self) -> bool {
        matches!(self, Self::Constant(_))
    }

    /// Whether it is known to be the same in all channels; of colour grids it is not.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Constant(albedo) => is_grey(*albedo),
            Self::Scalar { scale, .. } => is_grey(*scale),
            Self::Color { .. } => false,
            Self::Ramped(ramped) => ramped.is_grey(),
        }
    }

    /// The albedo at `p`.
    pub fn at(&self, p: WorldPoint) -> Rgb {
        let value = match self {
            Self::Constant(albedo) => return *albedo,
            Self::Color { grid, scale } => {
                Rgb::from(grid.value(grid.transform().point_to_local(p))) * *scale
            }
            Self::Scalar { grid, scale } => grid.value(grid.transform().point_to_local(p)) * *scale,
            Self::Ramped(ramped) => ramped.at(p),
        };
        value.clamp(Rgb::ZERO, Rgb::ONE)
    }
}
