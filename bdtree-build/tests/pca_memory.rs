//! Memory follows the chunk and the kept modes, not the frames. A program of its own, because the
//! peak is the process's.

#[cfg(target_os = "linux")]
#[test]
fn the_frames_are_never_held_together() {
    use std::io::{BufWriter, Write};

    use bdtree_build::basis::pca::{Modes, PcaOptions, pca_basis};
    use bdtree_build::input::RawMesh;
    use bdtree_build::input::sequence::FrameSequence;
    use bdtree_build::progress::Silent;

    const FRAMES: usize = 300;
    const SIDE: usize = 160;

    /// Kibibytes of memory that this process has had at most.
    fn peak() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let number = line.and_then(|line| line.split_whitespace().next());
        number.and_then(|n| n.parse().ok()).expect("a number of kB")
    }

    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("frames.pc2");
    let file = std::fs::File::create(&path).expect("writable");
    let mut out = BufWriter::new(file);
    let mut put = |bytes: &[u8]| out.write_all(bytes).expect("writable");
    put(b"POINTCACHE2\0");
    for word in [1, (SIDE * SIDE) as u32, 0, 1.0_f32.to_bits(), FRAMES as u32] {
        put(&word.to_le_bytes());
    }
    for t in 0..FRAMES {
        for i in 0..SIDE * SIDE {
            let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
            // Travelling parabolas: many components, and the same on every machine.
            let s = ((x * 0.02 + y * 0.013 + t as f32 * 0.017) % 1.0) - 0.5;
            for value in [x, y, 10.0 * s * s] {
                put(&value.to_le_bytes());
            }
        }
    }
    drop(out);

    let at = |i: usize| [(i % SIDE) as f64, (i / SIDE) as f64, 0.0];
    let mesh = RawMesh {
        name: "grid".into(),
        positions: (0..SIDE * SIDE).map(at).collect(),
        triangles: vec![[0, 1, SIDE as u32]],
        ..RawMesh::default()
    };
    let before = peak();
    let sequence = FrameSequence::open(&path, Some(&mesh), None, &Silent).expect("a sequence");
    let options = PcaOptions {
        modes: Modes::Count(12),
        align: true,
        ..PcaOptions::default()
    };
    let found = pca_basis(&mesh, &sequence, &options, &Silent, &mut Vec::new()).expect("a basis");
    assert_eq!(found.basis.mode_count(), 12);
    let grown = peak() - before;
    // The frames take 92 MB in f32 and 184 MB in f64; two chunks of 32 MiB, 12 modes of 25 600
    // vertices (7 MB, and half of it stored) and the triangle of 300 frames with its rows (4 MB)
    // are what is held.
    assert!(grown < 96 << 10, "{grown} kB");
    println!("{grown} kB");
}
