//! Media that velocities carry to other times, and media between two frames.

use crate::math::Spectrum;
use crate::medium::{Albedo, Density, Emission, Medium, Ramped};
use crate::vdb::{self, Advection, Grid, Voxel};

/// `medium`, all of whose grids are carried.
pub(super) fn carried(mut medium: Medium, advection: &Advection<'_>) -> Result<Medium, String> {
    if advection.drift.is_none() || advection.frames == 0.0 {
        return Ok(medium);
    }
    match &mut medium.density {
        Density::Voxel(grid) => carry(grid, advection)?,
        Density::Ramped(ramped) => carry_ramped(ramped, advection)?,
        Density::Homogeneous(_) => {}
    }
    carry_albedo(&mut medium.albedo, advection)?;
    carry_emission(&mut medium.emission, advection)?;
    Ok(medium)
}

fn carry<V: Voxel>(grid: &mut Grid<V>, advection: &Advection<'_>) -> Result<(), String> {
    if let Advection { drift: Some(drift), frames } = *advection
        && frames != 0.0
    {
        *grid = drift.moved(grid.clone(), frames)?;
    }
    Ok(())
}

fn carry_ramped<V: Spectrum>(
    ramped: &mut Ramped<V>,
    advection: &Advection<'_>,
) -> Result<(), String> {
    let mut grid = ramped.grid().clone();
    carry(&mut grid, advection)?;
    *ramped = Ramped::new(grid, ramped.transfer().clone());
    Ok(())
}

fn carry_albedo(albedo: &mut Albedo, advection: &Advection<'_>) -> Result<(), String> {
    match albedo {
        Albedo::Color { grid, .. } => carry(grid, advection),
        Albedo::Scalar { grid, .. } => carry(grid, advection),
        Albedo::Ramped(ramped) => carry_ramped(ramped, advection),
        Albedo::Constant(_) => Ok(()),
    }
}

fn carry_emission(
    emission: &mut Option<Emission>,
    advection: &Advection<'_>,
) -> Result<(), String> {
    match emission {
        Some(Emission::Grid { grid, .. } | Emission::Blackbody { grid, .. }) => {
            carry(grid, advection)
        }
        Some(Emission::Ramped(ramped)) => carry_ramped(ramped, advection),
        Some(Emission::Density(_)) | None => Ok(()),
    }
}

/// The mean of the `media` of two frames, in which the second has this `share`, each where its advection brings it. Density and emission
/// add up; albedo and temperature are means by density, as of smoke that mixes.
pub(super) fn blended(
    media: [Medium; 2],
    advections: &[Advection<'_>; 2],
    share: f64,
) -> Result<Medium, String> {
    let [mut first, mut second] = media;
    let mean = Mean { advections, share };
    let densities = first.density.grid().cloned().zip(second.density.grid().cloned());
    let densities = densities.as_ref().map(|(first, second)| [first, second]);
    match (&mut first.albedo, &second.albedo) {
        (Albedo::Color { grid, .. }, Albedo::Color { grid: next, .. }) => {
            mean.of(grid, next, densities)?;
        }
        (Albedo::Scalar { grid, .. }, Albedo::Scalar { grid: next, .. }) => {
            mean.of(grid, next, densities)?;
        }
        (Albedo::Ramped(ramped), Albedo::Ramped(next)) => {
            mean.of_ramped(ramped, next, densities)?;
        }
        (Albedo::Constant(_), Albedo::Constant(_)) => {}
        // One frame has no grid of it.
        (albedo, _) if share < 0.5 => carry_albedo(albedo, &advections[0])?,
        _ => {
            carry_albedo(&mut second.albedo, &advections[1])?;
            first.albedo = second.albedo;
        }
    }
    first.emission = mean.of_emission([first.emission, second.emission], densities)?;
    match (&mut first.density, &second.density) {
        (Density::Voxel(grid), Density::Voxel(next)) => mean.of(grid, next, None)?,
        (Density::Ramped(ramped), Density::Ramped(next)) => mean.of_ramped(ramped, next, None)?,
        // A region, which has no frames.
        _ => {}
    }
    Ok(first)
}

/// A mean of two frames.
struct Mean<'a> {
    advections: &'a [Advection<'a>; 2],
    /// That of the second.
    share: f64,
}

impl Mean<'_> {
    /// Makes `grid` the mean of it and the `next`, by `densities` where they are given. A grid of a file for all frames stays.
    fn of<V: Voxel>(
        &self,
        grid: &mut Grid<V>,
        next: &Grid<V>,
        densities: Option<[&Grid<f32>; 2]>,
    ) -> Result<(), String> {
        if grid.identity() != next.identity() {
            *grid = vdb::blended([grid, next], self.advections, self.share, densities)?;
        }
        Ok(())
    }

    fn of_ramped<V: Spectrum>(
        &self,
        ramped: &mut Ramped<V>,
        next: &Ramped<V>,
        densities: Option<[&Grid<f32>; 2]>,
    ) -> Result<(), String> {
        let mut grid = ramped.grid().clone();
        self.of(&mut grid, next.grid(), densities)?;
        *ramped = Ramped::new(grid, ramped.transfer().clone());
        Ok(())
    }

    /// The mean of two emissions, of which either may be none.
    fn of_emission(
        &self,
        emissions: [Option<Emission>; 2],
        densities: Option<[&Grid<f32>; 2]>,
    ) -> Result<Option<Emission>, String> {
        let [onward, back] = self.advections;
        match emissions {
            [Some(mut first), Some(next)] => {
                match (&mut first, &next) {
                    (Emission::Grid { grid, .. }, Emission::Grid { grid: next, .. }) => {
                        self.of(grid, next, None)?;
                    }
                    (Emission::Blackbody { grid, .. }, Emission::Blackbody { grid: next, .. }) => {
                        self.of(grid, next, densities)?;
                    }
                    (Emission::Ramped(ramped), Emission::Ramped(next)) => {
                        self.of_ramped(ramped, next, None)?;
                    }
                    // In proportion to the density, which is a mean by itself.
                    _ => {}
                }
                Ok(Some(first))
            }
            [mut first, None] => {
                carry_emission(&mut first, onward)?;
                first.map(|emission| dimmed(emission, 1.0 - self.share)).transpose()
            }
            [None, mut next] => {
                carry_emission(&mut next, back)?;
                next.map(|emission| dimmed(emission, self.share)).transpose()
            }
        }
    }
}

/// `emission` times `factor`, up to 1; under a ramp the values of its grid, as where the other frame has zeros.
fn dimmed(mut emission: Emission, factor: f64) -> Result<Emission, String> {
    match &mut emission {
        Emission::Density(color) | Emission::Grid { color, .. } => *color *= factor,
        Emission::Blackbody { scale, .. } => *scale *= factor,
        Emission::Ramped(ramped) => {
            let (grid, stays) = (ramped.grid(), Advection { drift: None, frames: 0.0 });
            let zeros = vdb::emptied(grid);
            let grid = vdb::blended([grid, &zeros], &[stays; 2], 1.0 - factor, None)?;
            *ramped = Ramped::new(grid, ramped.transfer().clone());
        }
    }
    Ok(emission)
}
