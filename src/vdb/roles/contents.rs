//! What a file holds.

use crate::error::Result;
use crate::vdb::{Grid, ReadAs, VdbFile};

use super::fire::{self, Fire};
use super::names::{Role, role_of};
use super::overlap::Smoke;
use super::triples::{GridRef, triples};
use super::up::{self, Axis};

/// What the grids of a file are to a renderer.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Contents {
    /// The density, a scalar.
    pub density: GridRef,
    /// What glows; nothing where nothing does.
    pub fire: Option<Fire>,
    /// The colour of the smoke, a vector to be read by [`VdbFile::read_color`]; nothing where it is
    /// black everywhere.
    pub color: Option<GridRef>,
    /// The velocity, a vector.
    pub velocity: Option<GridRef>,
    /// The axis that is up, and how that is known; nothing where it cannot be told.
    pub up: Option<(Axis, &'static str)>,
    /// What a user should know of these choices, one line each.
    pub notes: Vec<String>,
}

impl Contents {
    /// The roles of the grids of `file`, with its [default density](VdbFile::default_density).
    ///
    /// # Errors
    /// Where there is no density, or a grid that has to be looked at cannot be read.
    pub fn find(file: &VdbFile) -> Result<Self> {
        let index = file.default_density()?;
        Self::with_density(file, index, &file.read_scalar(index, ReadAs::Density)?)
    }

    /// As [`find`](Self::find), for a density that is chosen and read already. Besides it only grids are
    /// read whose names let them glow, colour the smoke or, where names do not tell which way is up,
    /// move it.
    ///
    /// # Errors
    /// Where there is no grid `index`, or one that has to be looked at cannot be read.
    pub fn with_density(file: &VdbFile, index: usize, density: &Grid<f32>) -> Result<Self> {
        file.info(index)?;
        let smoke = Smoke::sampled(density);
        let mut notes = Vec::new();
        let mut noted = |grid: GridRef| {
            notes.extend(file.ambiguity(&grid));
            grid
        };
        let density = noted(file.reference(index));
        let color = vector(file, Role::Color).map(&mut noted);
        let velocity = vector(file, Role::Velocity).map(&mut noted);
        let color = match color {
            Some(grid) if file.read_vector_of(&grid)?.max_value() <= 0.0 => {
                let path = file.path().display();
                let label = grid.label();
                notes.push(format!("{path}: grid \"{label}\" is black everywhere; it is not used"));
                None
            }
            color => color,
        };
        let fire = fire::find(file, &smoke, &mut notes)?;
        if let Some(fire) = &fire {
            notes.extend(file.ambiguity(&fire.grid));
        }
        let up = match up::by_names(file.grids().iter().map(|grid| grid.name.as_str())) {
            Some(up) => Some(up),
            None => match &velocity {
                Some(grid) => smoke
                    .motion(&file.read_vector_of(grid)?)
                    .and_then(|(mean, speed)| up::by_motion(mean, speed)),
                None => None,
            },
        };
        Ok(Self { density, fire, color, velocity, up, notes })
    }

    /// What grid number `index` of the file is taken for; nothing where it is not used.
    pub fn role(&self, index: usize) -> Option<Role> {
        let is = |grid: &GridRef| grid.indices().contains(&index);
        let fire = self.fire.as_ref().map(|fire| &fire.grid);
        let roles = [
            (Some(&self.density), Role::Density),
            (fire, Role::Fire),
            (self.color.as_ref(), Role::Color),
            (self.velocity.as_ref(), Role::Velocity),
        ];
        roles.into_iter().find(|(grid, _)| grid.is_some_and(is)).map(|(_, role)| role)
    }
}

/// The vector grid of that role which the table of names prefers; of one name a whole grid before
/// three scalar ones.
fn vector(file: &VdbFile, role: Role) -> Option<GridRef> {
    let rank = |name: &str| role_of(name).filter(|(known, _)| *known == role).map(|(_, rank)| rank);
    let grids = file.grids().iter().enumerate();
    let whole = grids
        .filter(|(_, grid)| grid.is_vector())
        .filter_map(|(i, grid)| Some((rank(&grid.name)?, file.reference(i))));
    let parted =
        triples(file.grids()).into_iter().filter_map(|grid| Some((rank(grid.label())?, grid)));
    whole.chain(parted).min_by_key(|(rank, _)| *rank).map(|(_, grid)| grid)
}
