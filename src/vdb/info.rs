//! What a file says of its grids before their voxels are read.

use std::collections::HashMap;

use glam::{DAffine3, DVec3};

use super::check::Checked;
use super::ffi::bridge;

/// What a file says about a grid before its voxels are read.
#[derive(Debug, Clone, serde::Serialize)]
pub struct GridInfo {
    /// The name, which need not be unique and may be empty.
    pub name: String,
    /// Which of the grids of this name it is, from 0.
    pub occurrence: usize,
    /// Type of the values, such as `float`, `vec3s` or `ptdataidx32`.
    pub value_type: String,
    /// OpenVDB's class: `fog volume`, `level set`, `staggered` or `unknown`.
    pub class: String,
    /// Whether the values are stored in 16 bits.
    pub half: bool,
    /// OpenVDB's name of the map, such as `UniformScaleMap`.
    pub map: String,
    /// Compression in the file, such as `blosc + active mask`.
    pub compression: String,
    /// Active voxels, where the file tells.
    pub voxel_count: Option<u64>,
    /// The map as rows of a column-vector matrix; nothing where it is not linear.
    pub matrix: Option<[[f64; 4]; 3]>,
    /// Metadata of the grid by name, as OpenVDB prints values; entries longer than 256 bytes and
    /// types that it does not know are left out.
    #[serde(skip)]
    pub metadata: Vec<(String, String)>,
    #[serde(skip)]
    tree_type: String,
    #[serde(skip)]
    registered: bool,
    #[serde(skip)]
    unique: bool,
}

impl GridInfo {
    /// The name as a user gives it: with the occurrence where several grids share the name.
    pub fn label(&self) -> String {
        if self.unique { self.name.clone() } else { format!("{}[{}]", self.name, self.occurrence) }
    }

    /// Whether the values are single numbers that can be read.
    pub fn is_scalar(&self) -> bool {
        self.has_type(&["float", "half", "double", "int32", "int64", "bool"])
    }

    /// Whether the values are three-vectors that can be read.
    pub fn is_vector(&self) -> bool {
        self.has_type(&["vec3s", "vec3d", "vec3i"])
    }

    /// Whether it is a level set.
    pub fn is_level_set(&self) -> bool {
        self.class == "level set"
    }

    fn has_type(&self, types: &[&str]) -> bool {
        self.registered && types.contains(&self.value_type.as_str())
    }

    /// Why its voxels cannot be read at all; nothing where they can.
    pub fn unreadable(&self) -> Option<String> {
        if !self.registered && self.value_type == "half" {
            return Some(format!(
                "is a grid of 16-bit floats ({}), which OpenVDB {} does not read; write it anew as a \
                 grid of floats, or build fogbow with OpenVDB 13",
                self.tree_type,
                bridge::library_version()
            ));
        }
        if !self.registered {
            return Some(format!(
                "has the type {}, which OpenVDB does not know; write it anew with another",
                self.tree_type
            ));
        }
        if self.value_type.starts_with("ptdataidx") {
            return Some("holds points; turn them into a fog volume first".into());
        }
        if !self.is_scalar() && !self.is_vector() {
            return Some(format!(
                "has the type {}; scalar grids (float, half, double, int32, int64, bool) and vec3 grids \
                 can be read",
                self.value_type
            ));
        }
        if self.matrix.is_none() {
            return Some(format!(
                "has a frustum transform ({}); resample it to a linear transform",
                self.map
            ));
        }
        None
    }

    /// From index space to the world; nothing where the map is not linear.
    pub(super) fn affine(&self) -> Option<DAffine3> {
        let [x, y, z] = self.matrix?;
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        Some(DAffine3::from_cols(column(0), column(1), column(2), column(3)))
    }
}

/// What the file tells of its grids.
pub(super) fn describe(
    file: &bridge::File,
    checked: &Checked,
) -> Result<Vec<GridInfo>, cxx::Exception> {
    let mut total = HashMap::<&str, usize>::new();
    for (name, ..) in checked.grids() {
        *total.entry(name).or_default() += 1;
    }
    let mut before = HashMap::<&str, usize>::new();
    let grid = |(name, half, place): (_, _, bridge::GridPlace)| {
        let header = file.header(&place)?;
        let count = before.entry(name).or_default();
        let occurrence = *count;
        *count += 1;
        Ok(GridInfo {
            name: name.into(),
            occurrence,
            unique: total[name] == 1,
            value_type: value_type(&place.tree_type).to_string(),
            class: header.grid_class,
            half,
            map: header.map,
            compression: compression(header.compression),
            voxel_count: u64::try_from(header.voxel_count).ok(),
            matrix: header.linear.then(|| {
                // OpenVDB multiplies row vectors from the left, so its rows are our columns.
                std::array::from_fn(|r| std::array::from_fn(|c| header.affine[4 * c + r]))
            }),
            metadata: texts(header.metadata),
            tree_type: place.tree_type,
            registered: header.registered,
        })
    };
    checked.grids().map(grid).collect()
}

/// Names and values as OpenVDB prints them.
pub(super) fn texts(metadata: Vec<bridge::MetadataText>) -> Vec<(String, String)> {
    metadata.into_iter().map(|entry| (entry.name, entry.value)).collect()
}

/// `Tree_float_5_4_3` holds `float`; other configurations keep their full name.
fn value_type(tree_type: &str) -> &str {
    let inner = tree_type.strip_prefix("Tree_").and_then(|t| t.strip_suffix("_5_4_3"));
    inner.unwrap_or(tree_type)
}

/// OpenVDB's compression flags in words.
fn compression(flags: u32) -> String {
    let names = [(1, "zip"), (2, "active mask"), (4, "blosc")];
    let set: Vec<_> = names.iter().filter(|(bit, _)| flags & bit != 0).map(|&(_, n)| n).collect();
    if set.is_empty() { "none".into() } else { set.join(" + ") }
}
