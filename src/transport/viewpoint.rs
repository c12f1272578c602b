//! Where a scene is seen from: the camera's position, and the size of a pixel in the scene.

use crate::math::{Aabb, Ray, World, WorldPoint};
use crate::medium::Medium;
use crate::scene::Scene;

/// Margin round a medium within which the camera counts as inside, as a share of the shortest side of
/// the medium's box. Cells as near as that are many pixels wide.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only verify`, the places of the camera.
const INSIDE_MARGIN: f64 = 0.02;

/// Place of the lens on the ray through the middle of the film and of the lens, in world space.
pub fn camera_position(scene: &Scene) -> WorldPoint {
    let [width, height] = scene.film.size.map(|side| 0.5 * f64::from(side));
    scene.camera.ray_from_lens(width, height, [0.5; 2]).origin
}

/// Whether a medium is bounded and the camera outside of its box and not near it.
pub fn is_camera_outside(scene: &Scene, medium: &Medium) -> bool {
    let outside = |b: Aabb<World>| {
        !b.grown(INSIDE_MARGIN * b.size().min_element()).contains(camera_position(scene))
    };
    medium.density.bounds().is_some_and(outside)
}

/// Size of a pixel in the scene, from the rays through two neighbouring pixels.
#[derive(Debug)]
pub struct PixelFootprint {
    rays: [Ray<World>; 2],
    /// Film pixels along each side that one pixel of the picture covers.
    film_pixels: f64,
}

impl PixelFootprint {
    /// The footprint of a pixel that covers `film_pixels` of the film of `scene` along each side.
    pub fn new(scene: &Scene, film_pixels: f64) -> Self {
        let [x, y] = scene.film.size.map(|side| 0.5 * f64::from(side));
        let rays = [x, x + 1.0].map(|x| scene.camera.ray_from_lens(x, y, [0.5; 2]));
        Self { rays, film_pixels }
    }

    /// Width of a pixel at the distance of `p`, in metres.
    pub fn width(&self, p: WorldPoint) -> f64 {
        let [here, next] = &self.rays;
        let t = self.distance(p);
        self.film_pixels * (next.at(t) - here.at(t)).length()
    }

    /// Distance of `p` from the camera, in metres.
    pub fn distance(&self, p: WorldPoint) -> f64 {
        (p - self.rays[0].origin).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(z: f64) -> Scene {
        Scene::of_text(&format!(
            "
            [camera]
            position = [0.0, 0.0, {z}]
            target = [0.0, 0.0, -100.0]
            fov = 90.0
            [film]
            size = [64, 64]
            [[medium]]
            region = {{ box = {{ min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] }} }}
            sigma_t = 1.0
            albedo = 0.5
            "
        ))
    }

    #[test]
    fn a_camera_is_outside_beyond_the_margin() {
        let outside = |z: f64| {
            let scene = scene(z);
            is_camera_outside(&scene, scene.media.get(0))
        };
        let margin = 2.0 * INSIDE_MARGIN;
        assert_eq!(
            [0.0, 1.0 + 0.9 * margin, 1.0 + 1.1 * margin].map(outside),
            [false, false, true]
        );
    }

    #[test]
    fn a_pixel_is_its_share_of_the_view_at_a_distance() {
        // A field of view of a right angle is twice as wide as far away.
        let footprint = PixelFootprint::new(&scene(5.0), 3.0);
        let width = footprint.width(WorldPoint::new(0.0, 0.0, -5.0));
        assert!((width - 3.0 * 20.0 / 64.0).abs() < 1e-3, "{width}");
    }
}
