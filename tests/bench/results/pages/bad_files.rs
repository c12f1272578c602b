//! What becomes of damaged OpenVDB files.

use serde::{Deserialize, Serialize};

use super::markdown::{decimals, table, whole};

/// Files by how a render of them ended.
#[derive(Debug, Serialize, Deserialize)]
pub struct Row {
    /// All of them.
    pub tried: u64,
    /// In one line that names the file.
    pub refused: u64,
    /// With a picture.
    pub rendered: u64,
    /// With neither.
    pub unclear: u64,
    /// By a signal.
    pub crashed: u64,
    /// Not within 30 s.
    pub hung: u64,
    /// The most memory over the file's size, or 64 KiB, where it was refused.
    pub memory_refused: f64,
    /// The same where it was rendered.
    pub memory_rendered: f64,
    /// MiB that a run takes on a tiny sound file, which those ratios leave out.
    pub sound_mib: f64,
}

/// The table.
pub fn tables(rows: &[Row]) -> String {
    let lines = rows.iter().map(|row| {
        let counts = [row.tried, row.refused, row.rendered, row.unclear, row.crashed, row.hung];
        let ratios = [row.memory_refused, row.memory_rendered];
        counts
            .map(|count| whole(count as f64))
            .into_iter()
            .chain(ratios.map(|ratio| decimals(ratio, 1)))
            .chain([decimals(row.sound_mib, 0)])
            .collect()
    });
    format!(
        "Damaged, hostile and unusable files made from the shipped ones. Memory is the peak beyond \
         what a run takes on a tiny sound file; files below 64 KiB count as 64.\n\n{}",
        table(
            &[
                "files tried",
                "refused clearly",
                "rendered",
                "unclear",
                "crashed",
                "hung",
                "peak memory over file size, refused",
                "rendered",
                "tiny sound file, MiB"
            ],
            lines
        )
    )
}
