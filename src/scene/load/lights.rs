//! `[[light]]` tables become lights.

use glam::DVec3;

use super::context::{Context, at};
use crate::error::Result;
use crate::image::{DecodedTexture, Encoding, read_texture};
use crate::light::{
    BeamPicture, Environment, Falloff, Light, PointLight, QuadLight, SpotLight, Sun,
};
use crate::math::{Rgb, WorldPoint};
use crate::scene::file::{
    Aim, DensitySection, LightKind, LightSection, RegionSection, SceneFile, SpotShape, Strength,
};
use crate::scene::reader::{FileReference, Place};
use crate::shape::{Quad, Shape};
use crate::surface::{CameraView, Material, Surface};

/// The light of `section`, whose index among the lights is `index`, with the surface that an area
/// light has.
pub(super) fn build(
    section: &LightSection,
    index: u32,
    context: &mut Context,
) -> Result<(Light, Option<Surface>)> {
    let place = &section.at;
    let light = match &section.kind {
        LightKind::Point { position, strength } => {
            Light::Point(at(place, point(*position, *strength))?)
        }
        LightKind::Spot { position, aim, strength, angle, shape, texture } => {
            let direction = match *aim {
                Aim::Target(target) => target - *position,
                Aim::Direction(direction) => direction,
            };
            let falloff = match *shape {
                SpotShape::Falloff(degrees) => Falloff::Smooth { start: angle - degrees },
                SpotShape::Exponent(exponent) => Falloff::Cosine { exponent },
            };
            let position = WorldPoint::from_xyz(*position);
            let intensity = match *strength {
                Strength::Intensity(intensity) => intensity,
                Strength::Power(_) => Rgb::ONE,
            };
            let mut spot =
                at(place, SpotLight::new(position, direction, intensity, *angle, falloff))?;
            if let Some(texture) = texture {
                let picture = beam_picture(texture, direction, context)?;
                spot = at(&texture.at, spot.with_picture(picture))?;
            }
            if let Strength::Power(power) = *strength {
                spot = at(place, spot.with_power(power))?;
            }
            Light::Spot(spot)
        }
        LightKind::Sun { direction, irradiance, angle } => {
            Light::Sun(at(place, Sun::new(*direction, *irradiance, *angle))?)
        }
        LightKind::Area { center, u, v, radiance } => {
            let (light, surface) = area(place, *center, [*u, *v], *radiance, index)?;
            let view = if section.visible { CameraView::Seen } else { CameraView::Hidden };
            return Ok((light, Some(surface.with_view(view))));
        }
        LightKind::Environment { radiance, texture: None, .. } => {
            Light::Environment(at(place, Environment::constant(*radiance))?)
        }
        LightKind::Environment { radiance, texture: Some(file), rotate } => {
            let DecodedTexture { image, encoding } = picture(file, context)?;
            if let Encoding::Srgb { bits } = encoding {
                context.notes.push(format!(
                    "{}: {bits}-bit picture as a sky, taken as sRGB; highlights are clipped, an .exr \
                     or .hdr holds them",
                    file.path.display()
                ));
            }
            let (width, height) = (image.width(), image.height());
            let texels = image.pixels().to_vec();
            let environment = Environment::picture(width, height, texels, *radiance, *rotate);
            Light::Environment(at(&file.at, environment)?)
        }
        LightKind::Gradient { stops } => {
            Light::Environment(at(place, Environment::gradient(stops))?)
        }
    };
    Ok((light, None))
}

fn point(position: DVec3, strength: Strength) -> Result<PointLight, String> {
    let position = WorldPoint::from_xyz(position);
    match strength {
        Strength::Intensity(intensity) => PointLight::new(position, intensity),
        Strength::Power(power) => PointLight::from_power(position, power),
    }
}

/// A quad of half sides `u` and `v` that shines along u x v, black otherwise.
fn area(
    place: &Place,
    center: DVec3,
    [u, v]: [DVec3; 2],
    radiance: Rgb,
    index: u32,
) -> Result<(Light, Surface)> {
    let center = WorldPoint::from_xyz(center);
    let light = at(place, QuadLight::new(center, u * 2.0, v * 2.0, radiance))?;
    let shape = Shape::Quad(at(place, Quad::new(center, u, v))?);
    let surface = at(place, Surface::new(shape, vec![Material::Black], Some(index)))?;
    Ok((Light::Quad(light), surface))
}

fn beam_picture(
    file: &FileReference,
    direction: DVec3,
    context: &mut Context,
) -> Result<BeamPicture> {
    let image = picture(file, context)?.image;
    // A beam straight up or down has its picture's upper edge toward -z, as a map has north.
    let level = direction.normalize().cross(DVec3::Y).length() > 1e-6;
    Ok(BeamPicture {
        width: image.width(),
        height: image.height(),
        texels: image.pixels().to_vec(),
        up: if level { DVec3::Y } else { DVec3::NEG_Z },
    })
}

fn picture(file: &FileReference, context: &mut Context) -> Result<DecodedTexture> {
    context.sources.add(&file.path);
    at(&file.at, read_texture(&file.path))
}

/// A warning where light from infinitely far is to cross endless fog: none arrives.
pub(super) fn endless_fog(file: &SceneFile) -> Option<String> {
    let fog = file.media.iter().find(|m| {
        m.density == DensitySection::Region(RegionSection::Everywhere)
            && m.sigma_t.max_element() > 0.0
    })?;
    let light = file.lights.iter().find(|l| is_infinite(&l.kind))?;
    Some(format!(
        "{} comes from infinitely far and cannot cross {}, which has no end; give the medium a \
         region with an end",
        light.at, fog.name
    ))
}

/// Whether light of this kind comes from infinitely far.
fn is_infinite(kind: &LightKind) -> bool {
    use LightKind::{Environment, Gradient, Sun};
    matches!(kind, Sun { .. } | Environment { .. } | Gradient { .. })
}
