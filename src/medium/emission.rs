//! Light that a medium gives off by itself.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::math::{
    Index, IndexPoint, Ray, Rgb, Span, Stage, Stream, Transform, World, WorldPoint, is_grey, luminance,
    warp,
};
use crate::shape::Region;
use crate::vdb::Grid;

use super::blackbody::Blackbody;
use super::{Density, Medium};

/// Most voxels that may glow: their table takes 20 bytes each.
const MOST_VOXELS: u64 = 1 << 28;

/// Radiance that counts as none beside that of the hottest voxel.
const FAINT: f64 = 1e-9;

/// Places by which the power of a region is estimated.
const PROBES: u32 = 4096;

/// Places of the two-point Gauss-Legendre rule on [0, 1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

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
    /// Blackbody radiance of the temperature times the absorption coefficient (Kirchhoff's law),
    /// so that an optically thick fire reaches the blackbody's radiance.
    Blackbody {
        /// Temperatures; kelvin = scale · value + offset.
        grid: Grid<f32>,
        /// Kelvin per unit of the grid.
        kelvin_scale: f64,
        /// Kelvin where the grid is 0.
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
            Some(Emission::Blackbody { grid, kelvin_scale, kelvin_offset, scale, table }) => {
                let value = grid.value(grid.transform().point_to_local(p));
                let sigma_a = self.sigma_t * density * (Rgb::ONE - self.albedo.at(p));
                table.radiance(kelvin_scale * value + kelvin_offset) * *scale * sigma_a
            }
        }
    }

    /// Emission coefficient at `p` where the density is known to be `density`, W/(m³ sr); 0 for an
    /// emission that has a grid of its own.
    pub fn emission_of(&self, density: f64, p: WorldPoint) -> Rgb {
        match &self.emission {
            None | Some(Emission::Grid { .. }) => Rgb::ZERO,
            Some(_) => self.emission_with(density, p),
        }
    }

    /// Integral over `span` of `ray` (unit direction) of an emission that has a grid of its own,
    /// W/(m² sr), nothing in between; 0 for the other kinds.
    pub fn emission_apart(&self, ray: &Ray<World>, span: Span) -> Rgb {
        match &self.emission {
            Some(Emission::Grid { grid, color }) => {
                *color * grid.integrate(&grid.transform().ray_to_local(ray), span)
            }
            _ => Rgb::ZERO,
        }
    }

    /// About the bytes of its [`EmissionSampler`]: the table of voxels that may glow.
    pub fn sampler_bytes(&self) -> u64 {
        let grid = match (&self.emission, &self.density) {
            (None, _) | (Some(Emission::Density(_)), Density::Homogeneous(_)) => return 0,
            (Some(Emission::Grid { grid, .. }), _) | (Some(_), Density::Voxel(grid)) => grid,
            (Some(Emission::Blackbody { .. }), _) if self.glows_beyond() => return 0,
            (Some(Emission::Blackbody { grid, .. }), Density::Homogeneous(_)) => grid,
        };
        let cells = if grid.is_cut() { grid.occupied_volume() as u64 } else { 0 };
        let places = grid.active_voxels().max(cells).min(MOST_VOXELS);
        places * (size_of::<IVec3>() + size_of::<f64>()) as u64
    }

    /// Whether a blackbody glows where its temperature grid ends, as that has its background as the
    /// value outside.
    fn glows_beyond(&self) -> bool {
        let Some(Emission::Blackbody { grid, kelvin_scale, kelvin_offset, table, .. }) =
            &self.emission
        else {
            return false;
        };
        let radiance =
            |value: f32| luminance(table.radiance(kelvin_scale * f64::from(value) + kelvin_offset));
        grid.is_cut() || radiance(grid.background()) > FAINT * radiance(grid.max_value())
    }

    /// Emission coefficient at `p`, W/(m³ sr).
    pub fn emission_at(&self, p: WorldPoint) -> Rgb {
        match &self.emission {
            None => Rgb::ZERO,
            Some(Emission::Grid { .. }) => self.emission_with(0.0, p),
            Some(_) => self.emission_with(self.density.value(p), p),
        }
    }
}

/// Where a photon leaves an emissive medium.
#[derive(Debug, Clone, Copy)]
pub struct EmissionStart {
    /// The photon's ray, of unit direction.
    pub ray: Ray<World>,
    /// The power of all the medium's light if one photon stands for it, in W.
    pub power: Rgb,
}

/// Samples places in an emissive medium, about in proportion to what they emit.
///
/// Where emission is trilinear a voxel is drawn by its emission and a place round it by the
/// trilinear hat, so that the density of places is the interpolation of the voxels' emission. What a
/// blackbody emits between voxels is not told by what it emits at them, as where a hot one without
/// soot lies beside a cold one with it: there a cell is drawn by its mean emission and a place
/// evenly inside.
#[derive(Debug)]
pub struct EmissionSampler {
    places: Places,
    /// Emitted power, W.
    power: f64,
}

#[derive(Debug)]
enum Places {
    Voxels { transform: Transform<Index>, voxels: Vec<IVec3>, cdf: Vec<f64> },
    Cells { transform: Transform<Index>, cells: Vec<IVec3>, cdf: Vec<f64> },
    Region { region: Region, volume: f64 },
}

impl EmissionSampler {
    /// Prepares `medium`; nothing where it emits nothing.
    ///
    /// # Errors
    /// Where the medium glows without end.
    pub fn new(medium: &Medium) -> Result<Option<Self>> {
        let grid = match (&medium.emission, &medium.density) {
            (None, _) => return Ok(None),
            (Some(Emission::Grid { grid, .. }), _) | (Some(_), Density::Voxel(grid)) => grid,
            (Some(Emission::Density(_)), Density::Homogeneous(region)) => {
                return everywhere(medium, region);
            }
            (Some(Emission::Blackbody { grid, .. }), Density::Homogeneous(region)) => {
                if medium.glows_beyond() {
                    return everywhere(medium, region);
                }
                grid
            }
        };
        let blackbody = matches!(medium.emission, Some(Emission::Blackbody { .. }));
        let places = if blackbody { cells(medium, grid) } else { voxels(medium, grid) };
        let places = places.ok_or_else(|| {
            Error::Usage(format!(
                "an emissive grid has over {MOST_VOXELS} voxels that may glow; resample it"
            ))
        })?;
        let sum = places.sum();
        let power = 4.0 * std::f64::consts::PI * sum * grid.transform().volume_scale();
        Ok((power > 0.0).then_some(Self { places, power }))
    }

    /// Emitted power by luminance, W.
    pub const fn power(&self) -> f64 {
        self.power
    }

    /// A photon's start, uniform over directions; nothing where this choice finds no place.
    pub fn emit(&self, medium: &Medium, rng: &mut Stream) -> Option<EmissionStart> {
        let (at, pdf) = self.place(medium, rng)?;
        let direction = warp::uniform_sphere(rng.uniform2());
        let power = medium.emission_at(at) / (pdf * warp::uniform_sphere_pdf());
        Some(EmissionStart { ray: Ray::new(at, direction), power })
    }

    /// A place and its density, 1/m³.
    fn place(&self, medium: &Medium, rng: &mut Stream) -> Option<(WorldPoint, f64)> {
        Some(match &self.places {
            Places::Region { region, volume } => (region.sample(rng)?, 1.0 / volume),
            Places::Cells { transform, cells, cdf } => {
                let index = choose(cdf, rng.uniform());
                let u = DVec3::from(std::array::from_fn(|_| rng.uniform()));
                let p = IndexPoint::from_xyz(cells[index].as_dvec3() + u);
                let below = if index == 0 { 0.0 } else { cdf[index - 1] };
                let share = (cdf[index] - below) / self.places.sum();
                (transform.point_to_world(p), share / transform.volume_scale())
            }
            Places::Voxels { transform, voxels, cdf } => {
                let index = choose(cdf, rng.uniform());
                let hat = DVec3::from(std::array::from_fn(|_| rng.uniform() + rng.uniform() - 1.0));
                let p = IndexPoint::from_xyz(voxels[index].as_dvec3() + hat);
                let grid = proportional(medium)?;
                let weight = trilinear(p, |voxel| voxel_glow(medium, grid, voxel));
                let total = self.places.sum() * transform.volume_scale();
                (transform.point_to_world(p), weight / total)
            }
        })
    }
}

impl Places {
    /// Sum of the emission of all voxels or cells.
    fn sum(&self) -> f64 {
        match self {
            Self::Voxels { cdf, .. } | Self::Cells { cdf, .. } => {
                cdf.last().map_or(0.0, |sum| *sum)
            }
            Self::Region { volume, .. } => *volume,
        }
    }
}

/// Places spread evenly over `region`, of which any may glow; nothing where none seems to.
///
/// # Errors
/// Where the region is endless.
fn everywhere(medium: &Medium, region: &Region) -> Result<Option<EmissionSampler>> {
    let Some(volume) = region.volume() else {
        return Err(Error::Usage(
            "an emissive medium without end has infinite power; give it a region".into(),
        ));
    };
    let mean = match &medium.emission {
        Some(Emission::Density(color)) => luminance(*color),
        _ => {
            let mut rng = Stream::new(0, Stage::Content, 0, 0);
            let probe = |_| region.sample(&mut rng).map_or(0.0, |p| luminance(medium.emission_at(p)));
            (0..PROBES).map(probe).sum::<f64>() / f64::from(PROBES)
        }
    };
    let power = 4.0 * std::f64::consts::PI * mean * volume;
    let places = Places::Region { region: region.clone(), volume };
    Ok((power > 0.0).then_some(EmissionSampler { places, power }))
}

/// The voxels of `grid` that glow; nothing where there are too many.
fn voxels(medium: &Medium, grid: &Grid<f32>) -> Option<Places> {
    let transform = *grid.transform();
    let (mut voxels, mut cdf, mut sum) = (Vec::new(), Vec::new(), 0.0);
    let mut too_many = false;
    grid.for_each_nonzero(|block| {
        let size = (block.max - block.min).as_u64vec3() + 1;
        too_many |= voxels.len() as u64 + size.element_product() > MOST_VOXELS;
        if too_many {
            return;
        }
        for ijk in within(block.min, block.max) {
            let emission = voxel_glow(medium, grid, ijk);
            if emission > 0.0 {
                sum += emission;
                voxels.push(ijk);
                cdf.push(sum);
            }
        }
    });
    (!too_many).then_some(Places::Voxels { transform, voxels, cdf })
}

/// The cells of `grid` that glow anywhere, by their means over the places of a two-point
/// Gauss-Legendre rule; nothing where there are too many. Where any place inside a cell glows, those
/// do: all eight corners count at each.
fn cells(medium: &Medium, grid: &Grid<f32>) -> Option<Places> {
    if grid.occupied_volume() > MOST_VOXELS as f64 {
        return None;
    }
    let transform = *grid.transform();
    let mean = |cell: IVec3| {
        let emission = |corner: usize| {
            let u = [corner & 1, (corner >> 1) & 1, corner >> 2].map(|high| GAUSS[high]);
            glow(medium, &transform, cell.as_dvec3() + DVec3::from(u))
        };
        (0..8).map(emission).sum::<f64>() / 8.0
    };
    let mut blocks = Vec::new();
    grid.for_each_occupied(|block| {
        blocks.push((block.min.xyz.as_ivec3(), block.max.xyz.as_ivec3()));
    });
    let glowing = |&(min, end): &(IVec3, IVec3)| {
        let cells = within(min, end - 1).map(|cell| (cell, mean(cell)));
        cells.filter(|(_, emission)| *emission > 0.0).collect::<Vec<_>>()
    };
    let (mut cells, mut cdf, mut sum) = (Vec::new(), Vec::new(), 0.0);
    for (cell, emission) in blocks.par_iter().map(glowing).collect::<Vec<_>>().into_iter().flatten()
    {
        sum += emission;
        cells.push(cell);
        cdf.push(sum);
    }
    Some(Places::Cells { transform, cells, cdf })
}

/// The entry of a running sum that `u` in [0, 1) falls on.
fn choose(cdf: &[f64], u: f64) -> usize {
    let last = cdf.len() - 1;
    cdf.partition_point(|&sum| sum <= u * cdf[last]).min(last)
}

/// The voxels from `min` to `max`, both inside.
fn within(min: IVec3, max: IVec3) -> impl Iterator<Item = IVec3> {
    (min.x..=max.x).flat_map(move |x| {
        (min.y..=max.y).flat_map(move |y| (min.z..=max.z).map(move |z| IVec3::new(x, y, z)))
    })
}

/// Luminance of the emission coefficient at `p` of the grid's index space.
fn glow(medium: &Medium, transform: &Transform<Index>, p: DVec3) -> f64 {
    luminance(medium.emission_at(transform.point_to_world(IndexPoint::from_xyz(p))))
}

/// The grid of which the emission is a multiple, where there is one.
const fn proportional(medium: &Medium) -> Option<&Grid<f32>> {
    match (&medium.emission, &medium.density) {
        (Some(Emission::Grid { grid, .. }), _)
        | (Some(Emission::Density(_)), Density::Voxel(grid)) => Some(grid),
        _ => None,
    }
}

/// Luminance of the emission coefficient at a voxel of `grid`, of which it is a multiple; 0 outside
/// its bounds, whose faces belong to them however places on them are rounded.
fn voxel_glow(medium: &Medium, grid: &Grid<f32>, voxel: IVec3) -> f64 {
    let (Some(Emission::Density(color) | Emission::Grid { color, .. }), true) =
        (&medium.emission, grid.has_voxel(voxel))
    else {
        return 0.0;
    };
    let transform = grid.transform();
    let p = transform.point_to_world(IndexPoint::from_xyz(voxel.as_dvec3()));
    luminance(*color * grid.value(transform.point_to_local(p)))
}

/// Trilinear interpolation at `p` of a value given at integer places.
fn trilinear(p: IndexPoint, value: impl Fn(IVec3) -> f64) -> f64 {
    let low = p.xyz.floor();
    let f = p.xyz - low;
    (0..8)
        .map(|corner| {
            let up = IVec3::new(corner & 1, (corner >> 1) & 1, corner >> 2);
            let w = DVec3::select(up.cmpgt(IVec3::ZERO), f, DVec3::ONE - f);
            w.element_product() * value(low.as_ivec3() + up)
        })
        .sum()
}
