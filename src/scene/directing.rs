//! Settings of the director: which maps it makes, and what they direct.

/// What decides on the budget of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Director {
    /// Every pixel gets the same.
    #[default]
    Fixed,
    /// The X-map alone: how much light survives the medium.
    X,
    /// The saliency map alone: what catches the eye.
    S,
    /// XS: both, combined as [`Directing`] says.
    Xs,
    /// XS as Anson et al. 2006 made it for their timings: X from transmittance, equal weights, their sum, rays alone.
    XsPaper,
    /// No map: each pixel gets the rays that bring its error to a tolerance, by the variance of a pilot's
    /// rays, which are not kept. Cycles and Arnold stop by the samples that they keep, which is biased.
    Variance,
}

/// Names in scene files and on the command line.
const DIRECTORS: [(&str, Director); 6] = [
    ("fixed", Director::Fixed),
    ("x", Director::X),
    ("s", Director::S),
    ("xs", Director::Xs),
    ("xs-paper", Director::XsPaper),
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

/// What the X-map measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Importance {
    /// Transmittance to the first surface, as in Anson et al. 2006.
    Transmittance,
    /// Deviation of the light that is seen, scattered light included, measured in a pilot with few photons.
    Scattering,
    /// Error that rays leave after reconstruction, measured in the picture's first rays.
    #[default]
    Error,
}

impl Importance {
    /// How it is combined with S where nothing is said.
    pub const fn default_operator(self) -> Operator {
        match self {
            Self::Transmittance | Self::Scattering => Operator::Sum,
            Self::Error => Operator::Tolerance,
        }
    }

    /// What XS directs where nothing is said. The error of rays does not tell where a larger radius or step does no harm.
    pub const fn default_directed(self) -> Directed {
        match self {
            Self::Transmittance | Self::Scattering => Directed::ALL,
            Self::Error => Directed::RAYS,
        }
    }

    /// Each by its name.
    pub const ALL: &[(&str, Self)] = &[
        ("transmittance", Self::Transmittance),
        ("scattering", Self::Scattering),
        ("error", Self::Error),
    ];

    /// Its name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// How X and S are combined to XS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// Weighed sum.
    Sum,
    /// Product of powers: X^w_x S^w_s.
    Product,
    /// A power of X over the error that passes where S is low: X^w_x / (1 + w_s (1 - S)).
    Tolerance,
}

impl Operator {
    /// Weights of X and S where none are given.
    pub const fn default_weights(self) -> [f64; 2] {
        match self {
            Self::Sum | Self::Product => [0.5, 0.5],
            Self::Tolerance => [1.0, 0.5],
        }
    }

    /// Each by its sign.
    pub const ALL: &[(&str, Self)] =
        &[("+", Self::Sum), ("*", Self::Product), ("tolerance", Self::Tolerance)];

    /// Its sign in scene files and on the command line.
    pub fn name(self) -> &'static str {
        name_of(Self::ALL, self)
    }
}

/// Parts of the budget that the XS-map directs; the others are the same for all pixels.
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
    /// All three.
    pub const ALL: Self = Self { rays: true, radius: true, step: true };

    /// Camera rays alone.
    pub const RAYS: Self = Self { rays: true, radius: false, step: false };

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

/// Largest ratio of the coarsest gather radius or march step to the finest.
pub const MAX_COARSENING: f64 = 256.0;

/// Range of the ratio of the maps' pixels to the film's, along each side.
pub const RESOLUTIONS: std::ops::RangeInclusive<f64> = 0.0625..=4.0;

/// Settings of the director.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directing {
    /// What the X-map measures.
    pub x: Importance,
    /// Weight of X and of S in [`Director::Xs`].
    pub weights: [f64; 2],
    /// How X and S are combined.
    pub operator: Operator,
    /// What XS directs.
    pub directed: Directed,
    /// Rays of the least important pixel, at most the ceiling.
    pub floor: u32,
    /// Ratio of the gather radius of the least important pixel to the most important one's.
    pub coarsest_radius: f64,
    /// March step of the least important pixel, in voxels.
    pub coarsest_step: f64,
    /// Ratio of standard error to mean of a pixel for which [`Director::Variance`] gives it rays.
    pub tolerance: f64,
    /// Ratio of the maps' pixels to the film's, along each side, in [`RESOLUTIONS`].
    pub resolution: f64,
}

impl Directing {
    /// The same by this `x`, with what goes with it where nothing is said.
    #[must_use]
    pub fn by(self, x: Importance) -> Self {
        let operator = x.default_operator();
        let (weights, directed) = (operator.default_weights(), x.default_directed());
        Self { x, operator, weights, directed, ..self }
    }

    /// These settings as `director` takes them.
    #[must_use]
    pub fn of(self, director: Director) -> Self {
        let alone = |weights| Self { weights, operator: Operator::Sum, ..self };
        match director {
            Director::X => alone([1.0, 0.0]),
            Director::S => alone([0.0, 1.0]),
            Director::XsPaper => {
                Self { x: Importance::Transmittance, directed: Directed::RAYS, ..alone([0.5, 0.5]) }
            }
            Director::Fixed | Director::Xs | Director::Variance => self,
        }
    }

    /// Width and height of the maps for a film of `size`.
    pub fn map_size(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| ((f64::from(side) * self.resolution).round() as u32).max(1))
    }
}

/// The names in `all`.
pub(super) fn names<T>(all: &[(&'static str, T)]) -> Vec<&'static str> {
    all.iter().map(|(name, _)| *name).collect()
}

pub(super) fn name_of<T: PartialEq>(all: &[(&'static str, T)], one: T) -> &'static str {
    all.iter().find(|(_, other)| *other == one).map_or("", |(name, _)| *name)
}
