//! Albedo and normals that a denoiser is shown, against closed forms.

use fogbow::image::{Features, Film};
use fogbow::render::{Silent, render, render_reference};
use fogbow::scene::{LoadOptions, RenderSettings, Scene};

/// Looks along -z at what stands before a white sky.
const VIEW: &str = "
    [camera]
    type = 'orthographic'
    position = [0.0, 0.0, 9.0]
    target = [0.0, 0.0, 0.0]
    height = 0.5
    [film]
    size = [6, 4]
    [render]
    rays = 4
    photons = 1000
    [[light]]
    type = 'environment'
    radiance = 1.0
";

/// A wall at z = -2 that faces the camera.
const WALL: &str = "
    [[surface]]
    shape = 'plane'
    point = [0.0, 0.0, -2.0]
    normal = [0.0, 0.0, -1.0]
    material = { type = 'diffuse', reflectance = [0.3, 0.6, 0.1] }
";
const WALL_ALBEDO: [f64; 3] = [0.3, 0.6, 0.1];

/// The same albedo and optical thickness per metre everywhere in one metre of haze.
const HAZE: &str = "
    [[medium]]
    region = { box = { min = [-3.0, -3.0, 0.0], max = [3.0, 3.0, 1.0] } }
    sigma_t = 0.7
    albedo = [0.9, 0.5, 0.2]
";

fn scene(parts: &[&str]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, VIEW.to_owned() + &parts.concat()).unwrap();
    Scene::load(&path, &LoadOptions::default()).unwrap()
}

fn film(scene: &Scene, denoise: bool) -> [Film; 2] {
    let settings = RenderSettings { denoise, ..scene.render };
    let marched = render(scene, &settings, &Silent).unwrap();
    [marched, render_reference(scene, &settings, &Silent)].map(|rendered| rendered.film)
}

/// Checks what each pixel of both renderers' films shows.
fn check(parts: &[&str], albedo: [f64; 3], normal: [f64; 3]) {
    for film in film(&scene(parts), true) {
        assert_eq!(film.features().len(), film.width() * film.height());
        for Features { albedo: a, normal: n } in film.features() {
            let (found, expected) = ([*a, *n], [albedo, normal]);
            let pairs = found.as_flattened().iter().zip(expected.as_flattened());
            let error = pairs.map(|(f, e)| (f64::from(*f) - e).abs()).fold(0.0, f64::max);
            assert!(error < 1e-5, "{found:?} instead of {expected:?}");
        }
    }
}

#[test]
fn a_medium_counts_what_is_seen_of_it_and_the_wall_what_is_left() {
    let through = (-0.7_f64).exp();
    let haze = [0.9, 0.5, 0.2];
    let both = |c: usize| haze[c] * (1.0 - through) + WALL_ALBEDO[c] * through;
    check(&[HAZE, WALL], std::array::from_fn(both), [0.0, 0.0, through]);
    check(&[HAZE], haze.map(|albedo| albedo * (1.0 - through)), [0.0; 3]);
    check(&[WALL], WALL_ALBEDO, [0.0, 0.0, 1.0]);
    check(&[], [0.0; 3], [0.0; 3]);
}

#[test]
fn media_that_overlap_share_by_their_coefficients() {
    let other = "
        [[medium]]
        region = { box = { min = [-3.0, -3.0, 0.5], max = [3.0, 3.0, 2.0] } }
        sigma_t = [1.0, 2.0, 3.0]
        albedo = 0.6
    ";
    let haze = [0.9, 0.5, 0.2];
    let albedo = |c: usize| {
        let (a, b): (f64, f64) = (0.7, [1.0, 2.0, 3.0][c]);
        // One metre of the other alone, half of both, half of the haze.
        let mixed = (a * haze[c] + b * 0.6) / (a + b);
        let (first, second) = ((-b).exp(), (-(a + b) / 2.0).exp());
        let rest = mixed * (1.0 - second) + second * haze[c] * (1.0 - (-a / 2.0).exp());
        0.6 * (1.0 - first) + first * rest
    };
    check(&[HAZE, other], std::array::from_fn(albedo), [0.0; 3]);
}

#[test]
fn mirrors_show_what_they_reflect() {
    // Turns the view upward, to a ceiling.
    let mirror = "
        [[surface]]
        shape = 'quad'
        center = [0.0, 0.0, 0.0]
        u = [2.0, 0.0, 0.0]
        v = [0.0, 2.0, -2.0]
        material = { type = 'mirror', reflectance = [0.9, 0.8, 0.7] }
        [[surface]]
        shape = 'plane'
        point = [0.0, 5.0, 0.0]
        normal = [0.0, -1.0, 0.0]
        material = { type = 'diffuse', reflectance = 0.5 }
    ";
    let weight = (0.2126 * 0.9 + 0.7152 * 0.8 + 0.0722 * 0.7) as f32;
    check(&[mirror, WALL], [0.45, 0.4, 0.35], [0.0, -f64::from(weight), 0.0]);
}

#[test]
fn glass_shows_what_it_lets_through_by_fresnels_equations() {
    let pane = "
        [[surface]]
        shape = 'box'
        min = [-2.0, -2.0, 3.0]
        max = [2.0, 2.0, 3.5]
        material = { type = 'glass', ior = 1.5, tint = 0.9 }
    ";
    // At right angles a face reflects ((n - 1) / (n + 1))², and what the second one reflects leaves
    // through the first, to the sky.
    let through = (0.96 * 0.9_f64).powi(2);
    check(&[pane, WALL], WALL_ALBEDO.map(|albedo| albedo * through), [0.0, 0.0, through]);
}

#[test]
fn they_are_left_out_where_nothing_is_denoised_and_change_nothing_else() {
    let scene = scene(&[HAZE, WALL]);
    let [without, with] = [false, true].map(|denoise| film(&scene, denoise));
    for (without, with) in without.iter().zip(&with) {
        assert!(without.features().is_empty());
        assert_eq!(with.features().len(), 24);
    }
    // The march chooses its gathers by whether it is denoised; paths are traced alike.
    let [plain, told] = [&without[1], &with[1]].map(|film| film.layers().collect::<Vec<_>>());
    assert_eq!(plain, told);
}
