//! `[[light]]`.

use glam::DVec3;

use super::group;
use super::surface::half_sides;
use crate::error::Result;
use crate::math::Rgb;
use crate::scene::groups::GroupName;
use crate::scene::keys::light as keys;
use crate::scene::reader::{FileReference, Place, Range, Section, Value};

/// One `[[light]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSection {
    /// Where the table stands.
    pub at: Place,
    /// `type` with its keys.
    pub kind: LightKind,
    /// `visible`: whether rays from the camera see it.
    pub visible: bool,
    /// `group`: the group of its light.
    pub group: Option<GroupName>,
}

/// A light.
#[derive(Debug, Clone, PartialEq)]
pub enum LightKind {
    /// Shines the same in every direction.
    Point {
        /// Where it is, in metres.
        position: DVec3,
        /// How strong.
        strength: Strength,
    },
    /// Shines into a cone.
    Spot {
        /// Where it is, in metres.
        position: DVec3,
        /// Where it shines.
        aim: Aim,
        /// How strong.
        strength: Strength,
        /// Half angle of the cone in degrees, in (0, 180].
        angle: f64,
        /// How it fades toward the edge.
        shape: SpotShape,
        /// A picture in the beam.
        texture: Option<FileReference>,
    },
    /// Parallel light, or nearly so.
    Sun {
        /// Direction the light travels, of any length.
        direction: DVec3,
        /// On a plane square to the light, in W/m².
        irradiance: Rgb,
        /// Angular diameter in degrees, in [0, 180).
        angle: f64,
    },
    /// A quad that shines along u x v.
    Area {
        /// Its centre, in metres.
        center: DVec3,
        /// Half of one side, in metres.
        u: DVec3,
        /// Half of the other side, in metres.
        v: DVec3,
        /// In W/(m² sr).
        radiance: Rgb,
    },
    /// Light from infinitely far, all around.
    Environment {
        /// In W/(m² sr); the factor of a texture where there is one. `scale` is already in it.
        radiance: Rgb,
        /// A latitude-longitude picture.
        texture: Option<FileReference>,
        /// Turn about the y axis in degrees.
        rotate: f64,
    },
    /// Light from infinitely far that goes with the elevation.
    Gradient {
        /// Elevations in degrees, going upward, with the radiance there in W/(m² sr); `scale` is
        /// already in it.
        stops: Vec<(f64, Rgb)>,
    },
}

/// How strong a point or spot light is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// Intensity in W/sr; of a spot along its axis.
    Intensity(Rgb),
    /// Power in W, all of it.
    Power(Rgb),
}

/// Where a spot light shines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// At a point, in metres.
    Target(DVec3),
    /// Along a direction of any length.
    Direction(DVec3),
}

/// How a spot light fades toward the edge of its cone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpotShape {
    /// Smoothly over the outermost degrees of the half angle.
    Falloff(f64),
    /// As the cosine from the axis to this power.
    Exponent(f64),
}

#[derive(Clone, Copy)]
enum Kind {
    Point,
    Spot,
    Sun,
    Area,
    Environment,
}

/// The most stops of a gradient.
const MAX_STOPS: usize = 256;

const KINDS: &[(&str, Kind)] = &[
    ("point", Kind::Point),
    ("spot", Kind::Spot),
    ("sun", Kind::Sun),
    ("area", Kind::Area),
    ("environment", Kind::Environment),
];

pub(super) fn read(section: &Section<'_>) -> Result<LightSection> {
    let read = match section.word(&keys::TYPE, KINDS)? {
        Kind::Point => point,
        Kind::Spot => spot,
        Kind::Sun => sun,
        Kind::Area => area,
        Kind::Environment => environment,
    };
    let kind = read(section)?;
    Ok(LightSection {
        at: section.place(),
        kind,
        visible: section.switch(&keys::VISIBLE)?,
        group: group(section)?,
    })
}

fn point(section: &Section<'_>) -> Result<LightKind> {
    section.only(&keys::POINT)?;
    let position = section.triple(&keys::POSITION)?;
    Ok(LightKind::Point { position, strength: strength(section)? })
}

fn spot(section: &Section<'_>) -> Result<LightKind> {
    section.only(&keys::SPOT)?;
    section.at_most_one(&[&keys::FALLOFF, &keys::EXPONENT])?;
    let position = section.triple(&keys::POSITION)?;
    let angle = section.number(&keys::ANGLE)?;
    let shape = match section.maybe_number(&keys::EXPONENT)? {
        Some(exponent) => SpotShape::Exponent(exponent),
        None => SpotShape::Falloff(falloff(section, angle)?),
    };
    Ok(LightKind::Spot {
        position,
        aim: aim(section, position)?,
        strength: strength(section)?,
        angle,
        shape,
        texture: section.maybe_file(&keys::BEAM)?,
    })
}

fn falloff(section: &Section<'_>, angle: f64) -> Result<f64> {
    let falloff = section.number(&keys::FALLOFF)?;
    if falloff > angle {
        let right = format!("at most the half angle of the cone, {angle} degrees");
        return Err(section.require(&keys::FALLOFF)?.wrong(&right));
    }
    Ok(falloff)
}

fn aim(section: &Section<'_>, position: DVec3) -> Result<Aim> {
    section.at_most_one(&[&keys::TARGET, &keys::DIRECTION])?;
    if section.get(&keys::DIRECTION).is_some() {
        return section.triple(&keys::DIRECTION).map(Aim::Direction);
    }
    let target = section.triple(&keys::TARGET)?;
    if target == position {
        let value = section.require(&keys::TARGET)?;
        return Err(value.wrong("a point other than the light's position"));
    }
    Ok(Aim::Target(target))
}

fn sun(section: &Section<'_>) -> Result<LightKind> {
    section.only(&keys::SUN)?;
    Ok(LightKind::Sun {
        direction: section.triple(&keys::TRAVEL)?,
        irradiance: section.splat(&keys::IRRADIANCE)?,
        angle: section.number(&keys::DIAMETER)?,
    })
}

fn area(section: &Section<'_>) -> Result<LightKind> {
    section.only(&keys::AREA)?;
    let [u, v] = half_sides(section)?;
    Ok(LightKind::Area {
        center: section.triple(&keys::CENTER)?,
        u,
        v,
        radiance: section.splat(&keys::RADIANCE)?,
    })
}

fn environment(section: &Section<'_>) -> Result<LightKind> {
    section.only(&keys::ENVIRONMENT)?;
    section.at_most_one(&[&keys::SKY_RADIANCE, &keys::SKY, &keys::GRADIENT])?;
    let scale = section.number(&keys::SKY_SCALE)?;
    if let Some(value) = section.get(&keys::GRADIENT) {
        section.at_most_one(&[&keys::GRADIENT, &keys::SKY_ROTATE])?;
        return Ok(LightKind::Gradient { stops: stops(&value, scale)? });
    }
    let texture = section.maybe_file(&keys::SKY)?;
    let radiance = match &texture {
        Some(_) => Rgb::ONE,
        None => section.splat(&keys::SKY_RADIANCE)?,
    };
    let rotate = section.number(&keys::SKY_ROTATE)?;
    Ok(LightKind::Environment { radiance: radiance * scale, texture, rotate })
}

/// The stops of a gradient, their radiance times `scale`.
fn stops(value: &Value<'_>, scale: f64) -> Result<Vec<(f64, Rgb)>> {
    let right = keys::GRADIENT.kind.right();
    let list = value.list(MAX_STOPS, &right)?;
    if list.len() < 2 {
        return Err(value.wrong(&right));
    }
    let mut stops: Vec<(f64, Rgb)> = Vec::with_capacity(list.len());
    for stop in &list {
        let right = "a stop [elevation, colour]";
        let pair = stop.list(2, right)?;
        let [elevation, color] = &pair[..] else { return Err(stop.wrong(right)) };
        let degrees = elevation.number(keys::ELEVATION)?;
        if let Some((last, _)) = stops.last().filter(|(last, _)| degrees < *last) {
            return Err(elevation.wrong(&format!("an elevation not below the one before, {last}")));
        }
        stops.push((degrees, color.color(Range::NOT_NEGATIVE)? * scale));
    }
    Ok(stops)
}

fn strength(section: &Section<'_>) -> Result<Strength> {
    section.at_most_one(&[&keys::INTENSITY, &keys::POWER])?;
    if section.get(&keys::POWER).is_some() {
        return section.splat(&keys::POWER).map(Strength::Power);
    }
    section.splat(&keys::INTENSITY).map(Strength::Intensity)
}
