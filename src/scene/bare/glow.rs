//! Emission of fire in a bare render.

use toml::Value;

use super::measure::{mean_thickness, world_bounds};
use crate::math::luminance;
use crate::medium::blackbody::{blackbody_color, blackbody_radiance};
use crate::scene::draft::{rounded, triple};
use crate::vdb::Grid;
use crate::vdb::roles::{Fire, FireKind, Unit};

/// Temperature of the hottest voxel where a grid does not hold kelvin.
const HOTTEST: f64 = 1900.0;
/// 0 degrees Celsius in kelvin.
const CELSIUS: f64 = 273.15;
/// Temperatures, in kelvin, whose blackbodies give the glow of a flame its hues, by its strength over the
/// largest; its luminance goes with the square of that.
const FLAME: [(f64, f64); 6] =
    [(0.0, 700.0), (0.15, 1000.0), (0.35, 1250.0), (0.6, 1500.0), (0.85, 1750.0), (1.0, HOTTEST)];
/// Radiance along a ray through a flame's mean thickness with the largest value throughout; flames are
/// weaker nearly everywhere.
const FLAME_GLOW: f64 = 2.0;
/// Radiance of optically thick voxels of the largest temperature: brighter than smoke in the key light.
const GLOW: f64 = 10.0;
/// Kelvin where a normalised temperature is 0: too cold to glow.
const COLD: f64 = 300.0;

/// The emission of a bare render.
#[derive(Debug)]
pub(super) struct Glow {
    /// The grid, by its name.
    pub(super) grid: String,
    /// Its number among the grids of that name.
    occurrence: Option<usize>,
    /// The unit of its values, in words.
    pub(super) unit: &'static str,
    kind: GlowKind,
}

#[derive(Debug)]
enum GlowKind {
    /// A blackbody at `kelvin_offset + kelvin_scale` x value kelvin, times `scale`.
    Blackbody { kelvin_scale: f64, kelvin_offset: f64, scale: f64 },
    /// Emission by a ramp over the values, the largest of which is `max`; their mean integral along a ray is
    /// `max` times `length` metres.
    Intensity { max: f64, length: f64 },
}

impl Glow {
    /// The emission of `fire`, whose voxels are `grid`; `None`, with a note, where it is too cold to be seen.
    pub(super) fn from_fire(
        fire: &Fire,
        grid: &Grid<f32>,
        notes: &mut Vec<String>,
    ) -> Option<Self> {
        let max = fire.range[1];
        let unit = match fire.kind {
            FireKind::Intensity | FireKind::Temperature(Unit::Normalised) => "",
            FireKind::Temperature(Unit::Kelvin) => " in kelvin",
            FireKind::Temperature(Unit::Celsius) => " in degrees Celsius",
        };
        let kind = match fire.kind {
            FireKind::Intensity => {
                let integral = mean_thickness(grid, &world_bounds(grid)?);
                GlowKind::Intensity { max, length: integral / max }
            }
            FireKind::Temperature(unit) => {
                let (kelvin_scale, kelvin_offset) = match unit {
                    Unit::Normalised => ((HOTTEST - COLD) / max, COLD),
                    Unit::Kelvin => (1.0, 0.0),
                    Unit::Celsius => (1.0, CELSIUS),
                };
                let hottest = luminance(blackbody_radiance(kelvin_scale * max + kelvin_offset));
                let scale = GLOW / hottest.max(f64::MIN_POSITIVE);
                if !scale.is_finite() || scale > 1e12 {
                    notes.push(format!(
                        "grid \"{}\" glows nowhere: it is too cold",
                        fire.grid.label()
                    ));
                    return None;
                }
                GlowKind::Blackbody { kelvin_scale, kelvin_offset, scale }
            }
        };
        let label = fire.grid.label();
        let (name, occurrence) = match label.strip_suffix(']').and_then(|l| l.rsplit_once('[')) {
            Some((name, number)) if number.parse::<usize>().is_ok() => (name, number.parse().ok()),
            _ => (label, None),
        };
        Some(Self { grid: name.into(), occurrence, unit, kind })
    }

    /// The value of the key `emission`.
    pub(super) fn value(&self) -> Value {
        let mut table = toml::Table::new();
        let mut put = |key: &str, value: Value| drop(table.insert(key.into(), value));
        let number = |x: f64| Value::Float(rounded(x));
        let name =
            if matches!(self.kind, GlowKind::Intensity { .. }) { "grid" } else { "temperature" };
        put(name, self.grid.as_str().into());
        if let Some(index) = self.occurrence {
            put("index", Value::Integer(index as i64));
        }
        match self.kind {
            GlowKind::Blackbody { kelvin_scale, kelvin_offset, scale } => {
                put("kelvin_scale", number(kelvin_scale));
                put("kelvin_offset", number(kelvin_offset));
                put("scale", number(scale));
            }
            GlowKind::Intensity { max, length } => {
                // The hues of blackbodies, and not their luminance, which falls by ten powers of ten.
                let stops = FLAME.map(|(place, kelvin)| {
                    let color = blackbody_color(kelvin) * (place * place);
                    Value::Array(vec![Value::Float(place), triple(color)])
                });
                put("from", Value::Array(vec![Value::Float(0.0), number(max)]));
                put("ramp", Value::Array(stops.to_vec()));
                put("scale", number(FLAME_GLOW / length));
            }
        }
        Value::Table(table)
    }
}
