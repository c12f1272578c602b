//! Memory of this process, where the system tells it.

/// Bytes in memory now.
pub(super) fn resident() -> Option<u64> {
    status("VmRSS:")
}

/// The most bytes that have been in memory.
pub(super) fn peak() -> Option<u64> {
    status("VmHWM:")
}

/// A line of Linux's account of the process, in bytes.
fn status(key: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}
