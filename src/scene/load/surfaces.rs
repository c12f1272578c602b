//! `[[surface]]` tables become surfaces, and lights where they shine.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::context::{Context, at};
use crate::error::Result;
use crate::image::{Image, decode_texture, read_texture};
use crate::light::{Light, MeshLight, QuadLight};
use crate::math::{Rgb, WorldPoint};
use crate::scene::file::{ColorSection, MaterialSection, ShapeSection, SurfaceSection};
use crate::scene::reader::{FileReference, Place};
use crate::shape::{
    Cuboid, LoadedMesh, Mesh, MeshMaterial, Plane, Quad, Shape, Sphere, TextureSource, load_mesh,
};
use crate::surface::{Glass, Material, Metal, Plastic, Surface, Texture};

/// A surface with the light that it emits.
pub(super) struct Built {
    pub(super) surface: Surface,
    pub(super) light: Option<Light>,
}

/// The surface of `section` so many `frames` after the time of the scene; `next_light` is the index its light would have.
pub(super) fn build(
    section: &SurfaceSection,
    frames: f64,
    next_light: u32,
    context: &mut Context,
) -> Result<Built> {
    let (shape, own) = shape(section, frames, context)?;
    let materials = match &section.material {
        Some(given) => {
            let slots = if let Shape::Mesh(mesh) = &shape { mesh.slot_count() } else { 1 };
            vec![material(given, context)?; slots]
        }
        None => own,
    };
    let light = match section.emission.filter(|radiance| *radiance != Rgb::ZERO) {
        Some(radiance) => Some(at(&section.at, light(&shape, radiance))?),
        None => None,
    };
    let surface = Surface::new(shape, materials, light.is_some().then_some(next_light));
    Ok(Built { surface: at(&section.at, surface)?.with_view(section.view), light })
}

/// The placed shape with its own materials.
fn shape(
    section: &SurfaceSection,
    frames: f64,
    context: &mut Context,
) -> Result<(Shape, Vec<Material>)> {
    section.next_file.iter().for_each(|next| context.sources.add(&next.path));
    let still = section.placement;
    let place = &section.at;
    let placement = &section.motion.map_or(still, |motion| motion.placed(&still, frames));
    let world = |p: DVec3| WorldPoint::from_xyz(placement.transform_point3(p));
    let turned = |v: DVec3| placement.transform_vector3(v);
    let shape = match &section.shape {
        ShapeSection::Sphere { center, radius } => {
            Shape::Sphere(at(place, Sphere::new(*center, *radius, placement))?)
        }
        ShapeSection::Quad { center, u, v } => {
            Shape::Quad(at(place, Quad::new(world(*center), turned(*u), turned(*v)))?)
        }
        ShapeSection::Box { min, max } => {
            Shape::Box(at(place, Cuboid::new(*min, *max, placement))?)
        }
        ShapeSection::Plane { point, normal } => {
            let normal = placement.matrix3.inverse().transpose() * *normal;
            Shape::Plane(at(place, Plane::new(world(*point), normal))?)
        }
        ShapeSection::Mesh(file) => {
            let (mesh, materials) = mesh_with_materials(file, placement, context)?;
            let next = section.next_file.as_ref().filter(|_| frames != 0.0);
            let mesh = match next {
                Some(next) => {
                    let there = self::mesh(next, placement, context)?.mesh;
                    at(&next.at, mesh.toward(&there, frames))?
                }
                None => mesh,
            };
            return Ok((Shape::Mesh(Arc::new(mesh)), materials));
        }
    };
    Ok((shape, vec![Material::Diffuse { reflectance: Texture::Constant(Rgb::splat(0.5)) }]))
}

/// The placed mesh of a file.
pub(super) fn mesh(
    file: &FileReference,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<LoadedMesh> {
    let in_memory = file.path.to_str().and_then(|name| context.meshes.get(name)).cloned();
    if let Some(data) = in_memory {
        context.sources.add_mesh(&file.path, &data);
        let mesh = at(&file.at, Mesh::new(data.as_ref().clone(), placement))?;
        return Ok(LoadedMesh { mesh, materials: Vec::new(), beside: Vec::new() });
    }
    context.sources.add(&file.path);
    let loaded = at(&file.at, load_mesh(&file.path, placement))?;
    loaded.beside.iter().for_each(|path| context.sources.add(path));
    Ok(loaded)
}

fn mesh_with_materials(
    file: &FileReference,
    placement: &DAffine3,
    context: &mut Context,
) -> Result<(Mesh, Vec<Material>)> {
    let loaded = mesh(file, placement, context)?;
    let materials = loaded
        .materials
        .iter()
        .map(|material| mesh_material(material, file, context))
        .collect::<Result<Vec<_>>>()?;
    Ok((loaded.mesh, materials))
}

fn mesh_material(
    material: &MeshMaterial,
    file: &FileReference,
    context: &mut Context,
) -> Result<Material> {
    let color = Rgb::from(material.color).clamp(Rgb::ZERO, Rgb::ONE);
    let image = match &material.texture {
        None => return Ok(Material::Diffuse { reflectance: Texture::Constant(color) }),
        Some(TextureSource::Path(path)) => {
            context.sources.add(path);
            at(&file.at, read_texture(path))?.image
        }
        Some(TextureSource::Bytes(bytes)) => at(&file.at, decode_texture(bytes, &file.path))?.image,
    };
    reflectance(&file.at, &image, color).map(|reflectance| Material::Diffuse { reflectance })
}

fn material(section: &MaterialSection, context: &mut Context) -> Result<Material> {
    Ok(match section {
        MaterialSection::Diffuse { reflectance } => {
            Material::Diffuse { reflectance: color(reflectance, context)? }
        }
        MaterialSection::Plastic { reflectance, roughness, ior } => {
            let base = color(reflectance, context)?;
            Material::Plastic(Plastic::new(base, *ior, roughness * roughness))
        }
        MaterialSection::Metal { reflectance, roughness } => {
            Material::Metal(Metal::new(color(reflectance, context)?, roughness * roughness))
        }
        MaterialSection::Mirror { reflectance } => Material::Mirror { reflectance: *reflectance },
        MaterialSection::Glass { ior, tint } => Material::Glass(Glass { ior: *ior, tint: *tint }),
    })
}

/// The colour of a material, a reflectance.
fn color(section: &ColorSection, context: &mut Context) -> Result<Texture> {
    match section {
        ColorSection::Constant(color) => Ok(Texture::Constant(*color)),
        ColorSection::Texture(file) => {
            context.sources.add(&file.path);
            let image = at(&file.at, read_texture(&file.path))?.image;
            reflectance(&file.at, &image, Rgb::ONE)
        }
    }
}

/// `image` times `color` as a reflectance, which must lie in [0, 1].
fn reflectance(place: &Place, image: &Image, color: Rgb) -> Result<Texture> {
    let tint = color.as_vec3().to_array();
    let outside = |v: &f32| !(0.0..=1.0).contains(v);
    if let Some(v) = image.pixels().as_flattened().iter().find(|v| outside(v)) {
        return Err(
            place.error(format!("the picture has a value of {v}; a reflectance lies from 0 to 1"))
        );
    }
    let pixels = image.pixels().iter().map(|p| std::array::from_fn(|i| p[i] * tint[i])).collect();
    Ok(Texture::Image(Arc::new(Image::new(image.width(), image.height(), pixels))))
}

/// The light of a shape that shines where its normal points.
fn light(shape: &Shape, radiance: Rgb) -> Result<Light, String> {
    match shape {
        Shape::Quad(quad) => {
            let [u, v] = quad.half_edges();
            QuadLight::new(quad.center(), u * 2.0, v * 2.0, radiance).map(Light::Quad)
        }
        Shape::Mesh(mesh) => MeshLight::new(triangles(mesh), radiance).map(Light::Mesh),
        Shape::Sphere(_) | Shape::Box(_) | Shape::Plane(_) => {
            Err("only quads and meshes can give off light".into())
        }
    }
}

fn triangles(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangle_count() as u32).map(|i| mesh.corners(i)).collect()
}
