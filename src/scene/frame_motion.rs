//! Where things are one frame later, for motion vectors.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::camera::{Camera, CameraMatrices};
use crate::math::{Rgb, WorldPoint};
use crate::medium::Media;
use crate::shape::Shape;
use crate::surface::{SurfaceHit, Surfaces};
use crate::vdb::Drift;

/// Where what a scene holds is one frame later.
#[derive(Debug, Clone)]
pub struct FrameMotion {
    cameras: [Camera; 2],
    /// Of the cameras; `None` where no matrix tells the projection.
    matrices: Option<[CameraMatrices; 2]>,
    /// Width and height of the film in pixels.
    size: [u32; 2],
    /// All surfaces one frame later.
    later: Arc<Surfaces>,
    /// What takes each surface that is no mesh there.
    placed: Vec<DAffine3>,
    media: Vec<MediumStep>,
}

/// How a medium comes to where it is one frame later.
#[derive(Debug, Clone)]
pub(super) enum MediumStep {
    /// Carried by velocities.
    Carried(Arc<Drift>),
    /// As a whole.
    Placed(DAffine3),
}

impl FrameMotion {
    /// What is seen by the first of two `cameras`, on films of this `size`, by the second one frame later: surfaces that are
    /// `later` there, or are `placed`, and media by their steps.
    pub(super) fn new(
        cameras: [Camera; 2],
        size: [u32; 2],
        later: Arc<Surfaces>,
        placed: Vec<DAffine3>,
        media: Vec<MediumStep>,
    ) -> Self {
        let [here, there] = cameras.each_ref().map(|camera| camera.matrices(size));
        let matrices = here.zip(there).map(|(here, there)| [here, there]);
        Self { cameras, matrices, size, later, placed, media }
    }

    /// How far the medium at `p`, one of `media`, moves in a frame, in metres: the mean by extinction where several are.
    pub fn of_media(&self, media: &Media, p: WorldPoint) -> DVec3 {
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for (medium, step) in media.iter().zip(&self.media) {
            // Between voxels that are seen there may be none at all.
            let part = medium.sigma_t_at(p).dot(Rgb::ONE).max(f64::MIN_POSITIVE);
            let moved = match step {
                MediumStep::Carried(drift) => drift.velocity_at(p),
                MediumStep::Placed(to) => to.transform_point3(p.xyz) - p.xyz,
            };
            (sum, weight) = (sum + moved * part, weight + part);
        }
        if weight > 0.0 { sum / weight } else { DVec3::ZERO }
    }

    /// How far the place of one of `surfaces` that was `hit` moves in a frame, in metres.
    pub fn of_surface(&self, surfaces: &Surfaces, hit: &SurfaceHit<'_>) -> DVec3 {
        let index = hit.surface as usize;
        let shapes = [surfaces, &*self.later].map(|all| all.surfaces()[index].shape());
        if let [Shape::Mesh(here), Shape::Mesh(there)] = shapes {
            let [a, b, c] = here.corners(hit.primitive);
            let moved = there.corners(hit.primitive);
            let [u, v] = weights([b - a, c - a], hit.point.xyz - a);
            return (moved[0] - a) * (1.0 - u - v) + (moved[1] - b) * u + (moved[2] - c) * v;
        }
        self.placed[index].transform_point3(hit.point.xyz) - hit.point.xyz
    }

    /// How far what is at `p`, and `step` metres from there one frame later, moves in the picture: in pixels rightward and upward,
    /// and away from the camera in metres. Nothing where it is not before both cameras.
    pub fn vector(&self, p: WorldPoint, step: DVec3) -> DVec3 {
        let Some([here, there]) = &self.matrices else { return DVec3::ZERO };
        let [from, to] = [p, p + step];
        let places = here.place(from.xyz, self.size).zip(there.place(to.xyz, self.size));
        let Some((a, b)) = places else { return DVec3::ZERO };
        let DVec2 { x, y } = b - a;
        let [before, after] = &self.cameras;
        DVec3::new(x, -y, distance(after, to) - distance(before, from))
    }
}

/// Distance of `p` from `camera` in metres, along the view where rays are parallel.
fn distance(camera: &Camera, p: WorldPoint) -> f64 {
    camera.place().map_or(camera.forward().dot(p.xyz), |place| (p - place).length())
}

/// Weights of the `edges` of a triangle at `p`, a place in its plane from the corner of both.
fn weights([b, c]: [DVec3; 2], p: DVec3) -> [f64; 2] {
    let normal = b.cross(c);
    let area = normal.length_squared();
    if area > 0.0 {
        [p.cross(c).dot(normal) / area, b.cross(p).dot(normal) / area]
    } else {
        [1.0 / 3.0; 2]
    }
}
