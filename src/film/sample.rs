//! What one camera ray brings: its light, in all and by component, and what it sees.

use glam::DVec3;

use crate::image::Features;
use crate::math::Rgb;

/// The result of one camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Radiance, W/(m² sr).
    pub radiance: Rgb,
    /// The part of the radiance that is indirect light estimated for other rays of the pixel too, which
    /// leave it out.
    pub indirect: Rgb,
    /// The part of the radiance that surfaces and the environment emit, seen without a mirror between: it
    /// hardly differs from ray to ray.
    pub visible_emission: Rgb,
    /// The radiance by component; what is in none of them is emission, and what mirrors and glass show.
    pub components: Components,
    /// What the ray sees.
    pub seen: Seen,
    /// Coverage, 0 to 1, without what shadows on a shadow catcher cover.
    pub alpha: f64,
    /// What the ray sees of a shadow catcher.
    pub caught: CaughtShadow,
    /// Transmittance to the first surface, or to infinity where there is none.
    pub transmittance: f64,
    /// Distance in metres to the first surface, or to where media before it have passed an opacity of one half; positive
    /// infinity where neither is.
    pub depth: f64,
    /// Features of the ray, where they are gathered.
    pub features: Option<Features>,
    /// Where its opacity lies, where that is gathered and there is any.
    pub depths: Option<OpacityDepths>,
}

impl Default for Sample {
    /// No light, where nothing is.
    fn default() -> Self {
        Self {
            radiance: Rgb::ZERO,
            indirect: Rgb::ZERO,
            visible_emission: Rgb::ZERO,
            components: Components::default(),
            seen: Seen::default(),
            alpha: 0.0,
            caught: CaughtShadow::default(),
            transmittance: 1.0,
            depth: f64::INFINITY,
            features: None,
            depths: None,
        }
    }
}

impl Sample {
    /// Whether f32 can hold it: no NaN, and nothing that an f32 cannot hold but an infinite depth.
    pub fn is_sound(&self) -> bool {
        let sound = |v: f64| v.abs() <= f64::from(f32::MAX); // false for NaN
        self.radiance.to_array().into_iter().all(sound)
            && sound(self.alpha)
            && self.caught.to_array().into_iter().all(sound)
            && sound(self.transmittance)
            && !self.depth.is_nan()
    }
}

/// What one camera ray sees of a shadow catcher: 0 where it meets none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CaughtShadow {
    /// Transmittance before the catcher.
    pub seen: f64,
    /// Luminance of its direct light, behind surfaces and media, times that transmittance, W/(m² sr).
    pub shadowed: f64,
    /// The same, were nothing between it and the lights.
    pub unshadowed: f64,
}

impl CaughtShadow {
    /// Its numbers, in their order.
    pub const fn to_array(self) -> [f64; 3] {
        [self.seen, self.shadowed, self.unshadowed]
    }
}

/// Light of one camera ray by component, W/(m² sr). What is in none of them is emission, and what mirrors
/// and glass show.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Components {
    /// Scattered or emitted by media in front of the first surface.
    pub media: Rgb,
    /// Reflected by the first surface, straight from lights.
    pub direct: Rgb,
    /// Reflected by the first surface, of photons.
    pub indirect: Rgb,
}

/// Where along a camera ray its opacity lies, that of media and of the first surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpacityDepths {
    /// Opacity in all, in (0, 1].
    pub opacity: f64,
    /// Distance at which it has reached a hundredth of that, in metres.
    pub first: f64,
    /// Its mean distance, in metres.
    pub mean: f64,
    /// Distance at which it has reached all but a hundredth, in metres.
    pub last: f64,
    /// Where the mean distance is, in metres, in the world.
    pub position: DVec3,
    /// How far what is seen moves in the picture in a frame: in pixels rightward and upward, and away from the camera in
    /// metres.
    pub motion: DVec3,
}

impl OpacityDepths {
    /// The same of a ray that begins so many metres in front.
    #[must_use]
    pub fn behind(self, near: f64) -> Self {
        let [first, mean, last] = [self.first, self.mean, self.last].map(|depth| near + depth);
        Self { first, mean, last, ..self }
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        let Self { opacity, first, mean, last, position, motion } = self;
        [opacity, first, mean, last].into_iter().all(|number| number.is_finite())
            && position.is_finite()
            && motion.is_finite()
    }
}

/// What one camera ray sees, before any mirror or glass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// The first surface, where it is diffuse.
    pub surface: Option<VisibleSurface>,
    /// Whether the first surface is a mirror or glass.
    pub specular: bool,
    /// Distance in metres at which media have half of their opacity; `None` without media.
    pub media_distance: Option<f64>,
}

/// A diffuse surface that a camera ray sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleSurface {
    /// Where it is, in metres from the camera along the axes of the world.
    pub offset: DVec3,
    /// Its unit shading normal, on the camera's side.
    pub normal: DVec3,
    /// Its albedo times the transmittance of media before it.
    pub reflectance: Rgb,
}
