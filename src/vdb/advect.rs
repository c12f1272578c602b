//! Grids that velocities carry away.
//!
//! What a grid holds at a place and time is looked up where it came from: semi-Lagrangian advection (Stam 1999, "Stable
//! Fluids", section 3.2) along the velocity of one time, followed backward by the midpoint rule. Where all of the smoke is carried along, its mean velocity
//! moves the grid as a whole, and voxels are made anew for what is left of the velocities beside it alone: smoke in an
//! even wind keeps its voxels.

use glam::{DMat3, DVec3, IVec3};
use rayon::prelude::*;

use crate::math::{Index, IndexPoint, Transform, WorldPoint};

use super::grid::{Grid, VoxelBox};
use super::regions::CellBox;
use super::source::{Leaf, Source};
use super::statistics::Statistics;
use super::tree::{BRICK, LOWER, place};
use super::velocity::{continued, dilated};
use super::voxel::Voxel;

/// Displacement, in voxels, that is not seen.
///
/// Unit: voxels. Limit: on the work of making voxels anew.
pub(super) const UNSEEN: f64 = 1e-3;

/// Voxels, at most, by which velocities are continued into where there are none.
///
/// Unit: voxels. Limit: on the work of it; smoke that moves farther in an exposure is a streak.
const CONTINUED: f64 = 48.0;

/// Leaves, at most, of a grid that is made anew.
///
/// Unit: count. Limit: on its memory, 12 GB.
pub(super) const MOST_LEAVES: usize = 1 << 22;

/// Places along each axis of a constant block at which its velocity is looked up, at most.
///
/// Unit: count. Limit: on the work of large tiles.
const PLACES: i32 = 16;

/// How the grids of a medium move.
#[derive(Debug, Clone)]
pub struct Drift {
    velocity: Grid<[f32; 3]>,
    /// From values of the grid to metres of the world a frame.
    scale: DMat3,
    /// Mean velocity of the smoke, in metres a frame; 0 where some of it may stand still.
    mean: DVec3,
    /// Largest velocity of the smoke, in metres a frame.
    fastest: f64,
    /// An upper bound of how far the velocity of any smoke is from the mean, in metres a frame.
    uneven: f64,
}

impl Drift {
    /// That of `smoke` under `velocity`, whose values times `scale` are metres of the world a frame, for times of up to
    /// `frames` in either direction. Velocities that are not finite are taken as 0.
    pub fn new(velocity: &Grid<[f32; 3]>, scale: DMat3, smoke: &Grid<f32>, frames: f64) -> Self {
        let columns = [scale.x_axis, scale.y_axis, scale.z_axis];
        let stretch = columns.iter().map(|column| column.length_squared()).sum::<f64>().sqrt();
        let voxel = velocity.transform().unit_lengths().min_element();
        let farthest = velocity.statistics().max * stretch * frames / voxel;
        let velocity = continued(velocity, farthest.min(CONTINUED).ceil() as u32 + 1);
        let mut drift = Self { velocity, scale, mean: DVec3::ZERO, fastest: 0.0, uneven: 0.0 };
        let (mut sum, mut mass) = (DVec3::ZERO, 0.0);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        smoke.for_each_nonzero(|block| {
            let size = (block.max - block.min + 1).as_dvec3().element_product();
            let places = places(&block);
            let weight = f64::from(block.value).abs() * size / places.len() as f64;
            for place in places {
                let v = drift.velocity_at(smoke.transform().point_to_world(place));
                (sum, mass) = (sum + v * weight, mass + weight);
                (low, high) = (low.min(v), high.max(v));
                drift.fastest = drift.fastest.max(v.length());
            }
        });
        if mass > 0.0 {
            drift.mean = sum / mass;
            drift.uneven = (high - drift.mean).max(drift.mean - low).length();
        }
        if drift.uneven > drift.mean.length() {
            // Some of it may stand still, and keeps its voxels so.
            (drift.mean, drift.uneven) = (DVec3::ZERO, drift.fastest);
        }
        drift
    }

    /// The velocity at `p` in metres a frame, 0 where there is none.
    pub fn velocity_at(&self, p: WorldPoint) -> DVec3 {
        let value = self.velocity.value(self.velocity.transform().point_to_local(p));
        self.scale * DVec3::from(value)
    }

    /// The largest velocity of the smoke, in metres a frame.
    pub const fn fastest(&self) -> f64 {
        self.fastest
    }

    /// `grid` so many `frames` later, or before where that is negative.
    ///
    /// # Errors
    /// The problem, where it would take too many voxels.
    pub fn moved<V: Voxel>(&self, grid: Grid<V>, frames: f64) -> Result<Grid<V>, String> {
        let uneven = self.reach(&grid, frames);
        let shift = glam::DAffine3::from_translation(self.shift(frames));
        let grid = if uneven > UNSEEN { self.advected(&grid, frames, uneven)? } else { grid };
        grid.placed(&shift).ok_or_else(|| "is carried beyond all numbers".into())
    }

    /// How far the mean velocity carries all of the smoke in so many `frames`, in metres.
    pub(super) fn shift(&self, frames: f64) -> DVec3 {
        self.mean * frames
    }

    /// An upper bound of how far velocities carry any voxel of `grid` beside their mean, in voxels.
    pub(super) fn reach<V: Voxel>(&self, grid: &Grid<V>, frames: f64) -> f64 {
        self.uneven * frames.abs() / grid.transform().unit_lengths().min_element()
    }

    /// Where what is at `p` was so many `frames` before, under what the velocities are beside their mean.
    pub(super) fn before(&self, p: WorldPoint, frames: f64) -> WorldPoint {
        let rest = |p: WorldPoint| self.velocity_at(p) - self.mean;
        let middle = p - rest(p) * (0.5 * frames);
        p - rest(middle) * frames
    }

    /// `grid` under what the velocities are beside their mean, which move no voxel farther than `reach` voxels.
    fn advected<V: Voxel>(
        &self,
        grid: &Grid<V>,
        frames: f64,
        reach: f64,
    ) -> Result<Grid<V>, String> {
        let transform = grid.transform();
        let value = |p: WorldPoint| {
            V::from_sample(grid.value(transform.point_to_local(self.before(p, frames))))
        };
        Ok(with_voxels(&leaves_near(grid, reach)?, transform, grid.background(), value))
    }
}

/// A grid with the leaves that begin at `keys`, whose voxels have the `value` of their places, and the `background` around.
pub(super) fn with_voxels<V: Voxel>(
    keys: &[[i32; 3]],
    transform: &Transform<Index>,
    background: V,
    value: impl Fn(WorldPoint) -> V + Sync,
) -> Grid<V> {
    let made = |key: &[i32; 3]| {
        let origin = IVec3::from(*key);
        let leaf: Leaf<V> = std::array::from_fn(|slot| {
            let voxel = origin + place(slot, BRICK);
            value(transform.point_to_world(IndexPoint::from_xyz(voxel.as_dvec3())))
        });
        let mut mask = [0_u64; 8];
        for (slot, _) in leaf.iter().enumerate().filter(|(_, v)| v.bits() != background.bits()) {
            mask[slot / 64] |= 1 << (slot % 64);
        }
        (mask != [0; 8]).then_some((origin, leaf, mask))
    };
    let leaves: Vec<_> = keys.par_iter().filter_map(made).collect();
    let ones = |mask: &[u64; 8]| mask.iter().map(|bits| u64::from(bits.count_ones())).sum::<u64>();
    let source = Source {
        background,
        active_voxels: leaves.iter().map(|(.., mask)| ones(mask)).sum(),
        origins: leaves.iter().map(|(origin, ..)| *origin).collect(),
        masks: leaves.iter().map(|(.., mask)| *mask).collect(),
        leaves: leaves.into_iter().map(|(_, leaf, _)| leaf).collect(),
        tiles: Vec::new(),
    };
    Grid::new(&source, *transform, Statistics::from_source(&source), 0)
}

/// Smallest voxels of all leaves within `reach` voxels of what differs from the background of `grid`, sorted.
pub(super) fn leaves_near<V: Voxel>(grid: &Grid<V>, reach: f64) -> Result<Vec<[i32; 3]>, String> {
    let background = grid.background();
    let (mut keys, mut count) = (Vec::new(), 0_usize);
    let differs = |value: V| value.bits() != background.bits();
    grid.tree().for_each_region(CellBox::ALL, &differs, &mut |region| {
        let edge = 1_usize << (region.log2_size - BRICK);
        count = count.saturating_add(edge.saturating_pow(3));
        if region.log2_size <= LOWER && count <= MOST_LEAVES {
            let leaf =
                |slot| (region.min + (place(slot, region.log2_size - BRICK) << BRICK)).to_array();
            keys.extend((0..edge.pow(3)).map(leaf));
        }
    });
    let around = (reach / f64::from(1 << BRICK)).ceil();
    if count <= MOST_LEAVES && around <= CONTINUED {
        keys.sort_unstable();
        keys.dedup();
        let keys = dilated(keys, around as i32);
        if keys.len() <= MOST_LEAVES {
            return Ok(keys);
        }
    }
    Err(format!(
        "would take more than {MOST_LEAVES} leaves of voxels where its velocities carry it; give a shorter shutter, a \
         coarser grid, or velocity = \"none\""
    ))
}

/// Places in `block`, even and not too many, at which its velocity is looked up.
fn places(block: &VoxelBox) -> Vec<IndexPoint> {
    let size = block.max - block.min + 1;
    let count = size.min(IVec3::splat(PLACES));
    let at = |i: i32, axis: usize| {
        let step = f64::from(size[axis]) / f64::from(count[axis]);
        f64::from(block.min[axis]) + (f64::from(i) + 0.5) * step - 0.5
    };
    let mut places = Vec::with_capacity(count.element_product() as usize);
    for x in 0..count.x {
        for y in 0..count.y {
            for z in 0..count.z {
                places.push(IndexPoint::new(at(x, 0), at(y, 1), at(z, 2)));
            }
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vdb::{Block, GridToWrite, ReadAs, ValueType, VdbFile, write};

    /// Edge of a voxel in metres.
    const VOXEL: f64 = 0.5;

    /// Grids of 32³ voxels around the origin, of density and velocity at places in metres.
    fn grids(
        density: impl Fn(DVec3) -> f64,
        velocity: impl Fn(DVec3) -> DVec3,
    ) -> (Grid<f32>, Grid<[f32; 3]>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("moving.vdb");
        let mut smoke = GridToWrite::fog("density", VOXEL, DVec3::ZERO);
        let mut vel = GridToWrite { value_type: ValueType::Vec3, ..smoke.clone() };
        vel.name = "vel".into();
        for slot in 0..64 {
            let origin = (place(slot, 2) - 2) * 8;
            let places = || (0..512).map(|i| (origin + place(i, 3)).as_dvec3() * VOXEL);
            let values: Vec<f32> = places().map(|p| density(p) as f32).collect();
            smoke.blocks.push(Block { origin, values, active: None });
            let values: Vec<f32> =
                places().flat_map(|p| velocity(p).as_vec3().to_array()).collect();
            vel.blocks.push(Block { origin, values, active: None });
        }
        write(&path, &[smoke, vel]).unwrap();
        let file = VdbFile::open(&path).unwrap();
        (file.read_scalar(0, ReadAs::Density).unwrap(), file.read_vector(1).unwrap())
    }

    fn ball(p: DVec3) -> f64 {
        (1.0 - (p - DVec3::new(1.5, 0.0, 0.0)).length() / 3.0).max(0.0)
    }

    fn mass(grid: &Grid<f32>) -> f64 {
        let mut sum = 0.0;
        grid.for_each_nonzero(|block| {
            let size = (block.max - block.min + 1).as_dvec3().element_product();
            sum += f64::from(block.value) * size;
        });
        sum
    }

    /// An even wind keeps the voxels, whether or not there are velocities beside the smoke.
    #[test]
    fn wind_moves_the_transform_alone() {
        let wind = DVec3::new(3.0, -2.0, 0.5);
        for everywhere in [true, false] {
            let (smoke, velocity) =
                grids(ball, |p| if everywhere || ball(p) > 0.0 { wind } else { DVec3::ZERO });
            let drift = Drift::new(&velocity, DMat3::IDENTITY * 2.0, &smoke, 1.0);
            assert!((drift.fastest() - 2.0 * wind.length()).abs() < 1e-12);
            let moved = drift.moved(smoke.clone(), 0.5).unwrap();
            assert_eq!(moved.identity(), smoke.identity());
            let p = |grid: &Grid<f32>| grid.transform().point_to_world(IndexPoint::new(1., 2., 3.));
            assert!((p(&moved) - p(&smoke) - wind).length() < 1e-9);
        }
    }

    /// A vortex turns smoke, and its mass stays within a hundredth.
    #[test]
    fn a_vortex_turns_smoke() {
        let spin = 0.9;
        let (smoke, velocity) = grids(ball, |p| DVec3::Z.cross(p) * spin);
        let drift = Drift::new(&velocity, DMat3::IDENTITY, &smoke, 1.0);
        for frames in [-0.4, 0.4] {
            let moved = drift.moved(smoke.clone(), frames).unwrap();
            let turned = glam::DQuat::from_rotation_z(spin * frames) * DVec3::new(1.5, 0.0, 0.0);
            let mut center = DVec3::ZERO;
            moved.for_each_nonzero(|block| {
                let p = IndexPoint::from_xyz(block.min.as_dvec3());
                center += moved.transform().point_to_world(p).xyz * f64::from(block.value);
            });
            let off = (center / mass(&moved) - turned).length();
            // The midpoint rule misses the arc by a third-order term.
            assert!(off < 0.03, "{off}");
            let kept = mass(&moved) / mass(&smoke);
            assert!((kept - 1.0).abs() < 0.01, "{kept}");
        }
    }

    /// Smoke that spreads arrives where there was neither smoke nor a velocity.
    #[test]
    fn smoke_spreads_into_empty_voxels() {
        let center = DVec3::new(1.5, 0.0, 0.0);
        let (smoke, velocity) =
            grids(ball, |p| if ball(p) > 0.0 { p - center } else { DVec3::ZERO });
        let drift = Drift::new(&velocity, DMat3::IDENTITY, &smoke, 1.0);
        let moved = drift.moved(smoke, 0.4).unwrap();
        let at = |reach: f64| {
            let p = WorldPoint::from_xyz(center + DVec3::Y * reach);
            moved.value(moved.transform().point_to_local(p))
        };
        // By the factor exp(0.4) where velocities are known; beyond, what is at the front goes on as fast as that.
        let expected = ball(center + DVec3::Y * (2.5 * (-0.4_f64).exp()));
        assert!((at(2.5) - expected).abs() < 0.04, "{} {expected}", at(2.5));
        assert!((0.1..0.25).contains(&at(3.5)), "{}", at(3.5));
        assert!(at(4.6) < 1e-6, "{}", at(4.6));
    }

    /// What is not finite does not spread.
    #[test]
    fn velocities_that_are_no_numbers_are_none() {
        let (smoke, velocity) = grids(ball, |p| {
            if p.x == 1.5 { DVec3::splat(f64::NAN) } else { DVec3::new(1.0, f64::INFINITY, 0.0) }
        });
        let drift = Drift::new(&velocity, DMat3::IDENTITY, &smoke, 1.0);
        assert!(drift.fastest().is_finite() && drift.fastest() > 0.9, "{}", drift.fastest());
        let moved = drift.moved(smoke, 1.0).unwrap();
        assert!(mass(&moved).is_finite() && mass(&moved) > 0.0);
    }
}
