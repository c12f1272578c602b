//! Matrices of cameras, as compositors read them from headers.

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::{Camera, Kind};
use crate::math::WorldPoint;

/// What takes points of the world to a camera. Vectors are rows, on the left of a matrix, as in OpenEXR: the rows are
/// what the axes x, y and z and the origin become.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraMatrices {
    /// To the camera, in metres: x rightward, y upward, and z against the view, as in OpenGL, USD and Nuke.
    pub camera: [[f64; 4]; 4],
    /// To the picture, whose upper left corner is (0, 0) and lower right one (1, 1), after division by the last number.
    pub picture: [[f64; 4]; 4],
}

impl CameraMatrices {
    /// Where `p`, in metres, is on a film of `size`, in pixels from its upper left corner; `None` where it is not before the
    /// camera.
    pub fn place(&self, p: DVec3, size: [u32; 2]) -> Option<DVec2> {
        let p = p.extend(1.0);
        let column = |i: usize| p.dot(DVec4::from(self.picture.map(|row| row[i])));
        let [u, v, w] = [0, 1, 3].map(column);
        (w > 0.0).then(|| DVec2::new(u, v) / w * DVec2::from(size.map(f64::from)))
    }
}

impl Camera {
    /// Its matrices for the film of `size`, width and height in pixels; `None` where no matrix tells the projection.
    pub fn matrices(&self, size: [u32; 2]) -> Option<CameraMatrices> {
        let (origin, axes, middle, pixel, is_perspective) = match &self.kind {
            Kind::Perspective(c) => (c.origin, c.axes, c.middle, c.pixel, true),
            Kind::Orthographic(c) => (c.origin, c.axes, c.middle, c.pixel, false),
            Kind::LatLong(_) => return None,
        };
        let [width, height] = size.map(f64::from);
        let [u, v] = [middle[0] / width, middle[1] / height];
        let to_camera = to_camera(origin, axes);
        // Columns of a matrix for column vectors. The view is along -z.
        let [across, down] = [1.0 / (width * pixel), -1.0 / (height * pixel)];
        let [x, y] = [DVec4::X * across, DVec4::Y * down];
        let projection = if is_perspective {
            DMat4::from_cols(x, y, DVec4::new(-u, -v, -1.0, -1.0), -DVec4::Z)
        } else {
            DMat4::from_cols(x, y, -DVec4::Z, DVec4::new(u, v, 0.0, 1.0))
        };
        // The columns of a matrix for column vectors are the rows of one for row vectors.
        Some(CameraMatrices {
            camera: to_camera.to_cols_array_2d(),
            picture: (projection * to_camera).to_cols_array_2d(),
        })
    }
}

fn to_camera(origin: WorldPoint, [right, up, forward]: [DVec3; 3]) -> DMat4 {
    let eye = origin - WorldPoint::from_xyz(DVec3::ZERO);
    let axes = [right, up, -forward];
    let row = |axis: DVec3| axis.extend(-axis.dot(eye));
    let [x, y, z] = axes.map(row);
    DMat4::from_cols(x, y, z, DVec4::W).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::{Pose, Projection};
    use proptest::prelude::*;

    /// The row `p`, 1 times `rows`.
    fn times(p: DVec3, rows: &[[f64; 4]; 4]) -> [f64; 4] {
        let p = [p.x, p.y, p.z, 1.0];
        std::array::from_fn(|column| (0..4).map(|row| p[row] * rows[row][column]).sum())
    }

    proptest! {
        #[test]
        fn points_of_rays_come_back_to_their_places(
            x in 0.0_f64..320.0, y in 0.0_f64..200.0, t in 0.1_f64..50.0, turn in 0.0_f64..6.0, parallel in any::<bool>(),
            shift in prop::array::uniform2(-0.5_f64..0.5),
        ) {
            let pose = Pose {
                position: DVec3::new(3.0, -2.0, 5.0),
                target: DVec3::new(3.0 + turn.sin(), -1.5, 5.0 + turn.cos()),
                up: DVec3::Y,
            };
            let projection = if parallel {
                Projection::Orthographic { height: 4.0, shift }
            } else {
                Projection::Perspective { fov: 50.0, aperture: 0.0, focus: None, shift }
            };
            let camera = Camera::new(&pose, &projection, [320, 200]).unwrap();
            let ray = camera.ray(x, y, [0.5; 2]);
            let p = ray.at(t) - WorldPoint::from_xyz(DVec3::ZERO);
            let matrices = camera.matrices([320, 200]).unwrap();
            let [u, v, _, w] = times(p, &matrices.picture);
            prop_assert!((u / w * 320.0 - x).abs() < 1e-9 && (v / w * 200.0 - y).abs() < 1e-9);
            let [right, up, backward, one] = times(p, &matrices.camera);
            let [across, above, forward] = pose.axes().unwrap();
            let from_eye = p - pose.position;
            let expected = [across.dot(from_eye), above.dot(from_eye), -forward.dot(from_eye), 1.0];
            for (found, expected) in [right, up, backward, one].into_iter().zip(expected) {
                prop_assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
            }
            prop_assert!(backward < 0.0);
        }
    }

    #[test]
    fn a_sphere_of_directions_has_no_matrix() {
        let pose = Pose { position: DVec3::ZERO, target: DVec3::X, up: DVec3::Y };
        assert!(
            Camera::new(&pose, &Projection::LatLong, [8, 4]).unwrap().matrices([8, 4]).is_none()
        );
    }
}
