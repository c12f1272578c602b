//! What is seen on a stage, prim by prim.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DAffine3, DVec3};
use openusd::usd::Stage;

use super::camera::Camera;
use super::geometry::Geometry;
use super::light::{self, Lights};
use super::material::Looks;
use super::shot::Files;
use super::values::Reader;
use super::volume::Volume;
use super::walk::{Placed, StageSpace};
use super::{mesh, primitive};
use crate::error::Result;
use crate::scene::draft::Draft;

/// What was seen on a stage.
pub(super) struct Seen {
    pub(super) cameras: Vec<Camera>,
    pub(super) volumes: Vec<Volume>,
    pub(super) geometry: Geometry,
    pub(super) lights: Draft,
    pub(super) looks: Looks,
    pub(super) files: Files,
    pub(super) warnings: Vec<String>,
    /// Prims of types that are left out: the first and how many there are.
    pub(super) unknown: BTreeMap<String, (String, usize)>,
    /// Meshes that are cages of subdivision surfaces.
    pub(super) cages: BTreeSet<String>,
    by_blender: bool,
    space: StageSpace,
}

/// Types of prims that are seen and left out.
const UNKNOWN: [&str; 12] = [
    "BasisCurves",
    "NurbsCurves",
    "HermiteCurves",
    "NurbsPatch",
    "Points",
    "TetMesh",
    "Cylinder",
    "Cone",
    "Capsule",
    "Plane",
    "Cylinder_1",
    "Capsule_1",
];

impl Seen {
    /// Nothing yet of `stage`, which lies in `space`; the scene names its files by `files`.
    pub(super) fn nothing(stage: &Stage, files: Files, space: StageSpace) -> Self {
        Self {
            cameras: Vec::new(),
            volumes: Vec::new(),
            geometry: Geometry::default(),
            lights: Draft::default(),
            looks: Looks::default(),
            files,
            warnings: Vec::new(),
            unknown: BTreeMap::new(),
            cages: BTreeSet::new(),
            by_blender: written_by_blender(stage),
            space,
        }
    }

    /// Adds what `placed` is.
    ///
    /// # Errors
    /// Where it cannot be used.
    pub(super) fn add(&mut self, reader: &Reader<'_>, placed: &Placed) -> Result<()> {
        match placed.kind.as_str() {
            "Camera" => self.cameras.push(Camera::read(reader, placed, self.space.metres)?),
            "Volume" => {
                let read = Volume::read(reader, placed, &self.space, &mut self.warnings)?;
                self.volumes.extend(read);
            }
            "Mesh" => self.add_mesh(reader, placed)?,
            "Sphere" => {
                let radius = reader.number(&placed.path, "radius")?.unwrap_or(1.0);
                self.add_shape(reader, placed, radius, primitive::sphere())?;
            }
            "Cube" => {
                let size = reader.number(&placed.path, "size")?.unwrap_or(2.0);
                self.add_shape(reader, placed, size, primitive::cube())?;
            }
            kind if light::is_light(kind) => {
                let mut lights = Lights {
                    reader,
                    draft: &mut self.lights,
                    files: &mut self.files,
                    geometry: &mut self.geometry,
                    warnings: &mut self.warnings,
                    by_blender: self.by_blender,
                    space: self.space,
                };
                lights.add(placed)?;
            }
            kind if UNKNOWN.contains(&kind) => {
                let path = || (placed.path.as_str().to_owned(), 0);
                self.unknown.entry(kind.into()).or_insert_with(path).1 += 1;
            }
            _ => {}
        }
        Ok(())
    }

    fn add_mesh(&mut self, reader: &Reader<'_>, placed: &Placed) -> Result<()> {
        let (parts, subdivides) = mesh::parts(reader, &placed.path)?;
        if subdivides {
            self.cages.insert(placed.path.as_str().into());
        }
        for part in parts {
            let own = match &part.subset {
                Some(subset) => reader.targets(subset, "material:binding")?.into_iter().next(),
                None => None,
            };
            let material = own.as_ref().or(placed.material.as_ref());
            let look = self.looks.of(reader, &placed.path, material, &mut self.files)?;
            self.geometry.add(placed.path.as_str(), &look, &placed.to_world, part.mesh);
        }
        Ok(())
    }

    fn add_shape(
        &mut self,
        reader: &Reader<'_>,
        placed: &Placed,
        size: f64,
        shape: crate::shape::MeshData,
    ) -> Result<()> {
        let material = placed.material.as_ref();
        let look = self.looks.of(reader, &placed.path, material, &mut self.files)?;
        let to_world = placed.to_world * DAffine3::from_scale(DVec3::splat(size));
        self.geometry.add(placed.path.as_str(), &look, &to_world, shape);
        Ok(())
    }
}

/// Whether Blender wrote the root layer.
fn written_by_blender(stage: &Stage) -> bool {
    let says = |name: &str| {
        let text = stage.stage_metadata(name).ok().flatten();
        text.is_some_and(|text| text.as_str().is_some_and(|text| text.starts_with("Blender ")))
    };
    says("doc") || says("documentation")
}
