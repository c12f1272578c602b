//! `trial.html`: the experiment as one file that opens offline.

use std::io::Write;
use std::path::Path;

use minijinja::context;
use minijinja::value::{Serde, Value};
use serde::Serialize;

use super::super::html::{data_uri, json, unmade, write_page};
use super::super::machine::Machine;
use super::answers::COLUMNS;
use super::pair::{Experiment, Pair, SCHEMA, name};
use crate::error::{Error, Result};
use crate::file;
use crate::image::Picture;
use crate::scene::Scene;

/// The page's file name.
pub const PAGE: &str = "trial.html";

/// The file beside the page that describes the experiment.
pub(super) const EXPERIMENT: &str = "trial.json";

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The two pictures of a scene, for the script.
#[derive(Serialize)]
struct Stimuli<'a> {
    name: &'a str,
    width: usize,
    height: usize,
    gold: String,
    directed: String,
}

/// Writes the page and `trial.json` to `folder`, which is made where it is missing. `command` is the
/// command line.
///
/// # Errors
/// Where there is no scene, two have the same name, or a file cannot be written.
pub fn write_trial(pairs: &[Pair], command: &str, folder: &Path) -> Result<()> {
    let names: Vec<&str> = pairs.iter().map(|pair| pair.scene.name.as_str()).collect();
    if names.is_empty() {
        return Err(Error::Usage("a trial needs at least one scene".into()));
    }
    check_names(&names)?;
    std::fs::create_dir_all(folder)
        .map_err(|e| Error::file(folder, format!("cannot be made: {e}; give a folder")))?;
    let path = folder.join(PAGE);
    let picture = |shown: &Picture| data_uri(&path, shown.width(), shown.height(), shown.bytes());
    let mut stimuli = Vec::new();
    for pair in pairs {
        stimuli.push(Stimuli {
            name: &pair.scene.name,
            width: pair.gold.width(),
            height: pair.gold.height(),
            gold: picture(&pair.gold)?,
            directed: picture(&pair.directed)?,
        });
    }
    let experiment = Experiment {
        schema: SCHEMA,
        version: env!("CARGO_PKG_VERSION").into(),
        command: command.into(),
        machine: Machine::here(),
        scenes: pairs.iter().map(|pair| pair.scene.clone()).collect(),
    };
    let context = context! {
        style => STYLE,
        script => SCRIPT,
        scenes => json(&path, &stimuli)?,
        columns => json(&path, &COLUMNS)?,
        names => Value::from(Serde(&names)),
        command => command,
        version => &experiment.version,
    };
    write_page(&path, TEMPLATE, context)?;
    let beside = folder.join(EXPERIMENT);
    let text = serde_json::to_vec_pretty(&experiment).map_err(|e| unmade(&beside, &e))?;
    file::write(&beside, |out| out.write_all(&text))
}

/// Checks, before any is rendered, that answers can be told apart by the scenes' names.
///
/// # Errors
/// Where two are the same.
pub fn check_scenes<'a>(scenes: impl Iterator<Item = &'a Scene>) -> Result<()> {
    let names: Vec<String> = scenes.map(name).collect();
    check_names(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

fn check_names(names: &[&str]) -> Result<()> {
    let same = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name));
    same.map_or(Ok(()), |(_, name)| {
        Err(Error::Usage(format!(
            "two scenes are named \"{name}\", by which answers are told apart; rename one file"
        )))
    })
}
