//! Memory that a mapped file takes.

use std::path::Path;

/// Resident bytes of this process' mappings of a file. (The counters of the whole process are
/// approximate, and other threads move them.)
#[must_use]
pub fn mapped_bytes(path: &Path) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/smaps").ok()?;
    let path = path.to_str()?;
    let (mut ours, mut kibibytes) = (false, 0);
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or("");
        if !first.ends_with(':') {
            ours = line.ends_with(path);
        } else if ours && first == "Rss:" {
            kibibytes += words.next()?.parse::<u64>().ok()?;
        }
    }
    Some(1024 * kibibytes)
}
