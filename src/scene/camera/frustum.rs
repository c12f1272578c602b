//! The part of space that a camera can see.

use glam::DVec3;

use super::{Camera, Kind};
use crate::math::WorldPoint;

/// How far outside of a plane a place must lie, as a share of its distance: more than rounding.
const MARGIN: f64 = 1e-9;

/// What lies where the camera begins to see or behind that, and between the planes through the edges of the film.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// A point of each plane and its unit normal, which points inside.
    planes: [(WorldPoint, DVec3); 5],
}

impl Camera {
    /// What it sees of a film of `size` pixels; nothing where that is not known to lie between
    /// planes: through a lens, or all round.
    pub fn frustum(&self, size: [u32; 2]) -> Option<Frustum> {
        match &self.kind {
            Kind::Perspective(camera) if camera.lens_radius > 0.0 => return None,
            Kind::Perspective(_) | Kind::Orthographic(_) => {}
            Kind::LatLong(_) => return None,
        }
        let [width, height] = size.map(f64::from);
        let ray = |x: f64, y: f64| self.ray(x * width, y * height, [0.5; 2]);
        let corners = [ray(0.0, 0.0), ray(1.0, 0.0), ray(1.0, 1.0), ray(0.0, 1.0)];
        let middle = ray(0.5, 0.5);
        let plane = |index: usize| {
            let (one, next) = (&corners[index], &corners[(index + 1) % 4]);
            let normal = one.direction.cross(next.at(1.0) - one.origin).normalize();
            let inside = (middle.at(1.0) - one.origin).dot(normal) >= 0.0;
            (one.origin, if inside { normal } else { -normal })
        };
        let planes = [plane(0), plane(1), plane(2), plane(3), (middle.origin, self.forward())];
        planes.iter().all(|(_, normal)| normal.is_finite()).then_some(Frustum { planes })
    }
}

impl Frustum {
    /// Whether what lies between `corners`, their convex hull, is certainly not seen.
    pub fn misses(&self, corners: &[WorldPoint]) -> bool {
        let outside = |(point, normal): &(WorldPoint, DVec3)| {
            corners.iter().all(|corner| {
                let from = *corner - *point;
                from.dot(*normal) < -MARGIN * from.length()
            })
        };
        self.planes.iter().any(outside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Aabb, Span, Stage, Stream, World};
    use crate::scene::camera::{Pose, Projection};

    #[test]
    fn no_ray_meets_what_is_missed() {
        let size = [40, 30];
        let pose = Pose {
            position: DVec3::new(3.0, 1.0, 4.0),
            target: DVec3::new(0.2, 0.0, 0.0),
            up: DVec3::Y,
        };
        for projection in [
            Projection::Perspective { fov: 40.0, aperture: 0.0, focus: None, shift: [0.0; 2] },
            Projection::Perspective { fov: 80.0, aperture: 0.0, focus: None, shift: [0.9, 0.4] },
            Projection::Orthographic { height: 2.0, shift: [0.2, 0.1] },
        ] {
            let camera = Camera::new(&pose, &projection, size).unwrap().clipped(Some([0.5, 50.0]));
            let frustum = camera.frustum(size).unwrap();
            let mut rng = Stream::new(2, Stage::Test, 0, 0);
            let (mut missed, mut seen) = (0, 0);
            for _ in 0..400 {
                let middle = DVec3::from(std::array::from_fn(|_| 12.0 * rng.uniform() - 6.0));
                let middle = WorldPoint::from_xyz(middle);
                let bounds: Aabb<World> = Aabb::new(middle, middle).grown(0.4 * rng.uniform());
                let misses = frustum.misses(&bounds.corners());
                let met = (0..=40 * 30).any(|_| {
                    let (x, y) = (40.0 * rng.uniform(), 30.0 * rng.uniform());
                    let ray = camera.ray(x, y, [0.5; 2]);
                    !bounds.clip(&ray).intersect(Span::AHEAD).is_empty()
                });
                assert!(!(misses && met), "{projection:?}: {bounds:?}");
                (missed, seen) = (missed + u32::from(misses), seen + u32::from(met));
            }
            assert!(missed > 200 && seen > 5, "{missed} missed, {seen} seen");
        }
    }

    #[test]
    fn a_lens_and_the_whole_sphere_have_no_planes() {
        let pose = Pose { position: DVec3::ZERO, target: DVec3::Z, up: DVec3::Y };
        let lens =
            Projection::Perspective { fov: 40.0, aperture: 0.1, focus: None, shift: [0.0; 2] };
        for projection in [lens, Projection::LatLong] {
            let camera = Camera::new(&pose, &projection, [4, 4]).unwrap();
            assert_eq!(camera.frustum([4, 4]), None);
        }
    }
}
