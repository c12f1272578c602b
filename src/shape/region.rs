//! Closed regions of space, for media.

use std::sync::Arc;

use glam::DVec3;

use super::{Cuboid, Mesh, Sphere};
use crate::math::{Aabb, Ray, Span, Stream, World, WorldPoint, warp};

/// The part of the world that a medium fills.
#[derive(Debug, Clone)]
pub enum Region {
    /// All of it.
    Everywhere,
    /// The inside of a box.
    Box(Cuboid),
    /// The inside of a sphere or an ellipsoid.
    Sphere(Sphere),
    /// The inside of a closed mesh.
    Mesh(ClosedMesh),
}

/// A mesh that bounds a volume.
#[derive(Debug, Clone)]
pub struct ClosedMesh {
    mesh: Arc<Mesh>,
    oriented: bool,
}

impl ClosedMesh {
    /// The inside of `mesh`.
    ///
    /// # Errors
    /// The problem, where the mesh has holes.
    pub fn new(mesh: Arc<Mesh>) -> Result<Self, String> {
        if !mesh.is_closed() {
            return Err("the mesh is not closed, so it has no inside; each of its edges must \
                        belong to exactly two triangles"
                .into());
        }
        let oriented = mesh.is_oriented();
        Ok(Self { mesh, oriented })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The whole line of `ray` is followed, so that each crossing is paired with its other end
    /// wherever the ray begins; edges count once (`triangle::cross`). Inside is where the winding
    /// number is not zero, or odd crossings where neighbours are wound against each other.
    fn spans(&self, ray: &Ray<World>, within: Span, f: &mut impl FnMut(Span)) {
        let mut crossings = Vec::new();
        self.mesh.each_crossing(ray, |t, front| crossings.push((t, front)));
        crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut depth = 0i32;
        let mut entry = 0.0;
        for (t, front) in crossings {
            let step = if front { 1 } else { -1 };
            let deeper = if self.oriented { depth + step } else { 1 - depth };
            match (depth, deeper) {
                (0, _) => entry = t,
                (_, 0) => give(Span::new(entry, t).intersect(within), f),
                _ => {}
            }
            depth = deeper;
        }
    }
}

/// Places tried in the box round a mesh before it is given up as too thin to meet.
const MOST_TRIES: u32 = 100_000;

impl Region {
    /// Calls `f` with the intervals of `within` where the ray runs inside, in order and apart.
    pub fn spans(&self, ray: &Ray<World>, within: Span, mut f: impl FnMut(Span)) {
        match self {
            Self::Everywhere => give(within, &mut f),
            Self::Box(b) => give(b.chord(ray).intersect(within), &mut f),
            Self::Sphere(s) => give(s.chord(ray).intersect(within), &mut f),
            Self::Mesh(m) => m.spans(ray, within, &mut f),
        }
    }

    /// Whether `p` lies inside.
    pub fn contains(&self, p: WorldPoint) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Box(b) => b.contains(p),
            Self::Sphere(s) => s.contains(p),
            Self::Mesh(m) => {
                // Any line through p tells; an oblique one seldom runs along a face.
                let direction = DVec3::new(0.632_455, 0.547_722, 0.547_723);
                let mut inside = false;
                if m.mesh.bounds().contains(p) {
                    let line = Span::new(f64::NEG_INFINITY, f64::INFINITY);
                    m.spans(&Ray::new(p, direction), line, &mut |s| {
                        inside |= s.start <= 0.0 && s.end >= 0.0;
                    });
                }
                inside
            }
        }
    }

    /// A place uniform in the region; nothing where it is infinite.
    pub fn sample(&self, rng: &mut Stream) -> Option<WorldPoint> {
        match self {
            Self::Everywhere => None,
            Self::Box(b) => Some(b.at(cube(rng))),
            Self::Sphere(s) => {
                let radius = rng.uniform().cbrt();
                Some(s.at(warp::uniform_sphere(rng.uniform2()) * radius))
            }
            Self::Mesh(m) => {
                let bounds = m.mesh.bounds();
                let place = |rng: &mut Stream| bounds.min + bounds.size() * cube(rng);
                (0..MOST_TRIES).map(|_| place(rng)).find(|p| self.contains(*p))
            }
        }
    }

    /// The box round it, or nothing where it is infinite.
    pub fn bounds(&self) -> Option<Aabb<World>> {
        match self {
            Self::Everywhere => None,
            Self::Box(b) => Some(b.bounds()),
            Self::Sphere(s) => Some(s.bounds()),
            Self::Mesh(m) => Some(m.mesh.bounds()),
        }
    }

    /// Its volume in m³; nothing where it is infinite or, for a mesh with its triangles wound
    /// against each other, not known. Parts of a mesh that overlap count twice.
    pub fn volume(&self) -> Option<f64> {
        match self {
            Self::Everywhere => None,
            Self::Box(b) => Some(b.volume()),
            Self::Sphere(s) => Some(s.volume()),
            Self::Mesh(m) => m.oriented.then(|| m.mesh.enclosed_volume()),
        }
    }
}

/// Uniform in the unit cube.
fn cube(rng: &mut Stream) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.uniform()))
}

/// Calls `f` with `span` unless it is empty.
fn give(span: Span, f: &mut impl FnMut(Span)) {
    if !span.is_empty() {
        f(span);
    }
}
