//! Light at any place by trilinear interpolation between the centres of the cells around it.

use glam::{DVec3, IVec3};

use crate::math::{Spectrum, WorldPoint};
use crate::transport::PathContext;

use super::lazy_cells::{EmptyCell, LazyCells};

/// Offsets from the first to each of the numbers by which a sample draws its cells.
///
/// Unit: none. Definition: the quarters of [0, 1), so that the numbers are stratified.
const OFFSETS: [f64; 4] = [0.0, 0.5, 0.25, 0.75];

/// The corners of a cube, opposite ones next to each other: they differ most.
///
/// Unit: count. Definition: the corners of the unit cube, in cells.
const CORNERS: [IVec3; 8] = [
    IVec3::new(0, 0, 0),
    IVec3::new(1, 1, 1),
    IVec3::new(0, 0, 1),
    IVec3::new(1, 1, 0),
    IVec3::new(0, 1, 0),
    IVec3::new(1, 0, 1),
    IVec3::new(1, 0, 0),
    IVec3::new(0, 1, 1),
];

impl<S: Spectrum> LazyCells<S> {
    /// Trilinear interpolation at `p` between the eight nearest cells; with `u` in [0, 1) an unbiased sample of it: the mean of
    /// four cells, drawn by their weights with numbers that are 1/4 apart, of which `u` is one, so that a cell which few rays
    /// sample is seldom filled. A cell that does not exist counts as 0. `fill` finds an empty cell's light, anew in each `pass`;
    /// passes follow one another. `ctx` counts the work, that of each cell once.
    #[inline]
    pub(super) fn at(
        &self,
        p: WorldPoint,
        u: Option<f64>,
        pass: u32,
        ctx: &mut PathContext,
        fill: impl Fn(&EmptyCell, &mut PathContext) -> S,
    ) -> S {
        let local = self.to_cells(p) - 0.5;
        let mut sum = S::ZERO;
        let mut add = |(cell, weight): (IVec3, f64)| {
            if weight > 0.0 {
                sum += self.light(cell, pass, ctx, &fill).unwrap_or(S::ZERO) * weight;
            }
        };
        match u {
            Some(u) => drawn(local, u).for_each(&mut add),
            None => around(local).for_each(&mut add),
        }
        sum
    }

    /// Trilinear interpolation at `p` between the eight nearest cells, if in each channel the least and the most of
    /// them, which are not negative, are alike. Elsewhere, and where there is no cell, nothing. `fill`, `pass` and `ctx` are
    /// as in [`at`](Self::at).
    #[inline]
    pub(super) fn interpolate(
        &self,
        p: WorldPoint,
        pass: u32,
        are_alike: impl Fn(f64, f64) -> bool,
        ctx: &mut PathContext,
        fill: impl Fn(&EmptyCell, &mut PathContext) -> S,
    ) -> Option<S> {
        let local = self.to_cells(p) - 0.5;
        // The least and the most in each channel.
        let mut range = [(f64::INFINITY, 0.0f64); 3];
        let mut sum = S::ZERO;
        for (cell, weight) in around(local) {
            let light = self.light(cell, pass, ctx, &fill)?;
            for (channel, (least, most)) in range[..S::CHANNELS].iter_mut().enumerate() {
                let light = light.channel(channel);
                (*least, *most) = (least.min(light), most.max(light));
                if !are_alike(*least, *most) {
                    return None;
                }
            }
            sum += light * weight;
        }
        Some(sum)
    }
}

/// The eight lattice points around `local`, each with its weight in trilinear interpolation.
fn around(local: DVec3) -> impl Iterator<Item = (IVec3, f64)> {
    let low = local.floor();
    let share = local - low;
    CORNERS.into_iter().map(move |corner| {
        let far = corner.as_dvec3();
        let weights = far * share + (1.0 - far) * (1.0 - share);
        (low.as_ivec3() + corner, weights.element_product())
    })
}

/// Lattice points around `local` that are drawn with numbers of which `u` is one, all with the same weight.
fn drawn(local: DVec3, u: f64) -> impl Iterator<Item = (IVec3, f64)> {
    let weight = 1.0 / OFFSETS.len() as f64;
    OFFSETS.into_iter().map(move |offset| (draw_corner(local, (u + offset).fract()), weight))
}

/// One of the eight lattice points around `local`, drawn by its weight in trilinear interpolation with `u` in [0, 1).
fn draw_corner(local: DVec3, u: f64) -> IVec3 {
    let low = local.floor();
    let mut left = u;
    // Below or above on each axis, by what the axes before have left of the number.
    let above = (local - low).to_array().map(|share| {
        let is_above = left < share;
        left = if is_above { left / share } else { (left - share) / (1.0 - share) };
        i32::from(is_above)
    });
    low.as_ivec3() + IVec3::from_array(above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};
    use crate::medium::{Density, SparseCells};
    use crate::scene::plan::Needs;
    use crate::shape::{Cuboid, Region};
    use glam::DAffine3;

    /// What is read at a place in cells, with the number that draws, of cells that hold `light` at their centres.
    fn read(light: impl Fn(DVec3) -> f64) -> impl FnMut(DVec3, Option<f64>) -> f64 {
        let region = Cuboid::new(DVec3::ZERO, DVec3::ONE, &DAffine3::IDENTITY).unwrap();
        let density = Density::Homogeneous(Region::Box(region));
        let cells = SparseCells::covering(&density, 0.2, 1).unwrap();
        let cache: LazyCells<f64> = LazyCells::new(cells.clone(), 1, 0);
        let mut ctx = PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
        move |local, u| {
            let p = cells.to_world(local);
            cache.at(p, u, 0, &mut ctx, |cell, _| light(cell.cell.as_dvec3() + 0.5))
        }
    }

    /// Interpolation of a linear function is the function, and so is the mean of samples over evenly spaced numbers: 4096 of
    /// them leave 3 steps of 1/4096 of a sum of eight values below 7.
    #[test]
    fn cells_are_read_by_their_weights() {
        let linear = |local: DVec3| local.dot(DVec3::new(1.0, 2.0, 3.0));
        let mut read = read(linear);
        for local in [DVec3::new(1.9, 2.5, 3.2), DVec3::new(2.5, 1.7, 2.01), DVec3::splat(2.5)] {
            let right = linear(local);
            let samples = (0..4096).map(|i| read(local, Some((f64::from(i) + 0.5) / 4096.0)));
            let mean = samples.sum::<f64>() / 4096.0;
            assert!((mean - right).abs() < 0.02, "{mean} for {right}");
            // To the precision in which cells are stored.
            let whole = read(local, None);
            assert!((whole / right - 1.0).abs() < 1e-5, "{whole} for {right}");
        }
    }

    /// Half way between cells along x each sample reads one on either side: light that varies along x alone is
    /// interpolated without noise.
    #[test]
    fn cells_on_both_sides_are_read() {
        let mut read = read(|local| local.x);
        for i in 0..64 {
            let u = (f64::from(i) + 0.5) / 64.0;
            assert_eq!(read(DVec3::new(3.0, 2.7, 2.2), Some(u)), 3.0, "at {u}");
        }
    }

    /// Evenly spaced numbers draw each corner as often as its weight says, but for one number at each of the three
    /// divisions between corners.
    #[test]
    fn corners_are_drawn_by_their_weights() {
        const COUNT: u32 = 4096;
        let local = DVec3::new(-1.3, 2.5, 7.9);
        let low = local.floor().as_ivec3();
        let draws: Vec<IVec3> = (0..COUNT)
            .map(|i| draw_corner(local, (f64::from(i) + 0.5) / f64::from(COUNT)) - low)
            .collect();
        for (cell, weight) in around(local) {
            let corner = cell - low;
            let drawn = draws.iter().filter(|drawn| **drawn == corner).count() as f64;
            assert!((drawn - weight * f64::from(COUNT)).abs() <= 3.0, "{drawn} of {corner}");
        }
        assert!(draws.iter().all(|drawn| CORNERS.contains(drawn)));
        // At the centre of a cell that is all there is.
        assert_eq!(draw_corner(DVec3::new(-1.0, 2.0, 7.0), 0.7), IVec3::new(-1, 2, 7));
    }
}
