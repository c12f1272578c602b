//! The pixels of a strategy pilot.

use crate::director::PixelBudget;
use crate::film::sample_pass;
use crate::math::{Rgb, Spectrum, Stage, Stream, luminance};
use crate::photon::PhotonDirection;
use crate::render::integrator::Integrator;
use crate::render::pass_settings::PassSettings;
use crate::render::pixel_sampling::{
    CameraRay, Numbering, Workspace, begin_sample, indirect_weight,
};
use crate::scene::Scene;
use crate::strategy::{self, BLOCK, PictureSize, RayLuminance};
use crate::transport::{PathContext, SobolPoint, camera_view};
use crate::work::Work;

/// Rays of a pixel of the pilot, each with the Sobol points of the picture's: a block of which stratification
/// is measured. Variances differ more from pixel to pixel than by the rays of one, so that more pixels tell more.
const RAYS: u32 = BLOCK as u32;

/// Pixels of the picture for each of the first round.
const PIXELS_PER_PIXEL: f64 = 64.0;

/// Fewest and most pixels of the first round: variances by 64 pixels of one picture tell apart what differs
/// much.
const FIRST_PIXELS: [usize; 2] = [4, 64];

/// Most pixels of the pilot: variances by so many are known to a few per cent.
const MAX_PIXELS: usize = 1024;

/// One in so many pixels of the first round is beside the media, where there are both: strategies differ there
/// only by what surfaces reflect.
const BESIDE_MEDIA: usize = 4;

/// Pixels that are spread over the film, each as it is in the picture but for the number of rays: a sample in two
/// strata, the pixels that media are seen in and those beside.
pub struct PilotPixels<'a> {
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a PassSettings,
    /// The picture.
    pub picture: PictureSize,
    /// Pixels along each side of the picture.
    size: [f64; 2],
    /// Places in a Sobol sequence over the film, in the order in which they are traced.
    order: Vec<StratumPixel>,
    /// Share of the picture that media are seen in.
    in_media: f64,
}

/// A pixel of one of the two strata.
#[derive(Debug, Clone, Copy)]
struct StratumPixel {
    /// Its place in the Sobol sequence.
    place: usize,
    /// Whether a medium is seen in it.
    in_media: bool,
}

impl<'a> PilotPixels<'a> {
    /// Pixels of the picture by `settings`.
    pub fn new(scene: &'a Scene, settings: &'a PassSettings) -> Self {
        let size = scene.film.size.map(|side| (f64::from(side) / settings.film_pixels).ceil());
        let rays = settings.rays.max(1);
        let pixels = size[0] * size[1];
        let picture = PictureSize { pixels, rays: rays.into(), gathers: gathers(rays) };
        let mut all = Self { scene, settings, picture, size, order: Vec::new(), in_media: 0.0 };
        let places = 0..MAX_PIXELS.min(pixels as usize);
        let count = places.len();
        let (media, beside): (Vec<_>, Vec<_>) = places.partition(|place| all.sees_medium(*place));
        all.in_media = media.len() as f64 / count.max(1) as f64;
        all.order = in_order(media, beside, all.first_count());
        all
    }

    /// Pixels of the first round.
    pub fn first_count(&self) -> usize {
        let [fewest, most] = FIRST_PIXELS;
        ((self.picture.pixels / PIXELS_PER_PIXEL) as usize).clamp(fewest, most)
    }

    /// Most pixels of all rounds.
    pub const fn max_count(&self) -> usize {
        self.order.len()
    }

    /// Weights of the first `count` pixels, of mean 1: each stratum counts by its share of the picture.
    pub fn shares(&self, count: usize) -> Vec<f64> {
        let pixels = &self.order[..count.min(self.order.len())];
        let inside = pixels.iter().filter(|pixel| pixel.in_media).count();
        let counts = [pixels.len() - inside, inside].map(|count| count as f64);
        let whole = pixels.len() as f64;
        // A stratum that has no pixel leaves the picture to the other.
        let of = [1.0 - self.in_media, self.in_media];
        let known: f64 = of.iter().zip(counts).filter(|(_, n)| *n > 0.0).map(|(of, _)| of).sum();
        let share = |pixel: &StratumPixel| {
            let stratum = usize::from(pixel.in_media);
            of[stratum] / known.max(f64::MIN_POSITIVE) * whole / counts[stratum]
        };
        pixels.iter().map(share).collect()
    }

    /// Corner of the pixel at this place of the Sobol sequence.
    fn corner(&self, place: usize) -> [f64; 2] {
        let scramble =
            Stream::new(self.settings.photons.seed, Stage::Strategy, u64::MAX, 0).scramble();
        let [u, v, ..] = SobolPoint { index: place as u32, scramble }.film_and_lens();
        [u * self.size[0], v * self.size[1]].map(f64::floor)
    }

    /// Whether the ray through the middle of a pixel meets a medium before a surface.
    fn sees_medium(&self, place: usize) -> bool {
        let scene = self.scene;
        let [x, y] = self.corner(place).map(|side| (side + 0.5) * self.settings.film_pixels);
        let ray = scene.camera.ray(x, y, [0.5; 2]);
        let seen = camera_view::clear_span(scene, &ray);
        scene.media.optical_thickness(&ray, seen) != Rgb::ZERO
    }

    /// Luminance along each ray of the pixel of this number, with one set of random numbers.
    pub fn luminances<S: Spectrum, H: PhotonDirection>(
        &self,
        integrator: &Integrator<'_, S, H>,
        [number, set]: [usize; 2],
        radius: f64,
    ) -> (Vec<RayLuminance>, Work) {
        let Self { scene, settings, .. } = self;
        let place = self.order[number].place;
        let corner = self.corner(place);
        let seed = settings.photons.seed;
        let stream = [seed, (2 * place + set) as u64];
        // Media are integrated exactly, so that what is chosen does not depend on the step.
        let budget = PixelBudget::fixed(RAYS, radius, 0.0).each_gathering();
        let start = Stream::new(seed, Stage::Strategy, 0, 0);
        let mut workspace = Workspace::new(PathContext::new(start, settings.photons.needs));
        let sample = |index: u32| {
            let sample = Numbering::Whole.number(index, &budget);
            let point = begin_sample(&mut workspace.ctx, stream, Stage::Strategy, &sample);
            let [x, y] = [0, 1].map(|axis| (corner[axis] + point[axis]) * settings.film_pixels);
            let weight = indirect_weight(&sample);
            let camera_ray = CameraRay {
                ray: scene.camera.ray(x, y, [point[2], point[3]]),
                budget: &budget,
                indirect_weight: weight,
                pass: sample_pass(index, settings.rays, 0),
                directed: None,
                half: None,
                time: 0,
            };
            let sample = integrator.radiance(&camera_ray, &mut workspace);
            let [whole, gathered] = [sample.radiance, sample.indirect].map(|radiance| {
                if radiance.is_finite() { luminance(Rgb::from(radiance)) } else { 0.0 }
            });
            let own = whole - gathered;
            RayLuminance { own, gathered: (weight > 0.0).then(|| gathered / weight) }
        };
        ((0..RAYS).map(sample).collect(), workspace.ctx.work)
    }

    /// Cost of a ray of the picture, by this work of whole pixels of the pilot. Density estimates count as
    /// often as the picture makes them, each of which meets so many photons for one of the pilot's.
    pub fn ray_cost(&self, work: &Work, photons: f64) -> f64 {
        let gathering = self.picture.gathers / self.picture.rays;
        let gathered = (work.gathered as f64 * photons) as u64;
        strategy::cost(&Work { gathered, ..*work }, gathering) / work.rays.max(1) as f64
    }
}

/// Rays that gather, of so many of a pixel.
fn gathers(rays: u32) -> f64 {
    PixelBudget::fixed(rays, 0.0, 0.0).gathers.min(rays).into()
}

/// Pixels of both strata in the order in which they are traced: those of the first round mixed, so that the first few are
/// of both, then those in media before the others.
fn in_order(media: Vec<usize>, beside: Vec<usize>, first: usize) -> Vec<StratumPixel> {
    let mut media = media.into_iter().map(|place| StratumPixel { place, in_media: true });
    let mut beside = beside.into_iter().map(|place| StratumPixel { place, in_media: false });
    let next = |number: usize| {
        if number < first && number.is_multiple_of(BESIDE_MEDIA) {
            beside.next().or_else(|| media.next())
        } else {
            media.next().or_else(|| beside.next())
        }
    };
    (0..).map_while(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::stage_settings::pass_settings;
    use crate::scene::RenderSettings;

    /// Cells are gathered for as often as rays read them.
    #[test]
    fn rays_read_caches_at_as_many_places_as_gathers_are_made_for() {
        assert_eq!(f64::from(strategy::places_at(0)), crate::cache::PLACES_PER_RAY);
    }

    /// The first few pixels are of both strata, the later ones of media while there are any.
    #[test]
    fn strata_take_turns() {
        let places = |media: Vec<usize>, beside: Vec<usize>| -> Vec<usize> {
            in_order(media, beside, 6).iter().map(|pixel| pixel.place).collect()
        };
        assert_eq!(
            places((0..8).collect(), vec![20, 21, 22]),
            [20, 0, 1, 2, 21, 3, 4, 5, 6, 7, 22]
        );
        assert_eq!(places(vec![], vec![5, 6]), [5, 6]);
        assert_eq!(places(vec![5, 6], vec![]), [5, 6]);
    }

    /// A cube of haze that a wall hides half of, seen from so far that all rays are parallel.
    const CUBE: &str = "
        [camera]
        position = [0.0, 0.0, 1000.0]
        target = [0.0, 0.0, 0.0]
        fov = 0.2291838
        [film]
        size = [64, 64]
        [[surface]]
        shape = 'quad'
        center = [-1.0, 0.0, 2.0]
        u = [1.0, 0.0, 0.0]
        v = [0.0, 2.0, 0.0]
        [[medium]]
        region = { box = { min = [-1.0, -1.0, -1.0], max = [1.0, 1.0, 1.0] } }
        sigma_t = 0.1
        ";

    /// A stratum counts by its share of the picture, however many of its pixels were traced. The share is within five
    /// standard errors of 1024 independent pixels, of which those of a Sobol sequence stay far below.
    #[test]
    fn strata_count_by_their_share_of_the_picture() {
        let scene = Scene::of_text(CUBE);
        let settings = pass_settings(&scene, &RenderSettings::default());
        let mut pixels = PilotPixels::new(&scene, &settings);
        // Half of a cube of 2 m in a picture of 4 m.
        assert!((pixels.in_media - 0.125).abs() < 0.05, "{}", pixels.in_media);
        assert_eq!(pixels.max_count(), MAX_PIXELS);
        let count = pixels.first_count();
        let shares = pixels.shares(count);
        let beside = count / BESIDE_MEDIA;
        for (pixel, share) in pixels.order.iter().zip(&shares) {
            let (of, traced) = if pixel.in_media {
                (pixels.in_media, count - beside)
            } else {
                (1.0 - pixels.in_media, beside)
            };
            assert!((share - of * count as f64 / traced as f64).abs() < 1e-12, "{share}");
        }
        // Where there are none beside, those in media stand for all.
        pixels.order = in_order((0..4).collect(), Vec::new(), 8);
        assert_eq!(pixels.shares(4), [1.0; 4]);
    }
}
