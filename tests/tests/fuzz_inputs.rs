//! A share of the mutated inputs for every reader, the same in every run; the long run is
//! `fuzz-inputs` (docs/design/fuzzing.md).

use bdtree_tests::fuzz::memory::Counting;
use bdtree_tests::fuzz::{Campaign, Format, Seeds};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Cases per format: about 20 s in all on two cores.
const CASES: u64 = 2500;

/// One in this many files that were read is baked and queried.
const FOLLOW: u64 = 6;

fn holds(format: Format) {
    let seeds = Seeds::fixtures();
    let tally = Campaign::new(&seeds, FOLLOW).run(format, 1, 0..CASES);
    println!("{format} {tally}");
    assert_eq!(
        tally.failures, [""; 0],
        "repeat with fuzz-inputs and these arguments"
    );
    assert_eq!(tally.read + tally.refused, CASES);
    assert!(tally.read > CASES / 20, "few are sound: {}", tally.read);
    assert!(
        tally.refused > CASES / 20,
        "few are refused: {}",
        tally.refused
    );
    assert!(
        tally.right > 5 || format == Format::List,
        "few are baked: {}",
        tally.right
    );
}

macro_rules! formats {
    ($($name:ident: $format:ident,)*) => {$(
        #[test]
        fn $name() {
            holds(Format::$format);
        }
    )*};
}

formats! {
    obj: Obj,
    compressed_obj: ObjGz,
    frames: Frames,
    glb: Glb,
    gltf: Gltf,
    pc2: Pc2,
    mdd: Mdd,
    npy: Npy,
    basis: Basis,
    frequencies: Frequencies,
    list: List,
    veg: Veg,
    vtk: Vtk,
    msh: Msh,
    scene: Scene,
    ply: Ply,
    stl: Stl,
}

/// Cases that longer runs failed in: a mesh that is shown a thousand times, and objects nested so deep that text written again
/// with indentation took most of 282 bytes of memory per byte.
#[test]
fn cases_that_failed_hold() {
    let seeds = Seeds::fixtures();
    let campaign = Campaign::new(&seeds, 0);
    for (seed, number) in [(3, 47), (2611, 1_170_223)] {
        let tally = campaign.run(Format::Gltf, seed, [number]);
        assert_eq!(tally.failures, [""; 0]);
    }
}

/// The checks above can fail: memory is counted, and cases repeat.
#[test]
fn cases_repeat_and_memory_is_counted() {
    let seeds = Seeds::fixtures();
    let campaign = Campaign::new(&seeds, 0);
    let run = || campaign.run(Format::Gltf, 7, 0..50);
    let (one, two) = (run(), run());
    assert_eq!((one.read, one.refused), (two.read, two.refused));
    assert!(one.largest.0 > 10_000, "{}", one.largest.0);
}
