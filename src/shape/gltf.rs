//! glTF 2.0 and GLB, through the gltf crate.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat4, DVec3, Vec2, Vec3};
use gltf::json::validation::Checked;
use gltf::mesh::Mode;

use super::parsed::{Parsed, folder};
use super::{MeshData, MeshMaterial, TextureSource};
use crate::file;

/// How deep nodes may lie in each other: the stack must hold them.
const DEEPEST: usize = 512;

/// The crate panics on some files that its validation lets through or that break the validation
/// itself; such a panic ends here as a problem of the file. What it unwinds through is dropped.
pub(super) fn read(path: &Path) -> Result<Parsed, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("cannot be read: {e}"))?;
    std::panic::catch_unwind(|| parse(&bytes, folder(path)))
        .unwrap_or_else(|_| Err("is no valid glTF file".into()))
}

fn parse(bytes: &[u8], folder: &Path) -> Result<Parsed, String> {
    let broken = |e: gltf::Error| format!("is no glTF file that can be read: {e}");
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice_without_validation(bytes).map_err(broken)?;
    let json = document.into_json();
    check_positions(&json)?;
    let document = gltf::Document::from_json(json).map_err(broken)?;
    let beside = buffer_files(&document, folder)?;
    let buffers = gltf::import_buffers(&document, Some(folder), blob).map_err(broken)?;
    check_views(&document)?;
    let mut materials: Vec<_> =
        document.materials().map(|m| material(&m, &buffers, folder)).collect::<Result<_, _>>()?;
    let mut reader = Reader {
        buffers: &buffers,
        plain: materials.len() as u32,
        data: MeshData::default(),
        nodes_left: document.nodes().count(),
    };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    match scene {
        Some(scene) => {
            for node in scene.nodes() {
                reader.node(&node, DAffine3::IDENTITY, 0)?;
            }
        }
        None => {
            for mesh in document.meshes() {
                reader.mesh(&mesh, DAffine3::IDENTITY)?;
            }
        }
    }
    let data = reader.data;
    if data.slots.contains(&(materials.len() as u32)) {
        materials.push(MeshMaterial::default());
    }
    Ok(Parsed { data, materials, beside })
}

/// Refuses primitives whose positions name no accessor: the crate's validation looks them up.
fn check_positions(json: &gltf::json::Root) -> Result<(), String> {
    let positions = Checked::Valid(gltf::Semantic::Positions);
    let mut primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let lost = |p: &gltf::json::mesh::Primitive| {
        p.attributes.get(&positions).is_some_and(|i| i.value() >= json.accessors.len())
    };
    if primitives.any(lost) {
        return Err("the positions of a primitive name an accessor that is not there".into());
    }
    Ok(())
}

/// The files that hold buffers. Refuses what is no regular file: a pipe would be waited for, a
/// device has no end.
fn buffer_files(document: &gltf::Document, folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for buffer in document.buffers() {
        let gltf::buffer::Source::Uri(uri) = buffer.source() else { continue };
        if uri.starts_with("data:") {
            continue;
        }
        let absolute = uri.strip_prefix("file://").or_else(|| uri.strip_prefix("file:"));
        let path = match absolute {
            Some(path) => path.into(),
            None => {
                let name = urlencoding::decode(uri);
                folder.join(&*name.map_err(|e| format!("names a buffer {uri:?}: {e}"))?)
            }
        };
        file::open(&path).map_err(|e| format!("buffer {}: {e}", buffer.index()))?;
        files.push(path);
    }
    Ok(files)
}

/// Refuses views and accessors that reach past their buffer: the crate trusts them.
fn check_views(document: &gltf::Document) -> Result<(), String> {
    for view in document.views() {
        let end = view.offset().checked_add(view.length());
        if end.is_none_or(|end| end > view.buffer().length()) {
            return Err(format!("buffer view {} reaches past its buffer", view.index()));
        }
    }
    for accessor in document.accessors() {
        let (Some(view), None) = (accessor.view(), accessor.sparse()) else {
            let index = accessor.index();
            return Err(format!(
                "accessor {index} is sparse or without data; write it out plainly"
            ));
        };
        let stride = view.stride().unwrap_or(accessor.size());
        let end =
            accessor.count().checked_sub(1).and_then(|last| last.checked_mul(stride)).and_then(
                |start| start.checked_add(accessor.size())?.checked_add(accessor.offset()),
            );
        if end.is_none_or(|end| end > view.length()) {
            return Err(format!("accessor {} reaches past its buffer view", accessor.index()));
        }
    }
    Ok(())
}

struct Reader<'a> {
    buffers: &'a [gltf::buffer::Data],
    plain: u32,
    data: MeshData,
    /// How many nodes may still come, each having one parent at most.
    nodes_left: usize,
}

impl Reader<'_> {
    fn node(&mut self, node: &gltf::Node<'_>, above: DAffine3, depth: usize) -> Result<(), String> {
        if depth > DEEPEST || self.nodes_left == 0 {
            return Err(format!(
                "nodes lie more than {DEEPEST} deep or have several parents; they must form trees"
            ));
        }
        self.nodes_left -= 1;
        let matrix = node.transform().matrix().map(|column| column.map(f64::from));
        let to_world = above * DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix));
        if let Some(mesh) = node.mesh() {
            self.mesh(&mesh, to_world)?;
        }
        node.children().try_for_each(|child| self.node(&child, to_world, depth + 1))
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, to_world: DAffine3) -> Result<(), String> {
        mesh.primitives().try_for_each(|p| self.primitive(&p, to_world))
    }

    fn primitive(
        &mut self,
        primitive: &gltf::Primitive<'_>,
        to_world: DAffine3,
    ) -> Result<(), String> {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(()); // points and lines have no surface
        }
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(|b| &b.0[..]));
        let Some(positions) = reader.read_positions() else {
            return Err("a primitive has no positions".into());
        };
        let data = &mut self.data;
        let base = data.positions.len();
        data.positions
            .extend(positions.map(|p| to_world.transform_point3(DVec3::from(p.map(f64::from)))));
        let end = data.positions.len();
        let count = (end - base) as u32;
        if let Some(normals) = reader.read_normals() {
            let map = to_world.matrix3.inverse().transpose();
            data.normals.resize(base, Vec3::ZERO);
            data.normals.extend(
                normals
                    .map(|n| (map * DVec3::from(n.map(f64::from))).normalize_or_zero().as_vec3()),
            );
        }
        if let Some(uvs) = reader.read_tex_coords(0) {
            data.uvs.resize(base, Vec2::ZERO);
            // glTF counts v downward from the upper left corner (section 3.8.2).
            data.uvs.extend(uvs.into_f32().map(|[u, v]| Vec2::new(u, 1.0 - v)));
        }
        if !data.normals.is_empty() {
            data.normals.resize(end, Vec3::ZERO);
        }
        if !data.uvs.is_empty() {
            data.uvs.resize(end, Vec2::ZERO);
        }
        let indices: Vec<u32> = match reader.read_indices() {
            Some(indices) => indices.into_u32().collect(),
            None => (0..count).collect(),
        };
        if let Some(index) = indices.iter().find(|i| **i >= count) {
            return Err(format!("a primitive has index {index}, but only {count} vertices"));
        }
        let flip = to_world.matrix3.determinant() < 0.0; // section 3.7.4
        for mut triangle in assemble(primitive.mode(), &indices) {
            if flip {
                triangle.swap(1, 2);
            }
            data.triangles.push(triangle.map(|i| base as u32 + i));
        }
        let slot = primitive.material().index().map_or(self.plain, |i| i as u32);
        data.slots.resize(data.triangles.len(), slot);
        Ok(())
    }
}

/// Triangles of a list, strip or fan (glTF 2.0, section 3.7.2.1).
fn assemble(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan => super::parsed::fan(indices).collect(),
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}

fn material(
    m: &gltf::Material<'_>,
    buffers: &[gltf::buffer::Data],
    folder: &Path,
) -> Result<MeshMaterial, String> {
    let surface = m.pbr_metallic_roughness();
    let [r, g, b, _] = surface.base_color_factor().map(f64::from);
    let texture = match surface.base_color_texture().map(|t| t.texture().source().source()) {
        None => None,
        Some(gltf::image::Source::View { view, .. }) => {
            let bytes = buffers
                .get(view.buffer().index())
                .and_then(|b| b.0.get(view.offset()..view.offset() + view.length()))
                .ok_or("a texture reaches past its buffer")?;
            Some(TextureSource::Bytes(bytes.to_vec()))
        }
        Some(gltf::image::Source::Uri { uri, .. }) => Some(uri_texture(uri, folder)?),
    };
    Ok(MeshMaterial { name: m.name().unwrap_or_default().into(), color: [r, g, b], texture })
}

/// A texture beside the file, or inside its text as base64.
fn uri_texture(uri: &str, folder: &Path) -> Result<TextureSource, String> {
    if uri.starts_with("data:") {
        // The crate decodes such an address as the source of a buffer.
        let source = gltf::buffer::Source::Uri(uri);
        let bytes = gltf::buffer::Data::from_source(source, Some(folder))
            .map_err(|e| format!("a texture inside the file cannot be decoded: {e}"))?;
        return Ok(TextureSource::Bytes(bytes.0));
    }
    Ok(TextureSource::Path(folder.join(percent_decoded(uri))))
}

/// Replaces `%20` and its like (RFC 3986, section 2.1).
fn percent_decoded(uri: &str) -> String {
    let mut parts = uri.split('%');
    let mut bytes = parts.next().unwrap_or("").as_bytes().to_vec();
    for part in parts {
        match part.get(..2).and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                bytes.extend(&part.as_bytes()[2..]);
            }
            None => {
                bytes.push(b'%');
                bytes.extend(part.as_bytes());
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
