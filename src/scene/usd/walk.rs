//! Prims in the world: what is inherited, and what instances are of.

use std::collections::HashSet;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use openusd::schemas::geom::{Imageable, Xformable};
use openusd::sdf;
use openusd::usd::{Prim, PrimStatus, SchemaBase, SchemaKind, Stage, TimeCode};

use super::values::Reader;
use crate::error::{Error, Result};

/// Most prims, those of instances counted each time.
const MAX_PRIMS: usize = 20_000_000;
/// Operation that leaves out the transforms of prims above.
const RESETS: &str = "!resetXformStack!";
/// Deepest nesting of point instancers in prototypes.
const MAX_NESTED: u32 = 8;

/// A visible prim in the world.
#[derive(Debug, Clone)]
pub(super) struct Placed {
    pub(super) path: sdf::Path,
    /// Its type.
    pub(super) kind: String,
    /// From its space to the world, in metres.
    pub(super) to_world: DAffine3,
    /// The material that is bound to it or to a prim above it.
    pub(super) material: Option<sdf::Path>,
}

/// What a prim hands to those below it.
#[derive(Debug, Clone)]
struct Inherited {
    path: sdf::Path,
    to_world: DAffine3,
    material: Option<sdf::Path>,
    /// Whether the binding wins over those below.
    material_is_stronger: bool,
    purpose: Purpose,
    /// Point instancers above it.
    nested: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// Not said by any prim above.
    Unset,
    /// To be rendered.
    Rendered,
    /// A stand-in or a helper.
    Other,
}

/// Calls `visit` with every visible prim of the stage that is to be rendered, parents first. `root` takes the
/// stage's space to the world.
///
/// # Errors
/// Where a prim cannot be read, there are too many, or `visit` fails.
pub(super) fn prims(
    reader: &Reader<'_>,
    root: DAffine3,
    visit: &mut dyn FnMut(&Placed) -> Result<()>,
) -> Result<()> {
    let top = Inherited {
        path: sdf::Path::abs_root(),
        to_world: root,
        material: None,
        material_is_stronger: false,
        purpose: Purpose::Unset,
        nested: 0,
    };
    let (mut stack, mut count) = (Vec::new(), 0_usize);
    push_children(reader, &top, &mut stack)?;
    while let Some(parent_and_path) = stack.pop() {
        count += 1;
        if count > MAX_PRIMS {
            return Err(Error::file(
                reader.file,
                format!(
                    "has more than {MAX_PRIMS} prims with those of its instances; export less of it"
                ),
            ));
        }
        let (parent, path): (Inherited, sdf::Path) = parent_and_path;
        let Some((placed, own)) = place(reader, root, &parent, &path)? else { continue };
        if own.purpose != Purpose::Other {
            visit(&placed)?;
        }
        if placed.kind == "PointInstancer" {
            push_instances(reader, &own, &mut stack)?;
        } else {
            push_children(reader, &own, &mut stack)?;
        }
    }
    Ok(())
}

fn push_children(
    reader: &Reader<'_>,
    own: &Inherited,
    stack: &mut Vec<(Inherited, sdf::Path)>,
) -> Result<()> {
    let names = if own.path == sdf::Path::abs_root() {
        reader.stage.root_prims()
    } else {
        reader.stage.prim(own.path.clone()).child_names()
    };
    for name in reader.of(&own.path, names)?.iter().rev() {
        let path = reader.child(&own.path, name.as_str())?;
        stack.push((own.clone(), path));
    }
    Ok(())
}

/// The prim at `path`, and what it hands down; nothing where it is not to be seen.
fn place(
    reader: &Reader<'_>,
    root: DAffine3,
    parent: &Inherited,
    path: &sdf::Path,
) -> Result<Option<(Placed, Inherited)>> {
    let status = reader.of(path, reader.stage.prim_status(path.clone()))?;
    let needed = PrimStatus::ACTIVE | PrimStatus::LOADED | PrimStatus::DEFINED;
    if !status.contains(needed) || status.contains(PrimStatus::ABSTRACT) {
        return Ok(None);
    }
    // Asking for what is not there takes the time of the many prims that have nothing.
    let properties = reader.properties(path)?;
    let has = |name: &str| properties.iter().any(|property| property == name);
    let word = |name| if has(name) { reader.word(path, name) } else { Ok(None) };
    if word("visibility")?.as_deref() == Some("invisible") {
        return Ok(None);
    }
    let purpose = match word("purpose")?.as_deref() {
        None => parent.purpose,
        Some("proxy" | "guide") => Purpose::Other,
        Some(_) => Purpose::Rendered,
    };
    let to_world = if has("xformOpOrder") {
        transform(reader, path, [root, parent.to_world])?
    } else {
        parent.to_world
    };
    let (material, material_is_stronger) = binding(reader, parent, path, &has)?;
    let kind = reader.type_of(path)?;
    let placed = Placed { path: path.clone(), kind, to_world, material: material.clone() };
    let path = path.clone();
    let nested = parent.nested;
    let own = Inherited { path, to_world, material, material_is_stronger, purpose, nested };
    Ok(Some((placed, own)))
}

/// The transform of the prim at `path` from its space to the world, where `root` is that of the stage and `parent` that
/// of the prim above.
///
/// # Errors
/// Where it cannot be read or is not finite.
pub(super) fn transform(
    reader: &Reader<'_>,
    path: &sdf::Path,
    [root, parent]: [DAffine3; 2],
) -> Result<DAffine3> {
    let to_world = match reader.words(path, "xformOpOrder")?.as_slice() {
        [] => parent,
        order => {
            let above = if order[0] == RESETS { root } else { parent };
            above * local_transform(reader, path, order)?
        }
    };
    if to_world.is_finite() {
        return Ok(to_world);
    }
    Err(reader.wrong(path, "its transform is not finite; give other xformOps"))
}

/// The transform of the prim at `path` by its operations, from its space to that of its parent.
fn local_transform(
    reader: &Reader<'_>,
    path: &sdf::Path,
    operations: &[String],
) -> Result<DAffine3> {
    for name in operations {
        let plain = name.trim_start_matches('!');
        if !plain.chars().all(|c| c.is_alphanumeric() || "_:!".contains(c)) {
            return Err(reader.wrong(path, format!("`{name}` in xformOpOrder is no operation")));
        }
    }
    let prim = AnyPrim(reader.stage.prim(path.clone()));
    let local = prim.local_to_parent_transform(TimeCode::new(reader.time));
    // Rows of its matrices are columns here.
    let local = reader.of(path, local)?.into();
    Ok(DAffine3::from_mat4(DMat4::from_cols_array(&local)))
}

/// The material of the prim at `path`, which `has` properties, and whether it wins over those bound below.
fn binding(
    reader: &Reader<'_>,
    parent: &Inherited,
    path: &sdf::Path,
    has: &dyn Fn(&str) -> bool,
) -> Result<(Option<sdf::Path>, bool)> {
    if parent.material_is_stronger {
        return Ok((parent.material.clone(), true));
    }
    for name in ["material:binding:full", "material:binding"].into_iter().filter(|name| has(name)) {
        if let Some(material) = reader.targets(path, name)?.into_iter().next() {
            let strength = reader.strength_of_binding(path, name)?;
            return Ok((Some(material), strength.as_deref() == Some("strongerThanDescendants")));
        }
    }
    Ok((parent.material.clone(), false))
}

/// Puts the prototypes of the point instancer `own` onto the stack, once for each of its points.
fn push_instances(
    reader: &Reader<'_>,
    own: &Inherited,
    stack: &mut Vec<(Inherited, sdf::Path)>,
) -> Result<()> {
    let path = &own.path;
    if own.nested >= MAX_NESTED {
        return Err(reader.wrong(path, "is nested in prototypes too deeply, or in its own"));
    }
    let prototypes = reader.targets(path, "prototypes")?;
    let indices = reader.integers(path, "protoIndices")?;
    let positions = reader.triples(path, "positions")?;
    let scales = reader.triples(path, "scales")?;
    let turns = match reader.rotations(path, "orientationsf")? {
        none if none.is_empty() => reader.rotations(path, "orientations")?,
        turns => turns,
    };
    let hidden: HashSet<i64> = reader.integers(path, "invisibleIds")?.into_iter().collect();
    let ids = reader.integers(path, "ids")?;
    if positions.len() < indices.len() {
        return Err(reader.wrong(
            path,
            format!("has {} protoIndices and {} positions", indices.len(), positions.len()),
        ));
    }
    for (point, index) in indices.iter().enumerate().rev() {
        let id = ids.get(point).copied().unwrap_or(point as i64);
        if hidden.contains(&id) {
            continue;
        }
        let prototype = usize::try_from(*index).ok().and_then(|index| prototypes.get(index));
        let prototype = prototype.ok_or_else(|| {
            reader.wrong(path, format!("protoIndices[{point}] is {index}, of {}", prototypes.len()))
        })?;
        let turn = turns.get(point).map_or(DQuat::IDENTITY, |q| normalised(DQuat::from_array(*q)));
        let scale = scales.get(point).copied().unwrap_or(DVec3::ONE);
        let placed = DAffine3::from_scale_rotation_translation(scale, turn, positions[point]);
        let to_world = own.to_world * placed;
        let instance = Inherited { to_world, nested: own.nested + 1, ..own.clone() };
        stack.push((instance, prototype.clone()));
    }
    Ok(())
}

/// `turn` at length 1.
fn normalised(turn: DQuat) -> DQuat {
    let length = turn.length();
    if length.is_normal() { turn * (1.0 / length) } else { DQuat::IDENTITY }
}

/// Any prim as one with a transform.
struct AnyPrim(Prim);

impl SchemaBase for AnyPrim {
    const KIND: SchemaKind = SchemaKind::AbstractTyped;

    fn prim(&self) -> &Prim {
        &self.0
    }
}

impl Imageable for AnyPrim {}
impl Xformable for AnyPrim {}

/// How the space of a stage lies in the world: metres, y up.
#[derive(Debug, Clone, Copy)]
pub(super) struct StageSpace {
    pub(super) to_world: DAffine3,
    /// Metres in a unit.
    pub(super) metres: f64,
    /// Whether z is upward.
    pub(super) z_up: bool,
}

impl StageSpace {
    /// That of `stage`.
    pub(super) fn of(stage: &Stage) -> Self {
        let metres = match stage.stage_metadata("metersPerUnit") {
            Ok(Some(sdf::Value::Double(metres))) if metres > 0.0 && metres.is_finite() => metres,
            _ => 0.01,
        };
        let axis = stage.stage_metadata("upAxis");
        let z_up = matches!(axis, Ok(Some(axis)) if axis.as_str() == Some("Z"));
        let upright =
            if z_up { DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y) } else { DMat3::IDENTITY };
        Self { to_world: DAffine3::from_mat3(upright * metres), metres, z_up }
    }
}
