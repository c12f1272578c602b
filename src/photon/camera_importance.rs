//! Importance of the camera (Peter and Pietrek 1998, "Importance Driven Construction of Photon Maps"):
//! points in media and on surfaces that it sees, where photons are worth most.

use crate::light::TargetSphere;
use crate::math::{Aabb, Ray, Rgb, Span, Stage, Stream, World, WorldPoint, quantile};
use crate::medium::Profile;
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::transport::specular::{MAX_PROBE_BOUNCES, scatter_specular};
use crate::transport::{EnclosingSolids, camera_view};
use crate::work::Work;

/// Rays along each side of the film by which visible points are sampled.
///
/// Unit: count. Derivation: their square gives each of [`MAX_SPHERES`] some seventy points.
const RAYS: u32 = 48;

/// Target spheres at most. More spheres follow what is seen more closely, and each costs time at
/// every emission.
///
/// Unit: count. Limit: on the spheres that each emission weighs.
const MAX_SPHERES: usize = 32;

/// Radius of a target sphere over that of the points in it, which sample a wider region.
///
/// Unit: none. Derivation: n points spread evenly over a length span (n - 1) / (n + 1) of it, 1 / 1.2 for
/// 11 points, few for a sphere.
const MARGIN: f64 = 1.2;

/// Quantile of the distances of all points from their mean by which the sphere round them is as wide as
/// it is: single points far behind the others do not widen it.
///
/// Unit: none. Derivation: that of [`SPHERE_MARGIN`].
const SPHERE_SHARE: f64 = 0.95;

/// Radius of that sphere over that quantile.
///
/// Unit: none. Derivation: of points that are normally distributed about their mean all but one in two
/// thousand are within the sphere.
const SPHERE_MARGIN: f64 = 1.5;

/// Seed of all that photons are aimed by: rays of the camera, and paths of pilots.
///
/// Unit: none. Definition: any number does; this one has no pattern, pi in hexadecimal.
pub(super) const AIM_SEED: u64 = 0x243f_6a88_85a3_08d3;

/// Points that the camera sees, sampled by a coarse grid of rays.
#[derive(Debug, Default)]
pub struct CameraImportance {
    /// Points in media, in proportion to what a scattering there contributes.
    pub media: Vec<WorldPoint>,
    /// Points on surfaces that are not mirrors or glass.
    pub surfaces: Vec<WorldPoint>,
    /// Work done for them.
    pub work: Work,
}

/// A point where light may be scattered along one of the rays.
struct Candidate {
    place: WorldPoint,
    /// Opacity of all that the ray crosses.
    opacity: f64,
    /// A uniform number in [0, 1) that decides whether it is kept: with a probability in proportion to
    /// the opacity, 1 for the most opaque ray.
    choice: f64,
}

impl CameraImportance {
    /// Samples what the camera of `scene` sees. It does not depend on the seed of a render.
    pub fn look(scene: &Scene, needs: Needs) -> Self {
        let mut visible = Self::default();
        let mut profile = Profile::default();
        let scale = scene.film.size.map(|side| f64::from(side) / f64::from(RAYS));
        let mut candidates = Vec::new();
        for index in 0..RAYS * RAYS {
            let mut rng = Stream::new(AIM_SEED, Stage::Director, u64::from(index), 0);
            let x = (f64::from(index % RAYS) + rng.uniform()) * scale[0];
            let y = (f64::from(index / RAYS) + rng.uniform()) * scale[1];
            let ray = scene.camera.ray(x, y, rng.uniform2());
            visible.follow(scene, needs, ray, &mut profile, &mut candidates, &mut rng);
        }
        let most = candidates.iter().map(|c| c.opacity).fold(0.0, f64::max);
        let kept = candidates.iter().filter(|c| c.choice * most < c.opacity);
        visible.media = kept.map(|c| c.place).collect();
        visible
    }

    /// Traces a ray through mirrors and glass to the first diffuse surface, and samples one point of the
    /// media by opacity between two surfaces.
    fn follow(
        &mut self,
        scene: &Scene,
        needs: Needs,
        mut ray: Ray<World>,
        profile: &mut Profile,
        candidates: &mut Vec<Candidate>,
        rng: &mut Stream,
    ) {
        let mut solids = EnclosingSolids::NONE;
        let mut seen = Span::new(0.0, scene.camera.end(&ray));
        for bounce in 0..MAX_PROBE_BOUNCES {
            self.work.intersections += u64::from(needs.surfaces);
            let hit = if bounce == 0 {
                scene.surfaces.intersect_seen(&ray, seen)
            } else {
                scene.surfaces.intersect(&ray, seen)
            };
            if solids.is_none() && needs.media {
                let end = hit.as_ref().map_or(seen.end, |h| h.t);
                profile.trace(&scene.media, &ray, Span::new(0.0, end), 0.0, 0.5);
                profile.count(&mut self.work);
                let opacity = (Rgb::ONE - profile.transmittance()).max_element();
                if let Some(place) = profile.sample(rng.uniform2()) {
                    let place = ray.at(place.t);
                    candidates.push(Candidate { place, opacity, choice: rng.uniform() });
                }
            }
            let Some(hit) = hit else { return };
            if bounce == 0 && camera_view::is_holdout(scene, &hit) {
                return;
            }
            if !hit.material.is_followed() {
                self.surfaces.push(hit.point);
                return;
            }
            let Some(step) = scatter_specular(&ray, &hit, rng) else { return };
            solids = solids.after(step.crossing);
            (ray, seen) = (step.ray, Span::AHEAD);
        }
    }

    /// A sphere round most of what is seen of the media, or of the surfaces where no medium is
    /// seen: centre and radius in metres. `None` where nothing is seen.
    pub fn sphere(&self) -> Option<(WorldPoint, f64)> {
        sphere(if self.media.is_empty() { &self.surfaces } else { &self.media })
    }

    /// Spheres round groups of points in media, each weighed by their number.
    pub fn foci(&self) -> Vec<TargetSphere> {
        foci(&self.media)
    }

    /// Spheres round groups of points on surfaces, each weighed by their number.
    pub fn surface_foci(&self) -> Vec<TargetSphere> {
        foci(&self.surfaces)
    }

    /// Median of the mean free path at the points in media, in metres: how deep media are seen.
    pub fn depth(&self, scene: &Scene) -> f64 {
        let free_path = |p: &WorldPoint| 1.0 / scene.media.sigma_t_at(*p).max_element();
        let free_paths = self.media.iter().map(free_path).collect();
        quantile(free_paths, 0.5).unwrap_or(f64::INFINITY)
    }
}

/// A sphere round the mean of `places` with [`SPHERE_MARGIN`] times the quantile [`SPHERE_SHARE`] of their
/// distances as radius: centre and radius in metres.
fn sphere(places: &[WorldPoint]) -> Option<(WorldPoint, f64)> {
    let first = *places.first()?;
    let sum: glam::DVec3 = places.iter().map(|p| *p - first).sum();
    let center = first + sum / places.len() as f64;
    let distances = places.iter().map(|p| (*p - center).length()).collect();
    Some((center, SPHERE_MARGIN * quantile(distances, SPHERE_SHARE)?))
}

/// Spheres round groups of `places`, each weighed by their number: the group that is widest and
/// holds most is cut in two across its longest side, over and over.
fn foci(places: &[WorldPoint]) -> Vec<TargetSphere> {
    let mut groups = vec![Group::new(places.to_vec())];
    while groups.len() < MAX_SPHERES {
        let widest =
            groups.iter().enumerate().max_by(|(_, a), (_, b)| a.cost().total_cmp(&b.cost()));
        let Some((index, _)) = widest.filter(|(_, group)| group.cost() > 0.0) else { break };
        let halves = groups.swap_remove(index).halves();
        groups.extend(halves);
    }
    groups.iter().map(Group::ball).collect()
}

/// Points near each other.
#[derive(Debug)]
struct Group {
    places: Vec<WorldPoint>,
    bounds: Aabb<World>,
}

impl Group {
    fn new(places: Vec<WorldPoint>) -> Self {
        let bounds = Aabb::around(places.iter().copied());
        Self { places, bounds }
    }

    /// Gain of cutting it: the squared diagonal of its box times the number of points.
    fn cost(&self) -> f64 {
        if self.bounds.is_empty() {
            return 0.0;
        }
        self.places.len() as f64 * self.bounds.size().length_squared()
    }

    fn halves(self) -> [Self; 2] {
        let (axis, middle) = (self.bounds.size().max_position(), self.bounds.center());
        let is_low = |p: &WorldPoint| p.xyz[axis] < middle.xyz[axis];
        let (low, high) = self.places.into_iter().partition(is_low);
        [low, high].map(Self::new)
    }

    fn ball(&self) -> TargetSphere {
        let center = self.bounds.center();
        let radius = self.places.iter().map(|p| (*p - center).length()).fold(0.0, f64::max);
        TargetSphere { center, radius: MARGIN * radius, weight: self.places.len() as f64 }
    }
}
