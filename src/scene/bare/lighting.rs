//! Lights, ground and film of a bare render, as a scene.

use std::path::Path;

use glam::DVec3;
use toml::Value;

use super::super::keys::{camera, film, light, medium, surface};
use super::framing::Frame;
use super::look::{Ground, Look, LookOptions};
use super::subject::{Kind, Subject};
use crate::light::Environment;
use crate::math::Rgb;
use crate::scene::draft::{Draft, point, rounded, triple};

/// Direction of the key light for measurements, in the camera's (right, up, forward).
const KEY_TRAVEL: DVec3 = DVec3::new(0.7, -0.8, 0.6);
/// Its irradiance, W/m².
const KEY: f64 = 5.0;
/// Its angular diameter, in degrees.
const KEY_DIAMETER: f64 = 2.0;
/// Radiance of the sky for measurements, W/(m² sr).
const SKY: Rgb = Rgb::new(0.06, 0.08, 0.11);
/// Largest reflectance of the ground.
const MAX_REFLECTANCE: f64 = 0.8;

/// A light from infinitely far.
#[derive(Debug, Clone, Copy)]
struct DistantLight {
    title: &'static str,
    /// Its azimuth seen from the medium: degrees from the camera toward the camera's right.
    azimuth: f64,
    /// Degrees above the horizon.
    elevation: f64,
    /// W/m².
    irradiance: Rgb,
    /// Angular diameter in degrees.
    diameter: f64,
}

/// Lights and backdrop.
#[derive(Debug)]
struct LightingSetup {
    lights: Vec<DistantLight>,
    /// Radiance of the surroundings, W/(m² sr), by elevation in degrees.
    backdrop: Vec<(f64, Rgb)>,
}

impl LightingSetup {
    /// The lights and backdrop of a look; `None` for measurements.
    fn from_look(look: Look) -> Option<Self> {
        let grey = Rgb::splat;
        Some(match look {
            Look::Studio => Self {
                lights: vec![
                    DistantLight {
                        title: "Key: from the left and above",
                        azimuth: -80.0,
                        elevation: 40.0,
                        irradiance: Rgb::new(9.2, 8.6, 7.8),
                        diameter: 6.0,
                    },
                    DistantLight {
                        title: "Rim: from behind on the right",
                        azimuth: 150.0,
                        elevation: 20.0,
                        irradiance: Rgb::new(3.6, 4.3, 5.3),
                        diameter: 8.0,
                    },
                ],
                backdrop: vec![
                    (-90.0, Rgb::new(0.060, 0.062, 0.066)),
                    (-30.0, Rgb::new(0.020, 0.022, 0.026)),
                    (-14.0, Rgb::new(0.020, 0.023, 0.028)),
                    (0.0, Rgb::new(0.062, 0.070, 0.082)),
                    (14.0, Rgb::new(0.020, 0.024, 0.031)),
                    (35.0, Rgb::new(0.050, 0.060, 0.078)),
                    (90.0, Rgb::new(0.18, 0.22, 0.29)),
                ],
            },
            Look::Dusk => Self {
                lights: vec![DistantLight {
                    title: "Rim: what is left of the sky, from behind on the right",
                    azimuth: 155.0,
                    elevation: 35.0,
                    irradiance: Rgb::new(0.30, 0.38, 0.55),
                    diameter: 10.0,
                }],
                backdrop: vec![
                    (-90.0, grey(0.002)),
                    (0.0, Rgb::new(0.018, 0.021, 0.029)),
                    (12.0, Rgb::new(0.010, 0.013, 0.021)),
                    (90.0, Rgb::new(0.035, 0.048, 0.085)),
                ],
            },
            Look::Sky => Self {
                lights: vec![DistantLight {
                    title: "Sun: from the left and above",
                    azimuth: -92.0,
                    elevation: 32.0,
                    irradiance: Rgb::new(13.0, 12.0, 10.5),
                    diameter: 0.533,
                }],
                backdrop: vec![
                    (-90.0, Rgb::new(0.10, 0.11, 0.12)),
                    (-2.0, Rgb::new(0.16, 0.19, 0.22)),
                    (1.0, Rgb::new(0.46, 0.58, 0.74)),
                    (12.0, Rgb::new(0.20, 0.35, 0.62)),
                    (30.0, Rgb::new(0.10, 0.22, 0.50)),
                    (90.0, Rgb::new(0.05, 0.13, 0.36)),
                ],
            },
            Look::None => return None,
        })
    }

    /// The reflectance at which a lit, level ground is as bright as the horizon.
    fn ground_reflectance(&self) -> Rgb {
        let backdrop = Environment::gradient(&self.backdrop).expect("stops of a look go upward");
        let lights = self.lights.iter().map(|l| l.irradiance * l.elevation.to_radians().sin());
        let irradiance = lights.sum::<Rgb>() + backdrop.irradiance_up();
        let reflectance = backdrop.radiance(DVec3::X) * std::f64::consts::PI / irradiance;
        reflectance.min(Rgb::splat(MAX_REFLECTANCE))
    }
}

/// The scene that shows `subject` from `frame`; it names the file of `path`.
pub(super) fn draft(
    subject: &Subject,
    frame: &Frame,
    options: &LookOptions,
    size: [u32; 2],
    path: &Path,
) -> Draft {
    let mut draft = Draft::default();
    draft
        .table("camera", "Camera: the visible part fills 0.8 of the picture")
        .key(&camera::POSITION, point(frame.pose.position))
        .key(&camera::TARGET, point(frame.pose.target))
        .key(&camera::FOV, rounded(frame.fov));
    let exposure = if subject.look == Look::None { Value::Float(0.0) } else { "auto".into() };
    draft
        .table("film", "")
        .key(&film::SIZE, Value::Array(size.map(|n| Value::Integer(i64::from(n))).to_vec()))
        .key(&film::EXPOSURE, exposure)
        .key(&film::VIEW, "agx");
    medium(&mut draft, subject, path);
    match LightingSetup::from_look(subject.look) {
        Some(setup) => surroundings(&mut draft, &setup, subject, frame, options),
        None => for_measurements(&mut draft, frame),
    }
    draft
}

fn medium(draft: &mut Draft, subject: &Subject, path: &Path) {
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    draft
        .listed("medium", &format!("Medium: {}", subject.summary()))
        .key(&medium::FILE, file)
        .key(&medium::GRID, subject.name.as_str());
    if subject.occurrence > 0 {
        draft.key(&medium::INDEX, Value::Integer(subject.occurrence as i64));
    }
    if subject.level_set {
        draft.key(&medium::LEVEL_SET, "fog");
    }
    draft
        .key(&medium::SIGMA_T, rounded(subject.sigma_t))
        .key(&medium::ALBEDO, subject.albedo_value());
    if subject.g != 0.0 {
        let mut phase = toml::Table::new();
        phase.insert("type".into(), "henyey-greenstein".into());
        phase.insert("g".into(), subject.g.into());
        draft.key(&medium::PHASE_KEY, Value::Table(phase));
    }
    if let Some(emission) = subject.emission_value() {
        draft.key(&medium::EMISSION, emission);
    }
    if subject.rotation() != DVec3::ZERO {
        draft.key(&surface::ROTATE, triple(subject.rotation()));
    }
}

/// Adds key, rim, backdrop and, where the medium stands on one, the ground.
fn surroundings(
    draft: &mut Draft,
    setup: &LightingSetup,
    subject: &Subject,
    frame: &Frame,
    options: &LookOptions,
) {
    let back = frame.pose.position - frame.pose.target;
    let heading = back.x.atan2(back.z);
    for light in &setup.lights {
        let azimuth = heading + light.azimuth.to_radians();
        let (sin, cos) = light.elevation.to_radians().sin_cos();
        let toward = DVec3::new(cos * azimuth.sin(), sin, cos * azimuth.cos());
        draft
            .listed("light", light.title)
            .key(&light::TYPE, "sun")
            .key(&light::TRAVEL, triple(-toward))
            .key(&light::IRRADIANCE, triple(light.irradiance))
            .key(&light::DIAMETER, light.diameter);
    }
    let stops = setup.backdrop.iter().map(|(elevation, radiance)| {
        Value::Array(vec![Value::Float(*elevation), triple(*radiance)])
    });
    draft
        .listed("light", "Fill and backdrop")
        .key(&light::TYPE, "environment")
        .key(&light::GRADIENT, Value::Array(stops.collect()));
    let stands = match options.ground {
        Ground::Auto => subject.kind != Kind::Cloud && subject.look != Look::Sky && subject.stands,
        Ground::On => true,
        Ground::Off => false,
    };
    if stands {
        // Of such reflectance that the lit ground and the backdrop meet at the horizon without a line.
        let mut material = toml::Table::new();
        material.insert("type".into(), "diffuse".into());
        material.insert("reflectance".into(), triple(setup.ground_reflectance()));
        draft
            .listed("surface", "Ground, as bright as the horizon")
            .key(&surface::SHAPE, "plane")
            .key(&surface::POINT, point(DVec3::new(0.0, frame.bottom, 0.0)))
            .key(&surface::MATERIAL, Value::Table(material));
    }
}

/// Adds one key light from the upper left in front, and a faint sky of constant radiance.
fn for_measurements(draft: &mut Draft, frame: &Frame) {
    let Some([right, up, forward]) = frame.pose.axes() else { return };
    let travel = right * KEY_TRAVEL.x + up * KEY_TRAVEL.y + forward * KEY_TRAVEL.z;
    draft
        .listed("light", "Key: from the upper left, in front")
        .key(&light::TYPE, "sun")
        .key(&light::TRAVEL, triple(travel))
        .key(&light::IRRADIANCE, KEY)
        .key(&light::DIAMETER, KEY_DIAMETER);
    draft
        .listed("light", "Sky")
        .key(&light::TYPE, "environment")
        .key(&light::SKY_RADIANCE, triple(SKY));
}
