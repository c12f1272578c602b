//! Cameras of a shot.

use glam::DVec3;
use toml::Value;

use super::values::Reader;
use super::walk::Placed;
use crate::error::{Error, Result};
use crate::scene::draft::{Draft, exact, rounded};
use crate::scene::keys::{camera as keys, film};

/// Width of the film in pixels where the shot says nothing of it: that of the key `film.size`.
const WIDTH: f64 = 960.0;

/// The aperture and focal length of a camera without any, in tenths of the stage's unit:
/// the fallbacks of UsdGeomCamera.
const FALLBACK: [f64; 3] = [20.955, 15.2908, 50.0];

/// A camera of the shot.
#[derive(Debug, Clone)]
pub(super) struct Camera {
    /// Its path.
    pub(super) path: String,
    position: DVec3,
    forward: DVec3,
    up: DVec3,
    lens: Lens,
    /// Height of its aperture over width.
    aspect: f64,
    /// How far the aperture is shifted rightward and upward, in widths of it.
    shift: [f64; 2],
    /// Nearest and farthest distance that it sees, in metres, where the file says them.
    clip: Option<[f64; 2]>,
    /// What of it is left out, one line each.
    pub(super) warnings: Vec<String>,
}

#[derive(Debug, Clone, Copy)]
enum Lens {
    Perspective {
        /// Full angle along the width, in degrees.
        fov: f64,
        /// Diameter in metres and distance of the focus in metres, of a thin lens.
        thin: Option<[f64; 2]>,
    },
    Orthographic {
        /// Height of the view in metres.
        height: f64,
    },
}

impl Camera {
    /// The camera that `placed` is; a unit of the stage is `metres` long.
    pub(super) fn read(reader: &Reader<'_>, placed: &Placed, metres: f64) -> Result<Self> {
        let path = &placed.path;
        let number = |name| reader.number(path, name);
        let positive = |name, fallback| -> Result<f64> {
            let value = number(name)?.unwrap_or(fallback);
            if value > 0.0 {
                return Ok(value);
            }
            Err(reader.wrong(path, format!("{name} is {value}; give a number above 0")))
        };
        let width = positive("horizontalAperture", FALLBACK[0])?;
        let height = positive("verticalAperture", FALLBACK[1])?;
        let focal = positive("focalLength", FALLBACK[2])?;
        let offset = |name| Ok::<_, Error>(number(name)?.unwrap_or(0.0) / width);
        let shift = [offset("horizontalApertureOffset")?, offset("verticalApertureOffset")?];
        let mut warnings = Vec::new();
        let mut clip = reader.numbers(path, "clippingRange")?.map(|clip| clip.map(|d| d * metres));
        if clip.is_some_and(|[near, far]| near < 0.0 || near >= far) {
            let said = "clippingRange is left out: give a nearest distance of at least 0 below the farthest";
            warnings.push(reader.wrong(path, said).to_string());
            clip = None;
        }
        let is_parallel = reader.word(path, "projection")?.as_deref() == Some("orthographic");
        let lens = if is_parallel {
            Lens::Orthographic { height: 0.1 * height * metres }
        } else {
            let f_stop = number("fStop")?.filter(|stop| *stop > 0.0);
            let focus = number("focusDistance")?.filter(|distance| *distance > 0.0);
            let thin = f_stop.zip(focus);
            Lens::Perspective {
                fov: 2.0 * (0.5 * width / focal).atan().to_degrees(),
                thin: thin.map(|(stop, focus)| [0.1 * focal / stop * metres, focus * metres]),
            }
        };
        let direction = |v| placed.to_world.transform_vector3(v).try_normalize();
        let axes = direction(DVec3::NEG_Z).zip(direction(DVec3::Y));
        let (forward, up) = axes.ok_or_else(|| {
            reader.wrong(path, "its transform is singular; give a scale other than 0")
        })?;
        let position = placed.to_world.translation;
        let path = path.as_str().to_owned();
        Ok(Self {
            path,
            position,
            forward,
            up,
            lens,
            aspect: height / width,
            shift,
            clip,
            warnings,
        })
    }

    /// Writes it and a film of its shape, or of the size of the shot's render settings.
    pub(super) fn write(&self, draft: &mut Draft, resolution: Option<[i64; 2]>) {
        // The target lies on the plane in focus.
        let distance = match self.lens {
            Lens::Perspective { thin: Some([_, focus]), .. } => focus,
            _ => 1.0,
        };
        let kind = if matches!(self.lens, Lens::Orthographic { .. }) {
            "orthographic"
        } else {
            "perspective"
        };
        draft
            .table("camera", &format!("{}: camera", self.path))
            .key(&keys::TYPE, kind)
            .key(&keys::POSITION, exact(self.position))
            .key(&keys::TARGET, exact(self.position + self.forward * distance))
            .key(&keys::UP, exact(self.up));
        match self.lens {
            Lens::Orthographic { height } => {
                draft.key(&keys::HEIGHT, height);
            }
            Lens::Perspective { fov, thin } => {
                draft.key(&keys::FOV, fov);
                if let Some([diameter, focus]) = thin {
                    draft.key(&keys::APERTURE, rounded(diameter)).key(&keys::FOCUS, focus);
                }
            }
        }
        if self.shift != [0.0; 2] {
            draft.key(&keys::SHIFT, self.shift.to_vec());
        }
        if let Some(clip) = self.clip {
            draft.key(&keys::CLIP, clip.to_vec());
        }
        let by_aperture = || [WIDTH as i64, (WIDTH * self.aspect).round().max(1.0) as i64];
        let size = resolution.unwrap_or_else(by_aperture);
        let size = Value::Array(size.map(Value::Integer).to_vec());
        draft.table("film", "").key(&film::SIZE, size);
    }
}
