//! Memory of this process and of the machine, where the system tells it.

/// Bytes in memory now.
pub(super) fn resident() -> Option<u64> {
    line("/proc/self/status", "VmRSS:")
}

/// The most bytes that have been in memory.
pub(super) fn peak() -> Option<u64> {
    line("/proc/self/status", "VmHWM:")
}

/// A line of one of Linux's accounts, in bytes.
fn line(account: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(account).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// Bytes that could be taken now without anything being driven out of memory: what the machine has
/// left, and what the group of processes that this one runs in may still take.
pub(super) fn available() -> Option<u64> {
    let machine = line("/proc/meminfo", "MemAvailable:")?;
    Some(group().map_or(machine, |group| machine.min(group)))
}

/// What Linux's control group (version 2) leaves; files that it has read can be driven out.
fn group() -> Option<u64> {
    let number = |name: &str| {
        let text = std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?;
        text.trim().parse::<u64>().ok() // "max" where there is no limit
    };
    let (limit, now) = (number("memory.max")?, number("memory.current")?);
    let statistics = std::fs::read_to_string("/sys/fs/cgroup/memory.stat").unwrap_or_default();
    let files = statistics.lines().find_map(|line| line.strip_prefix("inactive_file "));
    let files = files.and_then(|count| count.trim().parse().ok()).unwrap_or(0);
    Some(limit.saturating_sub(now.saturating_sub(files)))
}
