//! Light that a medium gives off by itself.

use std::ops::ControlFlow;

use glam::IVec3;

use crate::math::{Ray, Rgb, Span, World, WorldPoint, is_grey, luminance};
use crate::vdb::Grid;

use super::Medium;
use super::blackbody::Blackbody;
use super::ramped::Ramped;
use super::transfer::Transfer;

/// Most voxels that may glow: their table takes 20 bytes each.
pub(super) const MOST_VOXELS: u64 = 1 << 28;

/// Radiance that counts as none beside that of the hottest voxel.
const FAINT: f64 = 1e-9;

/// Emission coefficient of a medium, W/(m³ sr).
#[derive(Debug)]
pub enum Emission {
    /// In proportion to the density: W/(m³ sr) per unit of it.
    Density(Rgb),
    /// A grid of its own, trilinear, times a colour in W/(m³ sr).
    Grid {
        /// The values.
        grid: Grid<f32>,
        /// Factor per channel.
        color: Rgb,
    },
    /// What the values of a grid of its own stand for, W/(m³ sr), 0 outside its bounds.
    Ramped(Ramped<Rgb>),
    /// Blackbody radiance of the temperature times the absorption coefficient (Kirchhoff's law),
    /// so that an optically thick fire reaches the blackbody's radiance.
    Blackbody {
        /// Temperatures; kelvin = scale · value + offset.
        grid: Grid<f32>,
        /// What values of the grid stand for before that; as they are where there is none.
        ramp: Option<Transfer<f64>>,
        /// Kelvin per unit of the value.
        kelvin_scale: f64,
        /// Kelvin where the value is 0.
        kelvin_offset: f64,
        /// Factor on the radiance.
        scale: f64,
        /// Radiance by temperature.
        table: Blackbody,
    },
}

impl Emission {
    /// Whether it is the same in all channels; that of hot gas is not.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Density(color) | Self::Grid { color, .. } => is_grey(*color),
            Self::Ramped(ramped) => ramped.is_grey(),
            Self::Blackbody { .. } => false,
        }
    }
}

impl Medium {
    /// Emission coefficient at `p` where the density is known to be `density`, W/(m³ sr).
    fn emission_with(&self, density: f64, p: WorldPoint) -> Rgb {
        match &self.emission {
            None => Rgb::ZERO,
            Some(Emission::Density(color)) => *color * density,
            Some(Emission::Grid { grid, color }) => {
                let p = grid.transform().point_to_local(p);
                if grid.bounds().contains(p) { *color * grid.value(p) } else { Rgb::ZERO }
            }
            Some(Emission::Ramped(ramped)) => ramped.inside(p),
            Some(Emission::Blackbody { grid, ramp, kelvin_scale, kelvin_offset, scale, table }) => {
                let value = grid.value(grid.transform().point_to_local(p));
                let value = ramp.as_ref().map_or(value, |ramp| ramp.at(value));
                let sigma_a = self.sigma_t * density * (Rgb::ONE - self.albedo.at(p));
                table.radiance(kelvin_scale * value + kelvin_offset) * *scale * sigma_a
            }
        }
    }

    /// Emission coefficient at `p` where the density is known to be `density`, W/(m³ sr); 0 for an
    /// emission that has a grid of its own.
    pub fn emission_of(&self, density: f64, p: WorldPoint) -> Rgb {
        match &self.emission {
            None | Some(Emission::Grid { .. } | Emission::Ramped(_)) => Rgb::ZERO,
            Some(_) => self.emission_with(density, p),
        }
    }

    /// Whether the emission has a grid of its own.
    pub const fn emits_apart(&self) -> bool {
        matches!(self.emission, Some(Emission::Grid { .. } | Emission::Ramped(_)))
    }

    /// Integral over `span` of `ray` (unit direction) of an emission that has a grid of its own,
    /// W/(m² sr), nothing in between; 0 for the other kinds.
    pub fn emission_apart(&self, ray: &Ray<World>, span: Span) -> Rgb {
        match &self.emission {
            Some(Emission::Grid { grid, color }) => {
                *color * grid.integrate(&grid.transform().ray_to_local(ray), span)
            }
            Some(Emission::Ramped(ramped)) => {
                let mut sum = Rgb::ZERO;
                let ray = ramped.grid().transform().ray_to_local(ray);
                let _ = ramped.cells(&ray, span, |_, integral, _| {
                    sum += integral;
                    ControlFlow::Continue(())
                });
                sum
            }
            _ => Rgb::ZERO,
        }
    }

    /// About the bytes of its [`EmissionSampler`](super::EmissionSampler): the table of voxels that may glow.
    pub fn sampler_bytes(&self) -> u64 {
        let Some(grid) = self.glowing_grid() else { return 0 };
        let cells = if grid.is_cut() { grid.occupied_volume() as u64 } else { 0 };
        let places = grid.active_voxels().max(cells).min(MOST_VOXELS);
        places * (size_of::<IVec3>() + size_of::<f64>()) as u64
    }

    /// The grid outside which nothing glows, where there is one.
    pub(super) fn glowing_grid(&self) -> Option<&Grid<f32>> {
        match &self.emission {
            None => None,
            Some(Emission::Grid { grid, .. }) => Some(grid),
            Some(Emission::Ramped(ramped)) => Some(ramped.grid()),
            Some(Emission::Density(_)) => self.density.grid(),
            Some(Emission::Blackbody { grid, .. }) => {
                self.density.grid().or_else(|| (!self.glows_beyond()).then_some(grid))
            }
        }
    }

    /// Whether a blackbody glows where its temperature grid ends, as that has its background as the
    /// value outside.
    fn glows_beyond(&self) -> bool {
        let Some(Emission::Blackbody { grid, .. }) = &self.emission else { return false };
        let [background, hottest] = [[grid.background(); 2], [grid.min_value(), grid.max_value()]]
            .map(|range| self.hottest(range.map(f64::from)));
        grid.is_cut() || background > FAINT * hottest
    }

    /// Luminance of the largest radiance that a blackbody has over a range of its grid's values.
    pub(super) fn hottest(&self, range: [f64; 2]) -> f64 {
        let Some(Emission::Blackbody { ramp, kelvin_scale, kelvin_offset, table, .. }) =
            &self.emission
        else {
            return 0.0;
        };
        let ends = ramp.as_ref().map_or(range, |ramp| ramp.range(range));
        let radiance = |v: f64| luminance(table.radiance(kelvin_scale * v + kelvin_offset));
        radiance(ends[0]).max(radiance(ends[1]))
    }

    /// Emission coefficient at `p`, W/(m³ sr).
    pub fn emission_at(&self, p: WorldPoint) -> Rgb {
        match &self.emission {
            None => Rgb::ZERO,
            Some(Emission::Grid { .. } | Emission::Ramped(_)) => self.emission_with(0.0, p),
            Some(_) => self.emission_with(self.density.value(p), p),
        }
    }
}
