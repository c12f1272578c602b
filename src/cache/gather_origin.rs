//! Where in a cell final gathers start.

use glam::DVec3;

use crate::math::{Rgb, Spectrum, WorldPoint, warp};
use crate::scene::Scene;
use crate::transport::{PathContext, PixelFootprint, SobolPoint, camera_view};

use super::camera_thickness::{CameraThickness, march};

/// Places of a cell among which the start of a gather is chosen: the first number, or the second where the
/// effective number of the first is less than half of it.
///
/// Unit: count. Limit: on the error of a cell's expected light, one over the square root of their effective
/// number in the worst case. The mean over cells, each of which has other places, is off by as little as one over it.
const CANDIDATES: [usize; 2] = [8, 16];

/// Bits of the weight of a place.
///
/// Unit: count. Limit: on memory: the weights of all places fit into 64 bits.
const WEIGHT_BITS: usize = 64 / CANDIDATES[1];

/// The largest weight of a place.
///
/// Unit: none. Definition: the largest number of so many bits.
const MAX_WEIGHT: u64 = (1 << WEIGHT_BITS) - 1;

/// A cubic cell in which final gathers start.
#[derive(Debug, Clone, Copy)]
pub struct GatherCell {
    /// Its centre.
    pub center: WorldPoint,
    /// Its width in metres.
    pub width: f64,
    /// What the Sobol points of its places are scrambled by.
    pub scramble: u32,
}

/// Places in a cell at which final gathers start.
///
/// Rays read a cell by trilinear interpolation, at places whose density is in proportion to a tent
/// function round its centre, to the scattering coefficient and to the transmittance toward the camera.
/// Gathers start at places of the same density, drawn by resampling (Talbot, Cline and Egbert 2005,
/// "Importance Resampling for Global Illumination"). The tents of all cells sum to 1, so that all cells
/// together send as much light to the camera as if each ray had gathered at its own place, however
/// light varies across them: cells blur it and lose none.
#[derive(Debug, Clone, Copy)]
pub struct GatherOrigins {
    cell: GatherCell,
    weights: OriginWeights,
}

/// Weights of the places of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OriginWeights {
    /// Width of the cell times the mean over the tent of extinction coefficient and transmittance to the camera.
    opacity: f32,
    /// Integers in proportion to the density at each place, the first in the lowest bits; 0 where rays see none of them, and
    /// gathers start at the centre.
    weights: u64,
}

impl GatherOrigins {
    /// The single place `p`, with the opacity of a cell of `width` metres in which density is the same as there.
    pub fn at<S: Spectrum>(
        scene: &Scene,
        medium: usize,
        p: WorldPoint,
        width: f64,
        footprint: &PixelFootprint,
        ctx: &mut PathContext,
    ) -> Self {
        let seen: S = visibility(scene, p, footprint, None, ctx);
        let across = width * scene.media.get(medium).sigma_t_at(p).max_element();
        let opacity = (seen.max_element() * -(-across).exp_m1()) as f32;
        let cell = GatherCell { center: p, width, scramble: 0 };
        Self { cell, weights: OriginWeights { opacity, weights: 0 } }
    }

    /// For light that the medium of this index scatters toward the camera from a `cell`: by the `thickness` from places to
    /// the camera, or a march for each.
    pub fn in_cell<S: Spectrum>(
        scene: &Scene,
        medium: usize,
        cell: GatherCell,
        footprint: &PixelFootprint,
        thickness: Option<&CameraThickness<S>>,
        ctx: &mut PathContext,
    ) -> Self {
        let of = scene.media.get(medium);
        let (mut light_of, mut seen) = ([0.0; CANDIDATES[1]], 0.0);
        let mut count = 0;
        for wanted in CANDIDATES {
            for (index, found) in light_of.iter_mut().enumerate().take(wanted).skip(count) {
                let p = cell.place(index);
                ctx.work.grid_lookups += u64::from(of.density.is_voxel());
                let sigma_t = of.sigma_t_at(p);
                if sigma_t == Rgb::ZERO {
                    continue;
                }
                let light = S::from_rgb(sigma_t) * visibility(scene, p, footprint, thickness, ctx);
                seen += light.max_element();
                ctx.work.grid_lookups += u64::from(!of.albedo.is_constant());
                *found = (light * S::from_rgb(of.albedo.at(p))).element_sum();
            }
            count = wanted;
            if effective_number(&light_of) >= wanted as f64 / 2.0 {
                break;
            }
        }
        let opacity = (cell.width * seen / count as f64) as f32;
        Self { cell, weights: OriginWeights { opacity, weights: cell.rounded(&light_of) } }
    }

    /// In a `cell` with these weights.
    pub const fn new(cell: GatherCell, weights: OriginWeights) -> Self {
        Self { cell, weights }
    }

    /// Weights of its places.
    pub const fn weights(&self) -> OriginWeights {
        self.weights
    }

    /// The place that `u` in [0, 1) chooses.
    pub fn place(&self, u: f64) -> WorldPoint {
        let weight = |index: usize| self.weights.weights >> (index * WEIGHT_BITS) & MAX_WEIGHT;
        let sum: u64 = (0..CANDIDATES[1]).map(weight).sum();
        let mut left = (u * sum as f64) as u64;
        let chosen = (0..CANDIDATES[1]).find(|&index| {
            let is_here = left < weight(index);
            left = left.saturating_sub(weight(index));
            is_here
        });
        chosen.map_or(self.cell.center, |index| self.cell.place(index))
    }

    /// Weight of the cell's source function in the radiance of a ray from the camera through all of it,
    /// without unit.
    pub fn opacity(&self) -> f64 {
        self.weights.opacity.into()
    }
}

impl GatherCell {
    /// The place of this index, by the density of a tent round the centre.
    fn place(&self, index: usize) -> WorldPoint {
        let [x, y, z, _] = self.point(index);
        self.center + self.width * DVec3::new(x, y, z).map(warp::tent)
    }

    fn point(&self, index: usize) -> [f64; 4] {
        SobolPoint { index: index as u32, scramble: self.scramble }.scattering()
    }

    /// Integers whose mean over cells is in proportion to the density at each place.
    fn rounded(&self, light_of: &[f64; CANDIDATES[1]]) -> u64 {
        let most = light_of.iter().copied().fold(0.0, f64::max);
        if !(most > 0.0 && most.is_finite()) {
            return 0;
        }
        let weight = |(index, light): (usize, &f64)| {
            let [.., up] = self.point(index);
            let weight = (light / most * MAX_WEIGHT as f64 + up) as u64;
            weight.min(MAX_WEIGHT) << (index * WEIGHT_BITS)
        };
        light_of.iter().enumerate().map(weight).sum()
    }
}

impl OriginWeights {
    /// As words of a file.
    pub const fn to_words(self) -> [u32; 3] {
        [self.opacity.to_bits(), self.weights as u32, (self.weights >> 32) as u32]
    }

    /// Those of these words.
    pub const fn from_words([opacity, low, high]: [u32; 3]) -> Self {
        Self { opacity: f32::from_bits(opacity), weights: low as u64 | (high as u64) << 32 }
    }
}

/// The number of equal weights whose mean is as certain as that of these (Kish 1965, "Survey Sampling").
fn effective_number(weights: &[f64]) -> f64 {
    let squares = weights.iter().map(|weight| weight * weight).sum::<f64>();
    weights.iter().sum::<f64>().powi(2) / squares.max(f64::MIN_POSITIVE)
}

/// Transmittance from `p` to the camera: that of media, or 0 where a surface stands between.
fn visibility<S: Spectrum>(
    scene: &Scene,
    p: WorldPoint,
    footprint: &PixelFootprint,
    thickness: Option<&CameraThickness<S>>,
    ctx: &mut PathContext,
) -> S {
    let (ray, distance) = camera_view::toward_camera(scene, p, footprint);
    if !camera_view::is_clear(scene, &ray, distance, ctx) {
        return S::ZERO;
    }
    match thickness {
        Some(thickness) => thickness.transmittance(scene, p, footprint, ctx),
        None => (-march::<S>(scene, p, footprint, ctx)).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};
    use crate::medium::SparseCells;
    use crate::scene::plan::Needs;

    /// Cells of a mean, each with numbers of its own.
    const CELLS: u64 = 16_384;

    /// A medium left of x = 0, seen from above by parallel rays, with `more` beside it.
    fn scene(sigma_t: f64, more: &str) -> Scene {
        scene_at_a_slant(sigma_t, 1.0, more)
    }

    /// As [`scene`], by rays that meet the upper side at an angle of this `cosine` to its normal.
    fn scene_at_a_slant(sigma_t: f64, cosine: f64, more: &str) -> Scene {
        let [x, y] = [50.0 * (1.0 - cosine * cosine).sqrt(), 50.0 * cosine];
        Scene::of_text(&format!(
            "
            [camera]
            type = 'orthographic'
            position = [{x:?}, {y:?}, 0.0]
            target = [0.0, 0.0, 0.0]
            up = [0.0, 0.0, 1.0]
            height = 4.0
            [film]
            size = [4, 4]
            [[medium]]
            region = {{ box = {{ min = [-9.0, -9.0, -9.0], max = [0.0, 9.0, 9.0] }} }}
            sigma_t = {sigma_t}
            {more}
            "
        ))
    }

    /// Origins in [`CELLS`] cells of width 1 round `center`, each with numbers of its own, and their opacities.
    fn origins(scene: &Scene, center: DVec3) -> Vec<GatherOrigins> {
        let center = WorldPoint::new(center.x, center.y, center.z);
        let footprint = PixelFootprint::new(scene, 1.0);
        let cells = SparseCells::covering(&scene.media.get(0).density, 1.0, 1).unwrap();
        let thickness = CameraThickness::<Rgb>::new(cells, 0);
        let of_cell = |cell: u64| {
            let mut ctx = PathContext::new(Stream::new(1, Stage::Test, cell, 0), Needs::EVERYTHING);
            let cell = GatherCell { center, width: 1.0, scramble: ctx.rng.scramble() };
            GatherOrigins::in_cell(scene, 0, cell, &footprint, Some(&thickness), &mut ctx)
        };
        (0..CELLS).map(of_cell).collect()
    }

    /// The mean place of 16 gathers of each cell, from the centre.
    fn mean(origins: &[GatherOrigins], center: DVec3) -> DVec3 {
        let numbers = || (0..16).map(|i| (f64::from(i) + 0.5) / 16.0);
        let places = origins.iter().flat_map(|o| numbers().map(|u| o.place(u)));
        let center = WorldPoint::new(center.x, center.y, center.z);
        places.map(|p| p - center).sum::<DVec3>() / (16.0 * origins.len() as f64)
    }

    /// Integral over [-1, b] of a tent function times f.
    fn over_tent(b: f64, f: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        let width = (b + 1.0) / f64::from(n);
        let at = |i: i32| -1.0 + (f64::from(i) + 0.5) * width;
        (0..n).map(|i| width * warp::tent_pdf(at(i)) * f(at(i))).sum()
    }

    /// The mean place of the smallest part of a tent, 0.24 of it, has a standard error of 0.0023: two of a
    /// cell's places lie there, each with a deviation of 0.41. The bound is four of those, a false alarm of
    /// 6e-5 a number at this fixed seed.
    #[test]
    fn gathers_start_as_rays_sample_a_cell() {
        // Thin, at the side: a tent cut off there. `far` is the coordinate of the side from the centre.
        for far in [-0.3, 0.0, 0.4] {
            let (scene, center) = (scene(1e-6, ""), DVec3::new(-far, 0.0, 0.0));
            let found = origins(&scene, center);
            let part = over_tent(far, |_| 1.0);
            let right = over_tent(far, |x| x) / part;
            let mean = mean(&found, center);
            assert!((mean - right * DVec3::X).length() < 0.01, "{mean} for {right} at {far}");
            let opacity = found.iter().map(GatherOrigins::opacity).sum::<f64>() / CELLS as f64;
            assert!((opacity / (1e-6 * part) - 1.0).abs() < 0.01, "{opacity} at {far}");
        }
        // Thick, within: transmittance from above, and at a slant, beside the thickness of what lies before the
        // cell.
        for (cosine, thickness, [x, y]) in [
            (1.0, 1.0, [-4.0, 0.0]),
            (1.0, 4.0, [-4.0, 6.0]),
            (1.0, 4.0, [-4.0, 8.7]),
            (0.6, 1.0, [-8.0, 4.0]),
            (0.6, 4.0, [-8.0, 6.0]),
            (0.6, 4.0, [-8.0, 8.7]),
        ] {
            let sigma_t = thickness * cosine;
            let scene = scene_at_a_slant(sigma_t, cosine, "");
            let center = DVec3::new(x, y, 0.0);
            let found = origins(&scene, center);
            let seen = |x: f64| if y + x < 9.0 { (-thickness * (9.0 - y - x)).exp() } else { 0.0 };
            let part = over_tent(1.0, seen);
            let right = over_tent(1.0, |x| x * seen(x)) / part;
            let mean = mean(&found, center);
            assert!(
                (mean - right * DVec3::Y).length() < 0.02,
                "{mean} for {right} at {y}, {cosine}"
            );
            let opacity = found.iter().map(GatherOrigins::opacity).sum::<f64>() / CELLS as f64;
            assert!((opacity / (sigma_t * part) - 1.0).abs() < 0.02, "{opacity} for {part} at {y}");
        }
    }

    #[test]
    fn another_medium_hides_what_lies_behind_it() {
        let thick = "
            [[medium]]
            region = { box = { min = [-9.0, 0.0, -9.0], max = [9.0, 9.0, 9.0] } }
            sigma_t = 1e9
        ";
        let found = origins(&scene(1e-6, thick), DVec3::new(-4.0, 0.0, 0.0));
        assert!(found.iter().all(|o| o.opacity() == 0.0), "nothing is seen through it");
        let found = origins(&scene(1e-6, thick), DVec3::new(-4.0, 8.5, 0.0));
        let highest = |o: &GatherOrigins| (0..16).all(|i| o.place(f64::from(i) / 16.0).xyz.y > 8.9);
        assert!(
            found.iter().filter(|o| o.opacity() > 0.0).all(highest),
            "seen near its upper side"
        );
    }

    #[test]
    fn surfaces_hide_places_below_them() {
        let floor = "
            [[surface]]
            shape = 'plane'
            point = [0.0, 0.1, 0.0]
            normal = [0.0, 1.0, 0.0]
        ";
        let found = origins(&scene(1e-6, floor), DVec3::new(-4.0, 0.0, 0.0));
        let above = |o: &GatherOrigins| (0..16).all(|i| o.place(f64::from(i) / 16.0).xyz.y > 0.1);
        assert!(found.iter().all(above), "all places are above the floor");
        let opacity = found.iter().map(GatherOrigins::opacity).sum::<f64>() / CELLS as f64;
        let right = 1e-6 * (1.0 - over_tent(0.1, |_| 1.0));
        assert!((opacity / right - 1.0).abs() < 0.02, "{opacity} for {right}");
    }

    #[test]
    fn a_cell_that_rays_do_not_see_starts_gathers_at_its_centre() {
        let found = origins(&scene(1.0, ""), DVec3::new(3.0, 0.0, 0.0));
        assert!(found.iter().all(|o| o.opacity() == 0.0 && o.place(0.7) == o.cell.center));
    }
}
