//! The memory of this process, as the system tells of it. In go files in `/proc`, out come peak and limits.
//! Invariant: where the system does not tell, there is no limit.

use std::fs::read_to_string;

/// The most memory that the process has held so far, where Linux tells (proc(5), `VmHWM`).
pub(super) fn peak_memory_bytes() -> Option<u64> {
    let status = read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = peak.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

/// Address space below which there is not enough for most scenes.
const TIGHT_BYTES: u64 = 200_000_000;

/// Says that the process may not have much memory: when it cannot have more, the standard library says how
/// much that was, and nobody may say anything after it.
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

/// Whether the system may refuse memory. Where it has no limit it gives more than there is, and kills a
/// process when that is used up (proc(5), `overcommit_memory`).
pub(super) fn is_there_any() -> bool {
    let overcommit = read_to_string("/proc/sys/vm/overcommit_memory").unwrap_or_default();
    overcommit.trim() == "2" || limit("Max address space").is_some() || limit("Max data size").is_some()
}

/// A limit that is not `unlimited`, by its name in proc(5), `limits`.
fn limit(name: &str) -> Option<u64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix(name))?;
    limit.split_whitespace().next()?.parse().ok()
}
