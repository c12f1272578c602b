//! The plan of a render: the work that it needs, and the work that it leaves out.
//!
//! A [`RenderPlan`] follows from the scene and its settings alone. Its [`Needs`] are plain facts that
//! the stages of a render take; its items are the same in words, and name the counter of
//! [`Work`](crate::work::Work) that stays 0 where the item is left out.
//!
//! | where | left out | counter that is 0 |
//! | --- | --- | --- |
//! | no medium, or none that weakens or gives light | march, volume photons; X is 1 | `marches` |
//! | no grid: regions | grid lookups, for closed forms | `grid_lookups` |
//! | albedo 0, no light, `max_scatter` 0 | volume photons and gathers | `gathers`, `volume_photons` |
//! | no emission | emission along rays | `emission_lookups` |
//! | isotropic phase functions | directions of photons in media | `directed_gathers` |
//! | nothing coloured | two channels of three | `colored_paths` |
//! | nothing but absorption, no surface | voxels out of sight | `unseen_voxels` |
//! | no surface | search, surface photons | `intersections`, `surface_photons` |
//! | no diffuse surface | surface photons | `surface_photons` |
//! | no mirror or glass | recursion | `specular_bounces` |
//! | one light | choice among lights | `light_choices` |
//! | no light infinitely far | its lookup; X is 0 where nothing is hit | `environment_lookups` |
//! | fixed or variance director | maps | `map_pixels` |
//! | always | photons that can reach neither a medium nor a surface | `photons_missed` |
//!
//! Constant blocks of a grid cost one step each, whatever their size, and grids that no medium names
//! are not read.
//!
//! Left out is only what cannot change the picture's mean; what could be left out at the price of
//! an error is offered with a bound of it, and never taken silently.

mod needs;
mod offer;

use serde::Serialize;

use super::{Planning, RenderSettings, Scene};

pub use needs::Needs;

/// One stage or term of a render.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Item {
    /// The stage it belongs to.
    pub stage: &'static str,
    /// What it is.
    pub name: &'static str,
    /// Whether it is needed, or left out.
    pub needed: bool,
    /// Why.
    pub why: String,
    /// The counter that is 0 where it is left out.
    pub counter: &'static str,
}

/// The plan of a render.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RenderPlan {
    /// The same as plain facts.
    pub needs: Needs,
    /// Every stage and term.
    pub items: Vec<Item>,
    /// Work that could be left out at the price of a small error, one sentence each.
    pub offers: Vec<String>,
}

impl RenderPlan {
    /// The plan for rendering `scene` under `settings`.
    pub fn new(scene: &Scene, settings: &RenderSettings) -> Self {
        let mut items = items(scene, settings, &Needs::least(scene, settings));
        if settings.planning == Planning::Everything {
            // No flag can force grids on a scene without them.
            let left_out = |item: &&mut Item| !item.needed && item.counter != GRID_LOOKUPS;
            for item in items.iter_mut().filter(left_out) {
                item.needed = true;
                item.why = format!("asked for, though {}", item.why);
            }
        }
        let offers = offer::single_scattering(scene, settings).into_iter().collect();
        Self { needs: Needs::new(scene, settings), items, offers }
    }

    /// The plan in one line.
    pub fn line(&self) -> String {
        let list = |needed: bool| {
            let items = self.items.iter().filter(|item| item.needed == needed);
            let names: Vec<&str> = items.map(|item| item.name).collect();
            if names.is_empty() { "nothing".into() } else { names.join(", ") }
        };
        format!("plan: {}; left out: {}", list(true), list(false))
    }
}

const GRID_LOOKUPS: &str = "grid_lookups";

fn items(scene: &Scene, settings: &RenderSettings, needs: &Needs) -> Vec<Item> {
    let media = scene.media.len();
    let grids = grid_count(scene);
    let surfaces = scene.surfaces.surfaces().len();
    let lights = scene.lights.lights.len();
    let scattering = scene.media.iter().filter(|m| needs::scatters(m)).count();
    let glowing = scene.media.iter().filter(|m| needs::emits(m)).count();
    let dark = lights == 0 && glowing == 0;
    let no_scattering = if media == 0 {
        "there is no medium"
    } else if scattering == 0 {
        "no medium scatters: albedo 0"
    } else if dark {
        "nothing shines"
    } else {
        "max_scatter is 0"
    };
    let no_volume_photons = if needs.scattering {
        "single scattering of lamps' light is sampled directly"
    } else {
        no_scattering
    };
    let no_surface_photons = if surfaces == 0 {
        "there is no surface"
    } else if dark {
        "nothing shines"
    } else {
        "no surface is diffuse"
    };
    let unseen = scene.unseen.filter(|_| grids > 0).map_or("no grid is named".into(), |unseen| {
        let voxels = count(unseen.voxels as usize, "voxel");
        format!("only the camera asks for voxels, and {voxels} lie out of its sight")
    });
    let row = |stage, name, needed, counter, yes: String, no: &str| Item {
        stage,
        name,
        needed,
        why: if needed { yes } else { no.into() },
        counter,
    };
    vec![
        row(
            "load",
            "voxel grids",
            grids > 0,
            GRID_LOOKUPS,
            format!("{} in use", count(grids, "grid")),
            "no grid is named: closed forms",
        ),
        row(
            "load",
            "voxels out of sight",
            scene.unseen.is_none_or(|unseen| !unseen.left_out) && grids > 0,
            "unseen_voxels",
            "light may pass anywhere".into(),
            &unseen,
        ),
        row(
            "load",
            "tree of surfaces",
            needs.surfaces,
            "intersections",
            count(surfaces, "surface"),
            "there is no surface",
        ),
        row(
            "director",
            "maps",
            needs.maps,
            "map_pixels",
            format!("director {}", settings.director.name()),
            &format!("director {} looks at none", settings.director.name()),
        ),
        row(
            "photons",
            "volume photons",
            needs.volume_photons,
            "volume_photons",
            format!("media that scatter: {scattering} of {media}"),
            no_volume_photons,
        ),
        row(
            "photons",
            "surface photons",
            needs.surface_photons,
            "surface_photons",
            "there are diffuse surfaces".into(),
            no_surface_photons,
        ),
        row(
            "photons",
            "photons into the void",
            needs.void,
            "photons_missed",
            String::new(),
            "lights aim at spheres round what can be reached; draws that miss it all the same are \
             rejected before they fly",
        ),
        row(
            "march",
            "media",
            needs.media,
            "marches",
            count_of(media, "medium", "media"),
            if media == 0 { "there is no medium" } else { "no medium weakens or gives light" },
        ),
        row(
            "march",
            "scattering in media",
            needs.scattering,
            "gathers",
            format!("media that scatter: {scattering} of {media}"),
            no_scattering,
        ),
        row(
            "all",
            "colours",
            needs.colors,
            "colored_paths",
            "a light, medium or surface is coloured".into(),
            "all is grey: one channel stands for three",
        ),
        row(
            "march",
            "directions of photons",
            needs.directions,
            "directed_gathers",
            "a phase function is not isotropic".into(),
            if needs.scattering { "all phase functions are isotropic" } else { no_scattering },
        ),
        row(
            "march",
            "emission",
            needs.emission,
            "emission_lookups",
            format!("media that glow: {glowing} of {media}"),
            "no medium gives off light",
        ),
        row(
            "march",
            "mirrors and glass",
            needs.specular,
            "specular_bounces",
            "there are such surfaces".into(),
            "no surface is a mirror or of glass",
        ),
        row(
            "march",
            "choice of lights",
            needs.light_choice,
            "light_choices",
            count(lights, "light"),
            if lights == 0 { "there is no light" } else { "there is one light" },
        ),
        row(
            "march",
            "environment",
            needs.environment,
            "environment_lookups",
            "a light is infinitely far and visible".into(),
            "rays that leave the scene end: nothing shines there",
        ),
    ]
}

/// How many voxel grids media use: densities, albedos and emissions, each once.
fn grid_count(scene: &Scene) -> usize {
    scene.media.grid_bytes().len()
}

fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

fn count_of(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}
