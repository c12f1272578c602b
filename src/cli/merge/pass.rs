//! Passes: parts with the same seed, and of equal passes the same number, which agree in all else and fill the frame.

use super::super::header::{PREFIX, WORK};
use super::part::Part;
use crate::error::{Error, Result};
use crate::image::Window;
use crate::image::merge::{CoverageError, PassWork, check_coverage};
use crate::scene::PicturePass;

/// Attributes in which the crops of a pass may differ. Those that begin with `work:` may, too.
const OF_CROPS: [&str; 3] = ["crop", "recipe", "photons_asked"];

/// The attribute that names saved photons, which were read in place of shooting any. Crops of a whole picture may differ
/// in it, since they have the pixels of those that shoot. Equal passes may not: one that shoots has a share of the photons,
/// one that reads them all.
const SAVED: &str = "photons_saved";

/// Attributes in which passes may differ as well: seeds, the work that weighs them, and what follows from that,
/// gather radius and estimators.
pub(super) const OF_PASSES: [&str; 5] = ["seed", "rays", "photons", "radius", "strategies"];

/// The attribute of an equal pass.
pub(super) const PASS: &str = "pass";

/// Attributes in which the equal passes of a picture may differ beside those of crops: each has photons of its own,
/// from which its radius follows.
const OF_SHARES: [&str; 2] = [PASS, "radius"];

/// The attributes that are compared first: the others follow from them.
const FOREMOST: [&str; 4] = ["version", "scene", "size", "method"];

/// Files or gaps that a message names, at most.
const NAMED: usize = 4;

/// The frame of one seed, or one of the equal passes that it was rendered in.
#[derive(Debug)]
pub(super) struct Pass {
    /// Its parts, from the top and then the left; at least one.
    pub(super) parts: Vec<Part>,
}

impl Pass {
    /// Its first part, which has the settings of all.
    pub(super) fn first(&self) -> &Part {
        &self.parts[0]
    }

    /// The work that was asked for, of an equal pass its share: no photons where none were shot.
    pub(super) fn work(&self) -> PassWork {
        let first = self.first();
        let count = |name| first.count(name).unwrap_or(0);
        let is_shot = |part: &Part| part.count("work:photon_paths").unwrap_or(0) > 0;
        let has_photons = |part: &Part| is_shot(part) || part.attribute(SAVED).is_some();
        let shot = self.parts.iter().all(has_photons);
        let (rays, photons) = (count("rays"), if shot { count("photons") } else { 0 });
        let Some(pass) = first.pass else { return PassWork { rays, photons } };
        let of_pixel = u32::try_from(rays).unwrap_or(u32::MAX);
        let [rays, photons] =
            [rays, photons].map(|total| pass.share(total, of_pixel)).map(|own| own.end - own.start);
        PassWork { rays, photons }
    }
}

/// The passes of `parts`, by seed and number, whatever the order of the parts.
///
/// # Errors
/// Where parts differ in what they must agree in, those of a pass overlap or leave gaps, or an equal pass is missing.
pub(super) fn group(mut parts: Vec<Part>) -> Result<Vec<Pass>> {
    parts.sort_by_key(|part| (part.seed, part.pass, part.window.top, part.window.left));
    let mut passes: Vec<Pass> = Vec::new();
    for part in parts {
        let of = |part: &Part| (part.seed, part.pass);
        match passes.last_mut().filter(|pass| of(pass.first()) == of(&part)) {
            Some(pass) => pass.parts.push(part),
            None => passes.push(Pass { parts: vec![part] }),
        }
    }
    for pass in &passes {
        let first = pass.first();
        agree(first, passes[0].first(), &[&OF_CROPS[..], &OF_PASSES, &[PASS, SAVED]].concat())?;
        let saved: &[&str] = if first.pass.is_none() { &[SAVED] } else { &[] };
        let free = [&OF_CROPS[..], saved].concat();
        pass.parts.iter().try_for_each(|part| agree(part, first, &free))?;
    }
    for of_seed in passes.chunk_by(|a, b| a.first().seed == b.first().seed) {
        are_all(of_seed)?;
    }
    passes.iter().try_for_each(fills)?;
    Ok(passes)
}

/// Checks that the passes of one seed, sorted, are one or all of the equal passes of a picture.
fn are_all(passes: &[Pass]) -> Result<()> {
    let first = passes[0].first();
    let count = |part: &Part| part.pass.map_or(1, |pass| pass.count);
    for pass in &passes[1..] {
        let part = pass.first();
        if count(part) != count(first) {
            let problem = format!(
                "is {}, and {} {}: they share rays; give all passes K/N of one N",
                named(part),
                first.path.display(),
                named(first)
            );
            return Err(Error::file(&part.path, problem));
        }
        agree(part, first, &[&OF_CROPS[..], &OF_SHARES].concat())?;
    }
    let known = |number: &u32| {
        passes.iter().any(|pass| pass.first().pass.is_none_or(|pass| pass.number == *number))
    };
    let of = |number| PicturePass { count: count(first), number };
    let missing: Vec<PicturePass> =
        (1..=count(first)).filter(|number| !known(number)).map(of).collect();
    let Some(next) = missing.first() else { return Ok(()) };
    let problem = format!(
        "is {}, of which others are missing: no part is {}; render --pass {next}",
        named(first),
        listed(&missing, PicturePass::to_string, " or "),
    );
    Err(Error::file(&first.path, problem))
}

/// The pass of a part in words.
fn named(part: &Part) -> String {
    let seed = part.seed;
    part.pass.map_or_else(
        || format!("the whole of seed {seed}"),
        |pass| format!("pass {pass} of seed {seed}"),
    )
}

/// Checks that two parts agree in layers and all attributes but `free`.
fn agree(part: &Part, other: &Part, free: &[&str]) -> Result<()> {
    let names = || part.attributes().chain(other.attributes()).map(|(name, _)| name);
    let is_compared = |name: &&str| !name.starts_with(WORK) && !free.contains(name);
    let mut names: Vec<&str> = FOREMOST.into_iter().chain(names().filter(is_compared)).collect();
    names[FOREMOST.len()..].sort_unstable();
    let told = |value: Option<&str>| value.map_or("not there".into(), |value| format!("`{value}`"));
    for name in names {
        let (found, known) = (part.attribute(name), other.attribute(name));
        if found != known {
            let problem = format!(
                "{PREFIX}{name} is {}, and {} in {}; parts of one picture have the same scene, settings and version",
                told(found),
                told(known),
                other.path.display()
            );
            return Err(Error::file(&part.path, problem));
        }
    }
    if part.layers != other.layers {
        let problem = format!(
            "has the layers {}, and {} those of {}; parts of one picture have the same",
            part.layers.join(" "),
            other.path.display(),
            other.layers.join(" ")
        );
        return Err(Error::file(&part.path, problem));
    }
    Ok(())
}

/// Checks that the parts of a pass fill the frame.
fn fills(pass: &Pass) -> Result<()> {
    let windows: Vec<Window> = pass.parts.iter().map(|part| part.window).collect();
    match check_coverage(pass.first().size, &windows) {
        Ok(()) => Ok(()),
        Err(CoverageError::Overlap { windows: [a, b], place }) => {
            Err(overlap(&pass.parts[a], &pass.parts[b], place))
        }
        Err(CoverageError::Gaps(gaps)) => Err(gap(pass, &gaps)),
    }
}

fn overlap(part: &Part, other: &Part, place: Window) -> Error {
    let (seed, other_path) = (part.seed, other.path.display());
    let pass = part.pass.map_or(String::new(), |pass| format!(" and pass {pass}"));
    let problem = if part.window == other.window {
        format!(
            "has the seed {seed}{pass} and the pixels {place}, as has {other_path}: one picture would count twice; \
             give each once, and render passes with different seeds"
        )
    } else {
        format!(
            "overlaps {other_path} in the pixels {place}, both with seed {seed}{pass}; give crops side by side"
        )
    };
    Error::file(&part.path, problem)
}

fn gap(pass: &Pass, gaps: &[Window]) -> Error {
    let Part { path, seed, pass: of_picture, .. } = pass.first();
    let others = match &pass.parts[1..] {
        [] => String::new(),
        others => {
            " with ".to_owned() + &listed(others, |part| part.path.display().to_string(), ", ")
        }
    };
    let places = listed(gaps, Window::to_string, " and ");
    let [with, flag] = match of_picture {
        Some(pass) => [format!(" and pass {pass}"), format!("--pass {pass} ")],
        None => [String::new(), String::new()],
    };
    let problem = format!(
        "leaves gaps{others}: no part with seed {seed}{with} has the pixels {places}; render {flag}--crop {}",
        gaps[0]
    );
    Error::file(path, problem)
}

/// The first few of `things` as `text` tells them, and how many there are beside.
fn listed<T>(things: &[T], text: impl Fn(&T) -> String, between: &str) -> String {
    let named: Vec<String> = things.iter().take(NAMED).map(text).collect();
    let more = match things.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    named.join(between) + &more
}

/// Warnings about the merged picture.
pub(super) fn warnings(passes: &[Pass]) -> Vec<String> {
    let has_crops = passes.iter().any(|pass| pass.parts.len() > 1);
    let first = passes[0].first();
    let is_denoised = first.attribute("denoised") == Some("true");
    let seams = (is_denoised && has_crops).then(|| {
        "the crops are denoised, each by its own pixels: seams between them may be seen".to_owned()
    });
    let view = first.view().is_none().then(|| {
        "there is no PNG: the parts do not tell fogbow:exposure and fogbow:view".to_owned()
    });
    seams.into_iter().chain(view).collect()
}
