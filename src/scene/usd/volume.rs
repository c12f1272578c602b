//! Volumes of a shot (UsdVol) as media.

use std::path::PathBuf;

use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use openusd::sdf;
use toml::Value;

use super::shading::{Given, Shading};
use super::shot::Files;
use super::values::{Reader, held};
use super::walk::{Placed, StageSpace, transform};
use crate::error::Result;
use crate::scene::draft::{Draft, exact};
use crate::scene::keys::{medium as keys, surface as placement};
use crate::vdb::roles::{Role, role_of};

/// Largest cosine between axes of a placement that counts as none: numbers of files have 24 bits.
const MAX_SHEAR: f64 = 1e-4;

/// A field of a volume: a grid of VDB files.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    /// What the volume calls it.
    pub(super) role: String,
    /// The grid's name.
    pub(super) grid: Option<String>,
    /// Which of several grids of that name.
    pub(super) index: Option<i64>,
    /// Its files by the time code from which each holds.
    pub(super) files: Vec<(f64, PathBuf)>,
    /// From the space of the grid, as its file places it, to the world.
    to_world: DAffine3,
}

/// A volume: its fields, and how it is shaded.
#[derive(Debug, Clone)]
pub(super) struct Volume {
    pub(super) path: String,
    pub(super) fields: Vec<Field>,
    pub(super) shading: Option<Given>,
    to_world: DAffine3,
    /// Which of the fields is the density.
    pub(super) density: usize,
}

impl Volume {
    /// The volume that `placed` is, on a stage of this `space`; nothing, with a warning, where it has no field that can be
    /// taken.
    pub(super) fn read(
        reader: &Reader<'_>,
        placed: &Placed,
        space: &StageSpace,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Self>> {
        let path = &placed.path;
        let mut fields: Vec<Field> = Vec::new();
        for name in reader.properties(path)? {
            let Some(role) = name.strip_prefix("field:") else { continue };
            let Some(field) = reader.targets(path, &name)?.into_iter().next() else { continue };
            let kind = reader.type_of(&field)?;
            if kind != "OpenVDBAsset" {
                let said = format!("{name}: a {kind} is left out; give an OpenVDBAsset");
                warnings.push(reader.wrong(path, said).to_string());
                continue;
            }
            // A field of another prim is in the space of the volume.
            let to_world = if field.parent().as_ref() == Some(path) {
                transform(reader, &field, [space.to_world, placed.to_world])?
            } else {
                placed.to_world
            };
            fields.push(read_field(reader, role, &field, to_world)?);
        }
        fields.sort_by(|a, b| a.role.cmp(&b.role));
        let shading = match &placed.material {
            Some(material) => Given::read(reader, material, space.metres)?,
            None => None,
        };
        let asked = shading.as_ref().and_then(|shading| shading.density_grid.clone());
        let density = fields.iter().position(|field| match &asked {
            Some(name) => field.role == *name || field.grid.as_ref() == Some(name),
            None => is_density(field),
        });
        let density = density.or_else(|| (fields.len() == 1).then_some(0));
        let Some(density) = density else {
            let names: Vec<_> = fields.iter().map(|field| field.role.as_str()).collect();
            let said =
                format!("has no field of density among `{}`; it is left out", names.join("`, `"));
            warnings.push(reader.wrong(path, said).to_string());
            return Ok(None);
        };
        let to_world = fields[density].to_world;
        for field in fields.iter().filter(|field| !field.to_world.abs_diff_eq(to_world, MAX_SHEAR))
        {
            let said = format!(
                "field:{} has another transform than field:{}; it is placed as that is",
                field.role, fields[density].role
            );
            warnings.push(reader.wrong(path, said).to_string());
        }
        let path = path.as_str().to_owned();
        Ok(Some(Self { path, fields, shading, to_world, density }))
    }

    /// The files that it has at `time`, each once.
    pub(super) fn files(&self, time: f64) -> Vec<PathBuf> {
        let mut files: Vec<_> =
            self.fields.iter().filter_map(|field| held(&field.files, time).cloned()).collect();
        files.dedup();
        files
    }

    /// Metres that one of its own units is long, by its volume.
    pub(super) fn scale(&self) -> f64 {
        self.to_world.matrix3.determinant().abs().cbrt()
    }

    /// Writes its medium at `reader`'s time, shaded as it says itself.
    ///
    /// # Errors
    /// Where its placement is sheared.
    pub(super) fn write(
        &self,
        reader: &Reader<'_>,
        shading: &Shading,
        draft: &mut Draft,
        files: &mut Files,
    ) -> Result<()> {
        let path = sdf::Path::new(&self.path).unwrap_or_else(|_| sdf::Path::abs_root());
        let field = &self.fields[self.density];
        let Some(file) = held(&field.files, reader.time) else { return Ok(()) };
        let file = files.asset(file.clone());
        draft
            .listed("medium", &format!("{}: volume", self.path))
            .key(&keys::NAME, self.path.as_str())
            .key(&keys::FILE, file.as_str());
        if let Some(grid) = &field.grid {
            draft.key(&keys::GRID, grid.as_str());
        }
        if let Some(index) = field.index {
            draft.key(&keys::INDEX, Value::Integer(index));
        }
        let named = |name: &str| {
            let field =
                self.fields.iter().find(|f| f.role == name || f.grid.as_deref() == Some(name));
            let field = field.or_else(|| self.fields.iter().find(|f| plays(f, name)))?;
            let file = held(&field.files, reader.time)?;
            Some((field.grid.clone().unwrap_or_else(|| field.role.clone()), file.clone()))
        };
        shading.write(draft, files, &file, &named);
        let Placement { translate, rotate, scale } =
            Placement::of(&self.to_world).map_err(|problem| reader.wrong(&path, problem))?;
        draft
            .key(&placement::TRANSLATE, exact(translate))
            .key(&placement::ROTATE, exact(rotate))
            .key(&placement::SCALE, exact(scale));
        Ok(())
    }
}

/// Whether the field is a density by one of its names.
fn is_density(field: &Field) -> bool {
    let names = [Some(field.role.as_str()), field.grid.as_deref()];
    names.into_iter().flatten().any(|n| matches!(role_of(n), Some((Role::Density, _))))
}

/// Whether the field plays the same role as grids called `name`.
fn plays(field: &Field, name: &str) -> bool {
    let role = |name: &str| role_of(name).map(|(role, _)| role);
    let wanted = role(name);
    wanted.is_some()
        && [Some(field.role.as_str()), field.grid.as_deref()]
            .into_iter()
            .flatten()
            .any(|name| role(name) == wanted)
}

fn read_field(
    reader: &Reader<'_>,
    role: &str,
    field: &sdf::Path,
    to_world: DAffine3,
) -> Result<Field> {
    let files = reader.assets(field, "filePath")?;
    if files.is_empty() {
        return Err(reader.wrong(field, "has no filePath; give the path of a VDB file"));
    }
    Ok(Field {
        role: role.into(),
        grid: reader.word(field, "fieldName")?.filter(|name| !name.is_empty()),
        index: reader.number(field, "fieldIndex")?.filter(|i| *i > 0.0).map(|i| i as i64),
        files,
        to_world,
    })
}

/// The keys of a placement: scaled, turned about x, y and z, moved.
struct Placement {
    translate: DVec3,
    /// In degrees.
    rotate: DVec3,
    scale: DVec3,
}

impl Placement {
    fn of(to_world: &DAffine3) -> Result<Self, String> {
        let matrix = to_world.matrix3;
        let mut scale = DVec3::from([0, 1, 2].map(|axis| matrix.col(axis).length()));
        if scale.min_element() <= 0.0 {
            return Err("its transform is singular; give a scale other than 0".into());
        }
        if matrix.determinant() < 0.0 {
            scale.x = -scale.x;
        }
        let turn = DMat3::from_cols(
            matrix.col(0) / scale.x,
            matrix.col(1) / scale.y,
            matrix.col(2) / scale.z,
        );
        let shear = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| turn.col(a).dot(turn.col(b)).abs());
        if shear.iter().any(|cosine| *cosine > MAX_SHEAR) {
            return Err(
                "its transform shears it, which media cannot be; scale it along its own axes"
                    .into(),
            );
        }
        let (z, y, x) = DQuat::from_mat3(&turn).to_euler(EulerRot::ZYX);
        let rotate = DVec3::new(x, y, z).map(f64::to_degrees);
        Ok(Self { translate: to_world.translation, rotate, scale })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placements_are_those_of_their_keys() {
        let turned = DMat3::from_quat(DQuat::from_euler(EulerRot::ZYX, 0.4, -1.1, 2.0));
        for scale in [DVec3::ONE, DVec3::new(0.5, 2.0, 3.0), DVec3::new(-1.0, 1.0, 4.0)] {
            let to_world =
                DAffine3::from_mat3_translation(turned * DMat3::from_diagonal(scale), DVec3::X);
            let Placement { translate, rotate, scale } = Placement::of(&to_world).unwrap();
            let [x, y, z] = rotate.map(f64::to_radians).to_array();
            let turn = DMat3::from_quat(DQuat::from_euler(EulerRot::ZYX, z, y, x));
            let again =
                DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), translate);
            assert!(again.abs_diff_eq(to_world, 1e-12), "{scale}");
        }
        let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
        assert!(Placement::of(&DAffine3::from_mat3(sheared)).is_err());
    }
}
