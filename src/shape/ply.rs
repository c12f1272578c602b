//! PLY, ascii and binary, through ply-rs-bw.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{DefaultElement, Property, PropertyAccess, PropertyAccessResult};

use super::MeshData;
use super::parsed::{Parsed, fan};
use super::ply_write::PART;

pub(super) fn read(path: &Path) -> Result<Parsed, String> {
    // The crate dumps the parser's state and the file's bytes behind the first line.
    let broken = |e: String| {
        let problem = e.lines().next().unwrap_or_default();
        format!("is no PLY file that can be read: {}", problem.escape_debug())
    };
    let file = File::open(path).map_err(|e| format!("cannot be read: {e}"))?;
    let length = file.metadata().map_err(|e| format!("cannot be read: {e}"))?.len();
    let mut reader = Reader::new(BufReader::new(file));
    let header = Parser::<DefaultElement>::new()
        .read_header(&mut reader)
        .map_err(|e| broken(e.to_string()))?;
    let (mut vertices, mut faces) = (Vec::<Vertex>::new(), Vec::<Face>::new());
    for (name, element) in &header.elements {
        // An element without properties has no bytes, however many there are.
        if element.count as u64 > length {
            return Err(format!(
                "claims {} elements {name:?} in {length} bytes; it is damaged",
                element.count
            ));
        }
        let problem = match name.as_str() {
            "vertex" => Parser::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|list| vertices = list),
            "face" => Parser::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(|list| faces = list),
            _ => Parser::<Skipped>::new()
                .read_payload_for_element(&mut reader, element, &header)
                .map(drop),
        };
        problem.map_err(|e| broken(e.to_string()))?;
    }
    let has = |property: &str| {
        header.elements.get("vertex").is_some_and(|v| v.properties.contains_key(property))
    };
    let mut data =
        MeshData { positions: vertices.iter().map(|v| v.position).collect(), ..Default::default() };
    if has("nx") && has("ny") && has("nz") {
        data.normals = vertices.iter().map(|v| v.normal).collect();
    }
    if has("s") || has("u") || has("texture_u") {
        data.uvs = vertices.iter().map(|v| v.uv).collect();
    }
    for (index, face) in faces.iter().enumerate() {
        let corners: Option<Vec<u32>> =
            face.corners.iter().map(|i| u32::try_from(*i).ok()).collect();
        let Some(corners) = corners else {
            return Err(format!("face {index} has a vertex index below 0: {:?}", face.corners));
        };
        data.triangles.extend(fan(&corners));
    }
    if data.triangles.len() == faces.len() {
        data.parts = header.comments.iter().filter_map(|comment| part(comment)).collect();
    }
    Ok(Parsed { data, materials: Vec::new(), beside: Vec::new() })
}

/// The part that a `comment` of fogbow names: its first face and its name.
fn part(comment: &str) -> Option<(u32, String)> {
    let (first, name) = comment.strip_prefix(PART)?.split_once(' ')?;
    Some((first.parse().ok()?, name.to_owned()))
}

#[derive(Debug, Default)]
struct Vertex {
    position: DVec3,
    normal: Vec3,
    uv: Vec2,
}

#[derive(Debug, Default)]
struct Face {
    corners: Vec<i64>,
}

struct Skipped;

/// A scalar of any type.
fn scalar(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

/// A list of integers of any type.
fn integers(property: Property) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
        list.into_iter().map(Into::into).collect()
    }
    Some(match property {
        Property::ListChar(x) => wide(x),
        Property::ListUChar(x) => wide(x),
        Property::ListShort(x) => wide(x),
        Property::ListUShort(x) => wide(x),
        Property::ListInt(x) => wide(x),
        Property::ListUInt(x) => wide(x),
        _ => return None,
    })
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let known = ["x", "y", "z", "nx", "ny", "nz", "s", "t", "u", "v", "texture_u", "texture_v"];
        if !known.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        let Some(value) = scalar(&property) else { return PropertyAccessResult::UnsupportedType };
        match name {
            "x" => self.position.x = value,
            "y" => self.position.y = value,
            "z" => self.position.z = value,
            "nx" => self.normal.x = value as f32,
            "ny" => self.normal.y = value as f32,
            "nz" => self.normal.z = value as f32,
            "s" | "u" | "texture_u" => self.uv.x = value as f32,
            _ => self.uv.y = value as f32,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if name != "vertex_indices" && name != "vertex_index" {
            return PropertyAccessResult::Ignored;
        }
        integers(property).map_or(PropertyAccessResult::UnsupportedType, |corners| {
            self.corners = corners;
            PropertyAccessResult::Set
        })
    }
}

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }

    fn set_property(&mut self, _: &str, _: Property) -> PropertyAccessResult {
        PropertyAccessResult::Ignored
    }
}
