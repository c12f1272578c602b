//! Lights of a shot (UsdLux) as those of a scene.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DVec3};

use super::geometry::Geometry;
use super::primitive;
use super::shot::Files;
use super::values::Reader;
use super::walk::{Placed, StageSpace};
use crate::error::Result;
use crate::math::{Rgb, luminance};
use crate::medium::blackbody::blackbody_color;
use crate::scene::draft::{Draft, exact};
use crate::scene::keys::{light as keys, surface};

/// What Blender's exporter divides the strength of suns by; `tests/check/usd.sh` holds it against Cycles.
const BLENDER_SUN: f64 = 4.0;

/// Half angle, in degrees, from which a spot is no cone.
const NO_CONE: f64 = 90.0;

/// The lights that are taken.
const KINDS: [&str; 6] =
    ["SphereLight", "RectLight", "DiskLight", "DistantLight", "DomeLight", "DomeLight_1"];

/// Where lights of a shot go.
pub(super) struct Lights<'a> {
    pub(super) reader: &'a Reader<'a>,
    pub(super) draft: &'a mut Draft,
    pub(super) files: &'a mut Files,
    /// Surfaces that shine.
    pub(super) geometry: &'a mut Geometry,
    pub(super) warnings: &'a mut Vec<String>,
    /// Whether Blender wrote the file.
    pub(super) by_blender: bool,
    /// How the stage lies in the world.
    pub(super) space: StageSpace,
}

/// Whether prims of this type are lights.
pub(super) fn is_light(kind: &str) -> bool {
    kind.ends_with("Light") || kind == "DomeLight_1"
}

impl Lights<'_> {
    /// Adds the light `placed`.
    pub(super) fn add(&mut self, placed: &Placed) -> Result<()> {
        let kind = placed.kind.as_str();
        if !KINDS.contains(&kind) {
            self.warn(placed, format!("a {kind} is left out; known are {}", KINDS.join(", ")));
            return Ok(());
        }
        let color = self.color(placed)?;
        if color == Rgb::ZERO {
            return Ok(());
        }
        match kind {
            "SphereLight" => self.sphere(placed, color),
            "RectLight" => self.rectangle(placed, color),
            "DiskLight" => self.disk(placed, color),
            "DistantLight" => self.distant(placed, color),
            _ => self.dome(placed, color),
        }
    }

    fn warn(&mut self, placed: &Placed, problem: impl std::fmt::Display) {
        self.warnings.push(self.reader.wrong(&placed.path, problem).to_string());
    }

    fn number(&self, placed: &Placed, name: &str, fallback: f64) -> Result<f64> {
        // Without the prefix, where the file is older than the schema's 21.02.
        let named = self.reader.number(&placed.path, &format!("inputs:{name}"))?;
        let named = match named {
            None => self.reader.number(&placed.path, name)?,
            named => named,
        };
        Ok(named.unwrap_or(fallback))
    }

    /// Radiance, or what `normalize` makes of it: intensity, exposure, colour and colour temperature.
    fn color(&self, placed: &Placed) -> Result<Rgb> {
        let path = &placed.path;
        let fallback = if placed.kind == "DistantLight" { 50_000.0 } else { 1.0 };
        let intensity = self.number(placed, "intensity", fallback)?;
        let exposure = self.number(placed, "exposure", 0.0)?;
        let color = self.reader.triple(path, "inputs:color")?.unwrap_or(Rgb::ONE);
        let temperature = if self.reader.flag(path, "inputs:enableColorTemperature")? {
            blackbody_color(self.number(placed, "colorTemperature", 6500.0)?)
        } else {
            Rgb::ONE
        };
        Ok((color * temperature * intensity * exposure.exp2()).max(Rgb::ZERO))
    }

    /// `color` as radiance of a surface of `area`, in square units of the stage.
    fn radiance(&self, placed: &Placed, color: Rgb, area: f64) -> Result<Rgb> {
        let normalize = self.reader.flag(&placed.path, "inputs:normalize")?;
        Ok(if normalize && area > 0.0 { color / area } else { color })
    }

    fn sphere(&mut self, placed: &Placed, color: Rgb) -> Result<()> {
        let radius = self.number(placed, "radius", 0.5)?;
        let is_point = radius <= 0.0 || self.reader.flag(&placed.path, "treatAsPoint")?;
        // The radius in metres of a ball as large as the one that is scaled.
        let scale = placed.to_world.matrix3.determinant().abs().cbrt();
        let world_radius = radius * scale;
        let area = 4.0 * PI * (world_radius / self.space.metres).powi(2);
        let normalize = self.reader.flag(&placed.path, "inputs:normalize")?;
        // Of a ball of radiance L the radiant intensity is that times the area of its disk.
        let intensity = if normalize {
            color / 4.0 * self.space.metres * self.space.metres
        } else {
            color * PI * world_radius * world_radius
        };
        let cone = self.number(placed, "shaping:cone:angle", NO_CONE)?;
        if cone < NO_CONE && cone > 0.0 {
            return self.spot(placed, intensity, cone);
        }
        if is_point {
            if intensity == Rgb::ZERO {
                self.warn(placed, "a point without `normalize` has no size and gives no light");
                return Ok(());
            }
            self.draft
                .listed("light", &title(placed, "sphere light without a size"))
                .key(&keys::TYPE, "point")
                .key(&keys::POSITION, exact(placed.to_world.translation))
                .key(&keys::INTENSITY, exact(intensity));
            return Ok(());
        }
        let radiance = self.radiance(placed, color, area)?;
        let place = placed.to_world * DAffine3::from_scale(DVec3::splat(radius));
        self.geometry.add_lamp(placed.path.as_str(), &place, primitive::sphere(), radiance);
        Ok(())
    }

    fn spot(&mut self, placed: &Placed, intensity: Rgb, cone: f64) -> Result<()> {
        let softness = self.number(placed, "shaping:cone:softness", 0.0)?.clamp(0.0, 1.0);
        // The light fades in the cosine, as Cycles and pbrt have it, from the edge inward.
        let edge = cone.to_radians().cos();
        let start = (edge + (1.0 - edge) * softness).clamp(-1.0, 1.0).acos().to_degrees();
        if self.number(placed, "shaping:focus", 0.0)? != 0.0 {
            self.warn(placed, "shaping:focus is left out");
        }
        self.draft
            .listed("light", &title(placed, "sphere light with a cone"))
            .key(&keys::TYPE, "spot")
            .key(&keys::POSITION, exact(placed.to_world.translation))
            .key(&keys::DIRECTION, exact(placed.to_world.transform_vector3(DVec3::NEG_Z)))
            .key(&keys::INTENSITY, exact(intensity))
            .key(&keys::ANGLE, cone)
            .key(&keys::FALLOFF, (cone - start).clamp(0.0, cone));
        Ok(())
    }

    fn rectangle(&mut self, placed: &Placed, color: Rgb) -> Result<()> {
        let width = self.number(placed, "width", 1.0)?;
        let height = self.number(placed, "height", 1.0)?;
        let half = |v: DVec3| 0.5 * placed.to_world.transform_vector3(v);
        // It shines along -z.
        let (u, v) = (half(DVec3::Y * height), half(DVec3::X * width));
        let area = 4.0 * u.cross(v).length();
        if area <= 0.0 {
            self.warn(placed, "has no area and gives no light");
            return Ok(());
        }
        self.shaping_is_left_out(placed)?;
        if self.reader.asset(&placed.path, "inputs:texture:file")?.is_some() {
            self.warn(placed, "its texture is left out");
        }
        let radiance =
            self.radiance(placed, color, area / (self.space.metres * self.space.metres))?;
        self.draft
            .listed("light", &title(placed, "rectangular light"))
            .key(&keys::TYPE, "area")
            .key(&keys::CENTER, exact(placed.to_world.translation))
            .key(&surface::U, exact(u))
            .key(&surface::V, exact(v))
            .key(&keys::RADIANCE, exact(radiance));
        Ok(())
    }

    fn disk(&mut self, placed: &Placed, color: Rgb) -> Result<()> {
        let radius = self.number(placed, "radius", 0.5)?;
        let place = placed.to_world * DAffine3::from_scale(DVec3::splat(radius));
        let axis = |v: DVec3| place.transform_vector3(v) / self.space.metres;
        let area = PI * axis(DVec3::X).cross(axis(DVec3::Y)).length();
        if area <= 0.0 {
            self.warn(placed, "has no area and gives no light");
            return Ok(());
        }
        self.shaping_is_left_out(placed)?;
        let radiance = self.radiance(placed, color, area)?;
        self.geometry.add_lamp(placed.path.as_str(), &place, primitive::disk(), radiance);
        Ok(())
    }

    fn shaping_is_left_out(&mut self, placed: &Placed) -> Result<()> {
        if self.number(placed, "shaping:cone:angle", NO_CONE)? < NO_CONE {
            self.warn(placed, "its cone is left out: only sphere lights have one here");
        }
        Ok(())
    }

    fn distant(&mut self, placed: &Placed, color: Rgb) -> Result<()> {
        let angle = self.number(placed, "angle", 0.53)?.clamp(0.0, 179.0);
        let solid = PI * (0.5 * angle.to_radians()).sin().powi(2);
        let normalize = self.reader.flag(&placed.path, "inputs:normalize")?;
        let irradiance = if normalize || angle == 0.0 { color } else { color * solid };
        let blender = if self.by_blender { BLENDER_SUN } else { 1.0 };
        self.draft
            .listed("light", &title(placed, "distant light"))
            .key(&keys::TYPE, "sun")
            .key(&keys::TRAVEL, exact(placed.to_world.transform_vector3(DVec3::NEG_Z)))
            .key(&keys::IRRADIANCE, exact(irradiance * blender))
            .key(&keys::DIAMETER, angle);
        Ok(())
    }

    fn dome(&mut self, placed: &Placed, color: Rgb) -> Result<()> {
        let texture = self.reader.asset(&placed.path, "inputs:texture:file")?;
        self.draft.listed("light", &title(placed, "dome light")).key(&keys::TYPE, "environment");
        let Some(texture) = texture else {
            self.draft.key(&keys::SKY_RADIANCE, exact(color));
            return Ok(());
        };
        let name = self.files.asset(texture);
        if color.max_element() - color.min_element() > 1e-6 * color.max_element() {
            self.warn(placed, "the colour on its texture is taken as grey");
        }
        let pole = self.reader.word(&placed.path, "poleAxis")?;
        let pole_is_up =
            placed.kind == "DomeLight_1" && self.space.z_up && pole.as_deref() != Some("Y");
        let upright = if pole_is_up { DMat3::from_rotation_x(0.5 * PI) } else { DMat3::IDENTITY };
        let (rotation, is_level) = turn_of_sky(&(placed.to_world.matrix3 * upright));
        // Blender does not turn its even skies upright.
        if !is_level && !self.by_blender {
            self.warn(
                placed,
                "its turn is about an axis other than the upright one; that is left out",
            );
        }
        self.draft
            .key(&keys::SKY, name.as_str())
            .key(&keys::SKY_SCALE, luminance(color))
            .key(&keys::SKY_ROTATE, rotation);
        Ok(())
    }
}

/// The turn of a dome about the upright axis in degrees, as the key `rotate` has it, and whether that is all of
/// its turn.
fn turn_of_sky(to_world: &DMat3) -> (f64, bool) {
    let up = (*to_world * DVec3::Y).normalize_or_zero();
    // The middle of the picture looks along +z of the dome, and along +z of the world where it is not turned.
    let middle = *to_world * DVec3::Z;
    let degrees = middle.x.atan2(middle.z).to_degrees();
    (degrees + 0.0, up.dot(DVec3::Y) > 1.0 - 1e-6)
}

fn title(placed: &Placed, what: &str) -> String {
    format!("{}: {what}", placed.path.as_str())
}
