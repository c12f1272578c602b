//! A radiance that goes with the elevation.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::super::checked_color;
use crate::math::{Cdf, Rgb, is_grey, luminance};

/// Radiance linear in y, the sine of the elevation, between nodes. As equal steps of y are equal solid
/// angles, directions are sampled by a linear density in y, whose inverse is a closed form.
#[derive(Debug, Clone)]
pub(super) struct Gradient {
    /// From y = -1 to y = 1, never downward.
    nodes: Vec<Node>,
    /// Over the pieces between nodes, by the integral of luminance over each, W/m²; nothing where all
    /// is black.
    pieces: Option<Cdf>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    y: f64,
    radiance: Rgb,
}

impl Gradient {
    /// As [`Environment::gradient`](super::Environment::gradient).
    pub(super) fn new(stops: &[(f64, Rgb)]) -> Result<Self, String> {
        let [(_, lowest), .., (_, highest)] = stops else {
            return Err(format!("stops of a gradient are {}: must be at least two", stops.len()));
        };
        let mut nodes = vec![Node { y: -1.0, radiance: *lowest }];
        for (i, &(elevation, radiance)) in stops.iter().enumerate() {
            if !(-90.0..=90.0).contains(&elevation) {
                return Err(format!("elevation is {elevation}°: must be from -90° to 90°"));
            }
            if i > 0 && elevation < stops[i - 1].0 {
                return Err(format!(
                    "elevation {elevation}° comes after {}°: stops must go upward",
                    stops[i - 1].0
                ));
            }
            let radiance = checked_color("radiance of a stop", radiance)?;
            nodes.push(Node { y: elevation.to_radians().sin(), radiance });
        }
        nodes.push(Node { y: 1.0, radiance: *highest });
        let pieces = Cdf::new(nodes.windows(2).map(|piece| luminance(integral(piece))));
        Ok(Self { nodes, pieces })
    }

    pub(super) fn is_grey(&self) -> bool {
        self.nodes.iter().all(|node| is_grey(node.radiance))
    }

    /// Radiance at the sine `y` of an elevation, W/(m² sr).
    pub(super) fn radiance(&self, y: f64) -> Rgb {
        let above = self.nodes.partition_point(|node| node.y <= y).clamp(1, self.nodes.len() - 1);
        let [low, high] = [self.nodes[above - 1], self.nodes[above]];
        // A piece of no height is found only by rounding beyond straight up or down.
        let share = if high.y > low.y { (y - low.y) / (high.y - low.y) } else { 0.0 };
        low.radiance.lerp(high.radiance, share.clamp(0.0, 1.0))
    }

    /// Integral of the radiance over all directions, W/m².
    pub(super) fn integral(&self) -> Rgb {
        self.nodes.windows(2).map(integral).sum()
    }

    /// Irradiance on a horizontal plane from above, W/m².
    pub(super) fn irradiance_up(&self) -> Rgb {
        let of_piece = |piece: &[Node]| {
            let [low, high] = [piece[0].y.max(0.0), piece[1].y.max(0.0)];
            if high <= low {
                return Rgb::ZERO;
            }
            let radiance = |y: f64| {
                let share = (y - piece[0].y) / (piece[1].y - piece[0].y);
                piece[0].radiance.lerp(piece[1].radiance, share)
            };
            // Simpson's rule, which is exact for the square that radiance times y is.
            let middle = 0.5 * (low + high);
            let sum =
                radiance(low) * low + radiance(middle) * (4.0 * middle) + radiance(high) * high;
            sum * (TAU * (high - low) / 6.0)
        };
        self.nodes.windows(2).map(of_piece).sum()
    }

    /// Density in 1/sr at the sine `y` of an elevation.
    pub(super) fn pdf(&self, y: f64) -> f64 {
        self.pieces.as_ref().map_or(0.0, |pieces| luminance(self.radiance(y)) / pieces.total())
    }

    /// A direction, its density and the radiance from there; nothing where all is black.
    pub(super) fn toward(&self, u: [f64; 2]) -> Option<(DVec3, f64, Rgb)> {
        let pieces = self.pieces.as_ref()?;
        let (piece, first) = pieces.sample(u[0]);
        let [low, high] = [self.nodes[piece], self.nodes[piece + 1]];
        let share = linear_inverse(luminance(low.radiance), luminance(high.radiance), first);
        let y = (low.y + (high.y - low.y) * share).clamp(-1.0, 1.0);
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let across = ((1.0 - y) * (1.0 + y)).sqrt();
        let direction = DVec3::new(across * sin, y, across * cos).normalize();
        let radiance = self.radiance(direction.y);
        // Rounding can lead onto the black side of an edge.
        let pdf = luminance(radiance) / pieces.total();
        (pdf > 0.0).then_some((direction, pdf, radiance))
    }
}

/// Integral of the radiance over the directions between two nodes, W/m².
fn integral(piece: &[Node]) -> Rgb {
    (piece[0].radiance + piece[1].radiance) * (PI * (piece[1].y - piece[0].y))
}

/// Where in [0, 1] the integral of a density that goes linearly from `a` to `b`, not both 0, reaches
/// the share `u` of its whole (Pharr, Jakob and Humphreys 2023, "Physically Based Rendering",
/// `SampleLinear`).
fn linear_inverse(a: f64, b: f64, u: f64) -> f64 {
    if u == 0.0 {
        return 0.0; // also where a is 0
    }
    let larger = a.max(b);
    let (a, b) = (a / larger, b / larger);
    let root = (a * a * (1.0 - u) + b * b * u).sqrt();
    (u * (a + b) / (a + root)).min(1.0)
}
