//! `[[surface]]`.

use glam::{DAffine3, DVec3};

use super::motion::{self, MotionStep};
use super::{ColorSection, color_or_texture, group, placement};
use crate::error::Result;
use crate::math::Rgb;
use crate::scene::groups::GroupName;
use crate::scene::keys::surface as keys;
use crate::scene::objects::ObjectName;
use crate::scene::reader::{FileReference, Place, Range, Section, Value};
use crate::surface::CameraView;

/// One `[[surface]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceSection {
    /// Where the table stands.
    pub at: Place,
    /// `name`, or what it is called in pictures without one.
    pub object: ObjectName,
    /// `shape` with its keys.
    pub shape: ShapeSection,
    /// `material`; without one a mesh has its own, everything else is diffuse, 0.5.
    pub material: Option<MaterialSection>,
    /// `emission`: radiance in W/(m² sr).
    pub emission: Option<Rgb>,
    /// `group`: the group of its emission.
    pub group: Option<GroupName>,
    /// `visible`, `holdout`, `shadow_catcher`: how the camera sees it.
    pub view: CameraView,
    /// `translate`, `rotate`, `scale`.
    pub placement: DAffine3,
    /// `motion`.
    pub motion: Option<MotionStep>,
    /// `next_file`: of a mesh, the file one frame later.
    pub next_file: Option<FileReference>,
}

impl SurfaceSection {
    /// Whether it, or its vertices, are elsewhere at other times.
    pub const fn moves(&self) -> bool {
        self.motion.is_some() || self.next_file.is_some()
    }
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
    /// A diffuse base under a rough dielectric coat.
    Plastic {
        /// Part that the base reflects, in [0, 1].
        reflectance: ColorSection,
        /// Square root of the width of the slopes of facets.
        roughness: f64,
        /// Index of refraction, from 1.01 to 10.
        ior: f64,
    },
    /// A rough metal.
    Metal {
        /// Part reflected at normal incidence, in [0, 1].
        reflectance: ColorSection,
        /// Square root of the width of the slopes of facets.
        roughness: f64,
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

const KINDS: &[(&str, Kind)] = &[
    ("sphere", Kind::Sphere),
    ("quad", Kind::Quad),
    ("box", Kind::Box),
    ("plane", Kind::Plane),
    ("mesh", Kind::Mesh),
];

pub(super) fn read(section: &Section<'_>) -> Result<SurfaceSection> {
    let kind = section.word(&keys::SHAPE, KINDS)?;
    let table = match kind {
        Kind::Sphere => &keys::SPHERE,
        Kind::Quad => &keys::QUAD,
        Kind::Box => &keys::BOX,
        Kind::Plane => &keys::PLANE,
        Kind::Mesh => &keys::MESH,
    };
    section.only(table)?;
    let emission = section.maybe(&keys::EMISSION, |v| {
        if matches!(kind, Kind::Sphere | Kind::Box | Kind::Plane) {
            let what = table.what;
            return Err(v.error(format!(
                "{what} cannot give off light; give emission to a quad or a mesh"
            )));
        }
        v.color(Range::NOT_NEGATIVE)
    })?;
    let material = section.maybe(&keys::MATERIAL, material)?;
    let shape = shape(section, kind)?;
    let name = section.maybe_text(&keys::NAME)?;
    let (file, kind) = match kind {
        Kind::Mesh => (section.maybe_text(&keys::MESH_FILE)?, "mesh"),
        Kind::Sphere => (None, "sphere"),
        Kind::Quad => (None, "quad"),
        Kind::Box => (None, "box"),
        Kind::Plane => (None, "plane"),
    };
    Ok(SurfaceSection {
        at: section.place(),
        object: ObjectName::new(name, file.as_deref(), kind),
        shape,
        view: view(section, material.as_ref(), emission)?,
        material,
        emission,
        group: group(section)?,
        placement: placement(section)?,
        motion: motion::step(section)?,
        next_file: match section.get(&keys::NEXT_FILE) {
            Some(value) => value.next_file(&keys::NEXT_FILE.kind.right())?,
            None => None,
        },
    })
}

/// How the camera sees a surface of this material and emission.
fn view(
    section: &Section<'_>,
    material: Option<&MaterialSection>,
    emission: Option<Rgb>,
) -> Result<CameraView> {
    let keys = [
        (&keys::VISIBLE, false, CameraView::Hidden),
        (&keys::HOLDOUT, true, CameraView::Holdout),
        (&keys::SHADOW_CATCHER, true, CameraView::ShadowCatcher),
    ];
    let mut given = None;
    for (key, value, view) in keys {
        if section.switch(key)? != value {
            continue;
        }
        let told = format!("`{} = {value}`", key.name);
        if let Some((other, _)) = &given {
            let value = section.require(key)?;
            return Err(
                value.error(format!("{other} and {told} exclude each other; give one of them"))
            );
        }
        given = Some((told, view));
    }
    let view = given.map_or(CameraView::Seen, |(_, view)| view);
    if view == CameraView::ShadowCatcher {
        if !matches!(material, None | Some(MaterialSection::Diffuse { .. })) {
            let value = section.require(&keys::MATERIAL)?;
            return Err(value.error(
                "shadows are caught on a diffuse surface alone; give a diffuse material, or leave out `shadow_catcher`",
            ));
        }
        if emission.is_some_and(|radiance| radiance != Rgb::ZERO) {
            let value = section.require(&keys::EMISSION)?;
            return Err(value.error(
                "a surface that gives off light catches no shadows; leave out `emission` or `shadow_catcher`",
            ));
        }
    }
    Ok(view)
}

fn shape(section: &Section<'_>, kind: Kind) -> Result<ShapeSection> {
    Ok(match kind {
        Kind::Sphere => ShapeSection::Sphere {
            center: section.triple(&keys::CENTER)?,
            radius: section.number(&keys::RADIUS)?,
        },
        Kind::Quad => {
            let [u, v] = half_sides(section)?;
            ShapeSection::Quad { center: section.triple(&keys::CENTER)?, u, v }
        }
        Kind::Box => {
            let (min, max) = corners(section)?;
            ShapeSection::Box { min, max }
        }
        Kind::Plane => ShapeSection::Plane {
            point: section.triple(&keys::POINT)?,
            normal: section.triple(&keys::NORMAL)?,
        },
        Kind::Mesh => ShapeSection::Mesh(section.file(&keys::MESH_FILE)?),
    })
}

/// `u` and `v`: half sides of a quad, which must span an area.
pub(super) fn half_sides(section: &Section<'_>) -> Result<[DVec3; 2]> {
    let (u, v) = (section.triple(&keys::U)?, section.triple(&keys::V)?);
    let flat = u.normalize().cross(v.normalize()).length() < 1e-9;
    if flat || !u.cross(v).length().is_normal() {
        let value = section.require(&keys::V)?;
        return Err(value.wrong("a vector that spans an area together with u"));
    }
    Ok([u, v])
}

/// `min` and `max` of a box, each side longer than 0.
pub(super) fn corners(section: &Section<'_>) -> Result<(DVec3, DVec3)> {
    let (min, max) = (section.triple(&keys::BOX_MIN)?, section.triple(&keys::BOX_MAX)?);
    if !max.cmpgt(min).all() {
        let value = section.require(&keys::BOX_MAX)?;
        return Err(value.wrong("a corner above `min` in x, y and z"));
    }
    Ok((min, max))
}

#[derive(Clone, Copy)]
enum MaterialKind {
    Diffuse,
    Plastic,
    Metal,
    Mirror,
    Glass,
}

const MATERIALS: &[(&str, MaterialKind)] = &[
    ("diffuse", MaterialKind::Diffuse),
    ("plastic", MaterialKind::Plastic),
    ("metal", MaterialKind::Metal),
    ("mirror", MaterialKind::Mirror),
    ("glass", MaterialKind::Glass),
];

fn material(value: &Value<'_>) -> Result<MaterialSection> {
    let section = Section::from_value(value, &keys::MATERIAL.kind.right())?;
    match section.word(&keys::MATERIAL_TYPE, MATERIALS)? {
        MaterialKind::Diffuse => {
            section.only(&keys::DIFFUSE)?;
            let reflectance =
                section.read(&keys::REFLECTANCE, |v| color_or_texture(v, Range::UNIT))?;
            Ok(MaterialSection::Diffuse { reflectance })
        }
        MaterialKind::Plastic => {
            section.only(&keys::PLASTIC)?;
            Ok(MaterialSection::Plastic {
                reflectance: section
                    .read(&keys::REFLECTANCE, |v| color_or_texture(v, Range::UNIT))?,
                roughness: section.number(&keys::ROUGHNESS)?,
                ior: section.number(&keys::COAT_IOR)?,
            })
        }
        MaterialKind::Metal => {
            section.only(&keys::METAL)?;
            Ok(MaterialSection::Metal {
                reflectance: section
                    .read(&keys::METAL_REFLECTANCE, |v| color_or_texture(v, Range::UNIT))?,
                roughness: section.number(&keys::ROUGHNESS)?,
            })
        }
        MaterialKind::Mirror => {
            section.only(&keys::MIRROR)?;
            let reflectance = section.splat(&keys::MIRROR_REFLECTANCE)?;
            Ok(MaterialSection::Mirror { reflectance })
        }
        MaterialKind::Glass => {
            section.only(&keys::GLASS)?;
            Ok(MaterialSection::Glass {
                ior: section.number(&keys::IOR)?,
                tint: section.splat(&keys::TINT)?,
            })
        }
    }
}
