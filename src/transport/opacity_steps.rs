//! Where along a ray media scatter light toward its start, in steps.

use smallvec::SmallVec;

use crate::math::{Span, Spectrum};
use crate::medium::Profile;

/// Steps of a ray, each with the same part of its opacity in one channel.
///
/// Unit: count. Derivation: over one of them transmittance changes by an eighth at most, but over the last.
const STEPS: usize = 8;

/// Transmittance times extinction along a ray, as its means over consecutive steps.
#[derive(Debug, Default)]
pub struct OpacitySteps {
    /// Front to back, with the mean over channels, 1/m; none where opacity is too small to tell.
    steps: SmallVec<[(Span, f64); STEPS]>,
}

impl OpacitySteps {
    /// Along the ray that `profile` was traced for, over its extent.
    pub fn along<S: Spectrum>(profile: &Profile<S>) -> Self {
        let extent = profile.extent();
        let part = |parts: f64| parts / STEPS as f64 * profile.middle_opacity();
        let mut steps = SmallVec::new();
        let (mut start, mut seen) = (extent.start, S::ONE);
        for step in 1..=STEPS {
            let end = if step < STEPS { profile.distance_at(part(step as f64)) } else { None };
            let end = end.map_or(extent.end, |end| end.clamp(start, extent.end));
            let after = profile.at(end).map_or(profile.transmittance(), |(after, _)| after);
            let length = if end.is_infinite() {
                // The mean is that over twice the way to half of the step's opacity.
                let half = profile.distance_at(part(step as f64 - 0.5));
                half.map_or(f64::INFINITY, |half| 2.0 * (half - start))
            } else {
                end - start
            };
            // At least that of the middle channel, as differences of transmittances lose it where they are small.
            let opacity = (seen - after).element_sum().max(part(1.0)) / S::CHANNELS as f64;
            if length > 0.0 {
                steps.push((Span::new(start, end), opacity / length));
            }
            (start, seen) = (end, after);
        }
        let is_told = steps.iter().all(|(_, mean): &(Span, f64)| mean.is_normal());
        if is_told { Self { steps } } else { Self::default() }
    }

    /// The steps, front to back, with the mean over each, 1/m.
    pub(super) fn iter(&self) -> impl Iterator<Item = (Span, f64)> {
        self.steps.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Ray, Rgb, WorldPoint};
    use crate::scene::Scene;
    use glam::DVec3;

    /// The steps of a ray through the middle of a ball of this extinction round the origin, of radius 1.
    fn through_ball<S: Spectrum>(sigma_t: &str) -> (OpacitySteps, Profile<S>) {
        let scene = Scene::of_text(&format!(
            "
            [camera]
            position = [0.0, 0.0, 9.0]
            target = [0.0, 0.0, 0.0]
            [[medium]]
            region = {{ sphere = {{ center = [0.0, 0.0, 0.0], radius = 1.0 }} }}
            sigma_t = {sigma_t}
            "
        ));
        let ray = Ray::new(WorldPoint::new(0.0, 0.0, 3.0), -DVec3::Z);
        let mut profile = Profile::<S>::default();
        profile.trace(&scene.media, &ray, Span::AHEAD, 0.0, 0.5);
        (OpacitySteps::along(&profile), profile)
    }

    /// Steps follow each other from the front of a medium to its back, and their means make its opacity.
    #[test]
    fn steps_hold_all_of_the_opacity() {
        fn check<S: Spectrum>(sigma_t: &str) {
            let (steps, profile) = through_ball::<S>(sigma_t);
            let (mut end, mut opacity) = (2.0, 0.0);
            for (step, mean) in steps.iter() {
                assert!((step.start - end).abs() < 1e-9 && mean > 0.0, "{sigma_t}: {step:?}");
                end = step.end;
                opacity += mean * step.length();
            }
            let expected = (S::ONE - profile.transmittance()).element_sum() / S::CHANNELS as f64;
            assert!((end - 4.0).abs() < 1e-9, "{sigma_t}: {end}");
            assert!((opacity / expected - 1.0).abs() < 1e-6, "{sigma_t}: {opacity} not {expected}");
        }
        for sigma_t in ["1e-6", "0.3", "40.0"] {
            check::<f64>(sigma_t);
            check::<Rgb>(sigma_t);
        }
        check::<Rgb>("[0.1, 2.0, 30.0]");
        check::<Rgb>("[2.0, 0.0, 0.5]");
    }

    /// Where opacity is hardly more than nothing, there are no steps, or such with a sound mean.
    #[test]
    fn hardly_any_opacity_has_no_steps_or_sound_ones() {
        for sigma_t in ["1e-18", "1e-300", "[1e-18, 0.0, 1e-18]", "1e18"] {
            let (steps, _) = through_ball::<Rgb>(sigma_t);
            assert!(steps.iter().all(|(_, mean)| mean.is_normal()), "{sigma_t}: {steps:?}");
        }
    }
}
