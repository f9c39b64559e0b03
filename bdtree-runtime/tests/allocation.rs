//! Opening, posing and asking allocate nothing, sinks say when they are full, and generalised
//! forces are derivatives.

use std::ops::ControlFlow;

use bdtree_fixtures::allocations::{Counting, allocations};
use bdtree_fixtures::skin::{BoneSource, LocalSource, NodeSource, SkinSource, with_skin};
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Asset, Ball, BoneMatrices, CacheSize, Capsule, Contact, Coverage, Cuboid, Frustum,
    FrustumState, HalfSpace, Instance, LaneId, LaneTriangle, Model, PairContact, PairFront, Proxy,
    Ray, Sink, SliceSink, StepCache, Transform, TriangleId, VertexId, Workspace, broad, joint,
};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Takes any number of things and keeps none.
struct Count(usize);

impl<T> Sink<T> for Count {
    fn push(&mut self, _: T) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

/// Files of four modes and three frames: all modes for each vertex, and few of them.
fn animated() -> [Model; 2] {
    let mesh = bake::bumpy_sphere(12, 1);
    let bases = [
        bake::smooth_basis(&mesh, 4, 1),
        bake::local_basis(&mesh, 4, 1),
    ];
    bases.map(|basis| bake::baked(&mesh, &bake::with_frames(basis, 3, 1.0, 1)))
}

#[test]
fn queries_allocate_nothing() {
    assert!(
        allocations(|| vec![1_u8; 100]).0 > 0,
        "allocations are counted"
    );
    for model in animated() {
        nothing_is_allocated(model.asset().bytes());
    }
}

/// All in memory on the stack.
fn nothing_is_allocated(bytes: &[u8]) {
    let mut memory = [0; 1 << 18];
    let mut contacts = [Contact::EMPTY; 512];
    let mut pairs = [PairContact::EMPTY; 512];
    let (count, found) = allocations(|| {
        let asset = Asset::open(bytes).expect("open");
        let (mut memory1, mut memory2) = ([0.0; 10], [0.0; 10]);
        let q = [0.5, -0.5, 0.2, 0.0];
        let pose = asset
            .pose(&q, Transform::IDENTITY, &mut memory1)
            .expect("pose");
        let place = Transform::from_translation([1.0, 0.0, 0.0]);
        let pose2 = asset.pose(&[0.0; 4], place, &mut memory2).expect("pose");
        let point = [0.9, 0.1, 0.2];
        let mut found = 0;
        assert!(Workspace::bytes_for_manifolds(&[&asset], 512) <= memory.len());
        let mut workspace = Workspace::in_bytes(&mut memory);
        let mut query = pose.query(&mut workspace);
        let mut sink = SliceSink::new(&mut contacts);
        let ball = Ball::new(point, 0.3);
        query.contacts(ball, &mut sink).expect("ball");
        found += sink.items().len();
        sink.clear();
        query
            .contacts(HalfSpace::new(point, -0.5), &mut sink)
            .expect("half-space");
        found += sink.items().len();
        sink.clear();
        query
            .contacts(Capsule::new(point, [0.0; 3], 0.1), &mut sink)
            .expect("capsule");
        found += sink.items().len();
        sink.clear();
        let cuboid = Cuboid::new(point, [0.2; 3]).rotated([0.0, 0.0, 0.6, 0.8]);
        query.contacts(cuboid, &mut sink).expect("box");
        found += sink.items().len();
        found += usize::from(query.intersects(cuboid).expect("box"));
        let planes = Frustum::new(&[[1.0, 0.0, 0.0, -0.1]]).expect("planes");
        let state = query.frustum_state(&planes).expect("frustum");
        found += usize::from(state == FrustumState::Intersects);
        let sphere = pose.bounding_sphere().expect("sphere");
        found += usize::from(sphere.radius > 1.0);
        let aabb = pose.aabb().expect("box");
        found += usize::from(aabb.max[0] > aabb.min[0]);
        let near = query.project_point(point, f64::INFINITY).expect("near");
        found += usize::from(near.is_some());
        let ray = Ray::new([3.0; 3], [-1.0; 3]);
        let hit = query.cast_ray(&ray).expect("ray");
        found += usize::from(hit.is_some());
        let size = CacheSize {
            nodes: 9,
            leaves: 9,
        };
        let mut slots = [0; 9 * 136 + 9 * 176 + 8];
        let mut cache = StepCache::in_bytes(&mut slots, size).expect("a cache");
        cache.start(&pose);
        let mut query = pose.query(&mut workspace).cached(&mut cache);
        let mut hits = [None; 2];
        query.cast_rays(&[ray; 2], &mut hits).expect("rays");
        found += hits.iter().flatten().count();
        let mut any = [false; 2];
        query.intersects_rays(&[ray; 2], &mut any).expect("rays");
        let mut all = Count(0);
        query.cast_rays_all(&[ray; 2], &mut all).expect("rays");
        found += all.0;
        let mut sink = SliceSink::new(&mut pairs);
        let mut query = pose.against(&pose2, &mut workspace);
        query.contacts(0.0, &mut sink).expect("pair");
        found += sink.items().len();
        let (mut slots1, mut slots2) = ([Proxy::EMPTY; 64], [Proxy::EMPTY; 64]);
        let (mut proxies1, mut proxies2) =
            (SliceSink::new(&mut slots1), SliceSink::new(&mut slots2));
        let query = pose.query(&mut workspace).cached(&mut cache);
        let mut query = query.max_level(0, &mut proxies1);
        query.contacts(ball, &mut Count(0)).expect("ball");
        found += proxies1.items().len();
        let query = pose.against(&pose2, &mut workspace);
        let mut query = (query.max_level1(1, &mut proxies1)).max_level2(0, &mut proxies2);
        query.contacts(0.0, &mut Count(0)).expect("pair");
        found += proxies2.items().len();
        let (mut lanes, mut lane_pairs) = ([LaneId::EMPTY; 8], [[LaneId::EMPTY; 2]; 8]);
        let mut lanes = SliceSink::new(&mut lanes);
        let mut query = pose.query(&mut workspace).cached(&mut cache);
        query.level_spheres(1, ball, &mut lanes).expect("ball");
        let mut lane_pairs = SliceSink::new(&mut lane_pairs);
        let mut query = pose.against(&pose2, &mut workspace);
        let coverage = query.level_spheres([0, 1], 0.0, 0.1, &mut lane_pairs);
        coverage.expect("pairs of spheres");
        let mut near = [LaneTriangle::EMPTY; 8];
        let mut near = SliceSink::new(&mut near);
        let coverage = query.level_triangles(1, 0.0, 0.1, &mut near);
        coverage.expect("spheres and triangles");
        assert!(!near.items().is_empty());
        assert!(!lanes.items().is_empty() && !lane_pairs.items().is_empty());
        let spheres = [&pose, &pose2].map(|pose| pose.bounding_sphere().expect("sphere"));
        let mut near = [[0; 2]; 1];
        let mut near = SliceSink::new(&mut near);
        broad::pairs(&spheres, 0.0, &mut workspace, &mut near).expect("pairs");
        assert_eq!(*near.items(), [[0, 1]]);
        let mut regions = Count(0);
        let mut query = pose.against(&pose2, &mut workspace);
        query
            .condense(sink.items_mut(), &mut regions)
            .expect("manifold");
        query
            .contact_manifolds(0.0, &mut regions)
            .expect("manifold");
        found += regions.0;
        let near = query.closest_points(9.0).expect("distance");
        found += usize::from(near.is_some());
        let near = query.max_visits(9).closest_points(9.0).expect("distance");
        found += usize::from(near.found.is_some());
        let mut query = pose.query(&mut workspace).max_visits(9);
        let near = query.project_point(point, 9.0).expect("near");
        found += usize::from(near.found.is_some());
        let mut out = [0.0; 4];
        pose.add_generalized_force(TriangleId(0), [1.0, 0.0, 0.0], [1.0; 3], &mut out)
            .expect("force");
        let rest = asset.rest_vertex(VertexId(3), &mut [[0.0; 3]; 4]);
        rest.expect("a vertex");
        let frame = asset.frame(2).expect("a frame");
        let placed = place.after(frame.transform()).expect("a placement");
        let mut sampled = [0.0; 4];
        asset.sample(0.05, &mut sampled).expect("a pose");
        let pose = asset.pose(frame.q(), placed, &mut memory1).expect("pose");
        let near = pose
            .query(&mut workspace)
            .project_point(point, f64::INFINITY);
        found += usize::from(near.expect("near").is_some());
        assert!(asset.verify(&mut |_| ControlFlow::Break(())));
        found
    });
    assert!(found > 20, "{found}");
    assert_eq!(count, 0, "nothing is allocated");
}

/// What owns its memory allocates when it is made and when more is asked of it than ever before.
#[test]
fn instances_allocate_nothing_after_the_first_step() {
    for model in animated() {
        let mut bodies = [0, 1].map(|_| Instance::new(&model).expect("an instance"));
        let mut workspace = Workspace::new();
        let mut slots = vec![0; 1 << 16];
        let mut front = PairFront::in_bytes(&mut slots);
        let mut contacts = [Contact::EMPTY; 512];
        let mut pairs = [PairContact::EMPTY; 512];
        let mut manifolds = Count(0);
        let mut taken = 0;
        // There and back, so that no step needs more than the first: the two are nearest there.
        for step in 0..12 {
            let (count, ()) = allocations(|| {
                let [a, b] = &mut bodies;
                let away = f64::from(step).min(f64::from(12 - step)) * 0.02;
                a.set_q(&[0.3, -0.1, 0.2, 0.0]).expect("q");
                b.set_placement(Transform::from_translation([1.2 + away, 0.0, 0.0]))
                    .expect("a placement");
                let mut sink = SliceSink::new(&mut contacts);
                let mut query = a.query(&mut workspace);
                query
                    .contacts(Ball::new([1.0, 0.0, 0.0], 0.5), &mut sink)
                    .expect("ball");
                query.cast_ray(&Ray::new([3.0; 3], [-1.0; 3])).expect("ray");
                taken += sink.items().len();
                let mut sink = SliceSink::new(&mut pairs);
                let query = a.against(b, &mut workspace);
                let mut query = query.front(&mut front);
                let coverage = query.contacts(0.01, &mut sink).expect("pair");
                assert_eq!(coverage, Coverage::Complete);
                taken += sink.items().len();
                query
                    .contact_manifolds(0.0, &mut manifolds)
                    .expect("manifolds");
                a.against(b, &mut workspace)
                    .distance(9.0)
                    .expect("distance");
                let mut near = [[0; 2]];
                let mut near = SliceSink::new(&mut near);
                broad::instance_pairs(&bodies, 0.0, &mut workspace, &mut near).expect("pairs");
                assert_eq!(*near.items(), [[0, 1]]);
            });
            assert_eq!(count > 0, step == 0, "step {step}: {count} allocations");
        }
        assert!(taken > 100 && manifolds.0 > 0);
    }
}

/// A sphere with two modes and five bones, each of which moves every fifth vertex.
fn skinned() -> Model {
    let mesh = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1));
    let vertices = 0..mesh.positions.len();
    let source = SkinSource {
        influences: vertices.map(|i| vec![((i % 5) as u16, 1.0)]).collect(),
        bones: (0..5)
            .map(|joint| BoneSource {
                joint,
                inverse_bind: joint::IDENTITY,
            })
            .collect(),
        nodes: (0..5)
            .map(|k| NodeSource {
                name: format!("joint {k}"),
                parent: None,
                local: LocalSource::Matrix(joint::IDENTITY.map(|row| row.map(|x| x as f32))),
            })
            .collect(),
        joints: (0..5).collect(),
        clips: Vec::new(),
    };
    Model::from_bytes(&with_skin(model.asset().bytes(), &source)).expect("a sound file")
}

#[test]
fn moving_bones_allocates_nothing() {
    let model = skinned();
    let asset = model.asset();
    let mut body = Instance::new(&model).expect("an instance");
    let mut memory = vec![0.0; asset.pose_len()];
    let (count, ()) = allocations(|| {
        let mut joints = [joint::IDENTITY; 5];
        for step in 0..4 {
            joints[step][0][3] = 0.25 * step as f64;
            body.set_joints(&joints).expect("joints");
            body.set_skinning_matrices(&joints).expect("matrices");
            let bones = BoneMatrices::Joints(&joints);
            body.set_pose_with_bones(&[0.1, 0.2], bones, Transform::IDENTITY)
                .expect("a pose");
            body.set_q(&[0.2, 0.1]).expect("q");
            let aabb = body.aabb().expect("a box");
            let pose = asset.pose_with_bones(&[0.2, 0.1], bones, Transform::IDENTITY, &mut memory);
            let pose = pose.expect("a pose");
            assert_eq!(pose.aabb().expect("a box"), aabb);
        }
    });
    assert_eq!(count, 0, "nothing is allocated");
}

#[test]
fn a_full_sink_is_said_and_holds_a_part_of_the_answer() {
    let mesh = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1));
    let asset = *model.asset();
    let mut memory = [0.0; 9];
    let pose = asset
        .pose(&[0.1, 0.2], Transform::IDENTITY, &mut memory)
        .expect("pose");
    let mut workspace = Workspace::new();
    let mut query = pose.query(&mut workspace);
    let ball = Ball::new([1.0, 0.0, 0.0], 0.6);
    let mut all: Vec<Contact> = Vec::new();
    query.contacts(ball, &mut all).expect("ball");
    assert!(all.len() > 4);
    for room in [0, 1, all.len() - 1, all.len(), all.len() + 1] {
        let mut slots = vec![Contact::EMPTY; room];
        let mut sink = SliceSink::new(&mut slots);
        let coverage = query.contacts(ball, &mut sink).expect("ball");
        let taken = sink.items().len();
        assert_eq!(
            coverage == Coverage::Truncated,
            room < all.len(),
            "room for {room} of {}",
            all.len()
        );
        assert_eq!(taken, room.min(all.len()));
        assert_eq!(slots[..taken], all[..taken], "the first ones, in order");
    }
    // Nothing found: no room is needed.
    let mut sink = SliceSink::<Contact>::new(&mut []);
    let far = query.contacts(Ball::new([9.0; 3], 0.1), &mut sink);
    assert_eq!(far, Ok(Coverage::Complete));
}

/// x·f is linear in q, so a difference quotient is its derivative up to rounding in f32.
#[test]
fn generalized_forces_are_derivatives_of_work() {
    let mesh = bake::bumpy_sphere(8, 1);
    let dense = bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 1));
    let sparse = bake::baked(&mesh, &bake::local_basis(&mesh, 3, 1));
    for model in [dense, sparse] {
        forces_are_derivatives(model.asset());
    }
}

fn forces_are_derivatives(asset: &Asset<'_>) {
    let mut rng = poses::rng(3);
    let place = poses::random_transform(2.0, &mut rng);
    let (weights, force) = ([0.2, 0.5, 0.3], [1.0, -2.0, 0.5]);
    for id in [0, 7, 50].map(TriangleId) {
        let work = |q: &[f32]| {
            let mut memory = [0.0; 9];
            let pose = asset.pose(q, place, &mut memory).expect("pose");
            let corners = asset.triangle(id).expect("triangle");
            let mut work = 0.0;
            for (corner, weight) in corners.iter().zip(weights) {
                let x = pose.deformed(*corner).expect("vertex");
                work += weight * (x[0] * force[0] + x[1] * force[1] + x[2] * force[2]);
            }
            work
        };
        let q = [0.25, -0.5, 0.125];
        let mut memory = [0.0; 9];
        let pose = asset.pose(&q, place, &mut memory).expect("pose");
        let mut out = [10.0; 3];
        pose.add_generalized_force(id, weights, force, &mut out)
            .expect("force");
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
