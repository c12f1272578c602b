//! A latitude-longitude picture as environment.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::super::checked_color;
use crate::math::{Cdf, Rgb, are_grey, is_grey, luminance};

/// A picture with what sampling it takes: texels are chosen by luminance times solid angle, then
/// directions uniformly in the texel, so that the density is the luminance over its integral.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    width: usize,
    height: usize,
    texels: Vec<[f32; 3]>,
    scale: Rgb,
    /// Rotation as a share of the full circle.
    turn: f64,
    /// Over rows, and in each row over columns; nothing in rows and pictures that are black.
    rows: Option<Cdf>,
    columns: Vec<Option<Cdf>>,
    /// Integral of radiance over the sphere, W/m².
    integral: Rgb,
}

impl Picture {
    /// As [`Environment::picture`](super::Environment::picture).
    pub(super) fn new(
        width: usize,
        height: usize,
        mut texels: Vec<[f32; 3]>,
        scale: Rgb,
        rotation: f64,
    ) -> Result<Self, String> {
        if texels.is_empty() || width.checked_mul(height) != Some(texels.len()) {
            return Err(format!(
                "environment has {} texels: must have {width} x {height}, at least one",
                texels.len()
            ));
        }
        if let Some(i) = texels.iter().position(|t| !t.iter().all(|v| v.is_finite())) {
            return Err(format!(
                "environment: texel {} of row {} is {:?}: must be finite",
                i % width,
                i / width,
                texels[i]
            ));
        }
        if !rotation.is_finite() {
            return Err(format!("rotation is {rotation}°: must be finite"));
        }
        for value in texels.as_flattened_mut() {
            *value = value.max(0.0);
        }
        let scale = checked_color("scale", scale)?;
        let turn = (rotation / 360.0).rem_euclid(1.0);
        let mut picture = Self {
            width,
            height,
            texels,
            scale,
            turn,
            rows: None,
            columns: Vec::new(),
            integral: Rgb::ZERO,
        };
        for row in 0..height {
            let colors = (0..width).map(|column| picture.color(row, column));
            let sum: Rgb = colors.clone().sum();
            picture.columns.push(Cdf::new(colors.map(luminance)));
            picture.integral += sum * picture.texel_solid_angle(row);
        }
        picture.rows = Cdf::new((0..height).map(|row| {
            let row_sum = picture.columns[row].as_ref().map_or(0.0, Cdf::total);
            row_sum * picture.texel_solid_angle(row)
        }));
        Ok(picture)
    }

    pub(super) fn is_grey(&self) -> bool {
        is_grey(self.scale) && are_grey(&self.texels)
    }

    /// Integral of the radiance over all directions, W/m².
    pub(super) const fn integral(&self) -> Rgb {
        self.integral
    }

    /// Irradiance on a horizontal plane from above, W/m².
    pub(super) fn irradiance_up(&self) -> Rgb {
        let horizon = self.height.div_ceil(2);
        let of_row = |row| {
            // The integral of cosine times sine over the part of the row above the horizon.
            let sine = |row| self.row_angle(row).min(0.5 * PI).sin();
            let (upper, lower) = (sine(row), sine(row + 1));
            let weight = 0.5 * (lower - upper) * (lower + upper) * TAU / self.width as f64;
            (0..self.width).map(|column| self.color(row, column)).sum::<Rgb>() * weight
        };
        (0..horizon).map(of_row).sum()
    }

    /// Density in 1/sr of a direction.
    pub(super) fn pdf(&self, direction: DVec3) -> f64 {
        let (row, column) = self.texel(direction);
        self.texel_pdf(row, column)
    }

    /// Angle from +y, in radians, of the upper edge of a row.
    fn row_angle(&self, row: usize) -> f64 {
        PI * row as f64 / self.height as f64
    }

    /// Solid angle in sr of each texel of a row: the difference of the cosines of its edges,
    /// written as a product, times its width.
    fn texel_solid_angle(&self, row: usize) -> f64 {
        let half = 0.5 * PI / self.height as f64;
        let middle = self.row_angle(row) + half;
        2.0 * middle.sin() * half.sin() * TAU / self.width as f64
    }

    fn color(&self, row: usize, column: usize) -> Rgb {
        let [r, g, b] = self.texels[row * self.width + column].map(f64::from);
        self.scale * Rgb::new(r, g, b)
    }

    /// Row and column of the texel in a direction.
    fn texel(&self, direction: DVec3) -> (usize, usize) {
        let theta = direction.x.hypot(direction.z).atan2(direction.y);
        let across = (direction.x.atan2(-direction.z) / TAU + self.turn).rem_euclid(1.0);
        let row = (theta / PI * self.height as f64) as usize;
        let column = (across * self.width as f64) as usize;
        (row.min(self.height - 1), column.min(self.width - 1))
    }

    pub(super) fn radiance(&self, direction: DVec3) -> Rgb {
        let (row, column) = self.texel(direction);
        self.color(row, column)
    }

    /// Density in 1/sr of every direction in a texel.
    fn texel_pdf(&self, row: usize, column: usize) -> f64 {
        self.rows.as_ref().map_or(0.0, |rows| luminance(self.color(row, column)) / rows.total())
    }

    /// A direction, its density and the radiance from there; nothing where all is black.
    pub(super) fn toward(&self, u: [f64; 2]) -> Option<(DVec3, f64, Rgb)> {
        let (row, down) = self.rows.as_ref()?.sample(u[0]);
        let (column, right) = self.columns[row].as_ref()?.sample(u[1]);
        // Uniform in the cosine within the row, found from its edges without cancellation.
        let step = PI / self.height as f64;
        let upper = self.row_angle(row);
        let drop = 2.0 * (upper + 0.5 * step).sin() * (0.5 * step).sin() * down;
        let cos_theta = upper.cos() - drop;
        let (sin_upper, cos_upper) = upper.sin_cos();
        let sin_theta = (sin_upper * sin_upper + drop * (2.0 * cos_upper - drop)).max(0.0).sqrt();
        let phi = TAU * ((column as f64 + right) / self.width as f64 - self.turn);
        let direction = DVec3::new(sin_theta * phi.sin(), cos_theta, -sin_theta * phi.cos());
        Some((direction.normalize(), self.texel_pdf(row, column), self.color(row, column)))
    }
}
