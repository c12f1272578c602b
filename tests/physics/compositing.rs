//! What the camera sees of hidden lights and surfaces, of holdouts and of shadow catchers, against closed forms and
//! against pictures laid over each other.

use fogbow::director::{Snapshot, x_map};
use fogbow::image::Film;
use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::plan::Needs;
use fogbow::scene::{Director, LoadOptions, RenderSettings, Scene};

/// Looks along -z from 9 m.
const VIEW: &str = "
    [camera]
    type = 'orthographic'
    position = [0.0, 0.0, 9.0]
    target = [0.0, 0.0, 0.0]
    height = 4.0
    [film]
    size = [20, 16]
    [render]
    rays = 8
    photons = 4000
";

/// A sky of radiance 1.
const SKY: &str = "
    [[light]]
    type = 'environment'
    radiance = 1.0
";

/// Soot in the right half of the view: it absorbs alone, with an optical thickness of 0.7.
const SOOT: &str = "
    [[medium]]
    region = { box = { min = [0.0, -9.0, -0.5], max = [9.0, 9.0, 0.5] } }
    sigma_t = 0.7
    albedo = 0.0
";

/// A ball of smoke.
const SMOKE: &str = "
    [[medium]]
    region = { sphere = { center = [0.3, 0.2, 0.0], radius = 1.4 } }
    sigma_t = 1.3
    albedo = 0.8
    phase = { type = 'henyey-greenstein', g = 0.4 }
";

/// A wall behind, as more keys say.
fn wall(keys: &str) -> String {
    format!(
        "
        [[surface]]
        shape = 'plane'
        point = [0.0, 0.0, -2.0]
        normal = [0.0, 0.0, 1.0]
        {keys}
        "
    )
}

/// A ball in front of the right half of the view, as more keys say.
fn ball(keys: &str) -> String {
    format!(
        "
        [[surface]]
        shape = 'sphere'
        center = [0.8, -0.3, 3.0]
        radius = 0.7
        {keys}
        "
    )
}

const HIDDEN: &str = "visible = false\n";

fn scene(parts: &[&str]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, parts.concat()).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

fn rendered(parts: &[&str]) -> Film {
    let scene = scene(parts);
    render(&scene, &scene.render, &Silent).unwrap().film
}

fn by_reference(parts: &[&str]) -> Film {
    let scene = scene(parts);
    render_reference(&scene, &scene.render, &Silent).film
}

fn layer(film: &Film, name: &str) -> Vec<f64> {
    film.layer(name).unwrap().iter().map(|v| f64::from(*v)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// `front` laid over `back`: green of each pixel.
fn over(front: &Film, back: &Film) -> Vec<f64> {
    let [green, alpha, behind] = [layer(front, "G"), layer(front, "A"), layer(back, "G")];
    green
        .iter()
        .zip(alpha)
        .zip(behind)
        .map(|((green, a), behind)| green + (1.0 - a) * behind)
        .collect()
}

fn assert_same(found: &[f64], expected: &[f64], off: f64, what: &str) {
    assert_eq!(found.len(), expected.len());
    for (pixel, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= off, "{what}, pixel {pixel}: {found} for {expected}");
    }
}

/// Whether a pixel of [`VIEW`] is right of the middle.
fn is_right(pixel: usize) -> bool {
    pixel % 20 >= 10
}

#[test]
fn a_film_is_transparent_where_the_sky_is_hidden() {
    let parts = [VIEW, SKY, HIDDEN, SOOT];
    let opacity = 1.0 - (-0.7_f64).exp();
    for (film, off) in [(rendered(&parts), 1e-6), (by_reference(&parts), 1.0)] {
        for name in ["R", "G", "B"] {
            assert!(layer(&film, name).iter().all(|v| *v == 0.0), "{name} is not 0");
        }
        let expected: Vec<f64> =
            (0..320).map(|pixel| if is_right(pixel) { opacity } else { 0.0 }).collect();
        assert_same(&layer(&film, "A"), &expected, off, "A");
        // 160 pixels with 8 rays, each opaque or not: 4.5 standard errors, a false alarm of 7e-6.
        let error = (opacity * (1.0 - opacity) / 1280.0).sqrt();
        let right: Vec<f64> = layer(&film, "A").into_iter().skip(10).step_by(20).collect();
        assert!((mean(&right) - opacity).abs() < 4.5 * 4.0 * error);
        assert!((2.0 * mean(&layer(&film, "A")) - opacity).abs() < 4.5 * error);
    }
}

/// Smoke, a wall in part of the view and a mirror ball, which shows the sky though it is hidden.
#[test]
fn a_transparent_film_over_the_sky_is_the_full_picture() {
    let mirror = ball("material = { type = 'mirror' }");
    for reconstruct in [false, true] {
        let film = |parts: &[&str]| {
            let scene = scene(parts);
            let settings = RenderSettings { reconstruct, ..scene.render };
            render(&scene, &settings, &Silent).unwrap().film
        };
        let full = film(&[VIEW, SKY, SMOKE, &mirror]);
        let front = film(&[VIEW, SKY, HIDDEN, SMOKE, &mirror]);
        let plate = rendered(&[VIEW, SKY]);
        assert_eq!(layer(&full, "A"), layer(&front, "A"));
        assert!(layer(&front, "A").contains(&0.0) && layer(&front, "A").contains(&1.0));
        // Edges that are reconstructed have visibility rays of their own, A has not.
        let off = if reconstruct { 0.2 } else { 1e-5 };
        let (laid, full) = (over(&front, &plate), layer(&full, "G"));
        assert_same(&laid, &full, off, "over");
        assert!((mean(&laid) / mean(&full) - 1.0).abs() < 0.01);
    }
}

/// A wall of soot that the camera does not see, before and behind smoke that glows and scatters nothing: all that is told
/// of the picture is as without it.
#[test]
fn a_hidden_surface_is_not_seen_by_anything_that_asks_for_the_camera() {
    let fire = "
        [[medium]]
        region = { sphere = { center = [0.3, 0.2, 0.0], radius = 1.4 } }
        sigma_t = 1.3
        albedo = 0.0
        emission = { color = [3.0, 2.0, 1.0] }
    ";
    let back = "
        [[surface]]
        shape = 'quad'
        center = [-1.0, 0.0, -3.0]
        u = [1.0, 0.0, 0.0]
        v = [0.0, 1.0, 0.0]
        material = { type = 'diffuse', reflectance = 0.0 }
    ";
    let black = format!("material = {{ type = 'diffuse', reflectance = 0.0 }}\n{HIDDEN}");
    let wall = wall(&black).replace("-2.0", "5.0");
    let ball = ball(&black);
    let [with, without] = [scene(&[VIEW, fire, &wall, &ball, back]), scene(&[VIEW, fire, back])];
    let needs = Needs::new(&with, &with.render);
    let [seen, other] = [&with, &without].map(|scene| Snapshot::look(scene, [20, 16], 0, needs).0);
    assert_eq!(seen, other);
    assert!(seen.depth.contains(&12.0));
    assert_eq!(x_map(&with, &seen, needs).0, x_map(&without, &seen, needs).0);
    let films = |scene: &Scene, settings: &RenderSettings| {
        [
            render(scene, settings, &Silent).unwrap().film,
            render_reference(scene, settings, &Silent).film,
        ]
    };
    for director in [Director::Fixed, Director::Xs, Director::XsPaper] {
        for reconstruct in [false, true] {
            let settings =
                RenderSettings { director, reconstruct, denoise: !reconstruct, ..with.render };
            let found = films(&with, &settings);
            for (found, expected) in found.iter().zip(films(&without, &settings)) {
                for (name, values) in expected.layers() {
                    assert!(found.layer(name).unwrap() == values, "{name} by {director:?}");
                }
                assert_eq!(found.features(), expected.features());
            }
        }
    }
}

/// A lamp that the camera looks at, with a mirror in the lower half of the view that shows it.
#[test]
fn a_hidden_lamp_shines_and_is_seen_in_mirrors() {
    let lamp = "
        [[light]]
        type = 'area'
        center = [0.0, 5.0, 0.0]
        u = [9.0, 0.0, 0.0]
        v = [0.0, 0.0, 9.0]
        radiance = 3.0
    ";
    let sheet = "
        [[light]]
        type = 'area'
        center = [0.0, 0.0, 0.0]
        u = [9.0, 0.0, 0.0]
        v = [0.0, 9.0, 0.0]
        radiance = 2.0
        visible = false
    ";
    let mirror = "
        [[surface]]
        shape = 'quad'
        center = [0.0, -1.0, 3.0]
        u = [9.0, 0.0, 0.0]
        v = [0.0, 0.70710678, -0.70710678]
        material = { type = 'mirror' }
    ";
    for film in [
        rendered(&[VIEW, lamp, HIDDEN, sheet, mirror]),
        by_reference(&[VIEW, lamp, HIDDEN, sheet, mirror]),
    ] {
        let (green, alpha) = (layer(&film, "G"), layer(&film, "A"));
        for (name, pixel, expected) in
            [("above", 10, [0.0, 0.0]), ("mirror", 12 * 20 + 10, [3.0, 1.0])]
        {
            let found = [green[pixel], alpha[pixel]];
            assert!(
                (found[0] - expected[0]).abs() < 1e-6 && found[1] == expected[1],
                "{name}: {found:?}"
            );
        }
    }
}

#[test]
fn a_holdout_is_a_hole_in_the_picture() {
    let fire = "
        [[medium]]
        region = { box = { min = [-9.0, -9.0, 0.0], max = [9.0, 9.0, 1.0] } }
        sigma_t = 0.6
        albedo = 0.0
        emission = { color = [3.0, 2.0, 1.0] }
    ";
    let lamp = "
        [[surface]]
        shape = 'quad'
        center = [0.0, 0.0, -2.0]
        u = [1.0, 0.0, 0.0]
        v = [0.0, 1.0, 0.0]
        material = { type = 'diffuse', reflectance = 0.0 }
        emission = 5.0
    ";
    let held = format!("{lamp}holdout = true\n");
    let behind = wall("").replace("-2.0", "-4.0");
    let opacity = 1.0 - (-0.6_f64).exp();
    let film = rendered(&[VIEW, fire, &held, &behind]);
    let alone = rendered(&[VIEW, fire]);
    let inside = |pixel: &usize| (6..14).contains(&(pixel % 20)) && (5..11).contains(&(pixel / 20));
    for pixel in (0..320).filter(inside) {
        let [z, a, g, right] =
            [layer(&film, "Z"), layer(&film, "A"), layer(&film, "G"), layer(&alone, "G")]
                .map(|values| values[pixel]);
        assert!((z - 11.0).abs() < 1e-5, "Z is {z}");
        assert!((a - opacity).abs() < 1e-6, "A is {a}");
        assert!((g - right).abs() < 1e-6, "{g} for {right}");
    }
    // Behind the holdout stands its own picture: fire and lamp over each other are both together.
    let full = rendered(&[VIEW, fire, lamp]);
    let laid = over(&rendered(&[VIEW, fire, &held]), &rendered(&[VIEW, lamp]));
    assert_same(&laid, &layer(&full, "G"), 1e-5, "over");
    let reference = by_reference(&[VIEW, fire, &held]);
    let other = by_reference(&[VIEW, fire]);
    // Both trace the same paths as far as the holdout.
    assert_same(&layer(&reference, "G"), &layer(&other, "G"), 1e-6, "reference");
}

/// Looks down on a floor.
const DOWN: &str = "
    [camera]
    type = 'orthographic'
    position = [0.0, 6.0, 0.0]
    target = [0.0, 0.0, 0.0]
    up = [0.0, 0.0, -1.0]
    height = 4.0
    [film]
    size = [20, 16]
    [render]
    rays = 16
    photons = 20000
";

fn floor(keys: &str) -> String {
    format!(
        "[[surface]]\nshape = 'plane'\nmaterial = {{ type = 'diffuse', reflectance = 0.5 }}\n{keys}\n"
    )
}

const CATCHES: &str = "shadow_catcher = true";

/// Sun and lamp, or sun and sky, on a floor with nothing on it. A lamp stands before the sky, and takes some of its light away.
#[test]
fn nothing_is_seen_where_no_shadow_is() {
    let sun = "
        [[light]]
        type = 'sun'
        direction = [0.3, -1.0, 0.2]
        irradiance = [3.0, 2.0, 1.0]
    ";
    let lamp = "
        [[light]]
        type = 'area'
        center = [5.0, 5.0, 2.0]
        u = [1.0, 0.0, 0.0]
        v = [0.0, 0.0, 1.0]
        radiance = [20.0, 16.0, 12.0]
    ";
    let sky = "
        [[light]]
        type = 'environment'
        gradient = [[0.0, 0.1], [90.0, [0.2, 0.4, 1.0]]]
    ";
    for other in [lamp, sky] {
        let parts = [DOWN, sun, other, &floor(CATCHES)];
        for film in [rendered(&parts), by_reference(&parts)] {
            for name in ["R", "G", "B", "A"] {
                assert!(layer(&film, name).iter().all(|v| *v == 0.0), "{name} is not 0: {other}");
            }
            assert!(layer(&film, "Z").iter().all(|z| (z - 6.0).abs() < 1e-5));
        }
    }
}

/// Sun through soot of the optical thickness 0.7 above the floor, seen from below and through the soot.
#[test]
fn soot_casts_a_shadow_as_the_closed_form_says() {
    let soot = SOOT.replace(
        "[0.0, -9.0, -0.5], max = [9.0, 9.0, 0.5]",
        "[-9.0, 2.0, -9.0], max = [9.0, 3.0, 9.0]",
    );
    let sun =
        "[[light]]\ntype = 'sun'\ndirection = [0.0, -1.0, 0.0]\nirradiance = 3.0\nangle = 0.0\n";
    for (camera, passes) in [(DOWN.replace("6.0", "1.0"), 1.0), (DOWN.to_owned(), 2.0)] {
        let expected = 1.0 - (-0.7_f64 * passes).exp();
        let parts = [camera.as_str(), sun, &soot, &floor(CATCHES)];
        let film = rendered(&parts);
        assert_same(&layer(&film, "A"), &[expected; 320], 1e-6, "A");
        assert!(layer(&film, "G").iter().all(|v| *v == 0.0));
        // 320 pixels of 16 rays, whose coverage is between 0 and 1: 4.5 standard errors at most, a false alarm of 7e-6.
        let off = mean(&layer(&by_reference(&parts), "A")) - expected;
        assert!(off.abs() < 4.5 * 0.5 / (320.0_f64 * 16.0).sqrt(), "{off} from {expected}");
    }
}

/// The part of the light of a square lamp of half side 1 at (0, 5, 0), which shines down, that a ball of radius 0.5 round
/// (0, 1, 0) lets through to the place x on the floor, by the midpoint rule.
fn let_through(x: f64) -> f64 {
    let count = 400;
    let (mut all, mut free) = (0.0, 0.0);
    for index in 0..count * count {
        let at = |i: i32| -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let toward = glam::DVec3::new(at(index % count) - x, 5.0, at(index / count));
        let light = 25.0 / toward.length_squared().powi(2);
        let center = glam::DVec3::new(-x, 1.0, 0.0);
        let foot = toward.normalize() * center.dot(toward.normalize());
        all += light;
        free += if (center - foot).length() > 0.5 { light } else { 0.0 };
    }
    free / all
}

#[test]
fn a_ball_casts_the_shadow_of_a_lamp() {
    let lamp = "
        [[light]]
        type = 'area'
        center = [0.0, 5.0, 0.0]
        u = [1.0, 0.0, 0.0]
        v = [0.0, 0.0, 1.0]
        radiance = 9.0
    ";
    let ball = "
        [[surface]]
        shape = 'sphere'
        center = [0.0, 1.0, 0.0]
        radius = 0.5
    ";
    for x in [0.0, 0.3, 0.55, 0.8, 2.0] {
        let camera = DOWN
            .replace("[0.0, 6.0, 0.0]", &format!("[{x:?}, 0.1, 0.0]"))
            .replace("target = [0.0, 0.0, 0.0]", &format!("target = [{x:?}, 0.0, 0.0]"))
            .replace("height = 4.0", "height = 0.001");
        let expected = 1.0 - let_through(x);
        let parts = [camera.as_str(), lamp, ball, &floor(CATCHES)];
        for (film, by) in [(rendered(&parts), "photon map"), (by_reference(&parts), "reference")] {
            let found = mean(&layer(&film, "A"));
            // 320 pixels of 16 rays with one sample each: at most 0.5 in each, 4.5 standard errors, a false alarm of 7e-6.
            let bound = 4.5 * 0.5 / (320.0_f64 * 16.0).sqrt();
            assert!((found - expected).abs() < bound, "{found} for {expected} at {x} by {by}");
        }
    }
}

/// A red wall beside a ball on the floor, in the light of a lamp without extent: the catcher over its own empty plate is
/// the full picture, with the wall's light on the floor.
#[test]
fn a_catcher_over_its_plate_is_the_full_picture() {
    let lamp = "
        [[light]]
        type = 'point'
        position = [1.0, 4.0, 1.0]
        intensity = 50.0
    ";
    let things = "
        [[surface]]
        shape = 'sphere'
        center = [-0.3, 0.5, 0.0]
        radius = 0.5
        [[surface]]
        shape = 'box'
        min = [-1.6, 0.0, -1.5]
        max = [-1.2, 1.0, 1.5]
        material = { type = 'diffuse', reflectance = [0.2, 0.9, 0.2] }
    ";
    let plate = rendered(&[DOWN, lamp, &floor("")]);
    for reconstruct in [false, true] {
        let film = |floor: &str| {
            let scene = scene(&[DOWN, lamp, things, floor]);
            let settings = RenderSettings { reconstruct, ..scene.render };
            render(&scene, &settings, &Silent).unwrap().film
        };
        let (full, caught) = (film(&floor("")), film(&floor(CATCHES)));
        let (laid, full) = (over(&caught, &plate), layer(&full, "G"));
        let is_floor = |pixel: &usize| layer(&caught, "Z")[*pixel] > 5.999;
        let (mut shadowed, mut red) = (0, 0);
        for pixel in (0..320).filter(is_floor) {
            // Light of a lamp without extent has no noise; it varies a little within a pixel.
            let off = (laid[pixel] - full[pixel]).abs();
            let bound = if reconstruct { 0.4 } else { 5e-3 };
            assert!(off < bound * f64::from(plate.layer("G").unwrap()[pixel]), "{off} at {pixel}");
            shadowed += usize::from(layer(&caught, "A")[pixel] > 0.9);
            red += usize::from(layer(&caught, "G")[pixel] > 2.0 * layer(&caught, "R")[pixel]);
        }
        assert!(shadowed > 10 && red > 50, "{shadowed} in shadow, {red} lit by the wall");
        assert!((mean(&laid) / mean(&full) - 1.0).abs() < 0.01);
    }
    // The reference has the same indirect light: means over 320 pixels of 16 rays and of 20,000 photons, within 4 %.
    let [ours, other] = [rendered, by_reference]
        .map(|film| film(&[DOWN, lamp, things, &floor(CATCHES)]))
        .map(|film| ["A", "G"].map(|name| mean(&layer(&film, name))));
    for (ours, other) in ours.into_iter().zip(other) {
        assert!((ours / other - 1.0).abs() < 0.04, "{ours} and {other}");
    }
}

/// Smoke over a floor that catches its shadow, with budgets from directors.
#[test]
fn directed_catchers_have_coverage_between_0_and_1() {
    let lights = "
        [[light]]
        type = 'sun'
        direction = [0.6, -1.0, 0.2]
        irradiance = 3.0
    ";
    let parts =
        [DOWN, lights, SKY, HIDDEN, SMOKE, &floor(&format!("point = [0.0, -1.5, 0.0]\n{CATCHES}"))];
    let scene = scene(&parts);
    let fixed = rendered(&parts);
    for director in [Director::Variance, Director::Xs, Director::XsPaper] {
        let settings = RenderSettings { director, reconstruct: true, ..scene.render };
        let film = render(&scene, &settings, &Silent).unwrap().film;
        let alpha = layer(&film, "A");
        assert!(alpha.iter().all(|a| (0.0..=1.0).contains(a)));
        assert!((mean(&alpha) / mean(&layer(&fixed, "A")) - 1.0).abs() < 0.03, "{director:?}");
        assert!((mean(&layer(&film, "G")) / mean(&layer(&fixed, "G")) - 1.0).abs() < 0.05);
    }
}
