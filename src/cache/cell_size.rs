//! How wide the cells of a lattice are.

use crate::math::{Ray, World, WorldPoint};
use crate::medium::{Medium, Phase};
use crate::scene::Scene;

use super::sparse_cells::SparseCells;

/// Flights that cross a cell, on average, where all flights together are as long as
/// [`WAYS`] times the edge of a cube of the medium's volume.
const CROSSINGS: f64 = 150.0;

/// See [`CROSSINGS`].
const WAYS: f64 = 1e6;

/// Optical thickness of a cell up to which light varies in it nearly as a straight line.
const THIN: f64 = 0.35;

/// How many times as fine cells for moments are, in transport mean free paths, as others are in mean
/// free paths, where that makes them wider than those.
const FINE: f64 = 3.0;

/// Finest edge in voxels of a cell that is filled for a picture.
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

/// As [`thin_edge`], for light that has been scattered so often that it hardly knows any more where
/// it came from: it varies over longer ways, the more the more a scattering leaves of its direction.
pub fn thin_edge_for_moments(medium: &Medium, visible: &[WorldPoint]) -> f64 {
    let forgets = (FINE * (1.0 - medium.phase.mean_cosine())).min(1.0);
    thin_edge(medium, visible) / forgets
}

/// How wide cells are that are filled for a picture.
pub(super) struct Widths {
    /// In pixels, where the camera sees them.
    pub pixels: f64,
    /// At most, in metres, for [`few`](Self::few) rays of a pixel and for fewer.
    pub widest: f64,
    /// See [`widest`](Self::widest).
    pub few: u32,
    /// The power of the number of rays as which that falls, each time that they double.
    pub fall: f64,
}

/// The edge of a pixel where something is seen.
#[derive(Debug)]
pub(super) struct Pixel {
    /// Through neighbouring pixels.
    rays: [Ray<World>; 2],
    /// How many of the film's a pixel stands for, along each side.
    stands_for: f64,
}

impl Pixel {
    /// Of a picture by the camera of `scene` of which each pixel stands for so many of the film
    /// along each side.
    pub fn new(scene: &Scene, stands_for: f64) -> Self {
        let [x, y] = scene.film.size.map(|side| 0.5 * f64::from(side));
        let rays = [x, x + 1.0].map(|x| scene.camera.ray(x, y, [0.5; 2]));
        Self { rays, stands_for }
    }

    /// The edge at `p`, in metres.
    pub fn edge(&self, p: WorldPoint) -> f64 {
        let [here, beside] = &self.rays;
        let t = self.distance(p);
        self.stands_for * (beside.at(t) - here.at(t)).length()
    }

    /// The distance of `p` from the camera, in metres.
    pub fn distance(&self, p: WorldPoint) -> f64 {
        (p - self.rays[0].origin).length()
    }

    /// Cells round `medium` as wide as `widths` says for a picture of so many rays a pixel, whose
    /// `visible` places it sees; nothing where there are none, or they would be much finer than voxels or
    /// too many. Where only those are that suit many rays, they are as wide as for fewer.
    pub fn cells(
        &self,
        medium: &Medium,
        visible: &[WorldPoint],
        rays: u32,
        widths: &Widths,
    ) -> Option<SparseCells> {
        let pixel = quantile(visible.iter().map(|p| self.edge(*p)).collect(), 0.5)?;
        let finest = FINEST * medium.density.detail().unwrap_or(0.0);
        let doubled = (rays / widths.few).max(1).ilog2();
        let edge = |times: u32| {
            let widest = widths.widest * (f64::from(times) * widths.fall).exp2();
            (widths.pixels * pixel).max(finest).min(widest)
        };
        let mut edges: Vec<f64> = (0..=doubled).rev().map(edge).collect();
        // Where pixels say how wide they are there is but one.
        edges.dedup();
        let mut sound = edges.into_iter().filter(|edge| *edge >= 0.5 * finest);
        sound.find_map(|edge| SparseCells::around(&medium.density, edge, 1))
    }
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
