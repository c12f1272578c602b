//! The header of a picture: settings, work counters, and the keys of checkpoints and recipes.

use serde_json::{Map, Value, json};

use super::partial::COMPLETE;
use crate::image::cryptomatte;
use crate::render::Rendered;
use crate::scene::{Director, Planning, Scene};

/// What names of attributes of fogbow begin with.
pub(super) const PREFIX: &str = "fogbow:";

/// What names of counters of work begin with, behind [`PREFIX`].
pub(super) const WORK: &str = "work:";

/// The attribute of a complete picture that holds its [`recipe`].
pub(super) const RECIPE: &str = "fogbow:recipe";

/// The attribute that says how colours and alpha belong together.
const ALPHA: &str = "fogbow:alpha";

/// What it says.
const PREMULTIPLIED: &str = "R, G and B are premultiplied (associated) by A";

/// Attributes beside those of fogbow that crops and passes of a picture have in common.
pub(super) const OF_CAMERA: [&str; 2] = ["worldToCamera", "worldToNDC"];

/// How a picture is rendered, beside the settings of its scene.
#[derive(Debug, Clone, Copy)]
pub(super) struct Method {
    /// Whether it is the unbiased reference.
    pub(super) reference: bool,
    /// Whether a level set of a bare VDB is taken as a fog volume.
    pub(super) level_set_as_fog: bool,
}

/// The settings of a picture, the same for the same input. `requested` is the number of photons before it
/// was fitted to limits.
pub(super) fn settings(
    scene: &Scene,
    rendered: Option<&Rendered>,
    reference: bool,
    requested: u64,
) -> Map<String, Value> {
    let (film, render) = (&scene.film, &scene.render);
    let mut settings = object(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene.hash,
        "method": if reference { "reference" } else { "photon map" },
        "size": film.size,
        "exposure": film.exposure,
        "view": film.view.to_string(),
        "rays": render.rays,
        "photons": render.photons,
        "radius": rendered.and_then(|r| r.radius).or(render.radius),
        "step": render.step,
        "director": render.director.name(),
        "seed": render.seed,
        "max_scatter": render.max_scatter,
        "strategy": render.strategy.name(),
        "final_gather": render.final_gather.name(),
    }));
    if let Some(strategy) = rendered.and_then(|r| r.strategy.as_ref()) {
        let media = strategy.media.iter().map(|medium| json!(medium.strategy));
        settings.insert("strategies".into(), media.collect());
    }
    if render.photons != requested {
        settings.insert("photons_asked".into(), json!(requested));
    }
    if let Some(radius) = render.radius {
        settings.insert("radius_asked".into(), json!(radius));
    }
    if let Some(goal) = render.error {
        settings.insert("error".into(), json!(goal.to_string()));
    }
    if let Some(reached) = rendered.and_then(|r| r.error) {
        settings.insert("rays".into(), json!(reached.rays));
        settings.insert("photons".into(), json!(reached.photons));
        if let Some(stated) = reached.stated {
            settings.insert("error_reached".into(), json!(stated.value));
            settings.insert("error_uncertainty".into(), json!(stated.uncertainty));
        }
    }
    if let Some(denoiser) = rendered.and_then(|r| r.film.denoiser()) {
        settings.insert("denoised".into(), json!(true));
        settings.insert("denoiser".into(), json!(denoiser));
    }
    if rendered.is_some_and(|r| r.film.is_reconstructed()) {
        settings.insert("reconstructed".into(), json!(true));
    }
    if !film.passes.is_empty() {
        settings.insert("film_passes".into(), json!(film.passes.to_string()));
    }
    let has_light = film.passes.has_light() || film.passes.has_parts();
    if has_light && rendered.is_some() {
        let is_denoised = |r: &Rendered| r.film.denoiser().is_some();
        let of = if rendered.is_some_and(is_denoised) {
            "noisy.R, noisy.G and noisy.B"
        } else {
            "R, G and B"
        };
        settings.insert("light_passes".into(), json!(format!("parts of {of}")));
    }
    if let Some(crop) = render.crop {
        settings.insert("crop".into(), json!(crop.to_string()));
    }
    if let Some(name) = render.saved_photons {
        settings.insert("photons_saved".into(), json!(name.to_string()));
    }
    if let Some(pass) = render.pass {
        settings.insert("pass".into(), json!(pass.to_string()));
    }
    if render.director != Director::Fixed && !reference {
        let directing = render.effective_directing();
        settings.insert(
            "directing".into(),
            json!({
                "x": directing.x.name(),
                "weights": directing.weights,
                "op": directing.operator.name(),
                "directs": directing.directed.to_string(),
                "floor": directing.floor,
                "coarsest_radius": directing.coarsest_radius,
                "coarsest_step": directing.coarsest_step,
                "tolerance": directing.tolerance,
                "resolution": directing.resolution,
            }),
        );
    }
    settings
}

/// The key of a checkpoint: all that the samples of a picture depend on.
pub(super) fn key(scene: &Scene, method: Method, requested: u64) -> Map<String, Value> {
    let mut key = settings(scene, None, method.reference, requested);
    // These matter for the PNG alone, which is made of the finished film.
    key.remove("exposure");
    key.remove("view");
    key.insert("level_set_as_fog".into(), json!(method.level_set_as_fog));
    key.insert("denoise".into(), json!(scene.render.denoise));
    key.insert("reconstruct".into(), json!(scene.render.reconstruct));
    key.insert("everything".into(), json!(scene.render.planning == Planning::Everything));
    key
}

/// Hash of all that a picture's files depend on, where photons were not reduced.
pub(super) fn recipe(scene: &Scene, method: Method) -> String {
    let key = key(scene, method, scene.render.photons);
    let all = format!("{} {:?}", Value::Object(key), scene.film);
    blake3::hash(all.as_bytes()).to_hex().to_string()
}

/// The attribute with the [`recipe`] of a picture, where it is complete and has the `requested` photons.
pub(super) fn recipe_of(
    scene: &Scene,
    rendered: &Rendered,
    method: Method,
    requested: u64,
) -> Option<(String, String)> {
    let is_as_asked = rendered.is_complete() && scene.render.photons == requested;
    is_as_asked.then(|| (RECIPE.into(), recipe(scene, method)))
}

/// The attributes of the EXR header: settings and work, whether the picture is unfinished, how its alpha is meant, and its
/// camera.
pub(super) fn attributes(
    scene: &Scene,
    settings: &Map<String, Value>,
    rendered: &Rendered,
) -> Vec<(String, String)> {
    let work = object(serde_json::to_value(rendered.work).unwrap_or_default());
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let setting = |(name, value)| (format!("{PREFIX}{name}"), text(value));
    let counter = |(name, value): (&String, &Value)| (format!("{PREFIX}{WORK}{name}"), text(value));
    let unfinished = (!rendered.is_complete()).then(|| (COMPLETE.into(), "false".into()));
    let all = settings.iter().map(setting).chain(work.iter().map(counter)).chain(unfinished);
    let all = all.chain([(ALPHA.into(), PREMULTIPLIED.into())]).chain(camera(scene));
    all.chain(objects(scene, rendered)).collect()
}

/// Those of `attributes` that a deep picture has, which tells of no objects.
pub(super) fn without_objects(attributes: &[(String, String)]) -> Vec<(String, String)> {
    let is_kept = |(name, _): &&(String, String)| !name.starts_with(cryptomatte::ATTRIBUTES);
    attributes.iter().filter(is_kept).cloned().collect()
}

/// The attributes that tell of the objects of a picture, where it has layers of them.
fn objects(scene: &Scene, rendered: &Rendered) -> impl Iterator<Item = (String, String)> {
    let is_there = rendered.film.passes().any(|(name, _)| cryptomatte::is_layer(name));
    let attributes = is_there.then(|| cryptomatte::attributes(scene.objects.names()));
    attributes.into_iter().flatten()
}

/// The matrices of the camera, by the names that OpenEXR gives them.
fn camera(scene: &Scene) -> impl Iterator<Item = (String, String)> {
    let matrices = scene.camera.matrices(scene.film.size);
    let named = matrices.map(|m| OF_CAMERA.into_iter().zip([m.camera, m.picture]));
    let text = |rows: [[f64; 4]; 4]| json!(rows.as_flattened()).to_string();
    named.into_iter().flatten().map(move |(name, rows)| (name.into(), text(rows)))
}

fn object(value: Value) -> Map<String, Value> {
    if let Value::Object(object) = value { object } else { Map::new() }
}
