//! Pairs that stay close: with a front the answers of every step are those of a walk from the root,
//! and where the two hardly move or stay apart no node is visited.

use bdtree_fixtures::{bake, compare, poses};
use bdtree_runtime::{
    Asset, Instance, Model, Motion, PairContact, PairFront, QueryError, Transform, TrianglePair,
    VertexId, Workspace,
};
use rand::RngExt;

fn bumpy() -> Model {
    let mesh = bake::bumpy_sphere(20, 3);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 7, 4))
}

/// What a walk of two bodies did.
#[derive(Debug, Default)]
struct Tally {
    touching: usize,
    visits_with: u64,
    visits_without: u64,
    steps_apart: usize,
}

/// How fast two bodies move per step, in shares of their diagonal.
#[derive(Clone, Copy)]
struct Speed {
    q: f64,
    place: f64,
}

/// Two bodies about each other, `gap` of their diagonal between their middles.
fn walk(asset: &Asset<'_>, slots: usize, gap: f64, speed: Speed, steps: usize, seed: u64) -> Tally {
    let mut rng = poses::rng(seed);
    let size = poses::diagonal(asset) * asset.unit();
    let mut bytes = vec![0xff; PairFront::SLOT_BYTES * slots + 7];
    let mut front = PairFront::in_bytes(&mut bytes);
    let mut workspace = Workspace::new();
    let mut q = [0, 1].map(|_| poses::random_q(asset, 0.1, &mut rng));
    let mut places = [0, 1].map(|k| Transform {
        translation: [gap * size * f64::from(k), 0.0, 0.0],
        ..poses::random_transform(size, &mut rng)
    });
    places.iter_mut().for_each(|place| place.scale = 1.0);
    let mut front_of_any = PairFront::new();
    let mut before: Option<[(Vec<f32>, Transform, Motion); 2]> = None;
    let mut tally = Tally::default();
    for step in 0..steps {
        let mut memory = [0; 4].map(|_| vec![0.0; asset.pose_len()]);
        let [m0, m1, m2, m3] = &mut memory;
        let now = [
            asset.pose(&q[0], places[0], m0).unwrap(),
            asset.pose(&q[1], places[1], m1).unwrap(),
        ];
        let motions = match &before {
            None => [Motion::new(&now[0]), Motion::new(&now[1])],
            Some([a, b]) => {
                let old = [
                    asset.pose(&a.0, a.1, m2).unwrap(),
                    asset.pose(&b.0, b.1, m3).unwrap(),
                ];
                let mut motions = [a.2, b.2];
                for k in 0..2 {
                    motions[k].advance(&old[k], &now[k]).unwrap();
                }
                motions
            }
        };
        let tolerance = if seed.is_multiple_of(2) {
            0.0
        } else {
            0.005 * size
        };
        let (mut with, mut without): (Vec<TrianglePair>, Vec<TrianglePair>) = (vec![], vec![]);
        let moving = [0, 1].map(|k| now[k].moving(&motions[k]).unwrap());
        let mut query = moving[0]
            .against(&moving[1], &mut workspace)
            .front(&mut front);
        query.triangle_pairs(tolerance, &mut with).unwrap();
        tally.visits_with += query.stats().nodes_visited;
        let mut query = moving[0]
            .against(&moving[1], &mut workspace)
            .front(&mut front_of_any);
        let is_near = query.is_within(tolerance).unwrap();
        assert_eq!(is_near, !with.is_empty(), "step {step}");
        let mut query = now[0].against(&now[1], &mut workspace);
        query.triangle_pairs(tolerance, &mut without).unwrap();
        tally.visits_without += query.stats().nodes_visited;
        with.sort_unstable_by_key(|p| (p.triangle1, p.triangle2));
        without.sort_unstable_by_key(|p| (p.triangle1, p.triangle2));
        assert_eq!(with, without, "step {step}");
        tally.touching += with.len();
        tally.steps_apart += usize::from(with.is_empty());

        let [p0, p1] = places;
        before = Some([
            (q[0].clone(), p0, motions[0]),
            (q[1].clone(), p1, motions[1]),
        ]);
        for q in &mut q {
            let change = poses::random_q(asset, speed.q, &mut rng);
            q.iter_mut().zip(change).for_each(|(q, c)| *q += c);
        }
        for place in &mut places {
            for x in &mut place.translation {
                *x += speed.place * size * rng.random_range(-1.0..1.0);
            }
            for x in &mut place.rotation {
                *x += speed.place * rng.random_range(-1.0..1.0);
            }
            let norm = place.rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
            place.rotation.iter_mut().for_each(|x| *x /= norm);
        }
    }
    tally
}

#[test]
fn answers_are_those_of_a_walk_from_the_root() {
    let model = bumpy();
    let mut touching = 0;
    for asset in compare::kernels(model.asset()) {
        for (seed, (q, place)) in [(0.0003, 0.0003), (0.004, 0.0), (0.0, 0.01), (0.1, 0.1)]
            .into_iter()
            .enumerate()
        {
            for (slots, gap) in [(0, 0.42), (3, 0.42), (4096, 0.42), (4096, 0.55)] {
                let speed = Speed { q, place };
                let tally = walk(&asset, slots, gap, speed, 25, 20 + seed as u64);
                touching += tally.touching;
            }
        }
    }
    assert!(touching > 1000, "{touching}");
}

#[test]
fn slow_pairs_and_separate_ones_visit_few_nodes() {
    let model = bumpy();
    let asset = *model.asset();
    let speed = Speed {
        q: 0.0002,
        place: 0.0002,
    };
    let close = walk(&asset, 8192, 0.42, speed, 60, 2);
    assert!(close.touching > 0, "{close:?}");
    assert!(close.visits_with * 2 < close.visits_without, "{close:?}");
    let apart = walk(&asset, 4096, 0.64, speed, 60, 4);
    assert!(apart.steps_apart > 50, "{apart:?}");
    assert!(apart.visits_with * 2 < apart.visits_without, "{apart:?}");
    // Too fast for any margin: about the visits of walks from the root.
    let speed = Speed { q: 0.2, place: 0.2 };
    let fast = walk(&asset, 8192, 0.42, speed, 60, 6);
    assert!(fast.visits_with * 10 < fast.visits_without * 13, "{fast:?}");
}

#[test]
fn points_are_the_same_too_and_wrong_motions_are_refused() {
    let model = bumpy();
    let asset = model.asset();
    let size = poses::diagonal(asset) * asset.unit();
    let mut rng = poses::rng(1);
    let mut memory = [0; 3].map(|_| vec![0.0; asset.pose_len()]);
    let [m0, m1, m2] = &mut memory;
    let q = poses::random_q(asset, 0.1, &mut rng);
    let aside = Transform::from_translation([0.5 * size, 0.0, 0.0]);
    let a = asset.pose(&q, Transform::IDENTITY, m0).unwrap();
    let b = asset.pose(&q, aside, m1).unwrap();
    let further: Vec<f32> = q.iter().map(|q| q * 1.001).collect();
    let c = asset.pose(&further, aside, m2).unwrap();
    let (motion_a, mut motion_b) = (Motion::new(&a), Motion::new(&b));
    let mut workspace = Workspace::new();
    let mut front = PairFront::new();
    let mut contacts: Vec<PairContact> = Vec::new();
    // Poses that do not say how far they have moved.
    for (first, second) in [(a, b), (a.moving(&motion_a).unwrap(), b)] {
        let mut query = first.against(&second, &mut workspace).front(&mut front);
        assert_eq!(query.contacts(0.0, &mut contacts), Err(QueryError::Motion));
        assert_eq!(query.intersects(), Err(QueryError::Motion));
        let mut ids: Vec<TrianglePair> = Vec::new();
        let refused = query.triangle_pairs(0.0, &mut ids);
        assert_eq!(refused, Err(QueryError::Motion));
    }
    assert!(contacts.is_empty());
    let (a, b) = (a.moving(&motion_a).unwrap(), b.moving(&motion_b).unwrap());
    for round in 0..3 {
        let (mut with, mut without): (Vec<PairContact>, Vec<PairContact>) = (vec![], vec![]);
        let mut query = a.against(&b, &mut workspace).front(&mut front);
        query.contacts(0.0, &mut with).unwrap();
        let visited = query.stats().nodes_visited;
        assert_eq!(query.intersects(), Ok(true));
        let mut query = a.against(&b, &mut workspace);
        query.contacts(0.0, &mut without).unwrap();
        assert!(!with.is_empty());
        assert_eq!(with, without);
        // The first walk finds out how much memory the front takes, the second fills it.
        assert_eq!(visited == 0, round > 1, "nothing moves");
    }
    // The motion has not come to c yet.
    assert_eq!(c.moving(&motion_b).err(), Some(QueryError::Motion));
    assert_eq!(motion_b.advance(&c, &b), Err(QueryError::Motion));
    motion_b.advance(&b, &c).unwrap();
    assert!(motion_b.total() > 0.0);
    let c = c.moving(&motion_b).unwrap();
    let mut query = a.against(&c, &mut workspace).front(&mut front);
    query.contacts(0.0, &mut contacts).unwrap();
    // Elsewhere it has no motion any more.
    let placed = c.placed(Transform::IDENTITY).unwrap();
    let mut query = a.against(&placed, &mut workspace).front(&mut front);
    assert_eq!(query.intersects(), Err(QueryError::Motion));
}

/// A front that another pair takes, whose poses are the same as those where the first pair stood: nothing of
/// the first pair is answered.
#[test]
fn a_front_of_another_pair_begins_anew() {
    let model = bumpy();
    let size = poses::diagonal(model.asset()) * model.asset().unit();
    let near = Transform::from_translation([0.5 * size, 0.0, 0.0]);
    let far = Transform::from_translation([2.0 * size, 0.0, 0.0]);
    let mut workspace = Workspace::new();
    let mut front = PairFront::new();
    let mut bodies = [0; 4].map(|_| Instance::new(&model).unwrap());
    let mut found: Vec<TrianglePair> = Vec::new();
    let [a, b, c, d] = &mut bodies;
    // Both pairs start at the same poses, and each moves away by the same steps.
    let mut answers = [Vec::new(), Vec::new()];
    for (step, place) in [near, near, near, far, near].into_iter().enumerate() {
        // The second pair is one step behind.
        for (pair, answers) in [(&mut *a, &mut *b), (&mut *c, &mut *d)]
            .into_iter()
            .zip(&mut answers)
        {
            let (first, second) = pair;
            second.set_placement(place).unwrap();
            found.clear();
            let mut query = first.against(second, &mut workspace).front(&mut front);
            query.triangle_pairs(0.0, &mut found).unwrap();
            assert_eq!(found.is_empty(), place == far, "step {step}");
            found.sort_unstable();
            answers.push(found.clone());
        }
    }
    assert_eq!(answers[0], answers[1]);
    // One stays apart where the other touches: the front says of each what is true of it.
    for round in 0..40 {
        b.set_placement(near).unwrap();
        d.set_placement(far).unwrap();
        let mut query = a.against(b, &mut workspace).front(&mut front);
        assert_eq!(query.intersects(), Ok(true), "round {round}");
        let mut query = c.against(d, &mut workspace).front(&mut front);
        assert_eq!(query.intersects(), Ok(false), "round {round}");
    }
}

/// No vertex comes farther than the motion says.
#[test]
fn motion_bounds_the_way_of_every_vertex() {
    let model = bumpy();
    let asset = model.asset();
    let size = poses::diagonal(asset) * asset.unit();
    let mut rng = poses::rng(9);
    for round in 0..40 {
        let mut memory = [0; 2].map(|_| vec![0.0; asset.pose_len()]);
        let [m0, m1] = &mut memory;
        let far = if round % 3 == 0 { 1e6 } else { 1.0 };
        let place = poses::random_transform(far * size, &mut rng);
        let mut next = place;
        let share = 10_f64.powi(-(round % 5));
        if round % 2 == 0 {
            next.translation[0] += share * size;
            next.scale *= 1.0 + 0.1 * share;
            next.rotation = poses::random_transform(size, &mut rng).rotation;
        }
        let q = poses::random_q(asset, 0.1, &mut rng);
        let change = poses::random_q(asset, share, &mut rng);
        let moved: Vec<f32> = q.iter().zip(change).map(|(q, c)| q + c).collect();
        let from = asset.pose(&q, place, m0).unwrap();
        let to = asset.pose(&moved, next, m1).unwrap();
        let mut motion = Motion::new(&from);
        motion.advance(&from, &to).unwrap();
        let mut largest = 0.0_f64;
        for vertex in 0..asset.vertex_count() as u32 {
            let vertex = VertexId(vertex);
            let a = from.deformed(vertex).unwrap();
            let b = to.deformed(vertex).unwrap();
            let way = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
            largest = largest.max(way);
        }
        assert!(motion.total() >= largest, "{} < {largest}", motion.total());
        // Not much more either: a bound that says nothing keeps no front.
        assert!(
            motion.total() <= 40.0 * largest + 1e-4 * far * size,
            "{round}"
        );
    }
}
