//! The snapshot (Anson et al. 2006): the scene without media, in direct light, with first-hit distances.

use rayon::prelude::*;

use crate::image::Image;
use crate::math::{Ray, Rgb, Stage, Stream, World};
use crate::medium::Media;
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::transport::specular::{MAX_SNAPSHOT_BOUNCES, scatter_specular};
use crate::transport::{PathContext, camera_view, direct_light, surface_light};
use crate::work::Work;

/// First-hit distances and direct light without the medium, one ray through the middle of each
/// pixel. It depends on camera, surfaces and lights alone, so a changed medium leaves it as it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Distance to the first surface in metres, row by row; infinite where there is none.
    pub depth: Vec<f64>,
    /// Direct light on the surfaces, W/(m² sr), and the environment where there is none.
    pub snapshot: Image,
}

impl Snapshot {
    /// Renders the snapshot of `scene` with `size` (width, height) pixels; the same on any number of
    /// threads.
    pub fn look(scene: &Scene, size: [u32; 2], seed: u64, needs: Needs) -> (Self, Work) {
        let [width, height] = size.map(|side| side as usize);
        let pixel = |index: usize, ctx: &mut PathContext| {
            ctx.rng = Stream::new(seed, Stage::Director, index as u64, 1);
            see(scene, middle(scene, size, index), ctx)
        };
        let rows: Vec<(Vec<(f64, Rgb)>, Work)> = (0..height)
            .into_par_iter()
            .map(|y| {
                let rng = Stream::new(seed, Stage::Director, 0, 1);
                let mut ctx = PathContext::new(rng, needs);
                let row = (0..width).map(|x| pixel(y * width + x, &mut ctx)).collect();
                (row, ctx.work)
            })
            .collect();
        let work = rows.iter().map(|(_, work)| *work).sum();
        let pixels = || rows.iter().flat_map(|(row, _)| row);
        let depth = pixels().map(|(depth, _)| *depth).collect();
        let stored =
            |light: &Rgb| light.to_array().map(|v| v.clamp(0.0, f64::from(f32::MAX)) as f32);
        let light = pixels().map(|(_, light)| stored(light)).collect();
        (Self { depth, snapshot: Image::new(width, height, light) }, work)
    }
}

/// The ray through the middle of the pixel `index` of a film divided into `size` pixels, and of the
/// lens.
pub(super) fn middle(scene: &Scene, size: [u32; 2], index: usize) -> Ray<World> {
    let width = size[0] as usize;
    let scale = |axis| f64::from(scene.film.size[axis]) / f64::from(size[axis]);
    let (x, y) = ((index % width) as f64, (index / width) as f64);
    scene.camera.ray((x + 0.5) * scale(0), (y + 0.5) * scale(1), [0.5, 0.5])
}

/// Distance to the first surface along `ray`, and the direct light seen there, through mirrors and
/// glass.
fn see(scene: &Scene, mut ray: Ray<World>, ctx: &mut PathContext) -> (f64, Rgb) {
    let near = scene.camera.near(&ray);
    let (mut first, mut light, mut throughput) = (f64::INFINITY, Rgb::ZERO, Rgb::ONE);
    for bounce in 0..MAX_SNAPSHOT_BOUNCES {
        let from_camera = bounce == 0;
        let hit = camera_view::surface_along(scene, &ray, from_camera, ctx);
        let emission: Rgb = match &hit {
            hit if from_camera => camera_view::emission(scene, &ray, hit.as_ref(), ctx),
            Some(hit) => direct_light::emitted(scene, &ray, hit),
            None => direct_light::environment(scene, &ray, ctx),
        };
        light += throughput * emission;
        let Some(hit) = hit else { break };
        if from_camera {
            first = near + hit.t;
            if camera_view::is_holdout(scene, &hit) {
                break;
            }
        }
        if !hit.material.is_followed() {
            let nothing = Media::default();
            let u = std::array::from_fn(|_| ctx.rng.uniform());
            let direct: Rgb =
                surface_light::direct_on_surface(scene, &nothing, ray.direction, &hit, u, ctx);
            light += throughput * direct;
            break;
        }
        let Some(step) = scatter_specular(&ray, &hit, &mut ctx.rng) else { break };
        throughput *= step.weight;
        ray = step.ray;
    }
    (first, if light.is_finite() { light } else { Rgb::ZERO })
}
