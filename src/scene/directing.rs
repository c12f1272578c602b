//! How the director is asked to spend a picture's budget.

/// Who decides what a pixel may spend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Director {
    /// Every pixel gets the same.
    #[default]
    Fixed,
    /// The X-map alone: how much light survives the medium.
    X,
    /// The saliency map alone: what catches the eye.
    S,
    /// Both, combined as [`Directing`] says.
    Xs,
    /// No map: each pixel is sampled until its own error estimate is small, as Cycles and Arnold
    /// do. Stopping looks at the samples, so it is biased where those of the maps are not.
    Variance,
}

/// Names in scene files and on the command line.
const DIRECTORS: [(&str, Director); 5] = [
    ("fixed", Director::Fixed),
    ("x", Director::X),
    ("s", Director::S),
    ("xs", Director::Xs),
    ("variance", Director::Variance),
];

impl Director {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] = &DIRECTORS;

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// What the X-map says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Importance {
    /// Transmittance to the first surface, as in Anson et al. 2006.
    Transmittance,
    /// How uncertain the light is that will be seen, scattered light included, from a coarse look
    /// with few photons.
    #[default]
    Scattering,
}

impl Importance {
    /// Each by its name.
    pub const ALL: &[(&str, Self)] =
        &[("transmittance", Self::Transmittance), ("scattering", Self::Scattering)];

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// How X and S become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Operator {
    /// Weighed sum.
    #[default]
    Sum,
    /// Product of powers: X^w_x S^w_s.
    Product,
}

impl Operator {
    /// Each by its sign.
    pub const ALL: &[(&str, Self)] = &[("+", Self::Sum), ("*", Self::Product)];

    /// Its sign in scene files and on the command line.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// What is handed out by the XS-map; the rest is the same for all pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Directed {
    /// Camera rays.
    pub rays: bool,
    /// Gather radius of volume photons.
    pub radius: bool,
    /// March step.
    pub step: bool,
}

impl Directed {
    /// From the words `rays`, `radius` and `step` with commas between, or `nothing`.
    ///
    /// # Errors
    /// What would be right, where it is something else.
    pub fn parse(words: &str) -> Result<Self, String> {
        let mut directed = Self { rays: false, radius: false, step: false };
        for word in words.split(',').map(str::trim).filter(|word| *word != "nothing") {
            match word {
                "rays" => directed.rays = true,
                "radius" => directed.radius = true,
                "step" => directed.step = true,
                _ => return Err("some of rays, radius, step with commas between".into()),
            }
        }
        Ok(directed)
    }
}

impl std::fmt::Display for Directed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let all = [(self.rays, "rays"), (self.radius, "radius"), (self.step, "step")];
        let words: Vec<&str> = all.iter().filter(|(on, _)| *on).map(|(_, word)| *word).collect();
        f.write_str(if words.is_empty() { "nothing" } else { "" })?;
        f.write_str(&words.join(","))
    }
}

/// The most that gather radius and march step of unimportant pixels may be wider.
pub const MAX_COARSENING: f64 = 256.0;

/// Pixels of the maps over those of the film, along each side.
pub const RESOLUTIONS: std::ops::RangeInclusive<f64> = 0.0625..=4.0;

/// How the director is asked to spend a picture's budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directing {
    /// What the X-map says.
    pub x: Importance,
    /// Weight of X and of S in [`Director::Xs`].
    pub weights: [f64; 2],
    /// How they become one.
    pub operator: Operator,
    /// What is handed out.
    pub directed: Directed,
    /// Rays of the least important pixel, at most the ceiling.
    pub floor: u32,
    /// Gather radius of the least important pixel over that of the most important one.
    pub coarsest_radius: f64,
    /// March step of the least important pixel, in voxels.
    pub coarsest_step: f64,
    /// Standard error of a pixel over its mean at which [`Director::Variance`] ends it.
    pub tolerance: f64,
    /// Pixels of the maps over those of the film, along each side, in [`RESOLUTIONS`].
    pub resolution: f64,
}

impl Directing {
    /// Width and height of the maps for a film of `size`.
    pub fn map_size(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| ((f64::from(side) * self.resolution).round() as u32).max(1))
    }
}

/// The words of `all`.
pub(super) fn names<T>(all: &[(&'static str, T)]) -> Vec<&'static str> {
    all.iter().map(|(name, _)| *name).collect()
}

pub(super) fn name_of<T: PartialEq>(all: &[(&'static str, T)], one: T) -> &'static str {
    all.iter().find(|(_, other)| *other == one).map_or("", |(name, _)| *name)
}
