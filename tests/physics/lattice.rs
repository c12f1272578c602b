//! Light kept on lattices: against closed forms and direct evaluation, the same on any number of
//! threads.

use fogbow::light::LightRegion;
use fogbow::math::{Ray, Rgb, Span, Stage, Stream, WorldPoint, warp};
use fogbow::photon::PhotonSettings;
use fogbow::render::{PassSettings, PhotonPass};
use fogbow::scene::plan::Needs;
use fogbow::scene::{FinalGather, LoadOptions, Scene, Strategy, StrategyRequest};
use fogbow::strategy::Assignment;
use fogbow::transport::{PathContext, direct_light};
use glam::DVec3;

/// A box of thin haze before the camera, lit from the side and from all around.
fn haze(lights: &str, phase: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = format!(
        "{lights}
        [camera]
        position = [0, 0, 6]
        target = [0, 0, 0]
        fov = 30
        [film]
        size = [64, 64]
        [[medium]]
        region = {{ box = {{ min = [-1, -1.2, -1], max = [1, 1.1, 0.9] }} }}
        sigma_t = 0.8
        albedo = 0.9
        phase = {phase}
        "
    );
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

const SUN: &str = "[[light]]
type = 'sun'
direction = [1, -0.3, -0.2]
irradiance = [2, 1.5, 1]";

const SKY: &str = "[[light]]
type = 'environment'
radiance = [0.5, 0.6, 0.7]";

const FORWARD: &str = "{ type = 'henyey-greenstein', g = 0.5 }";

fn kept(scene: &Scene, photons: u64, max_scatter: Option<u32>, levels: u32) -> PhotonPass {
    let needs = Needs::EVERYTHING;
    let photons = PhotonSettings {
        photons,
        seed: 3,
        max_scatter,
        radius: None,
        levels,
        needs,
        traced: None,
        any_camera: false,
    };
    let settings = PassSettings {
        photons,
        pass: None,
        strategy: StrategyRequest::Asked(Strategy::FluenceTowardEye),
        measures_one: false,
        final_gather: FinalGather::Auto,
        rays: 64,
        film_pixels: 1.0,
        gather_share: 1.0,
    };
    let media = scene.media.iter().len();
    let assignment = Assignment::uniform(Strategy::FluenceTowardEye, media, "it is asked for");
    PhotonPass::new(scene, &settings, &assignment, &|_| {}).unwrap().0
}

/// Places inside the haze.
fn places(count: usize) -> Vec<WorldPoint> {
    let mut rng = Stream::new(5, Stage::Test, 0, 0);
    let mut place = || std::array::from_fn(|_| 1.6 * rng.uniform() - 0.8);
    (0..count).map(|_| WorldPoint::from_xyz(DVec3::from(place()))).collect()
}

#[test]
fn light_of_the_sky_is_its_radiance_as_far_as_it_arrives() {
    // Straight from the sky alone, isotropically scattered.
    let scene = haze(SKY, "\"isotropic\"");
    let maps = kept(&scene, 200_000, Some(1), 2);
    for level in 0..3 {
        let mean =
            |f: &dyn Fn(WorldPoint) -> Rgb| places(500).into_iter().map(f).sum::<Rgb>() / 500.0;
        let grid = maps.caches.fluence[0].as_ref().unwrap();
        let light = mean(&|p| grid.toward_camera(p, level));
        // What is left of the sky on the way to a place.
        let mut rng = Stream::new(9, Stage::Test, 0, 0);
        let mut right = Rgb::ZERO;
        for p in places(500) {
            for _ in 0..64 {
                let direction = warp::uniform_sphere(rng.uniform2());
                let ray = Ray::new(p, direction);
                right += scene.media.transmittance(&ray, Span::AHEAD) / 64.0;
            }
        }
        let right = Rgb::new(0.5, 0.6, 0.7) * right / 500.0;
        // Photons and the sum over directions scatter by less than 0.3 %; wide cells blur.
        let allowed = [0.01, 0.015, 0.04][level];
        let off = ((light - right) / right).abs().max_element();
        assert!(off < allowed, "level {level}: {light} not {right}");
    }
}

#[test]
fn direct_light_is_that_found_at_the_place() {
    let scene = haze(SUN, FORWARD);
    let maps = kept(&scene, 1000, None, 0);
    let [Some(direct)] = &maps.caches.direct[..] else { panic!("the sun's light is kept") };
    assert!(direct.uncached(0) == LightRegion::Nowhere && direct.cells().is_some());
    let mut ctx = PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
    let mut mean = Rgb::ZERO;
    for p in places(200) {
        let light = direct.at(&scene, p, &mut ctx);
        let phase = &scene.media.get(0).phase;
        let toward = scene.camera.toward(p);
        let scatterers = [(phase, Rgb::ONE)];
        let sun = scene.lights.lights[0].sample(p, [0.5, 0.5]).unwrap();
        let right =
            direct_light::in_scattered(&scene, p, toward, &scatterers, &sun, &mut ctx) / sun.pdf;
        // The sun is nearly a point, so that only the cells' width is between both; it shows most
        // where the light of two faces of the box meets.
        let off = (light - right) / right;
        assert!(off.abs().max_element() < 0.12, "at {:?}: {light} not {right}", p.xyz);
        mean += off / 200.0;
    }
    assert!(mean.abs().max_element() < 0.003, "{mean}");
}

/// Where the sun grazes a thick ball its light falls by orders of magnitude from one cell to the next.
#[test]
fn direct_light_is_right_where_it_grazes_a_thick_ball() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
        [camera]
        position = [0.0, 0.0, 9.0]
        target = [0.0, 0.0, 0.0]
        fov = 15.0
        [film]
        size = [192, 192]
        [[medium]]
        region = { sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 } }
        sigma_t = 20.0
        albedo = 0.9
        [[light]]
        type = "sun"
        direction = [-1.0, 0.0, 0.0]
        irradiance = 1.0
    "#;
    let scene = crate::pictures::scene(folder.path(), text, 16, 1000);
    let maps = kept(&scene, 1000, None, 0);
    let [Some(direct)] = &maps.caches.direct[..] else { panic!("the sun's light is kept") };
    assert!(direct.cells().is_some());
    let mut ctx = PathContext::new(Stream::new(1, Stage::Test, 0, 0), Needs::EVERYTHING);
    let mut rng = Stream::new(6, Stage::Test, 0, 0);
    for band in [-0.2, -0.1, 0.0, 0.1] {
        let (mut light, mut right) = (0.0, 0.0);
        for _ in 0..4000 {
            // Up to one free path below the side that the camera sees.
            let [x, y] = [band + 0.1 * rng.uniform(), 1.6 * rng.uniform() - 0.8];
            let z = (1.0 - x * x - y * y).sqrt() - 0.05 * rng.uniform();
            let p = WorldPoint::new(x, y, z);
            let to_sun = Ray::new(p, DVec3::X);
            light += direct.at(&scene, p, &mut ctx).x;
            let arrived = scene.media.transmittance(&to_sun, Span::AHEAD).x;
            right += arrived * warp::uniform_sphere_pdf();
        }
        // The error of the mean of interpolated cells; without noise.
        assert!((light / right - 1.0).abs() < 0.02, "from {band}: {light} not {right}");
    }
}

#[test]
fn the_same_on_any_number_of_threads() {
    let scene = haze(&format!("{SUN}\n{SKY}"), FORWARD);
    let values = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let maps = pool.install(|| kept(&scene, 20_000, None, 1));
        let grid = maps.caches.fluence[0].as_ref().unwrap();
        let value = |p| (0..2).map(|level| grid.toward_camera(p, level).to_array()).collect();
        places(100).into_iter().map(value).collect::<Vec<Vec<[f64; 3]>>>()
    };
    assert_eq!(values(1), values(2));
    assert_eq!(values(1), values(3));
}
