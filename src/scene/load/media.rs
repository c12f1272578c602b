//! `[[medium]]` tables become media.

use std::sync::Arc;

use glam::DAffine3;

use super::context::{Context, at};
use super::grids::{self, colors};
use super::surfaces;
use crate::error::Result;
use crate::math::{Rgb, WorldPoint, is_grey};
use crate::medium::blackbody::Blackbody;
use crate::medium::{Albedo, Density, Emission, Medium, Phase, Ramped, Transfer};
use crate::scene::camera::Camera;
use crate::scene::file::{
    AlbedoSection, DensitySection, EmissionSection, MediumSection, PhaseSection, RegionSection,
    SceneFile, TransferSection,
};
use crate::scene::reader::Place;
use crate::shape::{ClosedMesh, Cuboid, Region, Sphere};
use crate::surface::Surfaces;

/// The medium of `section`, its grids read.
pub(super) fn build(section: &MediumSection, context: &mut Context) -> Result<Medium> {
    let placement = &section.placement;
    Ok(Medium {
        density: density(section, context)?,
        sigma_t: section.sigma_t,
        albedo: albedo(&section.albedo, placement, context)?,
        phase: at(&section.at, phase(section.phase))?,
        emission: match &section.emission {
            Some(emission) => Some(build_emission(emission, placement, context)?),
            None => None,
        },
    })
}

/// `medium` with free paths that are resolved where it is, for this `camera`.
pub(super) fn resolved(medium: Medium, camera: &Camera) -> Medium {
    let coordinate = largest_coordinate(&medium, camera);
    medium.resolved(coordinate)
}

/// The largest number by which places in `medium` are reckoned, in metres: a coordinate, or a distance from the camera.
fn largest_coordinate(medium: &Medium, camera: &Camera) -> f64 {
    let corners = medium.density.bounds().map(|bounds| bounds.corners());
    let of_corner = |corner: WorldPoint| {
        let distance = camera.place().map_or(0.0, |place| (corner - place).length());
        distance.max(corner.xyz.abs().max_element())
    };
    corners.into_iter().flatten().map(of_corner).fold(0.0, f64::max)
}

fn density(section: &MediumSection, context: &mut Context) -> Result<Density> {
    match &section.density {
        DensitySection::Grid { grid, level_set_as_fog, transfer } => {
            let grid = grids::density(grid, *level_set_as_fog, &section.placement, context)?;
            Ok(match transfer {
                Some(transfer) => Density::Ramped(Ramped::new(grid, scalar(transfer)?)),
                None => Density::Voxel(grid),
            })
        }
        DensitySection::Region(region) => {
            build_region(region, &section.at, &section.placement, context).map(Density::Homogeneous)
        }
    }
}

/// The transfer function to numbers that `section` is.
fn scalar(section: &TransferSection) -> Result<Transfer<f64>> {
    if section.stops.is_empty() {
        return at(&section.at, Transfer::remapped(section.remap));
    }
    if section.stops.iter().any(|(_, value)| !is_grey(*value)) {
        return Err(section.at.error("a colour where a number is meant; give [place, number]"));
    }
    let stops: Vec<_> = section.stops.iter().map(|(place, value)| (*place, value.x)).collect();
    at(&section.at, Transfer::new(section.remap, &stops))
}

fn build_region(
    region: &RegionSection,
    place: &Place,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Region> {
    Ok(match region {
        RegionSection::Everywhere => Region::Everywhere,
        RegionSection::Box { min, max } => {
            Region::Box(at(place, Cuboid::new(*min, *max, placement))?)
        }
        RegionSection::Sphere { center, radius } => {
            Region::Sphere(at(place, Sphere::new(*center, *radius, placement))?)
        }
        RegionSection::Mesh(file) => {
            let mesh = surfaces::mesh(file, placement, context)?.mesh;
            let closed = ClosedMesh::new(Arc::new(mesh));
            let named = closed.map_err(|problem| format!("{}: {problem}", file.path.display()));
            Region::Mesh(at(&file.at, named)?)
        }
    })
}

fn albedo(section: &AlbedoSection, placement: &DAffine3, context: &mut Context) -> Result<Albedo> {
    match section {
        AlbedoSection::Constant(albedo) => Ok(Albedo::Constant(*albedo)),
        AlbedoSection::Grid { grid, scale, transfer } => {
            grids::albedo(grid, Rgb::splat(*scale), transfer.as_ref(), placement, context)
        }
    }
}

fn phase(section: PhaseSection) -> Result<Phase, String> {
    match section {
        PhaseSection::Isotropic => Ok(Phase::ISOTROPIC),
        PhaseSection::Rayleigh => Ok(Phase::RAYLEIGH),
        PhaseSection::HenyeyGreenstein { g } => Phase::henyey_greenstein(g),
        PhaseSection::TwoLobe { g: [first, second], weight } => {
            Phase::two_lobe(first, second, weight)
        }
        PhaseSection::Fog { diameter } => Phase::fog(diameter),
    }
}

fn build_emission(
    section: &EmissionSection,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<Emission> {
    Ok(match section {
        EmissionSection::Density { color } => Emission::Density(*color),
        EmissionSection::Grid { grid, color, transfer } => {
            let (grid, color) = (grids::values(grid, placement, context)?, *color);
            match transfer {
                Some(transfer) => Emission::Ramped(Ramped::new(grid, colors(transfer, color)?)),
                None => Emission::Grid { grid, color },
            }
        }
        EmissionSection::Temperature { grid, kelvin_scale, kelvin_offset, scale, transfer } => {
            Emission::Blackbody {
                grid: grids::values(grid, placement, context)?,
                ramp: transfer.as_ref().map(scalar).transpose()?,
                kelvin_scale: *kelvin_scale,
                kelvin_offset: *kelvin_offset,
                scale: *scale,
                table: Blackbody::new(),
            }
        }
    })
}

/// Whether camera rays alone need voxels of the media: these scatter no light, and none crosses them to a
/// surface.
pub(super) fn only_camera_rays_need_voxels(file: &SceneFile, surfaces: &Surfaces) -> bool {
    surfaces.is_empty() && file.media.iter().all(|m| m.albedo == AlbedoSection::Constant(Rgb::ZERO))
}
