//! Groups of emitters, or orders of scattering.

use crate::error::Result;
use crate::math::{Group, MAX_GROUPS, Rgb};
use crate::scene::file::SceneFile;
use crate::scene::reader::Place;
use crate::scene::{Aov, GroupName, GroupNames, Groups};

/// The group of emitters that name none.
const REST: &str = "rest";

/// The groups of `file`, and that of each of its media; or orders in place of them, where the film asks for those.
pub(super) fn build(file: &SceneFile) -> Result<(Groups, Vec<Group>)> {
    let mut names = GroupNames::default();
    let rest = GroupName::new(REST).unwrap_or_default();
    let mut group = |name: Option<GroupName>, at: &Place| {
        names.group(name.unwrap_or(rest)).ok_or_else(|| {
            at.error(format!(
                "it is in one group more than the {MAX_GROUPS} that a scene can have, of which \"{REST}\" holds what is in \
                 no other; give `group` the name of another"
            ))
        })
    };
    let shines = |radiance: Option<Rgb>| radiance.is_some_and(|radiance| radiance != Rgb::ZERO);
    let mut lights = Vec::new();
    for light in &file.lights {
        lights.push(group(light.group, &light.at)?);
    }
    for surface in file.surfaces.iter().filter(|surface| shines(surface.emission)) {
        lights.push(group(surface.group, &surface.at)?);
    }
    let mut media = Vec::new();
    for medium in &file.media {
        let glows = medium.emission.is_some();
        media.push(if glows { group(medium.group, &medium.at)? } else { Group::default() });
    }
    if file.film.passes.has(Aov::Scattered) {
        return Ok((Groups::orders(), Vec::new()));
    }
    Ok((Groups::new(names, lights), media))
}
