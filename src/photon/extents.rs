//! Extents of a scene for photons.

use crate::math::{Aabb, World, WorldPoint};
use crate::scene::Scene;

use super::camera_importance::CameraImportance;

/// Radius, in metres, that stands for infinity.
///
/// Unit: m. Limit: its square fits 32 bits.
pub(super) const ENDLESS: f64 = 1e15;

/// Largest gather radius where none is given, as a share of the size of the media.
///
/// Unit: none. Bench: `cargo bench --bench results -- --only equal-time`.
const MAX_RADIUS: f64 = 0.02;

/// Boxes and lengths of a scene that follow from its media, its surfaces and what its camera sees.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extents {
    /// The box round all media.
    pub media: Aabb<World>,
    /// The box round all media and finite surfaces.
    pub everything: Aabb<World>,
    /// Diagonal of the media, in metres; of unbounded ones that of what the camera sees.
    pub size: f64,
    /// The gather radius in metres, where the scene names one.
    pub radius: Option<f64>,
    /// Largest gather radius, in metres: how far gathers reach beyond a medium.
    pub margin: f64,
    /// What stored positions are relative to.
    pub origin: WorldPoint,
    /// Depth to which the camera sees media, in metres: a typical mean free path.
    pub depth: f64,
}

impl Extents {
    /// The extents of `scene` with this gather radius in metres, if any.
    pub fn new(scene: &Scene, visible: &CameraImportance, radius: Option<f64>) -> Self {
        let media = scene.media.bounds();
        let everything = media.union(scene.surfaces.bounds());
        // Of an unbounded medium what the camera sees.
        let seen = visible.sphere().map(|(_, radius)| (2.0 * radius).min(ENDLESS));
        let size = seen.filter(|_| scene.media.is_endless()).unwrap_or(extent(media, everything));
        // A gather wider than all there is finds nothing more and spoils the rest.
        let radius = radius.map(|radius| radius.min(size));
        Self {
            media,
            everything,
            size,
            radius,
            margin: radius.unwrap_or(MAX_RADIUS * size),
            origin: visible.sphere().map_or_else(|| middle(everything), |(center, _)| center),
            depth: visible.depth(scene).min(size),
        }
    }

    /// Diagonal of surfaces and media together, in metres.
    pub fn full_size(&self) -> f64 {
        extent(self.everything, self.media)
    }
}

/// A box that stands for everything.
pub(super) fn endless() -> Aabb<World> {
    let middle = WorldPoint::new(0.0, 0.0, 0.0);
    Aabb::new(middle, middle).grown(ENDLESS)
}

/// The centre of `bounds`, or the world's origin where they are empty: a scene of infinite planes.
pub(super) fn middle(bounds: Aabb<World>) -> WorldPoint {
    if bounds.is_empty() { WorldPoint::new(0.0, 0.0, 0.0) } else { bounds.center() }
}

/// The diagonal of `first`, or of `second` where that is empty, or 1 m.
fn extent(first: Aabb<World>, second: Aabb<World>) -> f64 {
    [first, second].iter().find(|b| !b.is_empty()).map_or(1.0, |b| b.size().length())
}
