//! Materials of a shot as those of a scene.
//!
//! Surfaces of scenes are diffuse, plastic, metals, mirrors or glass. What UsdPreviewSurface and the surfaces of
//! MaterialX say more is left out, and said once for each material.

use std::collections::HashMap;

use openusd::sdf;
use toml::Value;

use super::geometry::Look;
use super::shot::Files;
use super::values::Reader;
use crate::error::Result;
use crate::math::{Rgb, luminance};
use crate::scene::draft::exact;
use crate::scene::keys::surface::LEAST_ROUGHNESS;

/// Metalness from which a surface is a metal, and weight of transmission from which it is glass.
const MOSTLY: f64 = 0.5;
/// Reflectance at normal incidence from which a colour of specular light is a metal's: dielectrics, diamond among
/// them, are below.
const LEAST_METAL: f64 = 0.2;
/// Reflectance at normal incidence below which a coat is left away.
const LEAST_COAT: f64 = 1e-3;
/// Reflectance of a surface that says none: the fallback of UsdPreviewSurface.
const FALLBACK: f64 = 0.18;

/// Names of the inputs of a surface shader.
struct Names {
    color: &'static str,
    /// Factor on the colour.
    weight: &'static str,
    metalness: &'static str,
    roughness: &'static str,
    /// Where the shader does not say it.
    usual_roughness: f64,
    /// Factor on the reflectance of the coat, and where it leaves that as it is.
    coat: (&'static str, f64),
    /// How much light goes through.
    transmission: &'static str,
    /// How much of the surface is there.
    opacity: &'static str,
    ior: &'static str,
    emission: &'static str,
    emission_weight: &'static str,
    /// What is left out where it is above 0.
    unknown: &'static [&'static str],
}

const PREVIEW: Names = Names {
    color: "diffuseColor",
    weight: "",
    metalness: "metallic",
    roughness: "roughness",
    usual_roughness: 0.5,
    // Blender's; it is no input of UsdPreviewSurface.
    coat: ("specular", 0.5),
    transmission: "",
    opacity: "opacity",
    ior: "ior",
    emission: "emissiveColor",
    emission_weight: "",
    unknown: &["clearcoat"],
};
const STANDARD_SURFACE: Names = Names {
    color: "base_color",
    weight: "base",
    metalness: "metalness",
    roughness: "specular_roughness",
    usual_roughness: 0.2,
    coat: ("specular", 1.0),
    transmission: "transmission",
    opacity: "",
    ior: "specular_IOR",
    emission: "emission_color",
    emission_weight: "emission",
    unknown: &["coat", "subsurface", "sheen", "thin_film_thickness", "specular_anisotropy"],
};
const OPEN_PBR: Names = Names {
    color: "base_color",
    weight: "base_weight",
    metalness: "base_metalness",
    roughness: "specular_roughness",
    usual_roughness: 0.3,
    coat: ("specular_weight", 1.0),
    transmission: "transmission_weight",
    opacity: "",
    ior: "specular_ior",
    emission: "emission_color",
    emission_weight: "emission_luminance",
    unknown: &[
        "coat_weight",
        "subsurface_weight",
        "fuzz_weight",
        "thin_film_weight",
        "specular_roughness_anisotropy",
    ],
};

/// The looks of materials, each read once.
#[derive(Default)]
pub(super) struct Looks {
    known: HashMap<String, Look>,
    /// What is left out, one line each.
    pub(super) warnings: Vec<String>,
}

impl Looks {
    /// The look of the material bound to the mesh at `mesh`, which has its display colour without one.
    pub(super) fn of(
        &mut self,
        reader: &Reader<'_>,
        mesh: &sdf::Path,
        material: Option<&sdf::Path>,
        files: &mut Files,
    ) -> Result<Look> {
        let Some(material) = material else {
            let shown = reader.triples(mesh, "primvars:displayColor")?;
            let color = shown.first().copied().filter(|_| shown.len() == 1);
            let color = color.unwrap_or(Rgb::splat(FALLBACK)).clamp(Rgb::ZERO, Rgb::ONE);
            return Ok(Look::diffuse("surface", exact(color), Rgb::ZERO));
        };
        if let Some(known) = self.known.get(material.as_str()) {
            return Ok(known.clone());
        }
        let look = self.read(reader, material, files)?;
        self.known.insert(material.as_str().into(), look.clone());
        Ok(look)
    }

    fn read(
        &mut self,
        reader: &Reader<'_>,
        material: &sdf::Path,
        files: &mut Files,
    ) -> Result<Look> {
        let name = material.name().unwrap_or("material").to_owned();
        let fallback = Look::diffuse(&name, FALLBACK, Rgb::ZERO);
        let mut warn = |problem: String| {
            self.warnings.push(reader.wrong(material, problem).to_string());
        };
        let Some((shader, names)) = surface(reader, material)? else {
            warn("has no surface that is known (UsdPreviewSurface, standard_surface, open_pbr_surface); \
                  it is diffuse, of reflectance 0.18".into());
            return Ok(fallback);
        };
        let number = |input: &str, fallback: f64| -> Result<f64> {
            if input.is_empty() {
                return Ok(fallback);
            }
            Ok(reader.number(&shader, &format!("inputs:{input}"))?.unwrap_or(fallback))
        };
        let color = reader.triple(&shader, &format!("inputs:{}", names.color))?;
        let color = color.unwrap_or(Rgb::splat(FALLBACK)) * number(names.weight, 1.0)?;
        let color = color.clamp(Rgb::ZERO, Rgb::ONE);
        let roughness = number(names.roughness, names.usual_roughness)?;
        let glow = reader.triple(&shader, &format!("inputs:{}", names.emission))?;
        let is_weighted = !names.emission_weight.is_empty();
        let weight = number(names.emission_weight, if is_weighted { 0.0 } else { 1.0 })?;
        let emission =
            (glow.unwrap_or(Rgb::splat(f64::from(u8::from(is_weighted)))) * weight).max(Rgb::ZERO);
        let through = number(names.transmission, 0.0)?.max(1.0 - number(names.opacity, 1.0)?);

        let mut left_out = Vec::new();
        for unknown in names.unknown {
            if number(unknown, 0.0)? > 0.0 {
                left_out.push(unknown.to_string());
            }
        }
        for (input, what) in [("normal", "the normal map"), ("displacement", "displacement")] {
            if reader.source(&shader, &format!("inputs:{input}"))?.is_some() {
                left_out.push(what.into());
            }
        }
        let texture = match texture(reader, &shader, names.color)? {
            Connected::Nothing => None,
            Connected::File(file) => Some(files.asset(file)),
            Connected::Other => {
                left_out.push(format!("what {} is connected to", names.color));
                None
            }
        };
        for input in [names.metalness, names.roughness, names.opacity, names.emission] {
            if !input.is_empty() && reader.source(&shader, &format!("inputs:{input}"))?.is_some() {
                left_out.push(format!("what {input} is connected to"));
            }
        }
        let mut value = toml::Table::new();
        if through > MOSTLY {
            value.insert("type".into(), "glass".into());
            value.insert("ior".into(), number(names.ior, 1.5)?.clamp(1.0, 10.0).into());
            value.insert("tint".into(), exact(color));
            if roughness >= LEAST_ROUGHNESS {
                left_out.push(format!("{} = {roughness} of glass", names.roughness));
            }
        } else {
            let ior = number(names.ior, 1.5)?;
            let ratio = (ior - 1.0) / (ior + 1.0);
            let (coat, as_it_is) = names.coat;
            let mut coat = ratio * ratio * (number(coat, as_it_is)? / as_it_is);
            let mut is_metal = number(names.metalness, 0.0)? >= MOSTLY;
            let mut reflectance = match texture {
                Some(file) => {
                    Value::Table(toml::Table::from_iter([("texture".into(), file.into())]))
                }
                None => exact(color),
            };
            // UsdPreviewSurface may give the reflectance at normal incidence in place of a metalness.
            if reader.flag(&shader, "inputs:useSpecularWorkflow")? {
                let given = reader.triple(&shader, "inputs:specularColor")?.unwrap_or(Rgb::ZERO);
                is_metal = given.max_element() > LEAST_METAL;
                coat = luminance(given);
                if is_metal {
                    reflectance = exact(given.clamp(Rgb::ZERO, Rgb::ONE));
                }
            }
            let is_smooth = roughness < LEAST_ROUGHNESS;
            let kind = match (is_metal, is_smooth) {
                (true, true) => "mirror",
                (true, false) => "metal",
                (false, _) if coat >= LEAST_COAT => "plastic",
                (false, _) => "diffuse",
            };
            value.insert("type".into(), kind.into());
            if kind == "mirror" && reflectance.is_table() {
                left_out.push(format!("the picture of {}", names.color));
                reflectance = exact(color);
            }
            value.insert("reflectance".into(), reflectance);
            if matches!(kind, "metal" | "plastic") {
                let roughness = roughness.clamp(LEAST_ROUGHNESS, 1.0);
                value.insert("roughness".into(), roughness.into());
            }
            if kind == "plastic" {
                let root = coat.clamp(0.0, LEAST_METAL).sqrt();
                value.insert("ior".into(), ((1.0 + root) / (1.0 - root)).into());
            }
        }
        if !left_out.is_empty() {
            warn(format!("left out: {}", left_out.join(", ")));
        }
        Ok(Look { name, material: Value::Table(value), emission })
    }
}

/// The surface shader of a material with the names of its inputs.
fn surface(
    reader: &Reader<'_>,
    material: &sdf::Path,
) -> Result<Option<(sdf::Path, &'static Names)>> {
    for output in ["outputs:surface", "outputs:mtlx:surface"] {
        let Some(shader) = reader.source(material, output)? else { continue };
        let id = reader.word(&shader, "info:id")?;
        let names = match id.as_deref() {
            Some("UsdPreviewSurface") => &PREVIEW,
            Some("ND_standard_surface_surfaceshader") => &STANDARD_SURFACE,
            Some("ND_open_pbr_surface_surfaceshader") => &OPEN_PBR,
            _ => continue,
        };
        return Ok(Some((shader, names)));
    }
    Ok(None)
}

/// What an input is connected to.
enum Connected {
    Nothing,
    File(std::path::PathBuf),
    Other,
}

/// The picture file that `input` of `shader` is connected to.
fn texture(reader: &Reader<'_>, shader: &sdf::Path, input: &str) -> Result<Connected> {
    let Some(source) = reader.source(shader, &format!("inputs:{input}"))? else {
        return Ok(Connected::Nothing);
    };
    let id = reader.word(&source, "info:id")?.unwrap_or_default();
    let is_picture = id == "UsdUVTexture" || id.starts_with("ND_image_color");
    let file = reader.asset(&source, "inputs:file")?;
    let whole = |file: &std::path::PathBuf| !file.to_string_lossy().contains("<UDIM>");
    Ok(match file.filter(|file| is_picture && whole(file)) {
        Some(file) => Connected::File(file),
        None => Connected::Other,
    })
}
