//! `[[light]]`.

use glam::DVec3;

use super::surface::half_sides;
use crate::error::Result;
use crate::math::Rgb;
use crate::scene::reader::{FileReference, Place, Range, Section, Value};

/// One `[[light]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct LightSection {
    /// Where the table stands.
    pub at: Place,
    /// `type` with its keys.
    pub kind: LightKind,
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

const HALF_ANGLE: Range =
    Range::new(|a| a > 0.0 && a <= 180.0, "an angle above 0 and at most 180 degrees");
const DIAMETER: Range =
    Range::new(|a| (0.0..180.0).contains(&a), "an angle from 0 to below 180 degrees");
const EXPONENT: Range = Range::new(|e| (0.0..=1e6).contains(&e), "a number from 0 to 1000000");

const ELEVATION: Range =
    Range::new(|e| (-90.0..=90.0).contains(&e), "an elevation from -90 to 90 degrees");

/// The most stops of a gradient.
const MAX_STOPS: usize = 256;

/// The sun's angular diameter seen from the earth, in degrees.
const SUN_DIAMETER: f64 = 0.533;

pub(super) fn read(section: &Section<'_>) -> Result<LightSection> {
    let list = "\"point\", \"spot\", \"sun\", \"area\" or \"environment\"";
    let kind = section.require("type", list)?.word(&[
        ("point", Kind::Point),
        ("spot", Kind::Spot),
        ("sun", Kind::Sun),
        ("area", Kind::Area),
        ("environment", Kind::Environment),
    ])?;
    let read = match kind {
        Kind::Point => point,
        Kind::Spot => spot,
        Kind::Sun => sun,
        Kind::Area => area,
        Kind::Environment => environment,
    };
    Ok(LightSection { at: section.place(), kind: read(section)? })
}

fn point(section: &Section<'_>) -> Result<LightKind> {
    section.only("a point light", &["type", "position", "intensity", "power"])?;
    Ok(LightKind::Point { position: position(section)?, strength: strength(section)? })
}

fn spot(section: &Section<'_>) -> Result<LightKind> {
    let own = ["type", "position", "target", "direction", "intensity", "power", "angle"];
    section.only("a spot light", &[&own[..], &["falloff", "exponent", "texture"]].concat())?;
    section.at_most_one(&["falloff", "exponent"])?;
    let position = position(section)?;
    let angle = section.or("angle", 30.0, |v| v.number(HALF_ANGLE))?;
    let shape = match section.get("exponent") {
        Some(value) => SpotShape::Exponent(value.number(EXPONENT)?),
        None => SpotShape::Falloff(section.or("falloff", 0.0, |v| falloff(&v, angle))?),
    };
    Ok(LightKind::Spot {
        position,
        aim: aim(section, position)?,
        strength: strength(section)?,
        angle,
        shape,
        texture: section.maybe("texture", |v| v.file("a picture file"))?,
    })
}

fn falloff(value: &Value<'_>, angle: f64) -> Result<f64> {
    let falloff = value.number(Range::NOT_NEGATIVE)?;
    if falloff > angle {
        return Err(value.wrong(&format!("at most the half angle of the cone, {angle} degrees")));
    }
    Ok(falloff)
}

fn aim(section: &Section<'_>, position: DVec3) -> Result<Aim> {
    section.at_most_one(&["target", "direction"])?;
    if let Some(value) = section.get("direction") {
        return value.direction().map(Aim::Direction);
    }
    let value = section.require("target", "a point to shine at, or `direction`")?;
    let target = value.triple(Range::ANY)?;
    if target == position {
        return Err(value.wrong("a point other than the light's position"));
    }
    Ok(Aim::Target(target))
}

fn sun(section: &Section<'_>) -> Result<LightKind> {
    section.only("a sun", &["type", "direction", "irradiance", "angle"])?;
    Ok(LightKind::Sun {
        direction: section.require("direction", "the direction the light travels")?.direction()?,
        irradiance: section
            .require("irradiance", "a colour in W/m²")?
            .color(Range::NOT_NEGATIVE)?,
        angle: section.or("angle", SUN_DIAMETER, |v| v.number(DIAMETER))?,
    })
}

fn area(section: &Section<'_>) -> Result<LightKind> {
    section.only("an area light", &["type", "center", "u", "v", "radiance"])?;
    let [u, v] = half_sides(section)?;
    Ok(LightKind::Area {
        center: section.require("center", "[x, y, z] in metres")?.triple(Range::ANY)?,
        u,
        v,
        radiance: section
            .require("radiance", "a colour in W/(m² sr)")?
            .color(Range::NOT_NEGATIVE)?,
    })
}

fn environment(section: &Section<'_>) -> Result<LightKind> {
    let known = ["type", "radiance", "texture", "gradient", "scale", "rotate"];
    section.only("an environment", &known)?;
    section.at_most_one(&["radiance", "texture", "gradient"])?;
    let scale = section.or("scale", 1.0, |v| v.number(Range::NOT_NEGATIVE))?;
    if let Some(value) = section.get("gradient") {
        section.at_most_one(&["gradient", "rotate"])?;
        return Ok(LightKind::Gradient { stops: stops(&value, scale)? });
    }
    let texture =
        section.maybe("texture", |v| v.file("a latitude-longitude EXR, HDR, TIFF, PNG or JPEG"))?;
    let radiance = match &texture {
        Some(_) => Rgb::ONE,
        None => section
            .require("radiance", "a colour in W/(m² sr), `texture` or `gradient`")?
            .color(Range::NOT_NEGATIVE)?,
    };
    Ok(LightKind::Environment {
        radiance: radiance * scale,
        texture,
        rotate: section.or("rotate", 0.0, |v| v.number(Range::ANY))?,
    })
}

/// The stops of a gradient, their radiance times `scale`.
fn stops(value: &Value<'_>, scale: f64) -> Result<Vec<(f64, Rgb)>> {
    let right = "at least two stops [elevation, colour], going upward";
    let list = value.list(MAX_STOPS, right)?;
    if list.len() < 2 {
        return Err(value.wrong(right));
    }
    let mut stops: Vec<(f64, Rgb)> = Vec::with_capacity(list.len());
    for stop in &list {
        let right = "a stop [elevation, colour]";
        let pair = stop.list(2, right)?;
        let [elevation, color] = &pair[..] else { return Err(stop.wrong(right)) };
        let degrees = elevation.number(ELEVATION)?;
        if let Some((last, _)) = stops.last().filter(|(last, _)| degrees < *last) {
            return Err(elevation.wrong(&format!("an elevation not below the one before, {last}")));
        }
        stops.push((degrees, color.color(Range::NOT_NEGATIVE)? * scale));
    }
    Ok(stops)
}

fn position(section: &Section<'_>) -> Result<DVec3> {
    section.require("position", "[x, y, z] in metres")?.triple(Range::ANY)
}

fn strength(section: &Section<'_>) -> Result<Strength> {
    section.at_most_one(&["intensity", "power"])?;
    if let Some(power) = section.get("power") {
        return power.color(Range::NOT_NEGATIVE).map(Strength::Power);
    }
    let right = "a colour in W/sr, or `power` in W";
    section.require("intensity", right)?.color(Range::NOT_NEGATIVE).map(Strength::Intensity)
}
