//! This process as the system describes it. In go files in `/proc`, out come memory, limits and ignored
//! signals. Invariant: where the system has no such files, there is no limit and no signal is ignored.

use std::fs::read_to_string;
use std::path::Path;

/// Peak memory of the process so far, on Linux (proc(5), `VmHWM`).
pub(super) fn peak_memory_bytes() -> Option<u64> {
    let kibibytes: u64 = status("VmHWM:")?.strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// A field of proc(5), `status`, by its name.
fn status(name: &str) -> Option<String> {
    let status = read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| Some(line.strip_prefix(name)?.trim().to_owned()))
}

/// Number of further units of `peak_bytes` that fit into memory: within half of the free memory (proc(5),
/// `MemAvailable`), and three quarters of the control group's limit (cgroups(7)). `None` elsewhere than on
/// Linux.
pub(super) fn times_more(peak_bytes: u64) -> Option<usize> {
    let info = read_to_string("/proc/meminfo").ok()?;
    let free = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let free_bytes = 1024 * free.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    let peak_bytes = peak_bytes.max(1);
    let of_group = group_limit().map_or(u64::MAX, |limit| (limit / 4 * 3 / peak_bytes).saturating_sub(1));
    usize::try_from(of_group.min(free_bytes / 2 / peak_bytes)).ok()
}

/// Smallest memory limit of the process's control groups, of either version.
fn group_limit() -> Option<u64> {
    let groups = read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().flat_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (kinds, group) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
        let (root, name) = match kinds {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
        };
        let is_of_memory = kinds.is_empty() || kinds.split(',').any(|kind| kind == "memory");
        let folders = Path::new(group).ancestors().filter(move |_| is_of_memory);
        folders
            .filter_map(move |folder| {
                let folder = Path::new(root).join(folder.strip_prefix("/").unwrap_or(folder));
                // `max` means no limit.
                read_to_string(folder.join(name)).ok()?.trim().parse().ok()
            })
            .collect::<Vec<u64>>()
    });
    limits.min()
}

/// Address space that is too small for most scenes.
const TIGHT_BYTES: u64 = 200_000_000;

/// Message about limited memory. When an allocation fails, the standard library prints its size and aborts,
/// and nothing can be printed after that.
pub(super) fn tight_memory() -> Option<String> {
    let bytes = limit("Max address space")?;
    let [limit, least] = [bytes, TIGHT_BYTES].map(|bytes| bytes / 1_000_000);
    (bytes < TIGHT_BYTES).then(|| {
        format!(
            "note: the address space is limited to {limit} MB: where memory cannot be had the command ends with exit \
             code 4\n  remedy: allow {least} MB and more (ulimit -v)"
        )
    })
}

/// Whether the system may refuse memory. Without a limit it overcommits, and kills a process when memory runs
/// out (proc(5), `overcommit_memory`).
pub(super) fn is_there_any() -> bool {
    let overcommit = read_to_string("/proc/sys/vm/overcommit_memory").unwrap_or_default();
    overcommit.trim() == "2" || limit("Max address space").is_some() || limit("Max data size").is_some()
}

/// Limit of this name in proc(5), `limits`, unless it is `unlimited`.
fn limit(name: &str) -> Option<u64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix(name))?;
    limit.split_whitespace().next()?.parse().ok()
}

/// Whether the process was started with a signal ignored (proc(5), `SigIgn`).
#[cfg(unix)]
pub(super) fn is_ignored(signal: i32) -> bool {
    let ignored = status("SigIgn:").and_then(|mask| u64::from_str_radix(&mask, 16).ok());
    ignored.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
