//! The share of each cell that the camera sees, where surfaces cut cells.

use std::array;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::math::{Span, Spectrum, WorldPoint};
use crate::medium::{BRICK, SparseCells, VOLUME, cell_at, cell_index};
use crate::scene::Scene;
use crate::transport::{PixelFootprint, SobolPoint, camera_view};

/// Places of a cell that are looked at from the camera: the first number, and the second where those are not all seen or
/// all hidden.
///
/// Unit: count. Limit: on the error of a share: a plane along an axis is placed to one part in so many.
const PLACES: [u32; 2] = [16, 128];

/// Distance of a surface from a brick, in cells, up to which its cells have shares. Light is interpolated between cells
/// whose centres are up to a diagonal away, and those take that of neighbours as far again.
///
/// Unit: none. Derivation: two diagonals of a cell.
const REACH: f64 = 3.47;

/// Distance of a cell's centre from a surface, in cells, up to which that may cut it.
///
/// Unit: none. Derivation: half the diagonal of a cell.
const HALF_DIAGONAL: f64 = 0.867;

/// Least share of a cell for which it has light of its own.
///
/// Unit: none. Limit: on noise: a cell of which less is seen takes that of its neighbours.
const MIN_SHARE: f32 = 0.5;

/// Shares of the cells near surfaces that the camera sees: a cell at the ground holds the light above it, and is not
/// darker by what lies below (boundary bias; Silverman 1986, "Density Estimation for Statistics and Data Analysis",
/// section 2.10, whose kernels are cut and scaled in the same way).
pub struct SeenShares<'a> {
    scene: &'a Scene,
    footprint: PixelFootprint,
    shares: Shares,
}

/// Shares of cells, brick by brick.
#[derive(Debug, Clone, Default)]
pub(super) struct Shares {
    bricks: Vec<Brick>,
}

/// Shares of the cells of a brick.
#[derive(Debug, Clone)]
enum Brick {
    /// All is seen.
    Seen,
    /// No surface is near, and its centre is hidden: its cells keep all of their light, and give none to seen ones.
    Hidden,
    /// One of each cell.
    Cut(Box<[f32; VOLUME]>),
}

impl<'a> SeenShares<'a> {
    /// Those of `cells`, or nothing where no surface is near any. Nothing either where surfaces reflect or let light
    /// through: what they show is not seen straight from the camera.
    pub fn new(scene: &'a Scene, cells: &SparseCells) -> Option<Self> {
        if scene.surfaces.is_empty() || scene.surfaces.has_specular() {
            return None;
        }
        let none = Shares::default();
        let own = Self { scene, footprint: PixelFootprint::new(scene, 1.0), shares: none };
        let positions = cells.brick_positions();
        let bricks: Vec<_> =
            positions.par_iter().map(|at| own.brick(cells, *at << BRICK)).collect();
        let any = bricks.iter().any(|brick| matches!(brick, Brick::Cut(_)));
        any.then_some(Self { shares: Shares { bricks }, ..own })
    }

    /// Shares of the brick whose lowest cell is `first`.
    fn brick(&self, cells: &SparseCells, first: IVec3) -> Brick {
        let sees = |p: DVec3| self.sees(cells.to_world(p));
        let is_near = |p: DVec3, most: f64| {
            let nearest = self.scene.surfaces.nearest(cells.to_world(p), most * cells.edge);
            nearest.is_some()
        };
        let half = f64::from(1 << BRICK) / 2.0;
        let center = first.as_dvec3() + half;
        if !is_near(center, half * 3_f64.sqrt() + REACH) {
            return if sees(center) { Brick::Seen } else { Brick::Hidden };
        }
        let share = |index: usize| {
            let low = (first + cell_at(index)).as_dvec3();
            if !is_near(low + 0.5, HALF_DIAGONAL) {
                return f32::from(u8::from(sees(low + 0.5)));
            }
            let sees_place = |index: &u32| {
                let [x, y, z, _] = SobolPoint { index: *index, scramble: 0 }.scattering();
                sees(low + DVec3::new(x, y, z))
            };
            let [few, all] = PLACES;
            let seen = (0..few).filter(sees_place).count();
            if seen == 0 || seen == few as usize {
                return f32::from(u8::from(seen > 0));
            }
            (seen + (few..all).filter(sees_place).count()) as f32 / all as f32
        };
        Brick::of(Box::new(array::from_fn(share)))
    }

    /// Whether the camera sees `p`.
    pub(super) fn sees(&self, p: WorldPoint) -> bool {
        let Self { scene, footprint, .. } = self;
        let (ray, distance) = camera_view::toward_camera(scene, p, footprint);
        !scene.surfaces.occluded_seen(&ray, Span::new(0.0, distance))
    }

    /// The shares alone.
    pub(super) const fn shares(&self) -> &Shares {
        &self.shares
    }
}

impl Shares {
    /// Shares of the cells of a brick; nothing where those have all of their light.
    pub fn of(&self, brick: usize) -> Option<&[f32; VOLUME]> {
        match &self.bricks[brick] {
            Brick::Cut(shares) => Some(shares),
            Brick::Seen | Brick::Hidden => None,
        }
    }

    /// Those of the `coarse` cells that hold eight of the `fine` ones each.
    pub fn coarser(&self, fine: &SparseCells, coarse: &SparseCells) -> Self {
        let brick = |at: &IVec3| {
            let mean = |within: IVec3| {
                let first = ((*at << BRICK) + within) * 2;
                let corner =
                    |i: i32| self.share(fine, first + IVec3::new(i & 1, i >> 1 & 1, i >> 2));
                (0..8).map(corner).sum::<f32>() * (0.5 * 0.5 * 0.5)
            };
            Brick::of(Box::new(array::from_fn(|index| mean(cell_at(index)))))
        };
        Self { bricks: coarse.brick_positions().par_iter().map(brick).collect() }
    }

    /// Makes means over what is seen of cells of means over their volume, which come brick by brick, and gives cells of
    /// which little or nothing is seen the mean of those around them.
    pub fn complete<S: Spectrum>(&self, cells: &SparseCells, values: &mut [S::F32]) {
        let value = |values: &[S::F32], cell: IVec3| {
            let brick = cells.find_brick(cell >> BRICK)?;
            let index = cell_index(cell & ((1 << BRICK) - 1));
            Some((values[brick * VOLUME + index], self.bricks[brick].share(index)))
        };
        let completed = |values: &[S::F32], cell: IVec3| {
            let (own, share) = value(values, cell)?;
            if share >= MIN_SHARE {
                return Some(own * share.recip());
            }
            let around = |i: i32| cell + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1;
            let (mut sum, mut seen) = (S::F32::default(), 0.0);
            for (value, share) in (0..27).filter_map(|i| value(values, around(i))) {
                (sum, seen) = (sum + value, seen + share);
            }
            (seen > 0.0).then(|| sum * seen.recip())
        };
        let means: &[S::F32] = values;
        let bricks: Vec<_> = cells
            .brick_positions()
            .into_par_iter()
            .enumerate()
            .filter_map(|(brick, at)| {
                let shares = self.of(brick)?;
                let of = |index: usize| match shares[index] {
                    1.0 => None,
                    _ => completed(means, (at << BRICK) + cell_at(index)),
                };
                Some((brick, (0..VOLUME).map(of).collect::<Vec<_>>()))
            })
            .collect();
        for (brick, completed) in bricks {
            let values = &mut values[brick * VOLUME..][..VOLUME];
            for (value, completed) in values.iter_mut().zip(completed) {
                *value = completed.unwrap_or(*value);
            }
        }
    }

    /// The share of a cell: all of one that is not stored.
    fn share(&self, cells: &SparseCells, cell: IVec3) -> f32 {
        let brick = cells.find_brick(cell >> BRICK);
        let index = cell_index(cell & ((1 << BRICK) - 1));
        brick.map_or(1.0, |brick| self.bricks[brick].share(index))
    }
}

impl Brick {
    /// That of these shares.
    fn of(shares: Box<[f32; VOLUME]>) -> Self {
        if shares.iter().all(|share| *share == 1.0) { Self::Seen } else { Self::Cut(shares) }
    }

    /// The share of the cell of this index.
    fn share(&self, index: usize) -> f32 {
        match self {
            Self::Seen => 1.0,
            Self::Hidden => 0.0,
            Self::Cut(shares) => shares[index],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::{CellContents, FluenceBuilder};
    use crate::medium::Phase;
    use crate::transport::FlightSegment;

    /// Width of cells in metres.
    const WIDTH: f64 = 0.25;

    /// Fog on both sides of a ground through `height` on the y axis that rises by this slope along z, seen from above.
    fn scene(height: f64, slope: f64, material: &str) -> Scene {
        Scene::of_text(&format!(
            "
            [camera]
            position = [0.0, 6.0, 5.0]
            target = [0.0, 0.0, 0.0]
            [film]
            size = [4, 4]
            [[medium]]
            region = {{ box = {{ min = [-2.0, -2.0, -2.0], max = [2.0, 2.0, 2.0] }} }}
            sigma_t = 0.1
            [[surface]]
            shape = 'quad'
            center = [0.0, {height:?}, 0.0]
            u = [0.0, {:?}, 3.0]
            v = [3.0, 0.0, 0.0]
            material = {{ {material} }}
            ",
            3.0 * slope
        ))
    }

    const DIFFUSE: &str = "type = 'diffuse', reflectance = 0.5";

    /// The least and the most of the light at places in view down to the ground, over that of even light from above, on
    /// cells of the finest level and of the next; with shares of cells or without.
    fn range(height: f64, slope: f64, with_shares: bool) -> [[f64; 2]; 2] {
        let scene = scene(height, slope, DIFFUSE);
        let cells = SparseCells::covering(&scene.media.get(0).density, WIDTH, 1).unwrap();
        let seen = SeenShares::new(&scene, &cells).unwrap();
        let seen = Some(&seen).filter(|_| with_shares);
        let contents = CellContents::TowardEye(&Phase::ISOTROPIC, &scene.camera, seen);
        let origin = WorldPoint::new(0.0, 0.0, 0.0);
        let mut builder = FluenceBuilder::<f64>::new(cells, origin, contents);
        let ground = |z: f64| height + slope * z;
        // Each stands for a column of light of 1 W/m².
        let (side, step) = (400, 0.01);
        let flight = |index: i32| {
            let at = |i: i32| (f64::from(i) + 0.5) * step - 2.0;
            let (x, z) = (at(index / side), at(index % side));
            let [from, to] = [3.0, ground(z)].map(|y| WorldPoint::new(x, y, z));
            FlightSegment::new(origin, from, to, step * step)
        };
        builder.add(&[&(0..side * side).map(flight).collect::<Vec<_>>()]);
        let grid = builder.finish(1, 1.0);
        let even = 1.0 / (4.0 * std::f64::consts::PI);
        [0, 1].map(|level| {
            let places = (0..1000).map(|index| {
                let [x, y, z, _] = SobolPoint { index, scramble: 7 }.scattering();
                let (x, z) = (2.0 * x - 1.0, 2.0 * z - 1.0);
                WorldPoint::new(x, ground(z) + 1e-3 + y * y, z)
            });
            places.fold([f64::INFINITY, 0.0], |[least, most]: [f64; 2], p| {
                let light = grid.toward_camera(p, level) / even;
                [least.min(light), most.max(light)]
            })
        })
    }

    #[test]
    fn even_light_is_even_down_to_the_ground() {
        for (height, slope) in [(0.0, 0.0), (0.07, 0.0), (-0.11, 0.0), (0.19, 0.3), (0.03, -0.7)] {
            for [least, most] in range(height, slope, true) {
                assert!(least > 0.93 && most < 1.07, "{least} to {most} at {height}, {slope}");
            }
            let [[least, _], _] = range(height, slope, false);
            assert!(least < 0.8, "{least} without shares at {height}, {slope}");
        }
    }

    #[test]
    fn cells_have_the_share_above_the_ground() {
        let scene = scene(0.1, 0.0, DIFFUSE);
        let cells = SparseCells::covering(&scene.media.get(0).density, WIDTH, 1).unwrap();
        let seen = SeenShares::new(&scene, &cells).unwrap();
        let share = |y: f64| {
            let cell = cells.to_cells(WorldPoint::new(0.1, y, 0.1)).floor().as_ivec3();
            let low = cells.to_world(cell.as_dvec3()).xyz.y;
            let right = ((low + WIDTH - 0.1) / WIDTH).clamp(0.0, 1.0);
            (f64::from(seen.shares().share(&cells, cell)), right)
        };
        for y in [-0.6, -0.2, 0.09, 0.11, 0.3, 0.6] {
            let (share, right) = share(y);
            assert!((share - right).abs() < 0.04, "{share} for {right} at {y}");
        }
    }

    #[test]
    fn all_is_seen_where_surfaces_show_more_or_are_elsewhere() {
        let of = |scene: &Scene| {
            let cells = SparseCells::covering(&scene.media.get(0).density, WIDTH, 1).unwrap();
            SeenShares::new(scene, &cells).is_some()
        };
        assert!(of(&scene(0.0, 0.0, DIFFUSE)));
        assert!(!of(&scene(0.0, 0.0, "type = 'mirror'")));
        assert!(!of(&scene(-9.0, 0.0, DIFFUSE)));
    }
}
