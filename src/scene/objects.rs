//! Objects of a scene, by the names that Cryptomatte tells.

use std::collections::BTreeSet;
use std::path::Path;

use crate::image::cryptomatte;

/// What a medium or a surface is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ObjectName {
    /// By its scene. Objects of the same name are one.
    Given(String),
    /// By its kind or its file, with a number where others are called so, too.
    Chosen(String),
}

impl ObjectName {
    /// The name that was `given`, or one by the `file` that a scene names, without the number of a frame, or by the `kind`.
    pub(super) fn new(given: Option<String>, file: Option<&str>, kind: &str) -> Self {
        let stem = file.and_then(|file| Path::new(file).file_stem());
        let stem = stem.map(|stem| plain(&stem.to_string_lossy()));
        let chosen = || stem.filter(|stem| !stem.is_empty()).unwrap_or_else(|| kind.to_owned());
        given.map_or_else(|| Self::Chosen(chosen()), Self::Given)
    }
}

/// The name `stem` of a file without the place of a frame's number at its end.
fn plain(stem: &str) -> String {
    let printed = stem.rfind('%').filter(|at| {
        let rest = &stem[at + 1..];
        rest.strip_suffix('d').is_some_and(|digits| digits.bytes().all(|b| b.is_ascii_digit()))
    });
    let stem = printed.map_or_else(|| stem.trim_end_matches('#'), |at| &stem[..at]);
    stem.trim_end_matches(['_', '.', '-', ' ']).to_owned()
}

/// The objects of a scene; none where no picture asks for them.
#[derive(Debug, Clone, Default)]
pub struct Objects {
    names: BTreeSet<String>,
    /// The [identifier](cryptomatte::identifier) of each medium.
    media: Vec<u32>,
    /// Of each surface the identifiers of its parts, with the first triangle of each.
    surfaces: Vec<Vec<(u32, u32)>>,
}

impl Objects {
    /// Those of `media`, then of surfaces: each has a name, and parts by its first triangles, which have names of their own, where
    /// there are any.
    pub(super) fn new<'n>(
        media: impl Iterator<Item = &'n ObjectName>,
        surfaces: impl Iterator<Item = (&'n ObjectName, &'n [(u32, String)])> + Clone,
    ) -> Self {
        let media: Vec<_> = media.collect();
        let mut names = BTreeSet::new();
        // Those that are chosen give way.
        for name in media.iter().copied().chain(surfaces.clone().map(|(name, _)| name)) {
            if let ObjectName::Given(name) = name {
                names.insert(name.clone());
            }
        }
        let has_parts = |(name, _): &(&ObjectName, _)| matches!(name, ObjectName::Chosen(_));
        let parts = surfaces.clone().filter(has_parts).flat_map(|(_, parts)| parts);
        names.extend(parts.map(|(_, name)| name.clone()));
        let mut identifier = |name: &ObjectName| match name {
            ObjectName::Given(name) => cryptomatte::identifier(name),
            ObjectName::Chosen(name) => {
                let numbered = (2..).map(|number| format!("{name}_{number}"));
                let mut free = [name.clone()].into_iter().chain(numbered);
                let name = free.find(|name| !names.contains(name)).unwrap_or_default();
                let identifier = cryptomatte::identifier(&name);
                names.insert(name);
                identifier
            }
        };
        let media = media.into_iter().map(&mut identifier).collect();
        let part = |(first, name): &(u32, String)| (*first, cryptomatte::identifier(name));
        let of_surface = |(name, parts): (&ObjectName, &[(u32, String)])| match (name, parts) {
            (ObjectName::Chosen(_), [_, ..]) => parts.iter().map(part).collect(),
            _ => vec![(0, identifier(name))],
        };
        let surfaces = surfaces.map(of_surface).collect();
        Self { names, media, surfaces }
    }

    /// The names of all.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// The identifier of a medium by its index.
    pub fn medium(&self, index: usize) -> Option<u32> {
        self.media.get(index).copied()
    }

    /// The identifier of a triangle of a surface, both by their indices.
    pub fn surface(&self, index: u32, triangle: u32) -> Option<u32> {
        let parts = self.surfaces.get(index as usize)?;
        let next = parts.partition_point(|(first, _)| *first <= triangle);
        parts.get(next.checked_sub(1)?).map(|(_, identifier)| *identifier)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_give_names_without_frames() {
        for (file, expected) in [
            ("a/smoke.vdb", "smoke"),
            ("smoke_####.vdb", "smoke"),
            ("smoke.%04d.vdb", "smoke"),
            ("%d.vdb", "kind"),
            ("smoke_0001.vdb", "smoke_0001"),
            ("100%.ply", "100%"),
        ] {
            let name = ObjectName::new(None, Some(file), "kind");
            assert_eq!(name, ObjectName::Chosen(expected.into()), "{file}");
        }
        let given = ObjectName::new(Some("x".into()), Some("smoke.vdb"), "kind");
        assert_eq!(given, ObjectName::Given("x".into()));
    }

    #[test]
    fn chosen_names_are_each_of_one_object() {
        let given = |name: &str| ObjectName::Given(name.into());
        let chosen = |name: &str| ObjectName::Chosen(name.into());
        let media = [chosen("sphere"), given("smoke")];
        let surfaces = [
            (chosen("sphere"), vec![]),
            (given("smoke"), vec![]),
            (given("sphere"), vec![]),
            (chosen("mesh"), vec![(0, "/a".to_owned()), (4, "/b".to_owned())]),
            (given("told"), vec![(0, "/a".to_owned())]),
        ];
        let of_surfaces = surfaces.iter().map(|(name, parts)| (name, parts.as_slice()));
        let objects = Objects::new(media.iter(), of_surfaces);
        let names: Vec<_> = objects.names().collect();
        assert_eq!(names, ["/a", "/b", "smoke", "sphere", "sphere_2", "sphere_3", "told"]);
        let id = |name: &str| Some(cryptomatte::identifier(name));
        assert_eq!(
            [0, 1, 2].map(|index| objects.medium(index)),
            [id("sphere_2"), id("smoke"), None]
        );
        let surface = |index, triangle| objects.surface(index, triangle);
        assert_eq!(surface(0, 5), id("sphere_3"));
        assert_eq!([surface(1, 0), surface(2, 0)], [id("smoke"), id("sphere")]);
        assert_eq!([surface(3, 3), surface(3, 4), surface(3, 9)], [id("/a"), id("/b"), id("/b")]);
        assert_eq!([surface(4, 7), surface(5, 0)], [id("told"), None]);
    }
}
