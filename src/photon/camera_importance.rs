//! What the camera sees of the media: where photons are worth most.

use crate::light::TargetSphere;
use crate::math::{Aabb, Ray, Rgb, Span, Stage, Stream, World, WorldPoint};
use crate::medium::Profile;
use crate::scene::Scene;
use crate::scene::plan::Needs;
use crate::surface::TransportMode;
use crate::work::Work;

/// Rays along each side of the film.
const RAYS: u32 = 48;

/// Mirrors and panes of glass that a ray follows at most.
const MAX_SPECULAR: u32 = 8;

/// Foci at most.
const MOST_FOCI: usize = 32;

/// How much wider than the places of a group its ball is: there are more where those are.
const WIDER: f64 = 1.2;

/// Places that the camera sees, found by a coarse sheet of rays.
#[derive(Debug, Default)]
pub struct CameraImportance {
    /// Places in media, in proportion to what a scattering there contributes.
    pub media: Vec<WorldPoint>,
    /// Places on surfaces that are not mirrors or glass.
    pub surfaces: Vec<WorldPoint>,
    /// What finding them took.
    pub work: Work,
}

/// A place where light may be scattered along one of the rays.
struct Candidate {
    place: WorldPoint,
    /// Of all that the ray crosses.
    opacity: f64,
    /// A number in [0, 1) which tells whether it is one of the visible places: those of the most opaque
    /// ray all are, however thin that is.
    choice: f64,
}

impl CameraImportance {
    /// Looks at `scene` through its camera, for what `needs` say.
    pub fn look(scene: &Scene, seed: u64, needs: Needs) -> Self {
        let mut visible = Self::default();
        let mut profile = Profile::default();
        let scale = scene.film.size.map(|side| f64::from(side) / f64::from(RAYS));
        let mut candidates = Vec::new();
        for index in 0..RAYS * RAYS {
            let mut rng = Stream::new(seed, Stage::Director, u64::from(index), 0);
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

    fn follow(
        &mut self,
        scene: &Scene,
        needs: Needs,
        mut ray: Ray<World>,
        profile: &mut Profile,
        candidates: &mut Vec<Candidate>,
        rng: &mut Stream,
    ) {
        let mut inside = 0;
        for _ in 0..MAX_SPECULAR {
            self.work.intersections += u64::from(needs.surfaces);
            let hit = scene.surfaces.intersect(&ray, Span::AHEAD);
            if inside == 0 && needs.media {
                let end = hit.as_ref().map_or(f64::INFINITY, |h| h.t);
                profile.trace(&scene.media, &ray, Span::new(0.0, end), 0.0, 0.5);
                profile.count(&mut self.work);
                let opacity = (Rgb::ONE - profile.transmittance()).max_element();
                if let Some(place) = profile.sample(rng.uniform2()) {
                    let place = ray.at(place.t);
                    candidates.push(Candidate { place, opacity, choice: rng.uniform() });
                }
            }
            let Some(hit) = hit else { return };
            if !hit.material.is_specular() {
                self.surfaces.push(hit.point);
                return;
            }
            let u = std::array::from_fn(|_| rng.uniform());
            let scattered = hit.material.scatter(ray.direction, &hit, u, TransportMode::Radiance);
            let Some(scattered) = scattered else { return };
            inside = (inside + i32::from(scattered.crossing)).max(0);
            ray = hit.leave(scattered.direction);
        }
    }

    /// A sphere round most of what is seen of the media, or of the surfaces where no medium is
    /// seen: centre and radius in metres. Nothing where nothing is seen.
    pub fn sphere(&self) -> Option<(WorldPoint, f64)> {
        sphere(if self.media.is_empty() { &self.surfaces } else { &self.media })
    }

    /// Balls round the places in media, each with their number as weight.
    pub fn foci(&self) -> Vec<TargetSphere> {
        foci(&self.media)
    }

    /// Balls round the places on surfaces, each with their number as weight.
    pub fn surface_foci(&self) -> Vec<TargetSphere> {
        foci(&self.surfaces)
    }

    /// How deep media are seen, in metres: the mean free path where they are, by the median.
    pub fn depth(&self, scene: &Scene) -> f64 {
        let free_path = |p: &WorldPoint| 1.0 / scene.media.sigma_t_at(*p).max_element();
        let mut paths: Vec<f64> = self.media.iter().map(free_path).collect();
        paths.sort_unstable_by(f64::total_cmp);
        paths.get(paths.len() / 2).copied().unwrap_or(f64::INFINITY)
    }
}

/// A sphere round most of `places`: centre and radius in metres.
fn sphere(places: &[WorldPoint]) -> Option<(WorldPoint, f64)> {
    let first = *places.first()?;
    let sum: glam::DVec3 = places.iter().map(|p| *p - first).sum();
    let center = first + sum / places.len() as f64;
    let mut distances: Vec<f64> = places.iter().map(|p| (*p - center).length()).collect();
    distances.sort_unstable_by(f64::total_cmp);
    Some((center, 1.5 * distances[distances.len() * 95 / 100]))
}

/// Balls round groups of `places`, each with their number as weight: what is wide and holds many is
/// cut in two across its longest side, over and over.
fn foci(places: &[WorldPoint]) -> Vec<TargetSphere> {
    let mut groups = vec![Group::new(places.to_vec())];
    while groups.len() < MOST_FOCI {
        let widest =
            groups.iter().enumerate().max_by(|(_, a), (_, b)| a.cost().total_cmp(&b.cost()));
        let Some((index, _)) = widest.filter(|(_, group)| group.cost() > 0.0) else { break };
        let halves = groups.swap_remove(index).halves();
        groups.extend(halves);
    }
    groups.iter().map(Group::ball).collect()
}

/// Places near each other.
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

    /// How much there is to gain by cutting it: its extent seen from a side, for each place.
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
        TargetSphere { center, radius: WIDER * radius, weight: self.places.len() as f64 }
    }
}
