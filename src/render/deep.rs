//! The deep picture beside a flat one: rays of each pixel tell at which distances its light comes from.

use std::time::Instant;

use rayon::prelude::*;

use super::pixel_sampling::Workspace;
use super::rendered::Rendered;
use super::stage_settings::finest_step;
use crate::film::{DeepPixel, FlatPixel};
use crate::image::{DeepImage, DeepSample, FAR, Film, NOISY_LAYERS, Window};
use crate::math::{Ray, Rgb, Spectrum, Stage, Stream, World, luminance};
use crate::medium::Profile;
use crate::scene::plan::Needs;
use crate::scene::{Aov, Scene};
use crate::transport::{PathContext, SobolPoint, camera_view};

/// Rays of a pixel.
///
/// Unit: count. Limit: on the noise of distances, of which a Sobol sequence of so many covers a pixel's edges to a
/// sixteenth.
const RAYS: u32 = 16;

/// Stretches of a ray through media, which are seen alike.
///
/// Unit: count. Limit: on the error of distances; as many as the deep pixel has samples.
const STRETCHES: u32 = 16;

/// Share of the opacity of media at which their last stretch ends: what is behind is hardly seen, and may be far.
///
/// Unit: none. Limit: on the opacity that lies deeper than told.
const END: f64 = 1.0 - 1e-3;

/// Opacity of media below which they count as none.
///
/// Unit: none. Limit: on the opacity that is left out.
const MIN_OPACITY: f64 = 1e-6;

impl Rendered {
    /// The deep picture that flattens to this one of `scene`, made as one more stage.
    pub fn deep(&mut self, scene: &Scene) -> DeepImage {
        let start = Instant::now();
        let needs = Needs::new(scene, &scene.render);
        let image = if needs.colors {
            deep_image::<Rgb>(scene, needs, &self.film)
        } else {
            deep_image::<f64>(scene, needs, &self.film)
        };
        self.timings.push(("deep", start.elapsed()));
        image
    }
}

fn deep_image<S: Spectrum>(scene: &Scene, needs: Needs, film: &Film) -> DeepImage {
    let (window, full) = (film.window(), film.full_size());
    let tracer = DeepTracer { scene, step: finest_step(scene, &scene.render), full };
    let flat = FlatPicture::new(film);
    let empty = || {
        let rng = Stream::new(scene.render.seed, Stage::Deep, 0, 0);
        (DeepPixel::default(), Workspace::<S>::new(PathContext::new(rng, needs)))
    };
    let pixels = (0..window.pixels() as usize).into_par_iter();
    let pixels = pixels.map_init(empty, |(pixel, workspace), index| -> Vec<DeepSample> {
        let Window { left, top, width, .. } = window;
        let place = [left + index as u32 % width, top + index as u32 / width];
        pixel.clear();
        tracer.trace(place, pixel, workspace);
        pixel.samples(&flat.pixel(index))
    });
    DeepImage { window, full, pixels: pixels.collect() }
}

/// Traces rays of pixels to find what is at which distance.
struct DeepTracer<'a> {
    scene: &'a Scene,
    /// March step in metres.
    step: f64,
    /// Width and height of the whole film.
    full: [u32; 2],
}

impl DeepTracer<'_> {
    /// Adds what the rays of the pixel (x, y) meet.
    fn trace<S: Spectrum>(
        &self,
        [x, y]: [u32; 2],
        pixel: &mut DeepPixel,
        workspace: &mut Workspace<S>,
    ) {
        let number = u64::from(y) * u64::from(self.full[0]) + u64::from(x);
        let scramble = Stream::new(self.scene.render.seed, Stage::Deep, number, 0).scramble();
        for index in 0..RAYS {
            let [u, v, a, b] = SobolPoint { index, scramble }.film_and_lens();
            let ray = self.scene.camera.ray(f64::from(x) + u, f64::from(y) + v, [a, b]);
            self.add_ray(&ray, pixel, workspace);
        }
    }

    fn add_ray<S: Spectrum>(
        &self,
        ray: &Ray<World>,
        pixel: &mut DeepPixel,
        workspace: &mut Workspace<S>,
    ) {
        let Workspace { ctx, profiles, .. } = workspace;
        let of_pixel = 1.0 / f64::from(RAYS);
        let near = self.scene.camera.near(ray);
        let hit = camera_view::first_surface(self.scene, ray, ctx);
        let mut transmittance = 1.0;
        if ctx.needs.media {
            let profile = &mut profiles.path;
            let span = camera_view::span_before(self.scene, ray, hit.as_ref());
            profile.trace(&self.scene.media, ray, span, self.step, 0.5);
            transmittance = luminance(profile.transmittance().rgb());
            add_stretches(profile, [near, of_pixel * (1.0 - transmittance)], pixel);
        }
        let seen = of_pixel * transmittance;
        match &hit {
            Some(hit) if camera_view::is_holdout(self.scene, hit) => {}
            Some(hit) => pixel.add_surface(near + hit.t, seen),
            None if camera_view::emission::<Rgb>(self.scene, ray, None, ctx) != Rgb::ZERO => {
                // It covers nothing.
                pixel.add_surface(FAR, 0.0);
            }
            None => {}
        }
    }
}

/// Adds the media of `profile`, which begins at the distance `near` in metres, in stretches that are seen alike; so much of
/// them is `seen` in all.
fn add_stretches<S: Spectrum>(profile: &Profile<S>, [near, seen]: [f64; 2], pixel: &mut DeepPixel) {
    let extent = profile.extent();
    if extent.is_empty() {
        return;
    }
    if seen < MIN_OPACITY {
        if profile.emitted() != S::ZERO {
            pixel.add_media([extent.start, extent.end].map(|t| near + t), 0.0);
        }
        return;
    }
    let (opacity, mut begin) = (profile.middle_opacity(), extent.start);
    for stretch in 1..=STRETCHES {
        let share = (f64::from(stretch) / f64::from(STRETCHES)).min(END);
        let end = profile.distance_at(share * opacity).unwrap_or(begin);
        pixel.add_media([begin, end].map(|t| near + t), seen / f64::from(STRETCHES));
        begin = end;
    }
}

/// The pixels that deep ones flatten to.
struct FlatPicture<'a> {
    radiance: [&'a [f32]; 3],
    alpha: &'a [f32],
    /// The picture before noise was taken off it, and the part of it that is light of media.
    raw: [&'a [f32]; 3],
    media: [&'a [f32]; 3],
}

impl<'a> FlatPicture<'a> {
    fn new(film: &'a Film) -> Self {
        let layer = |name: &str| film.layer(name).unwrap_or_default();
        let radiance = ["R", "G", "B"].map(layer);
        let noisy = NOISY_LAYERS.map(layer);
        let raw = if noisy[0].is_empty() { radiance } else { noisy };
        let media = Aov::Media.layers("").map(|name| layer(&name));
        Self { radiance, alpha: layer("A"), raw, media }
    }

    fn pixel(&self, index: usize) -> FlatPixel {
        let light = self.radiance.map(|values| f64::from(values[index]));
        let media: [f64; 3] = std::array::from_fn(|channel| {
            let [media, raw] = [self.media[channel], self.raw[channel]].map(|values| values[index]);
            let share = if raw > 0.0 { f64::from(media / raw).clamp(0.0, 1.0) } else { 0.0 };
            share * light[channel]
        });
        let other = std::array::from_fn(|channel| light[channel] - media[channel]);
        FlatPixel { alpha: self.alpha[index].into(), media, other }
    }
}
