//! What a call through the C interface costs beside the same call in Rust:
//! `cargo run --release -p bdtree-capi --example overhead [FILE.bdt] [RAYS]`. Without RAYS a thousand, to see that it runs.
//!
//! With `rust` or `c` behind RAYS only that one casts them, ten times: for `perf stat -e instructions:u`, which other
//! programs do not disturb.
//!
//! The two take turns, in one process; each number is the least of many rounds.
#![allow(unsafe_code)] // what C promises: docs/design/unsafe.md

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use bdtree_capi::answers::BdtHit;
use bdtree_capi::batch::bdt_cast_rays;
use bdtree_capi::border::{Handle, In, Kind, Out};
use bdtree_capi::instance::{BdtInstance, bdt_instance_new, bdt_instance_placement};
use bdtree_capi::model::{BdtModel, bdt_model_from_memory};
use bdtree_capi::query::bdt_cast_ray;
use bdtree_capi::status::BdtStatus;
use bdtree_capi::types::{BdtRay, BdtTransform, BdtVec3};
use bdtree_capi::version::bdt_version;
use bdtree_capi::workspace::{BdtWorkspace, bdt_workspace_new};
use bdtree_runtime::{Instance, Model, Ray, RayIntersection, Workspace};

/// Rounds of single calls, and of batches.
const ROUNDS: [usize; 2] = [301, 21];

const NOTHING: Option<RayIntersection> = None;

fn handle<K: Kind>(address: *mut K) -> Handle<K> {
    // SAFETY: the library made them, and they live until the program ends.
    unsafe { Handle::new(address) }
}

fn read<T>(values: &[T]) -> In<T> {
    // SAFETY: no larger count is passed than there are.
    unsafe { In::new(values.as_ptr()) }
}

fn write<T>(values: &mut [T]) -> Out<T> {
    // SAFETY: as above, and each for one argument alone.
    unsafe { Out::new(values.as_mut_ptr()) }
}

fn make<K>(make: impl FnOnce(Out<*mut K>) -> BdtStatus) -> *mut K {
    let mut made = [std::ptr::null_mut()];
    assert_eq!(make(write(&mut made)), BdtStatus::Ok);
    made[0]
}

/// The least time that each of two takes (ns, divided by `count`).
fn compare(rounds: usize, count: usize, mut rust: impl FnMut(), mut c: impl FnMut()) -> [f64; 2] {
    let time = |call: &mut dyn FnMut()| {
        let start = Instant::now();
        call();
        start.elapsed().as_secs_f64() * 1e9 / count as f64
    };
    let mut least = [f64::INFINITY; 2];
    for _ in 0..rounds {
        least[0] = least[0].min(time(&mut rust));
        least[1] = least[1].min(time(&mut c));
    }
    least
}

fn print(what: &str, [rust, c]: [f64; 2]) {
    let (more, share) = (c - rust, 100.0 * (c - rust) / rust);
    println!("{what}: Rust {rust:.1} ns, C {c:.1} ns, {more:+.1} ns ({share:+.1} %)");
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden/sparse.bdt");
    let path = arguments.next().map_or(golden, Into::into);
    let count: usize = arguments
        .next()
        .map_or(1000, |text| text.parse().expect("a number"));
    let bytes = std::fs::read(path).expect("a .bdt file");

    let model = Model::from_bytes(&bytes).expect("a .bdt file");
    let mut own = Instance::new(&model).expect("an instance");
    let mut memory = Workspace::new();
    let c_model: *mut BdtModel = make(|out| bdt_model_from_memory(read(&bytes), bytes.len(), out));
    let body: *mut BdtInstance = make(|out| bdt_instance_new(handle(c_model), out));
    let desk: *mut BdtWorkspace = make(|out| bdt_workspace_new(out));

    // Down onto the mesh, from places that fill its box, one of them beside it in ten.
    let aabb = own.aabb().expect("a sound file");
    let side = |k: usize, share: f64| aabb.min[k] + share * (aabb.max[k] - aabb.min[k]);
    let rays: Vec<Ray> = (0..count)
        .map(|i| {
            let share = |step: f64| 1.1 * (i as f64 * step).fract();
            let origin = [
                side(0, share(0.618_034)),
                side(1, 2.0),
                side(2, share(0.754_878)),
            ];
            Ray::new(origin, [0.02, -1.0, 0.01])
        })
        .collect();
    let c_rays: Vec<BdtRay> = (rays.iter())
        .map(|ray| BdtRay {
            origin: ray.origin.into(),
            direction: ray.direction.into(),
            max_distance: ray.max_distance,
        })
        .collect();
    let far = Ray::new([1e9, 1e9, 1e9], [0.0, 1.0, 0.0]);
    let c_far = [BdtRay {
        origin: BdtVec3 {
            x: 1e9,
            y: 1e9,
            z: 1e9,
        },
        direction: BdtVec3 {
            x: 0.0,
            y: 1.0,
            z: 0.0,
        },
        max_distance: f64::INFINITY,
    }];

    if let Some(side) = arguments.next() {
        let (mut hits, mut c_hits) = (vec![None; count], vec![BdtHit::from(NOTHING); count]);
        for _ in 0..10 {
            if side == "rust" {
                own.query(&mut memory)
                    .cast_rays(&rays, &mut hits)
                    .expect("rays");
            } else {
                bdt_cast_rays(
                    handle(desk),
                    handle(body),
                    read(&c_rays),
                    count,
                    write(&mut c_hits),
                );
            }
        }
        return;
    }

    let calls = 1000.max(count / 100);
    let empty = compare(
        ROUNDS[0],
        calls,
        || {
            for _ in 0..calls {
                black_box(black_box(&own).placement());
            }
        },
        || {
            let mut at = [BdtTransform::from(own.placement())];
            (0..calls).for_each(|_| {
                bdt_instance_placement(handle(black_box(body)), write(black_box(&mut at)));
            });
        },
    );
    print("reading a placement", empty);
    let version = compare(
        ROUNDS[0],
        calls,
        || {
            for call in 0..calls {
                black_box(call);
            }
        },
        || {
            for _ in 0..calls {
                black_box(bdt_version());
            }
        },
    );
    print("nothing", version);
    let mut found = None;
    let mut hit = [BdtHit::from(NOTHING)];
    let miss = compare(
        ROUNDS[0],
        calls,
        || {
            for _ in 0..calls {
                found = own
                    .query(&mut memory)
                    .cast_ray(black_box(&far))
                    .expect("a ray");
                black_box(&found);
            }
        },
        || {
            for _ in 0..calls {
                bdt_cast_ray(
                    handle(desk),
                    handle(body),
                    read(black_box(&c_far)),
                    write(&mut hit),
                );
                black_box(&hit);
            }
        },
    );
    print("a ray that misses everything", miss);

    let mut hits = vec![None; count];
    let mut c_hits = vec![hit[0]; count];
    let batch = compare(
        ROUNDS[1],
        count,
        || {
            own.query(&mut memory)
                .cast_rays(&rays, &mut hits)
                .expect("rays")
        },
        || {
            let status = bdt_cast_rays(
                handle(desk),
                handle(body),
                read(&c_rays),
                count,
                write(&mut c_hits),
            );
            assert_eq!(status, BdtStatus::Ok);
        },
    );
    print(&format!("each of {count} rays in one call"), batch);
    let same = hits.iter().zip(&c_hits).all(|(hit, c_hit)| {
        let hit = BdtHit::from(*hit);
        (hit.triangle, hit.distance) == (c_hit.triangle, c_hit.distance)
    });
    assert!(same, "the answers are the same");
    let met = hits.iter().flatten().count();
    println!("{met} of {count} rays hit");
}
