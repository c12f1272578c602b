//! How wide the cells of a lattice are.

use crate::math::WorldPoint;
use crate::medium::{Medium, Phase};
use crate::scene::Scene;

/// Flights that cross a cell, on average, where all flights together are as long as
/// [`WAYS`] times the edge of a cube of the medium's volume.
const CROSSINGS: f64 = 150.0;

/// See [`CROSSINGS`].
const WAYS: f64 = 1e6;

/// Optical thickness of a cell up to which light varies in it nearly as a straight line.
const THIN: f64 = 0.35;

/// Edge of a cell for direct light in pixels, where the camera sees it.
const PIXELS: f64 = 1.5;

/// Finest edge for direct light in voxels.
const FINEST: f64 = 0.5;

/// Edge of the cells, in metres, that suits a medium of this volume in m³ in which all flights
/// together are `flown` metres long. A pixel's variance falls with the number of flights and with
/// the edge, its squared bias with the fourth power of the edge; the sum is least where the edge
/// is as the -1/5th power of the number of flights.
pub fn edge_for_flights(volume: f64, flown: f64, phase: &Phase) -> f64 {
    let side = volume.cbrt();
    // A cell is crossed by 1.5 times its share of the flights over its edge.
    let across = (1.5 * WAYS / CROSSINGS).sqrt();
    let ways = (flown / phase.concentration() / side).max(1e-3);
    side / (across * (ways / WAYS).powf(0.2)).max(1.0)
}

/// The widest edge, in metres, of cells that are thin where the camera sees the medium; infinite
/// where it does not.
pub fn thin_edge(medium: &Medium, visible: &[WorldPoint]) -> f64 {
    thickest(medium, visible).map_or(f64::INFINITY, |sigma_t| THIN / sigma_t)
}

/// Edge of the cells for direct light, in metres: as fine as a picture of which each pixel stands
/// for so many along each side, but thin; nothing where the medium is not seen or cells would have
/// to be much finer than voxels.
pub fn edge_for_direct(
    scene: &Scene,
    medium: &Medium,
    visible: &[WorldPoint],
    pixels: f64,
) -> Option<f64> {
    let thickest = thickest(medium, visible)?;
    let middle = scene.film.size.map(|side| 0.5 * f64::from(side));
    let ray = |by| scene.camera.ray(middle[0] + by, middle[1], [0.5; 2]);
    let (here, beside) = (ray(0.0), ray(1.0));
    let pixel = |p: &WorldPoint| {
        let t = (*p - here.origin).length();
        (beside.at(t) - here.at(t)).length()
    };
    let pixel = quantile(visible.iter().map(pixel).collect(), 0.5)?;
    let finest = FINEST * medium.density.detail().unwrap_or(0.0);
    let edge = (PIXELS * pixels * pixel).max(finest).min(THIN / thickest);
    (edge >= 0.5 * finest).then_some(edge)
}

/// Extinction coefficient in 1/m, that few visible places exceed; nothing where the medium is not
/// seen.
fn thickest(medium: &Medium, visible: &[WorldPoint]) -> Option<f64> {
    let sigma_t = visible.iter().map(|p| medium.sigma_t_at(*p).max_element());
    quantile(sigma_t.filter(|sigma_t| *sigma_t > 0.0).collect(), 0.9)
}

fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get((values.len() as f64 * share) as usize).copied()
}
