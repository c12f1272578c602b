//! Levels that a share of values stays below.

/// The value that `share` of those above 0 stay below; nothing where there is none.
pub(super) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|v| *v > 0.0).collect();
    let rank = (values.len().checked_sub(1)? as f64 * share) as usize;
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}
