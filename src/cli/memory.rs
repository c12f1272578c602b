//! Memory of this process and of the machine, where the system tells it.

use std::fs::read_to_string;
use std::path::Path;

/// Makes the allocator return large blocks to the system as soon as they are freed. By default the C
/// library retains more of them the larger the blocks were that were freed before, so that a render now and
/// then takes far more memory than it needs.
pub(super) fn give_freed_blocks_back() {
    crate::vdb::map_large_blocks();
}

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
    let text = read_to_string(account).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// Bytes that could be taken now without anything being driven out of memory: what the machine has
/// left, and what the groups of processes that this one is in and its own limits leave.
pub(super) fn available() -> Option<u64> {
    let machine = line("/proc/meminfo", "MemAvailable:")?;
    let groups = read_to_string("/proc/self/cgroup").unwrap_or_default();
    let limits = [
        left_by_groups(&groups, Path::new("/sys/fs/cgroup")),
        left_by_limit("Max address space", "VmSize:"),
        left_by_limit("Max data size", "VmData:"),
    ];
    Some(limits.into_iter().flatten().fold(machine, u64::min))
}

/// What a limit of this process leaves beside what its account `used` says.
fn left_by_limit(name: &str, used: &str) -> Option<u64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix(name))?;
    let soft: u64 = limit.split_whitespace().next()?.parse().ok()?; // "unlimited" where there is none
    Some(soft.saturating_sub(line("/proc/self/status", used)?))
}

/// What Linux's control groups leave, whose folders are in `root`: `groups` are those of this process,
/// as `/proc/self/cgroup` has them, and the limits of all groups round them hold as well.
fn left_by_groups(groups: &str, root: &Path) -> Option<u64> {
    let left = |line: &str| {
        let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
        let (base, files) = match controllers {
            "" => (root.to_path_buf(), &VERSION_2),
            _ if controllers.split(',').any(|c| c == "memory") => (root.join("memory"), &VERSION_1),
            _ => return None,
        };
        let own = base.join(path.trim_start_matches('/'));
        let around = own.ancestors().take_while(|folder| folder.starts_with(&base));
        around.filter_map(|folder| files.left(folder)).min()
    };
    groups.lines().filter_map(left).min()
}

/// Where the folder of a control group tells of memory.
struct GroupFiles {
    limit: &'static str,
    now: &'static str,
    /// In its statistics, files that it has read and that can be driven out.
    files: &'static str,
}

const VERSION_1: GroupFiles = GroupFiles {
    limit: "memory.limit_in_bytes",
    now: "memory.usage_in_bytes",
    files: "total_inactive_file ",
};

const VERSION_2: GroupFiles =
    GroupFiles { limit: "memory.max", now: "memory.current", files: "inactive_file " };

impl GroupFiles {
    /// What the group of `folder` leaves; nothing where it has no limit.
    fn left(&self, folder: &Path) -> Option<u64> {
        let number = |name| {
            let text = read_to_string(folder.join(name)).ok()?;
            text.trim().parse::<u64>().ok() // "max" where there is no limit
        };
        let (limit, now) = (number(self.limit)?, number(self.now)?);
        let statistics = read_to_string(folder.join("memory.stat")).unwrap_or_default();
        let files = statistics.lines().find_map(|line| line.strip_prefix(self.files));
        let files = files.and_then(|count| count.trim().parse().ok()).unwrap_or(0);
        Some(limit.saturating_sub(now.saturating_sub(files)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tightest_group_counts() {
        let root = tempfile::tempdir().expect("a folder");
        let group = |folder: &str, files: [(&str, &str); 3]| {
            let folder = root.path().join(folder);
            std::fs::create_dir_all(&folder).expect("made");
            for (name, text) in files {
                std::fs::write(folder.join(name), text).expect("written");
            }
        };
        let second = |max: &'static str, now, stat| {
            [("memory.max", max), ("memory.current", now), ("memory.stat", stat)]
        };
        group("a.slice", second("1000\n", "300\n", "anon 200\ninactive_file 100\n"));
        group("a.slice/b.scope", second("max\n", "300\n", ""));
        group("a.slice/c.scope", second("500\n", "20\n", ""));
        let left = |groups: &str| left_by_groups(groups, root.path());
        assert_eq!(left("0::/a.slice/b.scope\n"), Some(800), "that of the group around it");
        assert_eq!(left("0::/a.slice/c.scope\n"), Some(480));
        assert_eq!(left("0::/\n"), None);
        assert_eq!(left("nonsense\n3:cpu:/a.slice\n"), None);
        let names = ["memory.limit_in_bytes", "memory.usage_in_bytes", "memory.stat"];
        let first = |numbers: [&'static str; 3]| [0, 1, 2].map(|i| (names[i], numbers[i]));
        group("memory/d", first(["700", "90", "inactive_file 1\ntotal_inactive_file 40"]));
        assert_eq!(left("4:cpu,memory:/d/gone\n0::/a.slice/b.scope\n"), Some(650));
    }
}
