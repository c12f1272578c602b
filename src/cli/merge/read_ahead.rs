//! Parts read by all threads, ahead of those that are merged, and handed over in their order.

use rayon::prelude::*;

use super::part::Part;
use crate::error::Result;
use crate::image::Layers;

/// Bytes of layers that are in memory at most, where a part alone has not more.
const READ_AHEAD: u64 = 1 << 30;

/// Calls `add` with the layers of each of `parts`, in their order, while others are read. `go_on` is asked before each is read.
///
/// # Errors
/// The first of the order of parts that cannot be read, or that of `go_on`.
pub(super) fn each<'p>(
    parts: &[&'p Part],
    go_on: impl Fn() -> Result<()> + Sync,
    mut add: impl FnMut(&'p Part, &Layers) + Send,
) -> Result<()> {
    let read = |parts: &[&'p Part]| -> Vec<Result<(&'p Part, Layers)>> {
        let read = |part: &&'p Part| {
            go_on()?;
            Ok((*part, part.read_layers()?))
        };
        parts.par_iter().map(read).collect()
    };
    let mut runs = parts.chunks(run_length(parts));
    let mut ready = runs.next().map_or_else(Vec::new, read);
    while !ready.is_empty() {
        let run = std::mem::take(&mut ready).into_iter().collect::<Result<Vec<_>>>()?;
        let merge = || run.into_iter().for_each(|(part, layers)| add(part, &layers));
        let ((), next) = rayon::join(merge, || runs.next().map_or_else(Vec::new, read));
        ready = next;
    }
    Ok(())
}

/// How many of `parts` are read at once, while as many are merged.
fn run_length(parts: &[&Part]) -> usize {
    let largest = parts.iter().map(|part| part.bytes()).max().unwrap_or(0).max(1);
    let fit = usize::try_from(READ_AHEAD / 2 / largest).unwrap_or(usize::MAX);
    fit.clamp(1, rayon::current_num_threads())
}
