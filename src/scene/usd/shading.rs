//! Shading of volumes: by their material, in the terms of Blender's Principled Volume and of MaterialX's volumes.

use std::path::{Path, PathBuf};

use openusd::sdf;
use toml::Value;

use super::shot::Files;
use super::values::Reader;
use crate::error::Result;
use crate::math::{Rgb, luminance};
use crate::medium::blackbody::blackbody_color;
use crate::scene::bare::Appearance;
use crate::scene::draft::{Draft, exact};
use crate::scene::keys::medium as keys;

/// Hottest temperature of a blackbody's ramp, in kelvin: beyond fire.
const HOTTEST: f64 = 8000.0;
/// Intervals of that ramp, between which the fourth power of temperature is taken as linear.
const INTERVALS: u32 = 160;
/// Radiance of a blackbody of 1 K over its fourth power, in W/(m² sr), times the factor that makes
/// flames of 1000 K about 0.02 (Cycles' Principled Volume).
const STEFAN_BOLTZMANN: f64 = 5.670_373e-8 * 1e-6 / std::f64::consts::PI;

/// The shading of a medium.
#[derive(Debug, Clone)]
pub(super) enum Shading {
    /// As the material says.
    Given(Given),
    /// Chosen by what is in the file, as for a VDB file alone.
    Chosen(Appearance),
}

/// What a material says of a volume.
#[derive(Debug, Clone)]
pub(super) struct Given {
    /// The field that it takes for density.
    pub(super) density_grid: Option<String>,
    /// For density 1, 1/m.
    sigma_t: Rgb,
    albedo: Rgb,
    /// The field of the albedo, which `albedo` is then a factor on.
    color_grid: Option<String>,
    g: f64,
    emission: Option<Emission>,
}

#[derive(Debug, Clone)]
enum Emission {
    /// Coefficient for density 1, or for a value of 1 of a field, W/(m³ sr).
    Even { color: Rgb, grid: Option<String> },
    /// Of a blackbody at the field times `kelvin`.
    Blackbody { grid: String, kelvin: f64, intensity: f64, tint: Rgb },
}

impl Given {
    /// What `material` says of volumes, a unit of the stage being `metres` long; nothing where it has no volume
    /// shader.
    pub(super) fn read(
        reader: &Reader<'_>,
        material: &sdf::Path,
        metres: f64,
    ) -> Result<Option<Self>> {
        let mut shader = None;
        for output in ["outputs:volume", "outputs:mtlx:volume"] {
            shader = reader.source(material, output)?;
            if shader.is_some() {
                break;
            }
        }
        let Some(shader) = shader else { return Ok(None) };
        let shader = reader.source(&shader, "inputs:vdf")?.unwrap_or(shader);
        let inputs = Inputs { reader, shader: &shader };
        let by_coefficients = [inputs.color("scattering")?, inputs.color("absorption")?];
        let (sigma_t, albedo) = match by_coefficients {
            [None, None] => principled(&inputs)?,
            [scattering, absorption] => {
                let [scattering, absorption] =
                    [scattering, absorption].map(Option::unwrap_or_default);
                let sum = scattering + absorption;
                let share = |s: f64, t: f64| if t > 0.0 { s / t } else { 0.0 };
                (sum, Rgb::from([0, 1, 2].map(|i| share(scattering[i], sum[i]))))
            }
        };
        let g = inputs.number(&["anisotropy", "scatter_anisotropy"], 0.0)?;
        Ok(Some(Self {
            density_grid: inputs.field(&["density_channel", "density_attribute"])?,
            sigma_t: sigma_t.max(Rgb::ZERO) / metres,
            albedo: albedo.clamp(Rgb::ZERO, Rgb::ONE),
            color_grid: inputs.field(&[
                "scatter_color_channel",
                "color_channel",
                "color_attribute",
            ])?,
            g: g.clamp(-0.99, 0.99),
            emission: emission(&inputs, metres)?,
        }))
    }

    /// Writes the keys of its medium, whose density is in `density`. `field` finds the grid and the file of a
    /// field.
    fn write(
        &self,
        draft: &mut Draft,
        files: &mut Files,
        density: &str,
        field: &dyn Fn(&str) -> Option<(String, PathBuf)>,
    ) {
        let mut table = |name: &str, key: &str| -> Option<toml::Table> {
            let (grid, file) = field(name)?;
            let mut table = toml::Table::new();
            table.insert(key.into(), grid.into());
            let file = files.asset(file);
            if file != density {
                table.insert("file".into(), file.into());
            }
            Some(table)
        };
        draft.key(&keys::SIGMA_T, exact(self.sigma_t));
        let color = self.color_grid.as_ref().and_then(|name| table(name, "grid"));
        match color {
            Some(mut grid) if luminance(self.albedo) > 0.0 => {
                grid.insert("scale".into(), luminance(self.albedo).into());
                draft.key(&keys::ALBEDO, grid);
            }
            _ => {
                draft.key(&keys::ALBEDO, exact(self.albedo));
            }
        }
        write_phase(draft, self.g);
        match &self.emission {
            None => {}
            Some(Emission::Even { color, grid }) => {
                let by_grid = grid.as_ref().and_then(|name| table(name, "grid"));
                let mut emission = by_grid.unwrap_or_default();
                emission.insert("color".into(), exact(*color));
                draft.key(&keys::EMISSION, emission);
            }
            Some(Emission::Blackbody { grid, kelvin, intensity, tint }) => {
                if let Some(mut emission) = table(grid, "grid") {
                    let to = HOTTEST / kelvin;
                    emission.insert("from".into(), Value::Array(vec![0.0.into(), to.into()]));
                    emission.insert("ramp".into(), blackbody_ramp(*intensity, *tint));
                    draft.key(&keys::EMISSION, emission);
                }
            }
        }
    }
}

impl Shading {
    /// As [`Given::write`].
    pub(super) fn write(
        &self,
        draft: &mut Draft,
        files: &mut Files,
        density: &str,
        field: &dyn Fn(&str) -> Option<(String, PathBuf)>,
    ) {
        match self {
            Self::Given(given) => given.write(draft, files, density, field),
            Self::Chosen(chosen) => {
                draft.key(&keys::SIGMA_T, chosen.sigma_t).key(&keys::ALBEDO, chosen.albedo.clone());
                write_phase(draft, chosen.g);
                if let Some(emission) = &chosen.emission {
                    draft.key(&keys::EMISSION, emission.clone());
                }
            }
        }
    }
}

fn write_phase(draft: &mut Draft, g: f64) {
    if g != 0.0 {
        let mut phase = toml::Table::new();
        phase.insert("type".into(), "henyey-greenstein".into());
        phase.insert("g".into(), g.into());
        draft.key(&keys::PHASE_KEY, Value::Table(phase));
    }
}

/// Extinction for density 1 and albedo of the Principled Volume: what is not scattered is absorbed, less where
/// the absorption colour is bright.
fn principled(inputs: &Inputs<'_>) -> Result<(Rgb, Rgb)> {
    let density = inputs.number(&["density"], 1.0)?;
    let color = inputs.color("scatter_color")?.or(inputs.color("color")?);
    let color = color.unwrap_or(Rgb::splat(0.5)).clamp(Rgb::ZERO, Rgb::ONE);
    let absorption = inputs.color("absorption_color")?.unwrap_or(Rgb::ZERO);
    let kept = absorption.clamp(Rgb::ZERO, Rgb::ONE).map(f64::sqrt);
    let absorbed = (Rgb::ONE - color) * (Rgb::ONE - kept);
    let sum = color + absorbed;
    let albedo = Rgb::from([0, 1, 2].map(|i| if sum[i] > 0.0 { color[i] / sum[i] } else { 0.0 }));
    Ok((sum * density, albedo))
}

fn emission(inputs: &Inputs<'_>, metres: f64) -> Result<Option<Emission>> {
    let intensity = inputs.number(&["blackbody", "blackbody_intensity"], 0.0)?;
    if intensity > 0.0 {
        let grid = inputs.field(&["temperature_channel", "temperature_attribute"])?;
        return Ok(Some(Emission::Blackbody {
            grid: grid.unwrap_or_else(|| "temperature".into()),
            kelvin: inputs.number(&["temperature", "blackbody_kelvin"], 1000.0)?.max(1e-6),
            intensity,
            tint: inputs.color("blackbody_tint")?.unwrap_or(Rgb::ONE).max(Rgb::ZERO) / metres,
        }));
    }
    let strength = inputs.number(&["emission", "emission_strength"], 0.0)?;
    let color = inputs.color("emission_color")?.unwrap_or(Rgb::ONE) * strength / metres;
    if !(color.min_element() >= 0.0 && color.max_element() > 0.0) {
        return Ok(None);
    }
    let grid = inputs.field(&["emission_channel", "emission_attribute"])?;
    Ok(Some(Emission::Even { color, grid }))
}

/// Emission by temperature from 0 to [`HOTTEST`], as Cycles has it: the colour of a blackbody, times the fourth
/// power of its temperature as far as `intensity` says.
fn blackbody_ramp(intensity: f64, tint: Rgb) -> Value {
    let stop = |k: u32| {
        let place = f64::from(k) / f64::from(INTERVALS);
        let kelvin = place * HOTTEST;
        let power = STEFAN_BOLTZMANN * (1.0 + (kelvin.powi(4) - 1.0) * intensity);
        let color = blackbody_color(kelvin) * power * tint;
        Value::Array(vec![Value::Float(place), exact(color.max(Rgb::ZERO))])
    };
    Value::Array((0..=INTERVALS).map(stop).collect())
}

/// Inputs of a volume shader.
struct Inputs<'a> {
    reader: &'a Reader<'a>,
    shader: &'a sdf::Path,
}

impl Inputs<'_> {
    /// The first of these that is there.
    fn number(&self, names: &[&str], fallback: f64) -> Result<f64> {
        for name in names {
            if let Some(number) = self.reader.number(self.shader, &format!("inputs:{name}"))? {
                return Ok(number);
            }
        }
        Ok(fallback)
    }

    fn color(&self, name: &str) -> Result<Option<Rgb>> {
        self.reader.triple(self.shader, &format!("inputs:{name}"))
    }

    /// The name of a field that the first of these gives.
    fn field(&self, names: &[&str]) -> Result<Option<String>> {
        for name in names {
            let word = self.reader.word(self.shader, &format!("inputs:{name}"))?;
            if let Some(word) = word.filter(|word| !word.is_empty()) {
                return Ok(Some(word));
            }
        }
        Ok(None)
    }
}

/// The file among `files` from which the look of a volume without a material is chosen: the largest.
pub(super) fn largest<'f>(files: impl Iterator<Item = &'f Path>) -> Option<&'f Path> {
    let size = |file: &&Path| std::fs::metadata(file).map_or(0, |file| file.len());
    // Of several as large the first.
    files.fold(None, |best: Option<&Path>, file| match best {
        Some(known) if size(&known) >= size(&file) => Some(known),
        _ => Some(file),
    })
}
