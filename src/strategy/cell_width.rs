//! How wide the cells of a cache are: as flights of photons, the medium and the pixels allow.

use std::f64::consts::PI;

use crate::math::{WorldPoint, quantile};
use crate::medium::{Medium, Phase, SparseCells};
use crate::scene::Scene;
use crate::transport::{PixelFootprint, is_camera_outside};

use super::kind::Conditions;

/// Mean number of flights that cross a cell, where all flights together are
/// [`REFERENCE_LENGTH`] times as long as the edge of a cube of the medium's volume.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only strategy`.
const CROSSINGS: f64 = 450.0;

/// The same where surfaces reach into the medium: they end flights, so that light has a kink there, and a cell of moments
/// that they cut is darker by what they take of its volume.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only strategy`.
const CROSSINGS_AT_SURFACES: f64 = 150.0;

/// Length of all flights, in edges of a cube of the medium's volume, for which [`CROSSINGS`] holds.
///
/// Unit: none. Definition: the length for which the number of crossings is stated.
const REFERENCE_LENGTH: f64 = 1e6;

/// Exponent of the width of cells over the length of flights.
///
/// Unit: none. Derivation: variance is as 1 / (flights width), squared bias as width⁴.
const WIDTH_EXPONENT: f64 = -0.2;

/// Quantile of the extinction at visible places for which cells of direct light and of final gathers are thin.
///
/// Unit: none. Derivation: in the rest, the thickest places, cells may be wider than thin ones: a tenth of
/// the picture.
const THICK_SHARE: f64 = 0.9;

/// Quantile of the extinction at visible places for which the cells of a fluence grid are thin: half of what is
/// seen. Where density rises softly the thickest places lie deep, and light that was scattered has no kinks there;
/// behind a hard face, where fluence has one, the median is as thick as the rest.
///
/// Unit: none. Derivation: the places that weigh half of the picture.
const FLUENCE_SHARE: f64 = 0.5;

/// Optical thickness of a cell up to which light is interpolated linearly across it.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const MAX_OPTICAL_THICKNESS: f64 = 0.35;

/// Factor on the reduced scattering, 1 - g, by which cells of multiply scattered light are wider than those of
/// direct light: it varies over the transport mean free path, not over the mean free path.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const SCATTERING_REFINEMENT: f64 = 3.0;

/// Least width, in voxels, of cells that follow the size of pixels.
///
/// Unit: none. Derivation: density is linear between voxels: finer cells would show nothing new.
const MIN_VOXELS: f64 = 0.5;

/// Width in pixels of the cells of direct light.
///
/// Unit: pixels. Bench: `cargo bench --bench results -- --only strategy`.
const DIRECT_PIXELS: f64 = 1.5;

/// Rays a pixel up to which the cells of direct light may be as wide as thin ones.
///
/// Unit: count. Definition: the number up to which the width is stated.
const DIRECT_RAYS: u32 = 16;

/// Places along a ray at which caches of the finest level are sampled.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only strategy`.
const PLACES: u32 = 4;

/// Fewest places along a ray at which caches are sampled: at the widest level.
///
/// Unit: count. Limit: on the noise of a ray: one place would make it that of a single lookup.
const MIN_PLACES: u32 = 2;

/// Samples of lights that all rays together would take within a cell of direct light, from which on it pays to fill it.
///
/// Unit: count. Bench: `cargo bench --bench results -- --only strategy`.
const MIN_LIGHT_SAMPLES: f64 = 5.0;

/// Exponent of the largest width of direct light's cells over the number of rays a pixel: variance is
/// as 1 / rays and the squared bias of interpolation as the fourth power of the width.
///
/// Unit: none. Derivation: the sum of both is least where both fall alike.
const DIRECT_EXPONENT: f64 = -0.25;

/// Width in pixels of the cells of final gathers, for [`GATHER_PIXELS_RAYS`] rays a pixel.
///
/// Unit: pixels. Bench: `cargo bench --bench results -- --only strategy`.
const GATHER_PIXELS: f64 = 2.5;

/// Rays a pixel for which [`GATHER_PIXELS`] holds.
///
/// Unit: count. Definition: the number for which the width is stated.
const GATHER_PIXELS_RAYS: f64 = 16.0;

/// Exponent of that width over the number of rays: variance is as 1 / (rays width²) and the squared
/// bias as width⁴; their sum is least for rays^(-1/6).
///
/// Unit: none. Derivation: the sum of both is least there.
const GATHER_PIXELS_EXPONENT: f64 = -1.0 / 6.0;

/// Least width in pixels of the cells of final gathers: that of direct light's.
///
/// Unit: pixels. Derivation: gathers are smoother than direct light, so that finer cells would show
/// nothing new.
const MIN_GATHER_PIXELS: f64 = DIRECT_PIXELS;

/// Largest width of the cells of final gathers, in thin cells of moments, for
/// [`GATHER_RAYS`] rays a pixel or fewer.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only strategy`.
const MAX_GATHER_WIDTH: f64 = 1.5;

/// Rays a pixel up to which [`MAX_GATHER_WIDTH`] holds.
///
/// Unit: count. Definition: the number up to which the width is stated.
const GATHER_RAYS: u32 = 32;

/// Exponent of the largest width of final gathers' cells over the number of rays. Across thick cells
/// light is not linear and the squared bias is about as width², for which the sum with variance is
/// least at -1/4. The bias has one sign all over a picture, so that it falls faster here.
///
/// Unit: none. Derivation: between -1/4, where the sum is least, and -1/2, where the bias alone
/// would fall as the variance does.
const GATHER_EXPONENT: f64 = -1.0 / 3.0;

/// Effective width of a tent function of half width 1: one over the integral of its square.
///
/// Unit: none. Derivation: that integral is 2/3.
const TENT_WIDTH: f64 = 1.5;

/// Number of places along a ray at which caches of this level are sampled: fewer where cells are wider.
pub const fn places_at(level: u32) -> u32 {
    let places = PLACES >> level;
    if places < MIN_PLACES { MIN_PLACES } else { places }
}

/// Width of the cells, in metres, that suits a medium of `scene` in which all flights together are
/// `flight_length` metres long and `phase` weighs each; `None` where the medium has no end. A pixel's variance
/// is as 1 / (flights width), its squared bias as width⁴; the sum is least for flights^(-1/5) (as in
/// Silverman 1986, "Density Estimation for Statistics and Data Analysis", section 3.3.2).
pub(super) fn width_for_flights(
    scene: &Scene,
    medium: &Medium,
    flight_length: f64,
    phase: &Phase,
) -> Option<f64> {
    let side = medium.density.volume()?.cbrt();
    let is_cut = scene.surfaces.reach_into(&medium.density.bounds()?);
    let crossings = if is_cut { CROSSINGS_AT_SURFACES } else { CROSSINGS };
    // The mean chord of a cube is 2/3 of its edge, so that 1.5 times as many flights cross a cell.
    let across = (3.0 / 2.0 * REFERENCE_LENGTH / crossings).sqrt();
    let length = flight_length / phase.concentration() / side;
    Some(side / (across * (length / REFERENCE_LENGTH).powf(-WIDTH_EXPONENT)).max(1.0))
}

/// Width of cells that suits so many times the photons, over that which suits the photons.
pub fn width_for_photons(ratio: f64) -> f64 {
    ratio.powf(WIDTH_EXPONENT)
}

/// Largest width, in metres, of cells that are optically thin at the quantile `share` of the extinction at the
/// `visible` places of a medium; infinite where none is in it.
fn thin_width(medium: &Medium, visible: &[WorldPoint], share: f64) -> f64 {
    let sigma_t = extinction(medium, visible, share);
    sigma_t.map_or(f64::INFINITY, |sigma_t| MAX_OPTICAL_THICKNESS / sigma_t)
}

/// As [`thin_width`], for multiply scattered light, which varies over the transport mean free path
/// 1 / (sigma_t (1 - g)).
fn thin_width_for_scattered(medium: &Medium, visible: &[WorldPoint], share: f64) -> f64 {
    thin_width(medium, visible, share) / reduced_scattering(medium)
}

/// Largest width, in metres, of the cells of a medium's fluence grid; infinite where no `visible` place is in it.
pub(super) fn max_fluence_width(medium: &Medium, visible: &[WorldPoint]) -> f64 {
    thin_width_for_scattered(medium, visible, FLUENCE_SHARE)
}

/// Least distance from the camera, in metres, of cells of this width that hold light which `phase` scatters toward
/// it; 0 where scattering is isotropic. Across a cell the direction toward the camera may turn by a quarter of a
/// lobe: one of concentration c covers a solid angle of about 4 pi / c, a cone of half angle 2 / sqrt(c).
pub(super) fn nearest_toward_eye(width: f64, phase: &Phase) -> f64 {
    if phase.is_isotropic() { 0.0 } else { width * phase.concentration().sqrt() }
}

/// Factor on the thickness of a medium by which cells of multiply scattered light are wider.
fn reduced_scattering(medium: &Medium) -> f64 {
    (SCATTERING_REFINEMENT * (1.0 - medium.phase.mean_cosine())).min(1.0)
}

/// Variance of a pixel of the picture, up to a factor, whose rays gather photons with kernels of this radius
/// in metres, where the camera sees `visible` places. A ray meets photons in an area as radius², a pixel in
/// one that is larger by its own.
pub fn noise_of_kernels(
    scene: &Scene,
    conditions: &Conditions,
    visible: &[WorldPoint],
    radius: f64,
) -> f64 {
    let footprint = PixelFootprint::new(scene, conditions.film_pixels);
    let pixel = pixel_width(&footprint, visible).unwrap_or(0.0);
    1.0 / (PI * radius.powi(2) + pixel.powi(2))
}

/// Effective number of pixels that share what they read from cells of `edge` metres by trilinear
/// interpolation, where a pixel is `pixel` metres wide: the square of a pixel convolved with tents. Its
/// effective area, one over the integral of the squared density, is about 1 + (1.5 e)² for cells of e pixels.
pub fn sharing_pixels(edge: f64, pixel: f64) -> f64 {
    1.0 + (TENT_WIDTH * edge / pixel).powi(2)
}

/// Whether the rays of a picture read direct light's `cells` in the medium of this index often enough that it pays to
/// fill them.
pub fn shares_direct_cells(
    scene: &Scene,
    conditions: &Conditions,
    visible: &[WorldPoint],
    medium: usize,
    cells: &SparseCells,
) -> bool {
    let footprint = PixelFootprint::new(scene, conditions.film_pixels);
    let pixel = pixel_width(&footprint, visible).unwrap_or(f64::INFINITY);
    let sigma_t = extinction(scene.media.get(medium), visible, 0.5).unwrap_or(0.0);
    // Of the places of all rays that cross a column of cells, those within one of them.
    let pixels = (cells.edge / pixel).powi(2);
    let places = f64::from(PLACES) * f64::from(conditions.rays) * pixels;
    let cached = scene.lights.lights.iter().filter(|light| !light.is_environment()).count();
    places * (sigma_t * cells.edge).min(1.0) * cached as f64 >= MIN_LIGHT_SAMPLES
}

/// Cells for direct light in each medium, where it can be cached.
pub fn direct_cells(
    scene: &Scene,
    conditions: &Conditions,
    visible: &[WorldPoint],
) -> Vec<Option<SparseCells>> {
    let Conditions { film_pixels, rays, volume_photons, .. } = *conditions;
    let cells = |(index, medium): (usize, &Medium)| {
        let can = volume_photons && is_camera_outside(scene, medium);
        can.then(|| direct_light_cells(scene, index, visible, film_pixels, rays))?
    };
    scene.media.iter().enumerate().map(cells).collect()
}

/// Cells for the direct light that the medium of this index scatters, of which the camera sees
/// `visible` places, in a picture whose pixels cover `film_pixels` of the film along each side and get
/// so many rays. `None` where cells would be optically thick or too many.
fn direct_light_cells(
    scene: &Scene,
    medium: usize,
    visible: &[WorldPoint],
    film_pixels: f64,
    rays: u32,
) -> Option<SparseCells> {
    let medium = scene.media.get(medium);
    let max_width = thin_width(medium, visible, THICK_SHARE);
    let widths =
        Widths { pixels: DIRECT_PIXELS, max_width, rays: DIRECT_RAYS, exponent: DIRECT_EXPONENT };
    cells(&PixelFootprint::new(scene, film_pixels), medium, visible, rays, &widths)
}

/// As [`direct_light_cells`], for what final gathers find.
pub fn final_gather_cells(
    scene: &Scene,
    medium: usize,
    visible: &[WorldPoint],
    film_pixels: f64,
    rays: u32,
) -> Option<SparseCells> {
    let medium = scene.media.get(medium);
    let by_rays = (f64::from(rays) / GATHER_PIXELS_RAYS).powf(GATHER_PIXELS_EXPONENT);
    let pixels = (GATHER_PIXELS * by_rays).max(MIN_GATHER_PIXELS);
    let max_width = MAX_GATHER_WIDTH * thin_width_for_scattered(medium, visible, THICK_SHARE);
    let widths = Widths { pixels, max_width, rays: GATHER_RAYS, exponent: GATHER_EXPONENT };
    cells(&PixelFootprint::new(scene, film_pixels), medium, visible, rays, &widths)
}

/// Width of cells that follow the size of pixels.
struct Widths {
    /// In pixels.
    pixels: f64,
    /// Upper bound in metres, for [`rays`](Self::rays) rays a pixel or fewer.
    max_width: f64,
    rays: u32,
    /// Exponent of that bound over the number of rays, applied at each doubling.
    exponent: f64,
}

/// Cells round `medium` as wide as `widths` says for so many rays a pixel; `None` where no place is
/// visible, or cells would be much finer than voxels or too many. Where only the finest are too many,
/// they are as wide as for fewer rays.
fn cells(
    footprint: &PixelFootprint,
    medium: &Medium,
    visible: &[WorldPoint],
    rays: u32,
    widths: &Widths,
) -> Option<SparseCells> {
    let pixel = pixel_width(footprint, visible)?;
    let min_width = MIN_VOXELS * medium.density.detail().unwrap_or(0.0);
    let doublings = (rays / widths.rays).max(1).ilog2();
    let width = |doublings: u32| {
        let max_width = widths.max_width * (f64::from(doublings) * widths.exponent).exp2();
        (widths.pixels * pixel).max(min_width).min(max_width)
    };
    let mut candidates: Vec<f64> = (0..=doublings).rev().map(width).collect();
    // All are the same where the size of pixels decides.
    candidates.dedup();
    let mut fine = candidates.into_iter().filter(|width| *width >= 0.5 * min_width);
    fine.find_map(|width| SparseCells::covering(&medium.density, width, 1))
}

/// Width in metres of a pixel at the median of the visible places; `None` where there are none.
pub(super) fn pixel_width(footprint: &PixelFootprint, visible: &[WorldPoint]) -> Option<f64> {
    quantile(visible.iter().map(|p| footprint.width(*p)).collect(), 0.5)
}

/// The quantile `share` of the extinction coefficient, in 1/m, at the visible places in the medium; `None`
/// where none is in it.
fn extinction(medium: &Medium, visible: &[WorldPoint], share: f64) -> Option<f64> {
    let sigma_t = visible.iter().map(|p| medium.sigma_t_at(*p).max_element());
    quantile(sigma_t.filter(|sigma_t| *sigma_t > 0.0).collect(), share)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball so thick that cells for very many rays are too many.
    const BALL: &str = r#"
        [camera]
        position = [0.0, 0.0, 5.0]
        target = [0.0, 0.0, 0.0]
        fov = 26.0
        [film]
        size = [64, 64]
        [[medium]]
        region = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
        sigma_t = 50.0
        albedo = 0.99
        phase = { type = "henyey-greenstein", g = 0.85 }
    "#;

    #[test]
    fn more_rays_never_make_cells_wider() {
        let scene = Scene::of_text(BALL);
        let visible = [WorldPoint::new(0.0, 0.0, 0.9)];
        let width = |rays: u32| final_gather_cells(&scene, 0, &visible, 1.0, rays).unwrap().edge;
        let widths = [16, 32, 64, 300, 2500, 20_000, 1 << 20].map(width);
        assert!(widths.windows(2).all(|pair| pair[1] <= pair[0]), "{widths:?}");
        assert!(widths[3] < 0.6 * widths[1] && widths[4] == widths[6], "{widths:?}");
    }
}
