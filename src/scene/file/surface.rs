//! `[[surface]]`.

use glam::{DAffine3, DVec3};

use super::{ColorSection, PLACEMENT, color_or_texture, placement};
use crate::error::Result;
use crate::math::Rgb;
use crate::scene::reader::{FileReference, Place, Range, Section, Value};

/// One `[[surface]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceSection {
    /// Where the table stands.
    pub at: Place,
    /// `shape` with its keys.
    pub shape: ShapeSection,
    /// `material`; without one a mesh has its own, everything else is diffuse, 0.5.
    pub material: Option<MaterialSection>,
    /// `emission`: radiance in W/(m² sr).
    pub emission: Option<Rgb>,
    /// `translate`, `rotate`, `scale`.
    pub placement: DAffine3,
}

/// The shape of a surface before placement, in metres.
#[derive(Debug, Clone, PartialEq)]
pub enum ShapeSection {
    /// A sphere.
    Sphere {
        /// Its centre.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A parallelogram.
    Quad {
        /// Its centre.
        center: DVec3,
        /// Half of one side.
        u: DVec3,
        /// Half of the other side.
        v: DVec3,
    },
    /// A box along the axes.
    Box {
        /// Smallest coordinates.
        min: DVec3,
        /// Largest coordinates.
        max: DVec3,
    },
    /// An endless plane.
    Plane {
        /// A point on it.
        point: DVec3,
        /// Its normal, of any length.
        normal: DVec3,
    },
    /// A mesh file.
    Mesh(FileReference),
}

/// What a surface does with light.
#[derive(Debug, Clone, PartialEq)]
pub enum MaterialSection {
    /// Reflects evenly.
    Diffuse {
        /// Part reflected, in [0, 1].
        reflectance: ColorSection,
    },
    /// Reflects like a mirror.
    Mirror {
        /// Part reflected, in [0, 1].
        reflectance: Rgb,
    },
    /// Reflects and refracts.
    Glass {
        /// Index of refraction, from 1 to 10.
        ior: f64,
        /// Part of the refracted light that gets through each face, in [0, 1].
        tint: Rgb,
    },
}

#[derive(Clone, Copy)]
enum Kind {
    Sphere,
    Quad,
    Box,
    Plane,
    Mesh,
}

const IOR: Range = Range::new(|n| (1.0..=10.0).contains(&n), "an index of refraction from 1 to 10");

pub(super) fn read(section: &Section<'_>) -> Result<SurfaceSection> {
    let kinds = [
        ("sphere", Kind::Sphere),
        ("quad", Kind::Quad),
        ("box", Kind::Box),
        ("plane", Kind::Plane),
        ("mesh", Kind::Mesh),
    ];
    let list = "\"sphere\", \"quad\", \"box\", \"plane\" or \"mesh\"";
    let kind = section.require("shape", list)?.word(&kinds)?;
    let (what, own): (&str, &[&str]) = match kind {
        Kind::Sphere => ("a sphere", &["center", "radius"]),
        Kind::Quad => ("a quad", &["center", "u", "v"]),
        Kind::Box => ("a box", &["min", "max"]),
        Kind::Plane => ("a plane", &["point", "normal"]),
        Kind::Mesh => ("a mesh", &["file"]),
    };
    section.only(what, &[&["shape"], own, &["material", "emission"], &PLACEMENT[..]].concat())?;
    let emission = section.maybe("emission", |v| {
        if matches!(kind, Kind::Sphere | Kind::Box | Kind::Plane) {
            return Err(v.error(format!(
                "{what} cannot give off light; give emission to a quad or a mesh"
            )));
        }
        v.color(Range::NOT_NEGATIVE)
    })?;
    Ok(SurfaceSection {
        at: section.place(),
        shape: shape(section, kind)?,
        material: section.maybe("material", |v| material(&v))?,
        emission,
        placement: placement(section)?,
    })
}

fn shape(section: &Section<'_>, kind: Kind) -> Result<ShapeSection> {
    let center =
        |section: &Section<'_>| section.or("center", DVec3::ZERO, |v| v.triple(Range::ANY));
    Ok(match kind {
        Kind::Sphere => ShapeSection::Sphere {
            center: center(section)?,
            radius: section.require("radius", "a radius in metres")?.number(Range::POSITIVE)?,
        },
        Kind::Quad => {
            let [u, v] = half_sides(section)?;
            ShapeSection::Quad { center: center(section)?, u, v }
        }
        Kind::Box => {
            let (min, max) = corners(section)?;
            ShapeSection::Box { min, max }
        }
        Kind::Plane => ShapeSection::Plane {
            point: section.or("point", DVec3::ZERO, |v| v.triple(Range::ANY))?,
            normal: section.or("normal", DVec3::Y, |v| v.direction())?,
        },
        Kind::Mesh => {
            let right = "a mesh (.obj, .ply, .gltf, .glb)";
            ShapeSection::Mesh(section.require("file", right)?.file(right)?)
        }
    })
}

/// `u` and `v`: half sides of a quad, which must span an area.
pub(super) fn half_sides(section: &Section<'_>) -> Result<[DVec3; 2]> {
    let u = section.require("u", "half of one side, [x, y, z] in metres")?.direction()?;
    let value = section.require("v", "half of the other side, [x, y, z] in metres")?;
    let v = value.direction()?;
    let flat = u.normalize().cross(v.normalize()).length() < 1e-9;
    if flat || !u.cross(v).length().is_normal() {
        return Err(value.wrong("a vector that spans an area together with u"));
    }
    Ok([u, v])
}

/// `min` and `max` of a box, each side longer than 0.
pub(super) fn corners(section: &Section<'_>) -> Result<(DVec3, DVec3)> {
    let min = section.require("min", "the smallest corner, [x, y, z]")?.triple(Range::ANY)?;
    let value = section.require("max", "the largest corner, [x, y, z]")?;
    let max = value.triple(Range::ANY)?;
    if !max.cmpgt(min).all() {
        return Err(value.wrong("a corner above `min` in x, y and z"));
    }
    Ok((min, max))
}

#[derive(Clone, Copy)]
enum MaterialKind {
    Diffuse,
    Mirror,
    Glass,
}

fn material(value: &Value<'_>) -> Result<MaterialSection> {
    let section = value.table("{ type = \"diffuse\", reflectance = 0.5 }")?;
    let list = "\"diffuse\", \"mirror\" or \"glass\"";
    let kind = section.require("type", list)?.word(&[
        ("diffuse", MaterialKind::Diffuse),
        ("mirror", MaterialKind::Mirror),
        ("glass", MaterialKind::Glass),
    ])?;
    match kind {
        MaterialKind::Diffuse => {
            section.only("a diffuse material", &["type", "reflectance"])?;
            let grey = ColorSection::Constant(Rgb::splat(0.5));
            let reflectance =
                section.or("reflectance", grey, |v| color_or_texture(&v, Range::UNIT))?;
            Ok(MaterialSection::Diffuse { reflectance })
        }
        MaterialKind::Mirror => {
            section.only("a mirror", &["type", "reflectance"])?;
            let reflectance = section.or("reflectance", Rgb::ONE, |v| v.color(Range::UNIT))?;
            Ok(MaterialSection::Mirror { reflectance })
        }
        MaterialKind::Glass => {
            section.only("glass", &["type", "ior", "tint"])?;
            Ok(MaterialSection::Glass {
                ior: section.or("ior", 1.5, |v| v.number(IOR))?,
                tint: section.or("tint", Rgb::ONE, |v| v.color(Range::UNIT))?,
            })
        }
    }
}
