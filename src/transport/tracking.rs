//! Null-collision tracking: the one flight of paths through media.
//!
//! Tentative collisions come at the rate of the majorant; each is a scattering, an absorption or a
//! null collision, chosen in proportion to the mean over channels of throughput times coefficient
//! (Kutz et al. 2017, "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes",
//! history-aware averages; Novák et al. 2018, section 4). pbrt-v4's `SampleT_maj` is the model: the
//! loop stands here, and a callback sees each step of it.

use glam::DVec3;

use crate::math::{Ray, Rgb, Span, Spectrum, World, WorldPoint};
use crate::medium::{Collision, Media};

use super::PathContext;

/// How a flight treats absorption.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absorption {
    /// Absorption is an event that ends the path (analog).
    Sampled,
    /// Absorption lowers the throughput at scatterings (survival weighting).
    Weighted,
}

/// One step of a flight: a segment up to a tentative collision, or to the flight's end.
#[derive(Debug, Clone, Copy)]
pub struct FlightStep<S> {
    /// The segment along the ray, in metres.
    pub span: Span,
    /// Throughput or power along it.
    pub throughput: S,
    /// The tentative collision at its end; `None` on the last segment, which reaches the end.
    pub collision: Option<Collision>,
}

/// How a flight ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlightEnd {
    /// It reached the end of its span.
    Through,
    /// A medium scatters the path.
    Scattered {
        /// Distance along the ray, in metres.
        t: f64,
        /// Index of the medium.
        medium: usize,
    },
    /// The path was absorbed at this distance, in metres.
    Absorbed(f64),
}

/// What a tentative collision turned out to be.
enum Event {
    Scattered,
    Absorbed,
    Null,
}

/// Flies along `ray` (unit direction) through `media` as far as `end` metres. `throughput` (or
/// power, any unit) is multiplied by the weight of each event. `visit` sees each segment with the
/// tentative collision at its end before it is known what the collision is: for emission, deposits
/// and the like.
#[inline]
pub fn fly<S: Spectrum>(
    media: &Media,
    ray: &Ray<World>,
    end: f64,
    throughput: &mut S,
    absorption: Absorption,
    ctx: &mut PathContext,
    mut visit: impl FnMut(&FlightStep<S>, &mut PathContext),
) -> FlightEnd {
    let mut weight = *throughput;
    let mut flights = media.flights(ray, Span::new(0.0, end), weight, &mut ctx.rng);
    let mut start = 0.0;
    let flown = loop {
        let collision = flights.next(&mut ctx.rng);
        ctx.work.grid_lookups += flights.take_lookups();
        let span = Span::new(start, collision.map_or(end, |c| c.t));
        visit(&FlightStep { span, throughput: weight, collision }, ctx);
        let Some(c) = collision else { break FlightEnd::Through };
        ctx.work.collisions += 1;
        let event;
        (event, weight) = collide(media, &c, ray.at(c.t), weight, absorption, ctx);
        match event {
            Event::Scattered => break FlightEnd::Scattered { t: c.t, medium: c.medium },
            Event::Absorbed => break FlightEnd::Absorbed(c.t),
            Event::Null => {
                ctx.work.null_collisions += 1;
                flights.carry_on(weight, c.t, &mut ctx.rng);
            }
        }
        start = c.t;
    };
    *throughput = weight;
    flown
}

/// Chooses what the tentative collision `c` at `p` is; with it comes the throughput times coefficient
/// over majorant and probability.
#[inline]
fn collide<S: Spectrum>(
    media: &Media,
    c: &Collision,
    p: WorldPoint,
    throughput: S,
    absorption: Absorption,
    ctx: &mut PathContext,
) -> (Event, S) {
    let medium = media.get(c.medium);
    ctx.work.grid_lookups += u64::from(!medium.albedo.is_constant());
    let null = S::splat(c.majorant) - S::from_rgb(medium.sigma_t) * c.density;
    let null = throughput * null.not_negative();
    let rate = throughput.element_sum() * c.majorant;
    let p_null = null.element_sum() / rate;
    let scattering = || throughput * S::from_rgb(media.sigma_s(c, p));
    if absorption == Absorption::Weighted {
        if ctx.rng.uniform() >= p_null {
            return (Event::Scattered, scattering() / (c.majorant * (1.0 - p_null)));
        }
    } else {
        let scattered = scattering();
        let p_scatter = scattered.element_sum() / rate;
        let u = ctx.rng.uniform();
        if u < p_scatter {
            return (Event::Scattered, scattered / (c.majorant * p_scatter));
        }
        if u >= p_scatter + p_null {
            return (Event::Absorbed, throughput);
        }
    }
    (Event::Null, null / (c.majorant * p_null))
}

/// Radiance that `media` emit along one step of a flight along `ray`, added to `radiance`, W/(m² sr):
/// emission that has no extinction of its own along the segment, other emission at the tentative
/// collision, divided by the majorant and times the `weight` of its place.
pub fn add_emission<S: Spectrum>(
    radiance: &mut S,
    media: &Media,
    ray: &Ray<World>,
    step: &FlightStep<S>,
    weight: impl Fn(&Collision, Rgb) -> f64,
    ctx: &mut PathContext,
) {
    for (index, medium) in media.iter().enumerate().filter(|(_, m)| m.emission.is_some()) {
        ctx.work.emission_lookups += 1;
        let emission = medium.emission_apart(ray, step.span);
        *radiance += step.throughput * S::of_group(emission, media.group(index));
    }
    if let Some(c) = &step.collision {
        let emission = media.get(c.medium).emission_of(c.density, ray.at(c.t));
        if emission != Rgb::ZERO {
            let group = media.group(c.medium);
            let emission = S::of_group(emission, group) * weight(c, emission);
            *radiance += step.throughput * emission / c.majorant;
        }
    }
}

/// The segment of a photon's flight with one power, as fluence grids take it: 36 bytes in colour, 28
/// without.
#[derive(Debug, Clone, Copy)]
pub struct FlightSegment<S: Spectrum = Rgb> {
    /// Metres from the maps' origin.
    from: [f32; 3],
    to: [f32; 3],
    power: S::Single,
}

impl<S: Spectrum> FlightSegment<S> {
    /// The segment from `from` to `to` flown with `power` (any unit), stored relative to `origin`.
    pub fn new(origin: WorldPoint, from: WorldPoint, to: WorldPoint, power: S) -> Self {
        let local = |p: WorldPoint| (p - origin).as_vec3().to_array();
        Self { from: local(from), to: local(to), power: S::pack_single(power.to_f32()) }
    }

    /// Its start, in metres from the maps' origin.
    pub fn start(&self) -> DVec3 {
        DVec3::from(self.from.map(f64::from))
    }

    /// Its end, in metres from the maps' origin.
    pub fn end(&self) -> DVec3 {
        DVec3::from(self.to.map(f64::from))
    }

    /// Its length, in metres.
    pub fn length(&self) -> f64 {
        (self.end() - self.start()).length()
    }

    /// The photon's power.
    pub fn power(&self) -> S::F32 {
        S::unpack_single(self.power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stage, Stream};
    use crate::scene::Scene;
    use crate::scene::plan::Needs;

    /// A slab, 2 m thick along z, whose optical thickness differs between channels.
    const SLAB: &str = r#"
        [camera]
        position = [0.0, 0.0, 5.0]
        target = [0.0, 0.0, 0.0]
        fov = 30.0
        [film]
        size = [16, 16]
        [[medium]]
        region = { box = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] } }
        sigma_t = [0.3, 0.6, 1.2]
        albedo = [0.9, 0.5, 0.2]
        phase = { type = "isotropic" }
    "#;

    /// The mean weight of paths that get through is exp(-tau), that of scattered ones is
    /// albedo (1 - exp(-tau)), a channel each. Bounds of 4.5 standard errors on 12 means make a false
    /// alarm of 8e-5 at this fixed seed.
    #[test]
    fn flights_through_a_slab_have_the_closed_form() {
        let scene = Scene::of_text(SLAB);
        let ray = Ray::new(WorldPoint::new(0.0, 0.0, 2.0), DVec3::NEG_Z);
        let through = Rgb::new(-0.6, -1.2, -2.4).exp();
        let scattered = Rgb::new(0.9, 0.5, 0.2) * (Rgb::ONE - through);
        for absorption in [Absorption::Sampled, Absorption::Weighted] {
            let rng = Stream::new(1, Stage::Test, 0, 0);
            let mut ctx = PathContext::new(rng, Needs::EVERYTHING);
            let (mut sums, mut squares) = ([Rgb::ZERO; 2], [Rgb::ZERO; 2]);
            let count = 100_000;
            for _ in 0..count {
                let mut weight = Rgb::ONE;
                let visit = |_: &FlightStep<Rgb>, _: &mut PathContext| ();
                let end = fly(&scene.media, &ray, 10.0, &mut weight, absorption, &mut ctx, visit);
                let kind = match end {
                    FlightEnd::Through => 0,
                    FlightEnd::Scattered { .. } => 1,
                    FlightEnd::Absorbed(_) => continue,
                };
                sums[kind] += weight;
                squares[kind] += weight * weight;
            }
            let n = f64::from(count);
            for (kind, expected) in [through, scattered].into_iter().enumerate() {
                let mean = sums[kind] / n;
                let error = ((squares[kind] / n - mean * mean) / n).map(f64::sqrt);
                let off = (mean - expected).abs() / error;
                assert!(off.max_element() < 4.5, "{absorption:?} {kind}: {mean} not {expected}");
            }
        }
    }
}
