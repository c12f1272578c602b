//! What noise adds to the flicker of a sequence.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, table, whole};

/// Flicker of a way of rendering with so many photons, less the smoke's own.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// The way: what directs rays and takes off noise, and whether strategies are those of the shot.
    pub way: String,
    /// Photons of a frame.
    pub photons: u64,
    /// With one seed for all frames, the mean over four seeds.
    pub one_seed: f64,
    /// With a seed a frame.
    pub seed_a_frame: f64,
    /// Of pictures with little noise: what the smoke itself does.
    pub smoke: f64,
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        vec![
            row.way.clone(),
            whole(row.photons as f64),
            decimals(row.one_seed, 3),
            decimals(row.seed_a_frame, 3),
            decimals(row.smoke, 3),
        ]
    });
    format!(
        "The mean over pixels of |L(t-1) - 2 L(t) + L(t+1)| over that of L, less the same of pictures \
         with little noise, which is the smoke's own; four frames of a gas simulation at 64 x 48 \
         pixels and 16 rays. Strategies are those of the shot where nothing else is said, as `--frames` has them.\n\n{}",
        table(&["way", "photons", "one seed", "a seed a frame", "the smoke's own"], lines)
    )
}
