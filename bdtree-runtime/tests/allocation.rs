//! Opening, posing and asking allocate nothing, sinks say when they are full, and generalised
//! forces are derivatives.
#![allow(unsafe_code)] // a counting allocator; every block has its proof

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::narrow::{Frustum, FrustumState};
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, LeafSlot, NodeSlot, PairContact, PairStackEntry, Pose, Posed,
    Proxy, RayHit, SearchEntry, Sink, SliceSink, StackEntry, StepCache, Transform, TriangleId,
    add_generalized_force, broad, query,
};

thread_local! {
    /// Allocations of this thread.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

fn count() {
    // A thread that ends has no counter any more.
    let _ = COUNT.try_with(|c| c.set(c.get() + 1));
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches a thread-local
// number that is initialised without allocating.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this layout, as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: `pointer` came from `System`; the rest is the caller's promise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations of this thread while `f` runs.
fn allocations<T>(f: impl FnOnce() -> T) -> (usize, T) {
    let before = COUNT.get();
    let result = f();
    (COUNT.get() - before, result)
}

struct CountRegions(usize);

impl Sink<query::ContactRegion> for CountRegions {
    fn push(&mut self, _: query::ContactRegion) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

#[test]
fn queries_allocate_nothing() {
    assert!(
        allocations(|| vec![1_u8; 100]).0 > 0,
        "allocations are counted"
    );
    let mesh = bake::bumpy_sphere(12, 1);
    for basis in [
        bake::smooth_basis(&mesh, 4, 1),
        bake::local_basis(&mesh, 4, 1),
    ] {
        let animated = bake::with_frames(basis, 3, 1.0, 1);
        nothing_is_allocated(&bake::baked(&mesh, &animated));
    }
}

/// A file of four modes and three frames.
fn nothing_is_allocated(bytes: &AlignedBytes) {
    let mut stack = [StackEntry::default(); 256];
    let mut pair_stack = [PairStackEntry::default(); 1024];
    let mut contacts = [Contact::EMPTY; 512];
    let mut pairs = [PairContact::EMPTY; 512];
    let mut search = [SearchEntry::default(); 256];
    let mut slots = [query::ManifoldSlot::default(); query::ManifoldSlot::count(512)];
    let (count, found) = allocations(|| {
        let asset = Asset::open(bytes).expect("open");
        let (mut memory, mut memory2) = ([0.0; 10], [0.0; 10]);
        let q = [0.5, -0.5, 0.2, 0.0];
        let pose = Pose::new(&asset, &q, Transform::IDENTITY, &mut memory).expect("pose");
        let place = Transform {
            translation: [1.0, 0.0, 0.0],
            ..Transform::IDENTITY
        };
        let pose2 = Pose::new(&asset, &[0.0; 4], place, &mut memory2).expect("pose");
        let point = [0.9, 0.1, 0.2];
        let mut found = 0;
        let mut sink = SliceSink::new(&mut contacts);
        query::ball(&asset, &pose, point, 0.3, &mut stack, &mut sink).expect("ball");
        found += sink.items().len();
        sink.clear();
        query::plane(&asset, &pose, point, -0.5, &mut stack, &mut sink).expect("plane");
        found += sink.items().len();
        sink.clear();
        query::capsule(&asset, &pose, point, [0.0; 3], 0.1, &mut stack, &mut sink)
            .expect("capsule");
        found += sink.items().len();
        sink.clear();
        let turned = [0.0, 0.0, 0.6, 0.8];
        query::cuboid(
            &asset, &pose, point, turned, [0.2; 3], &mut stack, &mut sink,
        )
        .expect("box");
        found += sink.items().len();
        let planes = Frustum::new(&[[1.0, 0.0, 0.0, -0.1]]).expect("planes");
        let state = query::frustum(&asset, &pose, &planes, &mut stack).expect("frustum");
        found += usize::from(state.state == FrustumState::Intersects);
        let sphere = query::root_sphere(&asset, &pose).expect("sphere");
        found += usize::from(sphere.radius > 1.0);
        let near = query::closest(&asset, &pose, point, f64::INFINITY, &mut stack).expect("near");
        found += usize::from(near.hit.is_some());
        let hit = query::ray(
            &asset,
            &pose,
            [3.0; 3],
            [-1.0; 3],
            f64::INFINITY,
            &mut stack,
        );
        found += usize::from(hit.expect("ray").hit.is_some());
        let mut cache = StepCache::new([NodeSlot::EMPTY; 9], [LeafSlot::EMPTY; 9]);
        let mut cached = cache.start(&pose);
        let ray = query::Ray {
            origin: [3.0; 3],
            direction: [-1.0; 3],
            max_distance: f64::INFINITY,
        };
        let mut hits = [None; 2];
        query::rays(&asset, &mut cached, &[ray; 2], &mut stack, &mut hits).expect("rays");
        found += hits.iter().flatten().count();
        let mut hits = [false; 2];
        query::rays_any(&asset, &mut cached, &[ray; 2], &mut stack, &mut hits).expect("rays");
        let mut all = [(0, RayHit::EMPTY); 8];
        let mut sink = SliceSink::new(&mut all);
        query::rays_all(&asset, &mut cached, &[ray; 2], &mut stack, &mut sink).expect("rays");
        found += sink.items().len();
        let mut sink = SliceSink::new(&mut pairs);
        let (a, b) = ((&asset, &pose), (&asset, &pose2));
        query::pair(a, b, 0.0, &mut pair_stack, &mut sink).expect("pair");
        found += sink.items().len();
        let (mut slots1, mut slots2) = ([Proxy::EMPTY; 64], [Proxy::EMPTY; 64]);
        let (mut proxies1, mut proxies2) =
            (SliceSink::new(&mut slots1), SliceSink::new(&mut slots2));
        let mut cache = StepCache::new([NodeSlot::EMPTY; 16], [LeafSlot::EMPTY; 16]);
        let mut cached = cache.start(&pose);
        let bounded = Posed::from(&mut cached).bounded(0, &mut proxies1);
        let far = SliceSink::<Contact>::new(&mut []);
        query::ball(&asset, bounded, point, 0.3, &mut stack, &mut { far }).expect("ball");
        found += proxies1.items().len();
        let coarse_a = (&asset, Posed::from(&mut cached).bounded(1, &mut proxies1));
        let coarse_b = (&asset, Posed::from(&pose2).bounded(0, &mut proxies2));
        query::pair(coarse_a, coarse_b, 0.0, &mut pair_stack, &mut sink).expect("pair");
        found += proxies2.items().len();
        let spheres = [&pose, &pose2].map(|p| query::root_sphere(&asset, p).expect("sphere"));
        let mut grid = [broad::GridSlot::EMPTY; broad::grid_slots(2)];
        let mut near = [[0; 2]; 1];
        let mut near = SliceSink::new(&mut near);
        broad::pairs(&spheres, 0.0, &mut grid, &mut near).expect("pairs");
        assert_eq!(*near.items(), [[0, 1]]);
        let mut regions = CountRegions(0);
        let pairs = sink.items_mut();
        query::manifold(a, b, pairs, &mut slots, &mut stack, &mut regions).expect("manifold");
        found += regions.0;
        let near = query::distance(a, b, 9.0, &mut search).expect("distance");
        found += usize::from(near.hit.is_some());
        let mut budget = query::Budget::new(9, &mut search);
        let near = budget.distance(a, b, 9.0).expect("distance");
        found += usize::from(near.found.is_some());
        let near = budget.closest(&asset, &pose, point, 9.0).expect("near");
        found += usize::from(near.found.is_some());
        let id = TriangleId(0);
        let mut out = [0.0; 4];
        add_generalized_force(&asset, &pose, id, [1.0, 0.0, 0.0], [1.0; 3], &mut out)
            .expect("force");
        let frame = asset.frame(2).expect("a frame");
        let placed = place.after(frame.transform()).expect("a placement");
        let pose = Pose::new(&asset, frame.q(), placed, &mut memory).expect("pose");
        let near = query::closest(&asset, &pose, point, f64::INFINITY, &mut stack).expect("near");
        found += usize::from(near.hit.is_some());
        assert!(asset.verify(&mut |_| std::ops::ControlFlow::Break(())));
        found
    });
    assert!(found > 20, "{found}");
    assert_eq!(count, 0, "nothing is allocated");
}

#[test]
fn a_full_sink_is_said_and_holds_a_part_of_the_answer() {
    let mesh = bake::bumpy_sphere(8, 1);
    let bytes = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1));
    let asset = Asset::open(&bytes).expect("open");
    let mut memory = [0.0; 9];
    let pose = Pose::new(&asset, &[0.1, 0.2], Transform::IDENTITY, &mut memory).expect("pose");
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut all: Vec<Contact> = Vec::new();
    let ball = |stack: &mut [StackEntry], slots: &mut [Contact]| {
        let mut sink = SliceSink::new(slots);
        let outcome = query::ball(&asset, &pose, [1.0, 0.0, 0.0], 0.6, stack, &mut sink);
        (outcome.expect("ball").truncated, sink.items().len())
    };
    query::ball(&asset, &pose, [1.0, 0.0, 0.0], 0.6, &mut stack, &mut all).expect("ball");
    assert!(all.len() > 4);
    for room in [0, 1, all.len() - 1, all.len(), all.len() + 1] {
        let mut slots = vec![Contact::EMPTY; room];
        let (truncated, taken) = ball(&mut stack, &mut slots);
        assert_eq!(
            truncated,
            room < all.len(),
            "room for {room} of {}",
            all.len()
        );
        assert_eq!(taken, room.min(all.len()));
        assert_eq!(slots[..taken], all[..taken], "the first ones, in order");
    }
    // Nothing found: no room is needed.
    let mut sink = SliceSink::<Contact>::new(&mut []);
    let far = query::ball(&asset, &pose, [9.0; 3], 0.1, &mut stack, &mut sink).expect("ball");
    assert!(!far.truncated);
}

/// x·f is linear in q, so a difference quotient is its derivative up to rounding in f32.
#[test]
fn generalized_forces_are_derivatives_of_work() {
    let mesh = bake::bumpy_sphere(8, 1);
    let dense = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 1));
    let sparse = bake::baked(&mesh, &bake::local_basis(&mesh, 3, 1));
    for bytes in [dense, sparse] {
        forces_are_derivatives(&Asset::open(&bytes).expect("open"));
    }
}

fn forces_are_derivatives(asset: &Asset<'_>) {
    let mut rng = poses::rng(3);
    let place = poses::random_transform(2.0, &mut rng);
    let (weights, force) = ([0.2, 0.5, 0.3], [1.0, -2.0, 0.5]);
    for id in [0, 7, 50].map(TriangleId) {
        let work = |q: &[f32]| {
            let mut memory = [0.0; 9];
            let pose = Pose::new(asset, q, place, &mut memory).expect("pose");
            let corners = asset.triangle(id).expect("triangle");
            let mut work = 0.0;
            for (corner, weight) in corners.iter().zip(weights) {
                let x = asset.deformed(&pose, *corner).expect("vertex");
                work += weight * (x[0] * force[0] + x[1] * force[1] + x[2] * force[2]);
            }
            work
        };
        let q = [0.25, -0.5, 0.125];
        let mut memory = [0.0; 9];
        let pose = Pose::new(asset, &q, place, &mut memory).expect("pose");
        let mut out = [10.0; 3];
        add_generalized_force(asset, &pose, id, weights, force, &mut out).expect("force");
        for j in 0..3 {
            let (mut up, mut down) = (q, q);
            up[j] += 1.0;
            down[j] -= 1.0;
            let quotient = (work(&up) - work(&down)) / 2.0;
            // Vertices of size 1 to 3, rounded to f32, times the force and the scale.
            let tolerance = 10.0 * place.scale * 2_f64.powi(-24) * 3.0;
            assert!(
                (out[j] - 10.0 - quotient).abs() < tolerance,
                "{} {quotient}",
                out[j]
            );
        }
    }
}
