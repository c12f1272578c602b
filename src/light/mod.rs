//! Lights: point, spot, sun, quad, mesh and environment.
//!
//! A light is asked three ways: [`Light::sample`] gives light that arrives at a place,
//! [`Light::emit`] starts a photon, [`Light::radiance_from`] tells what a ray that found the light
//! sees. All radiometry is in W, m and sr, per linear Rec.709 channel; visibility and media are
//! the caller's.

mod aim;
mod bounds;
mod emission_target;
mod environment;
mod ground;
mod lights;
mod mesh;
mod mixture;
mod origin;
mod point;
mod quad;
mod spherical_rectangle;
mod spot;
mod sun;
mod surface;

use glam::DVec3;
use smallvec::SmallVec;

use crate::math::{Ray, Rgb, Span, World, WorldPoint, is_grey};
pub use bounds::{LightBounds, LightRegion};
pub use emission_target::{EmissionTarget, TargetSphere};
pub use environment::Environment;
pub use lights::Lights;
pub use mesh::MeshLight;
pub use origin::{LightOrigin, LightPart};
pub use point::PointLight;
pub use quad::QuadLight;
pub use spot::{BeamPicture, Falloff, SpotLight};
pub use sun::Sun;
pub use surface::aim_from;

/// Light that arrives at a place from one sampled direction, were nothing in between.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Unit vector from the lit place toward the light.
    pub direction: DVec3,
    /// Metres to the light; infinite for sun and environment.
    pub distance: f64,
    /// Incident radiance in W/(m² sr); for a delta light the irradiance in W/m² on a surface
    /// perpendicular to the direction. Divided by `pdf` it estimates incident light either way.
    pub radiance: Rgb,
    /// Density of the direction per solid angle, 1/sr; 1 for a delta light.
    pub pdf: f64,
    /// Whether the light has no extent, so that no ray can find it by chance.
    pub delta: bool,
    /// Unit normal of the light's surface where the light comes from; none where it has no surface.
    pub normal: Option<DVec3>,
}

impl LightSample {
    /// Whether any light comes.
    pub fn shines(&self) -> bool {
        self.pdf > 0.0 && self.radiance != Rgb::ZERO
    }

    /// Where the light that arrives at `at` comes from, if the light is not infinitely far.
    pub fn origin(&self, at: WorldPoint) -> LightOrigin {
        LightOrigin { position: at + self.direction * self.distance, normal: self.normal }
    }
}

/// The start of a photon's path.
#[derive(Debug, Clone, Copy)]
pub struct PhotonStart {
    /// From the light, or from outside [`EmissionTarget`] for sun and environment; unit direction.
    pub ray: Ray<World>,
    /// Power in W that the photon carries when it is the only one emitted: divide by the number
    /// of paths started, those that gave none included.
    pub power: Rgb,
}

/// Where a ray met a surface that shines.
#[derive(Debug, Clone, Copy)]
pub struct EmitterHit {
    /// Metres from the lit place.
    pub distance: f64,
    /// Unit geometric normal on the side that shines.
    pub normal: DVec3,
}

/// A light.
#[derive(Debug, Clone)]
pub enum Light {
    /// Shines from one place in all directions.
    Point(PointLight),
    /// Shines from one place into a cone: a headlamp.
    Spot(SpotLight),
    /// Shines from very far in one direction.
    Sun(Sun),
    /// A parallelogram that shines on one side.
    Quad(QuadLight),
    /// Triangles that shine on one side.
    Mesh(MeshLight),
    /// Shines from very far all round.
    Environment(Environment),
}

impl Light {
    /// Light arriving at `at` from a sampled direction, or nothing where none can.
    pub fn sample(&self, at: WorldPoint, u: [f64; 2]) -> Option<LightSample> {
        match self {
            Self::Point(l) => l.sample(at),
            Self::Spot(l) => l.sample(at),
            Self::Sun(l) => l.sample(u),
            Self::Quad(l) => l.sample(at, u),
            Self::Mesh(l) => l.sample(at, u),
            Self::Environment(l) => l.sample(u),
        }
    }

    /// Density, 1/sr, with which [`Self::sample`] gives the unit `direction` from the place `at`,
    /// from which a ray that way meets this light's surface at `hit` or escapes. 0 for delta
    /// lights, for surfaces that escape is asked of and the other way round.
    pub fn pdf(&self, at: WorldPoint, direction: DVec3, hit: Option<EmitterHit>) -> f64 {
        match (self, hit) {
            (Self::Sun(l), None) => l.pdf(direction),
            (Self::Environment(l), None) => l.pdf(direction),
            (Self::Quad(l), Some(hit)) => l.pdf(at, direction, hit),
            (Self::Mesh(l), Some(hit)) => l.pdf(direction, hit),
            _ => 0.0,
        }
    }

    /// Radiance, W/(m² sr), that a ray along the unit `direction` sees of this light where it
    /// meets the light's surface at `hit` or escapes. 0 for delta lights and dark sides.
    pub fn radiance_from(&self, direction: DVec3, hit: Option<EmitterHit>) -> Rgb {
        match (self, hit) {
            (Self::Sun(l), None) => l.radiance(direction),
            (Self::Environment(l), None) => l.radiance(direction),
            (Self::Quad(l), Some(hit)) if direction.dot(hit.normal) < 0.0 => l.radiance(),
            (Self::Mesh(l), Some(hit)) if direction.dot(hit.normal) < 0.0 => l.radiance(),
            _ => Rgb::ZERO,
        }
    }

    /// Starts a photon toward `reach`, or nothing where this choice of numbers carries no power:
    /// that counts as a path that was emitted. What arrives inside `reach` is unbiased.
    pub fn emit(&self, reach: &EmissionTarget, u: [f64; 4]) -> Option<PhotonStart> {
        let start = match self {
            Self::Point(l) => l.emit(reach, u),
            Self::Spot(l) => l.emit(reach, u),
            Self::Sun(l) => l.emit(reach, u),
            Self::Quad(l) => l.emit(reach, u),
            Self::Mesh(l) => l.emit(reach, u),
            Self::Environment(l) => l.emit(reach, u),
        }?;
        (start.power.max_element() > 0.0 && start.power.is_finite()).then_some(start)
    }

    /// About the power in W that [`Self::emit`] covers, for choosing between lights; 0 only where
    /// nothing is emitted.
    pub fn power(&self, reach: &EmissionTarget) -> Rgb {
        match self {
            Self::Point(l) => l.power_toward(reach),
            Self::Spot(l) => l.power_toward(reach),
            Self::Sun(l) => l.power(reach),
            Self::Quad(l) => l.power_toward(reach),
            Self::Mesh(l) => l.power_toward(reach),
            Self::Environment(l) => l.power(reach),
        }
    }

    /// About the luminance of the light that arrives at `at` from all directions, were nothing in
    /// between, in W/m². Above 0 wherever [`Self::sample`] can give light.
    pub fn incident_estimate(&self, at: WorldPoint) -> f64 {
        match self {
            Self::Point(l) => l.incident_estimate(at),
            Self::Spot(l) => l.incident_estimate(at),
            Self::Sun(l) => l.incident_estimate(),
            Self::Quad(l) => l.incident_estimate(at),
            Self::Mesh(l) => l.incident_estimate(at),
            Self::Environment(l) => l.incident_estimate(),
        }
    }

    /// Where all of the light shines from; nothing where it has an extent or is infinitely far.
    pub const fn position(&self) -> Option<WorldPoint> {
        match self {
            Self::Point(l) => Some(l.position()),
            Self::Spot(l) => Some(l.position()),
            Self::Sun(_) | Self::Quad(_) | Self::Mesh(_) | Self::Environment(_) => None,
        }
    }

    /// The place that [`sample`](Self::sample) gives light from with the same numbers; nothing where that depends on the
    /// lit place, as it does on a quad, or the light is infinitely far.
    pub fn origin(&self, u: [f64; 2]) -> Option<LightOrigin> {
        match self {
            Self::Mesh(l) => Some(l.point(u).origin()),
            _ => self.position().map(LightOrigin::punctual),
        }
    }

    /// Parts of equal area, each about as long as wide: those of a quad, and a punctual light as one. None of a mesh, whose
    /// shape may be any, and of a light infinitely far.
    pub fn parts(&self) -> SmallVec<[LightPart; 1]> {
        match self {
            Self::Quad(l) => l.parts(),
            _ => self.position().map(LightPart::punctual).into_iter().collect(),
        }
    }

    /// A sphere round all that shines; nothing where the light is infinitely far.
    pub fn bounds(&self) -> Option<LightBounds> {
        match self {
            Self::Point(l) => Some(LightBounds { center: l.position(), radius: 0.0 }),
            Self::Spot(l) => Some(LightBounds { center: l.position(), radius: 0.0 }),
            Self::Quad(l) => Some(l.bounds()),
            Self::Mesh(l) => Some(l.bounds()),
            Self::Sun(_) | Self::Environment(_) => None,
        }
    }

    /// The part of a span of `ray` that light from `origin`, a place on this light, may reach, were nothing in
    /// between: the cone of a spot, the space in front of a surface.
    pub fn reach(&self, origin: &LightOrigin, ray: &Ray<World>, span: Span) -> Span {
        match self {
            Self::Spot(l) => l.reach(ray).intersect(span),
            _ => origin.in_front(ray, span),
        }
    }

    /// Whether it is light from all around.
    pub const fn is_environment(&self) -> bool {
        matches!(self, Self::Environment(_))
    }

    /// Whether it is light from all around, of which no part is brighter than others.
    pub const fn is_even(&self) -> bool {
        matches!(self, Self::Environment(l) if l.is_even())
    }

    /// Whether the light is farther than every place of the scene.
    pub const fn is_infinite(&self) -> bool {
        matches!(self, Self::Sun(_) | Self::Environment(_))
    }

    /// Whether it shines alike in all channels.
    pub fn is_grey(&self) -> bool {
        match self {
            Self::Point(l) => is_grey(l.intensity()),
            Self::Spot(l) => l.is_grey(),
            Self::Sun(l) => is_grey(l.irradiance()),
            Self::Quad(l) => is_grey(l.radiance()),
            Self::Mesh(l) => is_grey(l.radiance()),
            Self::Environment(l) => l.is_grey(),
        }
    }

    /// Whether the light has no extent, so that no ray can find it by chance.
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Point(_) | Self::Spot(_) => true,
            Self::Sun(l) => l.is_delta(),
            Self::Quad(_) | Self::Mesh(_) | Self::Environment(_) => false,
        }
    }
}

/// `color` where it is finite and nowhere negative.
fn checked_color(what: &str, color: Rgb) -> Result<Rgb, String> {
    if color.is_finite() && color.min_element() >= 0.0 {
        Ok(color)
    } else {
        Err(format!("{what} is {color}: must be finite and not negative"))
    }
}

/// `v` at unit length where it has a direction.
fn checked_direction(what: &str, v: DVec3) -> Result<DVec3, String> {
    let scale = v.abs().max_element();
    let unit = if scale > 0.0 && v.is_finite() { (v / scale).try_normalize() } else { None };
    unit.ok_or_else(|| format!("{what} is {v}: must be finite and not zero"))
}

/// `p` where it is finite.
fn checked_place(what: &str, p: WorldPoint) -> Result<WorldPoint, String> {
    if p.xyz.is_finite() { Ok(p) } else { Err(format!("{what} is {}: must be finite", p.xyz)) }
}

/// 1 - cos of an angle in radians, to full precision for small angles too.
fn one_minus_cos(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// 1 - cos of the angle below a right one that has this sine, to full precision for small angles too.
fn one_minus_cos_by_sine(sine: f64) -> f64 {
    let squared = sine * sine;
    squared / (1.0 + (1.0 - squared).sqrt())
}

/// 1 - cos of the angle between unit vectors, precise for small angles.
fn one_minus_cos_between(a: DVec3, b: DVec3) -> f64 {
    0.5 * (a - b).length_squared()
}
