//! The grid that a user or a scene means.

use crate::error::{Error, Result, nearest};
use crate::vdb::{GridInfo, VdbFile};

use super::names::{Role, role_of};
use super::triples::{GridRef, triple, triples};

impl VdbFile {
    /// The grid to take for density where none is named: the one that [`NAMES`](super::NAMES) prefer,
    /// else the only scalar fog volume without another role, else the only scalar fog volume.
    ///
    /// # Errors
    /// Where neither is there; the message lists what is.
    pub fn default_density(&self) -> Result<usize> {
        let grids = || self.grids().iter().enumerate();
        // A density that cannot be used is found too where nothing else is: reading it says why.
        let unusable = |grid: &GridInfo| !grid.is_scalar() || grid.is_level_set();
        let named = grids()
            .filter_map(|(i, grid)| match role_of(&grid.name)? {
                (Role::Density, rank) => Some((unusable(grid), rank, i)),
                _ => None,
            })
            .min();
        if let Some((false, _, index)) = named {
            return Ok(index);
        }
        let fog = |wanted: &dyn Fn(Option<Role>) -> bool| {
            let is_wanted = |grid: &GridInfo| {
                let role = role_of(&grid.name).map(|(role, _)| role);
                grid.class == "fog volume" && grid.is_scalar() && wanted(role)
            };
            grids().filter(|(_, grid)| is_wanted(grid)).map(|(i, _)| i).collect::<Vec<_>>()
        };
        let any = fog(&|role| role != Some(Role::Other));
        match (&fog(&|role| role.is_none())[..], &any[..], named) {
            (&[only], ..) | (_, &[only], _) => Ok(only),
            (.., Some((_, _, index))) => Ok(index),
            (_, [], _) => Err(self.no_choice("has no grid called \"density\" and no fog volume")),
            _ => Err(self.no_choice(
                "has no grid called \"density\" and several fog volumes; name one of them",
            )),
        }
    }

    /// The vector grid, or the three scalar grids, to take for velocities where none is named: of those with a usual name the
    /// one that [`NAMES`](super::NAMES) prefer.
    pub fn default_velocity(&self) -> Option<GridRef> {
        let vectors = (0..self.grids().len()).filter(|&i| self.grids()[i].is_vector());
        let all = vectors.map(|i| (self.grids()[i].name.clone(), self.reference(i)));
        let triples = triples(self.grids());
        let all = all.chain(triples.into_iter().map(|triple| (triple.label().to_owned(), triple)));
        let ranked = all.filter_map(|(name, grid)| match role_of(&name)? {
            (Role::Velocity, rank) => Some((rank, grid)),
            _ => None,
        });
        ranked.min_by_key(|(rank, _)| *rank).map(|(_, grid)| grid)
    }

    /// The grid of this name; where several share it, the one of this occurrence, counted from 0,
    /// or the first.
    ///
    /// # Errors
    /// Where there is none; the message lists what there is, and names one that is nearly the same.
    pub fn find(&self, name: &str, occurrence: Option<usize>) -> Result<usize> {
        let wanted = occurrence.unwrap_or(0);
        let named = self.named(name);
        match named.get(wanted) {
            Some(&i) => Ok(i),
            None if named.is_empty() => Err(self.unknown(name)),
            None => Err(self.no_choice(&format!(
                "has {} of the name \"{name}\", counted from 0, so none with index {wanted}",
                named.len()
            ))),
        }
    }

    /// As [`find`](Self::find), but three scalar grids such as `vel.x`, `vel.y` and `vel.z` are found
    /// by what their names have in common. A grid of that very name wins.
    ///
    /// # Errors
    /// As [`find`](Self::find).
    pub fn find_vector(&self, name: &str, occurrence: Option<usize>) -> Result<GridRef> {
        if self.named(name).is_empty()
            && let Some(triple) = triple(self.grids(), name)
        {
            return Ok(triple);
        }
        Ok(self.reference(self.find(name, occurrence)?))
    }

    /// What a user who asked for `name` should know of how `taken` was chosen: that several grids
    /// share the name, or that three more make up a vector of it.
    pub fn ambiguity(&self, taken: &GridRef) -> Option<String> {
        let GridRef::Single { index, label } = taken else { return None };
        let name = &self.grids()[*index].name;
        let named = self.named(name);
        if named.len() > 1 {
            return Some(format!(
                "{}: {} grids are called \"{name}\"; \"{label}\" is taken, and `index` names another",
                self.path().display(),
                named.len()
            ));
        }
        let GridRef::Triple { indices, .. } = triple(self.grids(), name)? else { return None };
        let parts = indices.map(|i| format!("\"{}\"", self.grids()[i].label()));
        Some(format!(
            "{}: grid \"{label}\" is taken, and not the three grids {}",
            self.path().display(),
            parts.join(", ")
        ))
    }

    fn named(&self, name: &str) -> Vec<usize> {
        (0..self.grids().len()).filter(|&i| self.grids()[i].name == name).collect()
    }

    /// The error that there is no grid `name`.
    fn unknown(&self, name: &str) -> Error {
        let triples = triples(self.grids());
        let parts = triple(self.grids(), name);
        let mut known: Vec<&str> = self.grids().iter().map(|grid| grid.name.as_str()).collect();
        known.extend(triples.iter().map(GridRef::label));
        let hint = match (parts, nearest(name, &known)) {
            (Some(_), _) => ", only its three components; name one of them".to_owned(),
            (None, Some(near)) => format!("; did you mean \"{near}\"?"),
            (None, None) => String::new(),
        };
        self.no_choice(&format!("has no grid called \"{name}\"{hint}"))
    }

    fn no_choice(&self, problem: &str) -> Error {
        let describe = |g: &GridInfo| format!("\"{}\" ({}, {})", g.label(), g.value_type, g.class);
        let list: Vec<_> = self.grids().iter().map(describe).collect();
        let list = if list.is_empty() {
            "no grids at all; write it anew with a density".into()
        } else {
            list.join(", ")
        };
        Error::file(self.path(), format!("{problem}; it holds {list}"))
    }
}
