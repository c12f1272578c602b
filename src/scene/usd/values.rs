//! Values of attributes at a time.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec2};
use openusd::sdf::{self, Value};
use openusd::usd::{Stage, TimeCode};

use crate::error::{Error, Result};
use crate::scene::reader::one_line;

/// Reads attributes of a stage at one time. Where an attribute has another type than is asked for, the
/// error names file, prim and attribute.
pub(super) struct Reader<'s> {
    pub(super) stage: &'s Stage,
    /// The file as the user named it.
    pub(super) file: &'s Path,
    /// In time codes.
    pub(super) time: f64,
}

impl Reader<'_> {
    /// An error about `prim`.
    pub(super) fn wrong(&self, prim: &sdf::Path, problem: impl std::fmt::Display) -> Error {
        Error::file(self.file, one_line(&format!("{}: {problem}", prim.as_str())))
    }

    /// `result`, its error made one about `prim`.
    pub(super) fn of<T>(
        &self,
        prim: &sdf::Path,
        result: Result<T, impl std::fmt::Display>,
    ) -> Result<T> {
        result.map_err(|e| self.wrong(prim, format!("{e:#}")))
    }

    fn attribute(&self, prim: &sdf::Path, name: &str) -> Result<openusd::usd::Attribute> {
        Ok(self.stage.attribute(self.property(prim, name)?))
    }

    /// The path of a property. The crate looks without end for the prim of a path that has a brace in its name.
    fn property(&self, prim: &sdf::Path, name: &str) -> Result<sdf::Path> {
        if !is_name(name) {
            return Err(self.wrong(prim, format!("`{name}` is no name of a property")));
        }
        self.of(prim, prim.append_property(name))
    }

    /// The path of the child `name` of `prim`.
    pub(super) fn child(&self, prim: &sdf::Path, name: &str) -> Result<sdf::Path> {
        if !is_name(name) {
            return Err(self.wrong(prim, format!("`{name}` is no name of a prim")));
        }
        self.of(prim, prim.append_path(name))
    }

    /// The path that `prim` names.
    fn named(&self, prim: &sdf::Path, path: &sdf::Path) -> Result<sdf::Path> {
        if path.as_str().contains(['{', '}']) {
            return Err(self.wrong(prim, format!("`{}` is no path of a prim", path.as_str())));
        }
        Ok(path.clone())
    }

    /// The list of words; empty where there is none.
    pub(super) fn words(&self, prim: &sdf::Path, name: &str) -> Result<Vec<String>> {
        let list = self.typed(prim, name, "a list of words", |value| match value {
            Value::TokenVec(list) => {
                Some(list.iter().map(|word| word.as_str().to_owned()).collect())
            }
            Value::StringVec(list) => Some(list.clone()),
            _ => None,
        })?;
        Ok(list.unwrap_or_default())
    }

    /// The value, if the attribute has one.
    pub(super) fn value(&self, prim: &sdf::Path, name: &str) -> Result<Option<Value>> {
        let value = self.attribute(prim, name)?.get_at::<Value>(TimeCode::new(self.time));
        let value = self.of(prim, value)?;
        Ok(value.filter(|value| !matches!(value, Value::None | Value::ValueBlock)))
    }

    fn typed<T>(
        &self,
        prim: &sdf::Path,
        name: &str,
        right: &str,
        read: impl FnOnce(&Value) -> Option<T>,
    ) -> Result<Option<T>> {
        let Some(value) = self.value(prim, name)? else { return Ok(None) };
        let read = read(&value);
        let wrong = || self.wrong(prim, format!("{name} is {}; give {right}", kind(&value)));
        read.map(Some).ok_or_else(wrong)
    }

    /// The finite number.
    pub(super) fn number(&self, prim: &sdf::Path, name: &str) -> Result<Option<f64>> {
        let finite = |value: &Value| scalar(value).filter(|number| number.is_finite());
        self.typed(prim, name, "a finite number", finite)
    }

    /// The truth value.
    pub(super) fn flag(&self, prim: &sdf::Path, name: &str) -> Result<bool> {
        let flag = self.typed(prim, name, "true or false", |value| match value {
            Value::Bool(flag) => Some(*flag),
            other => scalar(other).map(|number| number != 0.0),
        })?;
        Ok(flag.unwrap_or(false))
    }

    /// The word: a token or a string.
    pub(super) fn word(&self, prim: &sdf::Path, name: &str) -> Result<Option<String>> {
        self.typed(prim, name, "a word", |value| value.as_str().map(str::to_owned))
    }

    /// The finite colour or vector.
    pub(super) fn triple(&self, prim: &sdf::Path, name: &str) -> Result<Option<DVec3>> {
        let read = |value: &Value| triples(value)?.first().copied().filter(|v| v.is_finite());
        self.typed(prim, name, "three finite numbers", read)
    }

    /// Two finite numbers.
    pub(super) fn numbers(&self, prim: &sdf::Path, name: &str) -> Result<Option<[f64; 2]>> {
        let two = |value: &Value| match value {
            Value::Vec2f(v) => Some([v.x.into(), v.y.into()]),
            Value::Vec2d(v) => Some([v.x, v.y]),
            _ => None,
        };
        let finite = |value: &Value| two(value).filter(|v| v.iter().all(|x| x.is_finite()));
        self.typed(prim, name, "two finite numbers", finite)
    }

    /// Two whole numbers.
    pub(super) fn pair(&self, prim: &sdf::Path, name: &str) -> Result<Option<[i64; 2]>> {
        self.typed(prim, name, "two whole numbers", |value| match value {
            Value::Vec2i(v) => Some([v.x.into(), v.y.into()]),
            _ => None,
        })
    }

    /// The list of whole numbers; empty where there is none.
    pub(super) fn integers(&self, prim: &sdf::Path, name: &str) -> Result<Vec<i64>> {
        let list = self.typed(prim, name, "a list of whole numbers", |value| match value {
            Value::IntVec(list) => Some(list.iter().map(|i| i64::from(*i)).collect()),
            Value::Int64Vec(list) => Some(list.clone()),
            other => is_empty(other).then(Vec::new),
        })?;
        Ok(list.unwrap_or_default())
    }

    /// The list of points, vectors or colours; empty where there is none.
    pub(super) fn triples(&self, prim: &sdf::Path, name: &str) -> Result<Vec<DVec3>> {
        let read = |value: &Value| triples(value).or_else(|| is_empty(value).then(Vec::new));
        Ok(self.typed(prim, name, "a list of three numbers each", read)?.unwrap_or_default())
    }

    /// The list of texture coordinates; empty where there is none.
    pub(super) fn pairs(&self, prim: &sdf::Path, name: &str) -> Result<Vec<Vec2>> {
        let list = self.typed(prim, name, "a list of two numbers each", |value| match value {
            Value::Vec2fVec(list) => Some(list.iter().map(|v| Vec2::new(v.x, v.y)).collect()),
            Value::Vec2dVec(list) => {
                Some(list.iter().map(|v| Vec2::new(v.x as f32, v.y as f32)).collect())
            }
            other => is_empty(other).then(Vec::new),
        })?;
        Ok(list.unwrap_or_default())
    }

    /// The list of rotations as (x, y, z, w); empty where there is none.
    pub(super) fn rotations(&self, prim: &sdf::Path, name: &str) -> Result<Vec<[f64; 4]>> {
        let list = self.typed(prim, name, "a list of rotations", |value| match value {
            Value::QuathVec(list) => Some(
                list.iter().map(|q| [q.x, q.y, q.z, q.w].map(|c| f64::from(c.to_f32()))).collect(),
            ),
            Value::QuatfVec(list) => {
                Some(list.iter().map(|q| [q.x, q.y, q.z, q.w].map(f64::from)).collect())
            }
            Value::QuatdVec(list) => Some(list.iter().map(|q| [q.x, q.y, q.z, q.w]).collect()),
            other => is_empty(other).then(Vec::new),
        })?;
        Ok(list.unwrap_or_default())
    }

    /// How the values of a primvar are spread over the mesh.
    pub(super) fn interpolation(&self, prim: &sdf::Path, name: &str) -> Result<Option<String>> {
        self.metadata(prim, name, "interpolation")
    }

    /// How strong the material binding `name` of `prim` is.
    pub(super) fn strength_of_binding(
        &self,
        prim: &sdf::Path,
        name: &str,
    ) -> Result<Option<String>> {
        self.metadata(prim, name, "bindMaterialAs")
    }

    fn metadata(&self, prim: &sdf::Path, name: &str, key: &str) -> Result<Option<String>> {
        let value = self.of(prim, self.attribute(prim, name)?.get_metadata::<Value>(key))?;
        Ok(value.as_ref().and_then(Value::as_str).map(str::to_owned))
    }

    /// Targets of a relationship.
    pub(super) fn targets(&self, prim: &sdf::Path, name: &str) -> Result<Vec<sdf::Path>> {
        let path = self.property(prim, name)?;
        let targets = self.of(prim, self.stage.relationship(path).targets())?;
        targets.iter().map(|target| self.named(prim, target)).collect()
    }

    /// The prim and the output that an input is connected to.
    pub(super) fn source(&self, prim: &sdf::Path, name: &str) -> Result<Option<sdf::Path>> {
        let found = self.of(prim, self.attribute(prim, name)?.connections())?;
        let found = found.first().map(|path| self.named(prim, path)).transpose()?;
        Ok(found.as_ref().map(sdf::Path::prim_path))
    }

    /// The names of the properties of `prim`.
    pub(super) fn properties(&self, prim: &sdf::Path) -> Result<Vec<String>> {
        let names = self.of(prim, self.stage.prim(prim.clone()).property_names())?;
        Ok(names.iter().map(|name| name.as_str().to_owned()).collect())
    }

    /// The type of `prim`; empty where it has none.
    pub(super) fn type_of(&self, prim: &sdf::Path) -> Result<String> {
        let name = self.of(prim, self.stage.prim(prim.clone()).type_name())?;
        Ok(name.map(|name| name.as_str().to_owned()).unwrap_or_default())
    }

    /// The files that an asset attribute names, by the time from which each holds, in time codes; of a single
    /// one the time does not matter.
    pub(super) fn assets(&self, prim: &sdf::Path, name: &str) -> Result<Vec<(f64, PathBuf)>> {
        let attribute = self.attribute(prim, name)?;
        let samples = self.of(prim, attribute.time_samples())?.unwrap_or_default();
        let layers = self.of(prim, attribute.property_stack())?;
        let anchor = layers.first().map(|(layer, _)| Path::new(layer));
        let folder = anchor.and_then(Path::parent).unwrap_or(Path::new(""));
        let file = |value: &Value| match value {
            Value::AssetPath(asset) => Some(
                asset.resolved_path().map_or_else(|| folder.join(asset.asset_path()), Into::into),
            ),
            other => other.as_str().map(|text| folder.join(text)),
        };
        let mut files: Vec<_> =
            samples.iter().filter_map(|(time, value)| Some((*time, file(value)?))).collect();
        if files.is_empty() {
            let value = self.of(prim, attribute.get::<Value>())?;
            files.extend(value.as_ref().and_then(file).map(|path| (0.0, path)));
        }
        Ok(files)
    }

    /// The file that an asset attribute names at the reader's time.
    pub(super) fn asset(&self, prim: &sdf::Path, name: &str) -> Result<Option<PathBuf>> {
        Ok(held(&self.assets(prim, name)?, self.time).cloned())
    }
}

/// The sample that holds at `time`: the last one not after it, else the first.
pub(super) fn held<T>(samples: &[(f64, T)], time: f64) -> Option<&T> {
    let before = samples.iter().rfind(|(from, _)| *from <= time + TIME_ROUNDING);
    before.or(samples.first()).map(|(_, value)| value)
}

/// Time codes by which a sample may lie after the frame it is for: offsets of layers scale times.
const TIME_ROUNDING: f64 = 1e-6;

/// A number of any type.
fn scalar(value: &Value) -> Option<f64> {
    Some(match value {
        Value::Double(x) => *x,
        Value::Float(x) => f64::from(*x),
        Value::Half(x) => f64::from(x.to_f32()),
        Value::Int(x) => f64::from(*x),
        Value::Uint(x) => f64::from(*x),
        Value::Uchar(x) => f64::from(*x),
        Value::Int64(x) => *x as f64,
        Value::Uint64(x) => *x as f64,
        _ => return None,
    })
}

/// Vectors of any type; a single one counts as a list.
fn triples(value: &Value) -> Option<Vec<DVec3>> {
    let wide = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
    Some(match value {
        Value::Vec3d(v) => vec![DVec3::new(v.x, v.y, v.z)],
        Value::Vec3f(v) => vec![wide([v.x, v.y, v.z])],
        Value::Vec3h(v) => vec![wide([v.x, v.y, v.z].map(half::f16::to_f32))],
        Value::Vec3dVec(list) => list.iter().map(|v| DVec3::new(v.x, v.y, v.z)).collect(),
        Value::Vec3fVec(list) => list.iter().map(|v| wide([v.x, v.y, v.z])).collect(),
        Value::Vec3hVec(list) => {
            list.iter().map(|v| wide([v.x, v.y, v.z].map(half::f16::to_f32))).collect()
        }
        _ => return None,
    })
}

/// Whether `value` is a list without a type, as an empty one in text is.
fn is_empty(value: &Value) -> bool {
    matches!(value, Value::StringVec(list) if list.is_empty())
}

/// Whether `name` can be that of a prim or a property.
fn is_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || "_:-".contains(c))
}

/// The type of `value`, in a word.
fn kind(value: &Value) -> String {
    let text = format!("{value:?}");
    let end = text.find(['(', ' ', '{']).unwrap_or(text.len());
    format!("a {}", text[..end].to_lowercase())
}
