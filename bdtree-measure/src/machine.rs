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

/// A line of a file that the kernel fills, in bytes.
fn kernel_bytes(file: &str, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

/// A line of /proc/self/status in bytes, e.g. `VmHWM` (largest resident set) or `VmRSS`.
pub fn status_bytes(name: &str) -> Option<u64> {
    kernel_bytes("/proc/self/status", name)
}

/// Bytes of files that this process has mapped in huge pages: where the page cache holds them,
/// touching one byte counts 2 MiB as resident, which other processes share.
pub fn mapped_huge_bytes() -> u64 {
    kernel_bytes("/proc/self/smaps_rollup", "FilePmdMapped").unwrap_or(0)
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
