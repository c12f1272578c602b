//! `[[medium]]` tables become media.

use std::sync::Arc;

use glam::DAffine3;

use super::{Context, at, surfaces};
use crate::error::Result;
use crate::math::Rgb;
use crate::medium::blackbody::Blackbody;
use crate::medium::{Albedo, Density, Emission, Medium, Phase};
use crate::scene::file::{
    AlbedoSection, DensitySection, EmissionSection, MediumSection, PhaseSection, RegionSection,
};
use crate::scene::reader::Place;
use crate::shape::{ClosedMesh, Cuboid, Region, Sphere};

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

fn density(section: &MediumSection, context: &mut Context) -> Result<Density> {
    match &section.density {
        DensitySection::Grid { grid, level_set_as_fog } => {
            super::grids::density(grid, *level_set_as_fog, &section.placement, context)
                .map(Density::Voxel)
        }
        DensitySection::Region(region) => {
            build_region(region, &section.at, &section.placement, context).map(Density::Homogeneous)
        }
    }
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
        AlbedoSection::Grid { grid, scale } => {
            super::grids::albedo(grid, Rgb::splat(*scale), placement, context)
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
        EmissionSection::Grid { grid, color } => {
            Emission::Grid { grid: super::grids::values(grid, placement, context)?, color: *color }
        }
        EmissionSection::Temperature { grid, kelvin_scale, kelvin_offset, scale } => {
            Emission::Blackbody {
                grid: super::grids::values(grid, placement, context)?,
                ramp: None,
                kelvin_scale: *kelvin_scale,
                kelvin_offset: *kelvin_offset,
                scale: *scale,
                table: Blackbody::new(),
            }
        }
    })
}
