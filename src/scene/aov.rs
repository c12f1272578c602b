//! Passes that a picture may have beside its own layers: arbitrary output variables (AOVs).

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use crate::math::ORDERS;

/// A pass, of one layer or several.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aov {
    /// Distances at which the opacity of media and surfaces begins, is on average and ends.
    Depth,
    /// Albedo, as a denoiser has it.
    Albedo,
    /// Shading normals of surfaces, as a denoiser has them.
    Normal,
    /// Where opacity is on average.
    Position,
    /// How far what is there moves in the picture in a frame.
    Motion,
    /// Light that media before the first surface scatter or emit.
    Media,
    /// Light that the first surface reflects straight from lights.
    Direct,
    /// Light of photons that the first surface reflects.
    Indirect,
    /// Emission of surfaces and the environment, without a mirror between.
    Emission,
    /// All other light: what mirrors and glass show.
    Specular,
    /// Which objects are seen, and how much of each.
    Cryptomatte,
    /// Light of each group of emitters, which is of all kinds above.
    Groups,
    /// Light of media by the order of its scattering.
    Scattered,
}

impl Aov {
    /// Each by its name, which its layers begin with.
    pub const ALL: &[(&str, Self)] = &[
        ("depth", Self::Depth),
        ("albedo", Self::Albedo),
        ("normal", Self::Normal),
        ("position", Self::Position),
        ("motion", Self::Motion),
        ("media", Self::Media),
        ("direct", Self::Direct),
        ("indirect", Self::Indirect),
        ("emission", Self::Emission),
        ("specular", Self::Specular),
        ("cryptomatte", Self::Cryptomatte),
        ("groups", Self::Groups),
        ("scattered", Self::Scattered),
    ];

    /// What the parts of the pass of scattered light are called: as media emit it, of the orders 1 and above, toward the camera.
    pub const ORDERS: [&str; ORDERS] = ["emitted", "first", "more"];

    /// Those that add up to the picture, in the order in which they are stored.
    pub const LIGHT: [Self; 5] =
        [Self::Media, Self::Direct, Self::Indirect, Self::Emission, Self::Specular];

    /// What its layers are called behind its name.
    pub const fn channels(self) -> [&'static str; 3] {
        match self {
            Self::Depth => ["first", "mean", "last"],
            Self::Normal | Self::Position | Self::Motion => ["X", "Y", "Z"],
            _ => ["R", "G", "B"],
        }
    }

    /// Its name in scene files, on the command line and before its channels.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, aov)| *aov == self).map_or("", |(name, _)| name)
    }

    /// The names of its layers, where it has several parts those of `part`; Cryptomatte has layers of its own.
    pub fn layers(self, part: &str) -> [String; 3] {
        let name = match self {
            Self::Groups => format!("group.{part}"),
            Self::Scattered => format!("scattered.{part}"),
            _ => self.name().into(),
        };
        self.channels().map(|channel| format!("{name}.{channel}"))
    }

    const fn bit(self) -> u16 {
        1 << self as u16
    }
}

/// The passes that a picture has.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct Aovs(u16);

impl Aovs {
    /// Whether it has none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether `aov` is among them.
    pub const fn has(self, aov: Aov) -> bool {
        self.0 & aov.bit() != 0
    }

    /// All of them, in one order.
    pub fn iter(self) -> impl Iterator<Item = Aov> {
        Aov::ALL.iter().map(|(_, aov)| *aov).filter(move |aov| self.has(*aov))
    }

    /// Those of them that are light.
    pub fn light(self) -> impl Iterator<Item = Aov> {
        self.iter().filter(|aov| Aov::LIGHT.contains(aov))
    }

    /// Whether some are light.
    pub fn has_light(self) -> bool {
        self.light().next().is_some()
    }

    /// Whether some have the parts of light that spectra tell apart, by group or by order.
    pub const fn has_parts(self) -> bool {
        self.has(Aov::Groups) || self.has(Aov::Scattered)
    }

    /// Whether some follow from where opacity is.
    pub const fn has_depths(self) -> bool {
        self.has(Aov::Depth) || self.has(Aov::Position) || self.has(Aov::Motion)
    }

    /// Whether some are features of a denoiser.
    pub const fn has_features(self) -> bool {
        self.has(Aov::Albedo) || self.has(Aov::Normal)
    }
}

impl FromIterator<Aov> for Aovs {
    fn from_iter<T: IntoIterator<Item = Aov>>(aovs: T) -> Self {
        Self(aovs.into_iter().fold(0, |bits, aov| bits | aov.bit()))
    }
}

impl Display for Aovs {
    /// As they are parsed.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.iter().map(Aov::name).collect::<Vec<_>>().join(","))
    }
}

impl fmt::Debug for Aovs {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "Aovs({self})")
    }
}

impl FromStr for Aovs {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let aov = |name: &str| {
            let known = Aov::ALL.iter().find(|(known, _)| *known == name.trim());
            known.map(|(_, aov)| *aov).ok_or_else(|| name.trim().to_owned())
        };
        if text.trim().is_empty() {
            return Ok(Self::default());
        }
        let aovs = text.split(',').map(aov).collect::<Result<Self, String>>().map_err(|name| {
            let names: Vec<_> = Aov::ALL.iter().map(|(name, _)| *name).collect();
            format!("there is no pass \"{name}\"; give some of {}", names.join(", "))
        })?;
        if aovs.has(Aov::Groups) && aovs.has(Aov::Scattered) {
            return Err(
                "one picture does not have the passes groups and scattered; leave one of them out"
                    .into(),
            );
        }
        Ok(aovs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_written_as_they_are_read() {
        let read = |text: &str| text.parse::<Aovs>();
        assert_eq!(read("").unwrap(), Aovs::default());
        assert_eq!(read("normal, depth").unwrap().to_string(), "depth,normal");
        let all = Aov::ALL.iter().map(|(_, aov)| *aov).filter(|aov| *aov != Aov::Scattered);
        let all: Aovs = all.collect();
        assert_eq!(read(&all.to_string()), Ok(all));
        assert!(read("depth,,albedo").unwrap_err().contains("no pass \"\""));
        let wrong = read("depth,beauty").unwrap_err();
        assert!(wrong.starts_with("there is no pass \"beauty\"; give some of depth, albedo"));
        assert!(all.light().eq(Aov::LIGHT));
        assert_eq!(read("scattered,media").unwrap().to_string(), "media,scattered");
        assert!(read("scattered,media,groups").unwrap_err().contains("leave one of them out"));
    }

    #[test]
    fn layers_have_usual_names() {
        assert_eq!(Aov::Depth.layers(""), ["depth.first", "depth.mean", "depth.last"]);
        assert_eq!(Aov::Normal.layers(""), ["normal.X", "normal.Y", "normal.Z"]);
        assert_eq!(Aov::Media.layers(""), ["media.R", "media.G", "media.B"]);
        assert_eq!(Aov::Groups.layers("key"), ["group.key.R", "group.key.G", "group.key.B"]);
        let [first, ..] = Aov::Scattered.layers("first");
        assert_eq!(first, "scattered.first.R");
    }
}
