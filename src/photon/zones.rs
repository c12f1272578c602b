//! Where photons are kept even without a tentative collision.

use crate::math::{Aabb, Ray, Span, Stream, World, WorldPoint};
use crate::medium::Media;

/// Photons kept for each crossing of a zone's diagonal, beside those at tentative collisions.
const PER_CROSSING: f64 = 4.0;

/// Boxes round the media, wider by the gather radius, in which photons are kept at a constant
/// rate. They fill the outside of a medium's edge, where a gather inside reaches out and no
/// tentative collision happens.
#[derive(Debug, Default)]
pub struct Zones(Vec<Zone>);

#[derive(Debug)]
struct Zone {
    bounds: Aabb<World>,
    /// Photons kept per metre.
    rate: f64,
}

impl Zones {
    /// The boxes round all media that have an end, each face moved outward by `margin` metres.
    pub fn around(media: &Media, margin: f64) -> Self {
        let zone = |bounds: Aabb<World>| {
            let bounds = bounds.grown(margin);
            Zone { bounds, rate: PER_CROSSING / bounds.size().length() }
        };
        let boxes = media.iter().filter_map(|m| m.density.bounds()).filter(|b| !b.is_empty());
        Self(boxes.map(zone).filter(|z| z.rate.is_normal()).collect())
    }

    /// Whether `ray` crosses any.
    pub fn meet(&self, ray: &Ray<World>) -> bool {
        let ahead = |zone: &Zone| !zone.bounds.clip(ray).intersect(Span::AHEAD).is_empty();
        self.0.iter().any(ahead)
    }

    /// Photons kept per metre at `p` on account of the zones.
    pub fn rate_at(&self, p: WorldPoint) -> f64 {
        self.0.iter().filter(|z| z.bounds.contains(p)).map(|z| z.rate).sum()
    }

    /// Calls `f` with the distances along `ray` within `span` at which the zones keep a photon,
    /// front to back within each zone.
    pub fn events(
        &self,
        ray: &Ray<World>,
        span: Span,
        rng: &mut Stream,
        mut f: impl FnMut(f64, &mut Stream),
    ) {
        for zone in &self.0 {
            let inside = zone.bounds.clip(ray).intersect(span);
            let mut t = inside.start;
            while t < inside.end {
                t += rng.exponential() / zone.rate;
                if t < inside.end {
                    f(t, rng);
                }
            }
        }
    }
}
