//! What a picture may tell light apart by: groups of emitters, or orders of scattering.

use std::fmt::{self, Debug, Formatter};

use crate::math::{Group, MAX_GROUPS, RayParts, Spectrum};

/// The longest name of a group.
///
/// Unit: bytes. Limit: on the names of layers: `group.NAME.R` fits the 31 bytes that old readers of EXR take.
const LONGEST: usize = 23;

/// The name of a group: letters, digits, `_` and `-`.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct GroupName {
    bytes: [u8; LONGEST],
    length: u8,
}

impl GroupName {
    /// What names there are.
    pub(super) const RIGHT: &str = "a name of at most 23 letters (a to z), digits, _ and -";

    /// The name `text`; `None` where that is none.
    pub fn new(text: &str) -> Option<Self> {
        let is_right = |byte: u8| byte.is_ascii_alphanumeric() || b"_-".contains(&byte);
        if text.is_empty() || text.len() > LONGEST || !text.bytes().all(is_right) {
            return None;
        }
        let mut bytes = [0; LONGEST];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Some(Self { bytes, length: text.len() as u8 })
    }

    /// The name as text.
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl Debug for GroupName {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Debug::fmt(self.as_str(), f)
    }
}

/// The names of the groups of a scene, by [index](Group).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GroupNames {
    names: [GroupName; MAX_GROUPS],
    count: u8,
}

impl GroupNames {
    /// Each name in turn.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.names[..self.len()].iter().map(GroupName::as_str)
    }

    /// How many there are.
    pub const fn len(&self) -> usize {
        self.count as usize
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The group called `name`, which becomes one where it is none; `None` where there are too many.
    pub(super) fn group(&mut self, name: GroupName) -> Option<Group> {
        let known = self.names[..self.len()].iter().position(|known| *known == name);
        let index = known.unwrap_or(self.len());
        *self.names.get_mut(index)? = name;
        self.count = self.count.max(index as u8 + 1);
        Some(Group(index as u8))
    }
}

/// The groups of a scene, and which of them each of its emitters is in; or that light is told apart by the order of its
/// scattering, which begins in group 0 wherever it is emitted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Groups {
    /// Their names.
    pub names: GroupNames,
    /// The group of each light: those of `[[light]]`, then surfaces that shine.
    lights: Vec<Group>,
    /// Whether light is told apart by order.
    by_order: bool,
}

impl Groups {
    /// Those of these `names`, with the groups of all lights.
    pub(super) const fn new(names: GroupNames, lights: Vec<Group>) -> Self {
        Self { names, lights, by_order: false }
    }

    /// No groups, but [orders](crate::math::ORDERS) of scattering.
    pub(super) fn orders() -> Self {
        Self { by_order: true, ..Self::default() }
    }

    /// `light` after a medium has scattered it.
    pub fn scattered<S: Spectrum>(&self, light: S) -> S {
        if self.by_order { light.raised(1) } else { light }
    }

    /// `light` after a surface has reflected or refracted it.
    pub fn reflected<S: Spectrum>(&self, light: S) -> S {
        if self.by_order { light.raised(2) } else { light }
    }

    /// The parts that the picture tells apart of what a camera ray brings, of which `components` are light of media, direct
    /// and indirect light of surfaces and visible emission: parts of `all` light by group, or of that of media by order.
    pub fn told_apart<S: Spectrum>(&self, all: S, components: [S; 4]) -> Option<RayParts> {
        let [media, surfaces @ ..] = components;
        let all = if self.by_order { media } else { all }.parts()?;
        let of_surfaces =
            |light: S| if self.by_order { None } else { light.parts() }.unwrap_or_default();
        let [direct, indirect, emission] = surfaces.map(of_surfaces);
        Some(RayParts { all, media: media.parts()?, direct, indirect, emission })
    }

    /// The group of the light of this index.
    pub fn of_light(&self, index: usize) -> Group {
        self.lights.get(index).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_letters_digits_and_two_marks() {
        for name in ["key", "Rim_2", "a-b", &"x".repeat(LONGEST)] {
            assert_eq!(GroupName::new(name).unwrap().as_str(), name);
        }
        for name in ["", "a b", "a.b", "größe", &"x".repeat(LONGEST + 1)] {
            assert_eq!(GroupName::new(name), None, "{name}");
        }
    }

    #[test]
    fn groups_are_numbered_in_order() {
        let mut names = GroupNames::default();
        let name = |index: usize| GroupName::new(&format!("g{index}")).unwrap();
        for index in (0..MAX_GROUPS).chain(0..MAX_GROUPS) {
            assert_eq!(names.group(name(index)), Some(Group(index as u8)));
        }
        assert_eq!(names.group(name(MAX_GROUPS)), None);
        assert_eq!(names.iter().last(), Some("g7"));
    }
}
