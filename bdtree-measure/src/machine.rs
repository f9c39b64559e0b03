//! What the machine is and can do: the limits that figures are held against.

use std::hint::black_box;
use std::time::Instant;

/// The processor's type and the number of cores that this program may use.
pub fn processor() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        info.lines()
            .find(|line| line.starts_with(name))
            .and_then(|line| line.split_once(": "))
            .map_or("?", |(_, value)| value)
            .to_string()
    };
    let cores = std::thread::available_parallelism().map_or(0, |n| n.get());
    format!(
        "{} (family {}, model {}), {cores} cores",
        field("model name"),
        field("cpu family"),
        field("model\t"),
    )
}

/// A line of /proc/self/status in bytes, e.g. `VmHWM` (largest resident set) or `VmRSS`.
pub fn status_bytes(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(name))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// Bytes of files that this process has mapped in huge pages: where the page cache holds them,
/// touching one byte counts 2 MiB as resident, which other processes share.
pub fn mapped_huge_bytes() -> u64 {
    let maps = std::fs::read_to_string("/proc/self/smaps_rollup").unwrap_or_default();
    let kib = maps
        .lines()
        .find(|line| line.starts_with("FilePmdMapped"))
        .and_then(|line| line.split_whitespace().nth(1)?.parse().ok());
    kib.unwrap_or(0_u64) * 1024
}

/// Bytes per second of summing an array of this many bytes front to back, best of several runs.
pub fn read_bandwidth(bytes: usize) -> f64 {
    const LANES: usize = 32;
    let data = vec![1.0_f32; (bytes / 4).max(LANES)];
    let passes = ((64 << 20) / bytes.max(1)).clamp(1, 100_000);
    let mut best = 0.0_f64;
    for _ in 0..5 {
        let start = Instant::now();
        for _ in 0..passes {
            let mut sums = [0.0_f32; LANES];
            for chunk in black_box(&data).as_chunks::<LANES>().0 {
                for (sum, x) in sums.iter_mut().zip(chunk) {
                    *sum += x;
                }
            }
            black_box(sums);
        }
        let seconds = start.elapsed().as_secs_f64();
        best = best.max((passes * data.len() * 4) as f64 / seconds);
    }
    best
}
