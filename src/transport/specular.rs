//! Steps of paths through mirrors and glass.
//!
//! Paths that follow mirrors and glass end after a number of such steps, by what follows them:
//!
//! | path | limit |
//! | --- | --- |
//! | camera rays | [`MAX_CAMERA_BOUNCES`] |
//! | rays of the director's snapshot | [`MAX_SNAPSHOT_BOUNCES`] |
//! | rays that look for features and for what the camera sees | [`MAX_PROBE_BOUNCES`] |
//!
//! Final gathers and the reference have no limit of their own: Russian roulette ends them.

use smallvec::SmallVec;

use crate::math::{Ray, Rgb, Stream, World};
use crate::surface::{Scattered, SurfaceHit, TransportMode};

/// Mirrors and glass that a camera ray follows, in bounces. It decides the picture, so it is high:
/// glass that reflects inside of itself ends here, darkened.
///
/// Unit: count. Limit: on paths between mirrors that face each other.
pub const MAX_CAMERA_BOUNCES: u32 = 64;

/// Mirrors and glass that a ray of the director's snapshot follows, in bounces. The snapshot directs
/// rays only; a path that is longer is seen faintly.
///
/// Unit: count. Limit: as [`MAX_CAMERA_BOUNCES`].
pub const MAX_SNAPSHOT_BOUNCES: u32 = 16;

/// Mirrors and glass that rays follow which look for denoiser features and for the media that the
/// camera sees, in bounces.
///
/// Unit: count. Limit: as [`MAX_CAMERA_BOUNCES`].
pub const MAX_PROBE_BOUNCES: u32 = 8;

/// Where a path goes on behind a mirror or a pane of glass.
#[derive(Debug, Clone, Copy)]
pub struct SpecularStep {
    /// The reflected or refracted ray.
    pub ray: Ray<World>,
    /// Value times cosine, over the density where it was sampled.
    pub weight: Rgb,
    /// +1 where the ray enters a solid, -1 where it leaves one, else 0.
    pub crossing: i8,
}

/// Reflects or refracts radiance that arrives along `ray` at the specular surface `hit`; `None`
/// where the surface absorbs it.
pub fn scatter_specular(
    ray: &Ray<World>,
    hit: &SurfaceHit<'_>,
    rng: &mut Stream,
) -> Option<SpecularStep> {
    let u = std::array::from_fn(|_| rng.uniform());
    let scattered = hit.material.scatter(ray.direction, hit, u, TransportMode::Radiance)?;
    Some(SpecularStep::new(hit, &scattered))
}

/// Reflects and refracts radiance that arrives along `ray` at the specular surface `hit`: all that it is split into,
/// weighed by values times cosines.
pub fn split_specular(ray: &Ray<World>, hit: &SurfaceHit<'_>) -> SmallVec<[SpecularStep; 2]> {
    let branches = hit.material.specular_branches(ray.direction, hit);
    branches.iter().map(|scattered| SpecularStep::new(hit, scattered)).collect()
}

impl SpecularStep {
    fn new(hit: &SurfaceHit<'_>, scattered: &Scattered) -> Self {
        Self {
            ray: hit.leave(scattered.direction),
            weight: scattered.weight,
            crossing: scattered.crossing,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::{Span, Stage, WorldPoint};
    use crate::scene::Scene;
    use crate::transport::EnclosingSolids;

    /// A ball of glass without tint.
    const BALL: &str = r#"
        [camera]
        position = [0.0, 0.0, 5.0]
        target = [0.0, 0.0, 0.0]
        fov = 30.0
        [film]
        size = [16, 16]
        [[surface]]
        shape = "sphere"
        center = [0.0, 0.0, 0.0]
        radius = 1.0
        material = { type = "glass", ior = 1.5 }
    "#;

    /// In the mean over choices a ray goes on as it is split, and both parts of untinted glass have all of its power:
    /// radiance that is refracted grows by the squared index.
    #[test]
    fn split_rays_are_the_mean_of_chosen_ones() {
        let scene = Scene::of_text(BALL);
        let direction = DVec3::new(0.2, 0.1, -1.0).normalize();
        let ray = Ray::new(WorldPoint::new(0.0, 0.0, 3.0), direction);
        let hit = scene.surfaces.intersect(&ray, Span::AHEAD).unwrap();
        let split = split_specular(&ray, &hit);
        let mut rng = Stream::new(2, Stage::Test, 0, 0);
        let count = 20_000;
        let mut sums = [0.0; 2];
        for _ in 0..count {
            let step = scatter_specular(&ray, &hit, &mut rng).unwrap();
            let same = |branch: &SpecularStep| branch.crossing == step.crossing;
            let index = split.iter().position(same).unwrap();
            assert!((split[index].ray.direction - step.ray.direction).length() < 1e-12);
            sums[index] += step.weight.x / f64::from(count);
        }
        for (sum, branch) in sums.iter().zip(&split) {
            // 4.5 standard errors of a choice at most: a false alarm of 7e-6 at this fixed seed.
            assert!((sum - branch.weight.x).abs() < 4.5 * 0.5 / f64::from(count).sqrt());
        }
        let squared = 1.5 * 1.5;
        assert!((split[0].weight.x + split[1].weight.x * squared - 1.0).abs() < 1e-12);
    }

    /// Along a diameter nothing is refracted: the ray enters, is reflected inside or not, and leaves
    /// along the same line, outside of the ball exactly where the count of solids is 0.
    #[test]
    fn a_ray_through_a_ball_of_glass_is_inside_between_its_faces() {
        let scene = Scene::of_text(BALL);
        let mut rng = Stream::new(1, Stage::Test, 0, 0);
        for _ in 0..100 {
            let mut ray = Ray::new(WorldPoint::new(0.0, 0.0, 3.0), DVec3::NEG_Z);
            let mut solids = EnclosingSolids::NONE;
            while let Some(hit) = scene.surfaces.intersect(&ray, Span::AHEAD) {
                let step = scatter_specular(&ray, &hit, &mut rng).unwrap();
                solids = solids.after(step.crossing);
                ray = step.ray;
                assert!(ray.direction.x.abs() + ray.direction.y.abs() < 1e-9);
                let leaves = ray.direction.dot(hit.normal) > 0.0;
                assert_eq!(solids.is_none(), leaves);
            }
        }
    }
}
