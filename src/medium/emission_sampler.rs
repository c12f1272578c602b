//! Places in an emissive medium from which photons leave.

use std::f64::consts::PI;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::math::{
    Aabb, Cdf, Index, IndexPoint, Ray, Rgb, Stage, Stream, Transform, World, WorldPoint, luminance,
    warp,
};
use crate::shape::Region;
use crate::vdb::Grid;

use super::emission::MOST_VOXELS;
use super::{Density, Emission, Medium};

/// Places by which the power of a region is estimated.
const PROBES: u32 = 4096;

/// Under a ramp, the least share of what a cell may glow with that it is drawn by.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// Cells of another grid along an axis of a cell up to which its voxels are looked at.
const MOST_ROUND: i32 = 4;

/// Rounding of places, in cells.
const ROUNDING: f64 = 1e-6;

/// Places of the two-point Gauss-Legendre rule on [0, 1].
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

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
    Voxels { transform: Transform<Index>, voxels: Vec<IVec3>, cdf: Cdf },
    Cells { transform: Transform<Index>, cells: Vec<IVec3>, cdf: Cdf },
    Region { region: Region, volume: f64 },
}

impl EmissionSampler {
    /// Prepares `medium`; nothing where it emits nothing.
    ///
    /// # Errors
    /// Where the medium glows without end.
    pub fn new(medium: &Medium) -> Result<Option<Self>> {
        let grid = match (&medium.emission, medium.glowing_grid(), &medium.density) {
            (None, ..) => return Ok(None),
            (Some(_), Some(grid), _) => grid,
            (Some(_), None, Density::Homogeneous(region)) => return everywhere(medium, region),
            (Some(_), None, _) => return Ok(None),
        };
        let places = match proportional(medium) {
            Some(grid) => voxels(medium, grid)?,
            None => cells(medium, grid)?,
        };
        Ok(places.and_then(|places| {
            let power = 4.0 * PI * places.sum() * grid.transform().volume_scale();
            (power > 0.0).then_some(Self { places, power })
        }))
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

    /// A place that may glow and its density, 1/m³; nothing where this choice finds no place.
    pub fn place(&self, medium: &Medium, rng: &mut Stream) -> Option<(WorldPoint, f64)> {
        Some(match &self.places {
            Places::Region { region, volume } => (region.sample(rng)?, 1.0 / volume),
            Places::Cells { transform, cells, cdf } => {
                let (index, _) = cdf.sample(rng.uniform());
                let u = DVec3::from(std::array::from_fn(|_| rng.uniform()));
                let p = IndexPoint::from_xyz(cells[index].as_dvec3() + u);
                let pdf = cdf.probability(index) / transform.volume_scale();
                (transform.point_to_world(p), pdf)
            }
            Places::Voxels { transform, voxels, cdf } => {
                let (index, _) = cdf.sample(rng.uniform());
                let hat = DVec3::from(std::array::from_fn(|_| rng.uniform() + rng.uniform() - 1.0));
                let p = IndexPoint::from_xyz(voxels[index].as_dvec3() + hat);
                let grid = proportional(medium)?;
                let weight = trilinear(p, |voxel| voxel_glow(medium, grid, voxel));
                let total = cdf.total() * transform.volume_scale();
                (transform.point_to_world(p), weight / total)
            }
        })
    }
}

impl Places {
    /// Sum of the emission of all voxels or cells.
    fn sum(&self) -> f64 {
        match self {
            Self::Voxels { cdf, .. } | Self::Cells { cdf, .. } => cdf.total(),
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
            let probe =
                |_| region.sample(&mut rng).map_or(0.0, |p| luminance(medium.emission_at(p)));
            (0..PROBES).map(probe).sum::<f64>() / f64::from(PROBES)
        }
    };
    let power = 4.0 * PI * mean * volume;
    let places = Places::Region { region: region.clone(), volume };
    Ok((power > 0.0).then_some(EmissionSampler { places, power }))
}

fn too_many() -> Error {
    Error::Usage(format!(
        "an emissive grid has over {MOST_VOXELS} voxels that may glow; resample it"
    ))
}

/// The voxels of `grid` that glow; `None` where none does.
///
/// # Errors
/// Where there are too many.
fn voxels(medium: &Medium, grid: &Grid<f32>) -> Result<Option<Places>> {
    let transform = *grid.transform();
    let (mut voxels, mut weights) = (Vec::new(), Vec::new());
    let mut are_many = false;
    grid.for_each_nonzero(|block| {
        let size = (block.max - block.min).as_u64vec3() + 1;
        are_many |= voxels.len() as u64 + size.element_product() > MOST_VOXELS;
        if are_many {
            return;
        }
        for ijk in within(block.min, block.max) {
            let emission = voxel_glow(medium, grid, ijk);
            if emission > 0.0 {
                voxels.push(ijk);
                weights.push(emission);
            }
        }
    });
    if are_many {
        return Err(too_many());
    }
    Ok(Cdf::new(weights).map(|cdf| Places::Voxels { transform, voxels, cdf }))
}

/// The cells of `grid` that glow anywhere, by their means over the places of a two-point
/// Gauss-Legendre rule; `None` where none does. Where any place inside a cell glows, those do: all
/// eight corners count at each. Under a ramp they need not, and a cell has a share of what it may
/// glow with at most.
///
/// # Errors
/// Where there are too many.
fn cells(medium: &Medium, grid: &Grid<f32>) -> Result<Option<Places>> {
    let blocks = occupied(medium, grid).ok_or_else(too_many)?;
    let transform = *grid.transform();
    let has_ramp = medium.has_ramp();
    let mean = |cell: IVec3| {
        let emission = |corner: usize| {
            let u = [corner & 1, (corner >> 1) & 1, corner >> 2].map(|high| GAUSS[high]);
            glow(medium, &transform, cell.as_dvec3() + DVec3::from(u))
        };
        let mean = (0..8).map(emission).sum::<f64>() / 8.0;
        if has_ramp { mean.max(LEAST_SHARE * medium.most_in(cell, &transform)) } else { mean }
    };
    let glowing = |&(min, end): &(IVec3, IVec3)| {
        let cells = within(min, end - 1).map(|cell| (cell, mean(cell)));
        cells.filter(|(_, emission)| *emission > 0.0).collect::<Vec<_>>()
    };
    let blocks: Vec<Vec<(IVec3, f64)>> = blocks.par_iter().map(glowing).collect();
    let (cells, weights): (Vec<_>, Vec<_>) = blocks.into_iter().flatten().unzip();
    Ok(Cdf::new(weights).map(|cdf| Places::Cells { transform, cells, cdf }))
}

/// The blocks of cells of `grid` that may glow, by their first and the one after their last; nothing
/// where there are too many.
fn occupied(medium: &Medium, grid: &Grid<f32>) -> Option<Vec<(IVec3, IVec3)>> {
    let mut blocks = Vec::new();
    let mut add = |block: Aabb<Index>| {
        blocks.push((block.min.xyz.as_ivec3(), block.max.xyz.as_ivec3()));
    };
    match (&medium.emission, &medium.density) {
        (Some(Emission::Ramped(ramped)), _) => ramped.for_each_occupied(&mut add),
        (_, Density::Ramped(ramped)) => ramped.for_each_occupied(&mut add),
        _ => grid.for_each_occupied(&mut add),
    }
    let volume = |&(min, end): &(IVec3, IVec3)| (end - min).as_dvec3().element_product();
    let volume: f64 = blocks.iter().map(volume).sum();
    (volume <= MOST_VOXELS as f64).then_some(blocks)
}

impl Medium {
    /// Whether a transfer function decides on what glows.
    const fn has_ramp(&self) -> bool {
        matches!(self.density, Density::Ramped(_))
            || matches!(
                self.emission,
                Some(Emission::Ramped(_) | Emission::Blackbody { ramp: Some(_), .. })
            )
    }

    /// A bound of the luminance of the emission coefficient in a cell of index space.
    fn most_in(&self, cell: IVec3, transform: &Transform<Index>) -> f64 {
        let cell = Aabb::<Index>::new(
            IndexPoint::from_xyz(cell.as_dvec3()),
            IndexPoint::from_xyz((cell + 1).as_dvec3()),
        );
        let corners = cell.corners().map(|corner| transform.point_to_world(corner));
        let density = || match &self.density {
            Density::Homogeneous(_) => 1.0,
            Density::Voxel(grid) => range_round(grid, &corners)[1],
            Density::Ramped(ramped) => ramped.transfer().peak(range_round(ramped.grid(), &corners)),
        };
        match &self.emission {
            None => 0.0,
            Some(Emission::Density(color)) => luminance(*color) * density(),
            Some(Emission::Grid { grid, color }) => {
                luminance(*color) * range_round(grid, &corners)[1]
            }
            Some(Emission::Ramped(ramped)) => {
                ramped.transfer().peak(range_round(ramped.grid(), &corners))
            }
            Some(Emission::Blackbody { grid, scale, .. }) => {
                let radiance = self.hottest(range_round(grid, &corners));
                radiance * *scale * self.sigma_t.max_element() * density()
            }
        }
    }
}

/// Bounds of the values of `grid` in the box of its index space round `corners`: of the voxels round
/// it, or where these are many of all.
fn range_round(grid: &Grid<f32>, corners: &[WorldPoint; 8]) -> [f64; 2] {
    let around = Aabb::around(corners.map(|corner| grid.transform().point_to_local(corner)));
    let around = around.grown(-ROUNDING);
    let (min, max) = (around.min.xyz.floor().as_ivec3(), around.max.xyz.ceil().as_ivec3());
    if (max - min).max_element() > MOST_ROUND {
        return [grid.min_value(), grid.max_value()].map(f64::from);
    }
    within(min, max).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], voxel| {
        let value = grid.value(IndexPoint::from_xyz(voxel.as_dvec3()));
        [low.min(value), high.max(value)]
    })
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
