//! Manifolds keep what the engine stores in them from step to step.

use bdtree_fixtures::poses;

use super::ours::{DeformingMesh, MeshDispatcher};
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::{
    ContactManifold, ContactManifoldsWorkspace, PersistentQueryDispatcher, PointQuery,
    PointQueryWithLocation,
};
use super::parry::shape::{Cuboid, PackedFeatureId, Shape};
use super::support;

const PREDICTION: Real = 0.05;

/// What an engine keeps: a mark for each manifold and each point.
type Kept = ContactManifold<u32, u32>;

fn update(pos12: &Pose, one: &dyn Shape, two: &dyn Shape, kept: &mut Vec<Kept>) {
    // An engine drops the workspace when a shape has changed.
    let mut workspace: Option<ContactManifoldsWorkspace> = None;
    MeshDispatcher::new()
        .contact_manifolds(pos12, one, two, PREDICTION, kept, &mut workspace)
        .expect("manifolds");
    assert!(
        workspace.is_some(),
        "tells that the order of manifolds may change"
    );
}

#[test]
fn marks_stay_with_points_that_stay() {
    let mut rng = poses::rng(31);
    let model = support::bumpy();
    let mesh = support::mesh(model, &mut rng);
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let height = -0.5 - 0.8 + 0.1;
    for is_swapped in [false, true] {
        let mut kept: Vec<Kept> = Vec::new();
        let (mut found, mut lost, mut marks) = (0, 0, 1);
        for step in 0..40 {
            // Sinks slowly, slides a little, and q wobbles.
            let wobble = 0.002 * (step as f32).sin();
            let q: Vec<f32> = mesh.q().iter().map(|q| q + wobble).collect();
            let mesh = DeformingMesh::new(model, &q).expect("a mesh");
            let slide = 0.0005 * step as Real;
            let pos = Pose::translation(slide, height + 0.2 * slide, 0.0);
            let before: usize = kept
                .iter()
                .map(|m| m.points.iter().filter(|p| p.data > 0).count())
                .sum();
            match is_swapped {
                false => update(&pos, &mesh, &ground, &mut kept),
                true => update(&pos.inverse(), &ground, &mesh, &mut kept),
            }
            let points = || kept.iter().flat_map(|m| &m.points);
            let marked: Vec<u32> = points().map(|p| p.data).filter(|mark| *mark > 0).collect();
            let mut once = marked.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), marked.len(), "no mark is there twice");
            found += marked.len();
            lost += before - marked.len().min(before);
            for manifold in &mut kept {
                if step > 0 && manifold.data == 0 {
                    marks += 1;
                }
                manifold.data = manifold.data.max(marks);
                for point in &mut manifold.points {
                    if point.data == 0 {
                        marks += 1;
                        point.data = marks;
                    }
                }
            }
            assert!(!kept.is_empty(), "step {step}: no contact");
        }
        assert!(
            found > 40 && lost * 5 < found,
            "{found} marks stayed, {lost} were lost"
        );
    }
}

#[test]
fn what_parted_leaves_no_manifold() {
    let mut rng = poses::rng(37);
    let mesh = support::mesh(support::bumpy(), &mut rng);
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let mut kept: Vec<Kept> = Vec::new();
    update(
        &Pose::translation(0.0, -1.2, 0.0),
        &mesh,
        &ground,
        &mut kept,
    );
    assert!(!kept.is_empty());
    update(
        &Pose::translation(0.0, -3.0, 0.0),
        &mesh,
        &ground,
        &mut kept,
    );
    assert!(kept.is_empty());
}

/// How far two bodies may drift, world units.
const DRIFT: Real = 0.02;

/// Contacts of a body and of something that nobody remembers.
fn fresh(pos12: &Pose, one: &DeformingMesh, two: &dyn Shape, kept: &[Kept]) -> Vec<Kept> {
    let plain = |mesh: &DeformingMesh| DeformingMesh::new(mesh.model(), mesh.q()).expect("a mesh");
    let mut found = kept.to_vec();
    match two.as_shape::<DeformingMesh>() {
        Some(mesh) => update(pos12, &plain(one), &plain(mesh), &mut found),
        None => update(pos12, &plain(one), two, &mut found),
    }
    found
}

type Told = (Vector, Vector, Real, [u32; 2]);

fn told(kept: &[Kept]) -> Vec<Told> {
    let each = kept.iter().flat_map(|manifold| &manifold.points);
    each.map(|p| (p.local_p1, p.local_p2, p.dist, [p.fid1.0, p.fid2.0]))
        .collect()
}

fn deepest(kept: &[Kept]) -> Real {
    told(kept)
        .iter()
        .map(|p| p.2)
        .fold(Real::INFINITY, Real::min)
}

/// q at which no vertex has moved farther than `way` from where it was, and some may have.
fn moved(mesh: &DeformingMesh, way: Real) -> DeformingMesh {
    let model = mesh.model();
    let asset = model.model().asset();
    let reach: f64 = asset
        .modes()
        .iter()
        .map(|mode| f64::from(mode.field_norm_max.get()))
        .sum();
    let change = (f64::from(way) / (reach * asset.unit() * model.scale())) as f32;
    let q: Vec<f32> = mesh.q().iter().map(|q| q + change).collect();
    mesh.with_q(&q).expect("a mesh")
}

#[test]
fn contacts_follow_the_surface() {
    let mut rng = poses::rng(41);
    let start = support::mesh(support::bumpy(), &mut rng);
    let [body, other] = [(); 2].map(|()| start.with_lasting_contacts(DRIFT).expect("a mesh"));
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let cases: [(&dyn Shape, Real); 2] = [(&ground, -1.2), (&other, 1.5)];
    for (two, height) in cases {
        let mut kept: Vec<Kept> = Vec::new();
        update(&Pose::translation(0.0, height, 0.0), &body, two, &mut kept);
        let features: Vec<_> = told(&kept).iter().map(|p| p.3).collect();
        assert!(!features.is_empty());
        for step in 1..10 {
            // Both move and deform: contacts together by less than they may, what is elsewhere perhaps by more.
            let way = 0.05 * DRIFT * step as Real;
            let pos = Pose::translation(way, height, 0.0);
            let deformed = moved(&body, 1.5 * way);
            update(&pos, &deformed, two, &mut kept);
            let now: Vec<_> = told(&kept).iter().map(|p| p.3).collect();
            assert_eq!(now, features, "step {step}: the same points");
            let off = (deepest(&kept) - deepest(&fresh(&pos, &deformed, two, &[]))).abs();
            assert!(off <= 2.5 * way, "step {step}: the deepest is {off} off");
            for manifold in &kept {
                for point in &manifold.points {
                    let on = deformed.project_local_point(point.local_p1, false).point;
                    let off = on.distance(point.local_p1);
                    assert!(off < 1e-5, "step {step}: {off} off the surface");
                    let dist = (pos * point.local_p2 - point.local_p1).dot(manifold.local_n1);
                    assert!((dist - point.dist).abs() < 1e-6);
                }
            }
        }
    }
}

#[test]
fn contacts_are_looked_for_anew_after_a_drift() {
    let mut rng = poses::rng(43);
    let start = support::mesh(support::bumpy(), &mut rng);
    let [body, other] = [(); 2].map(|()| start.with_lasting_contacts(DRIFT).expect("a mesh"));
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let wider = Cuboid::new(support::vector([2.5, 0.5, 2.0]));
    let (low, high) = (
        Pose::translation(0.0, -1.2, 0.0),
        Pose::translation(0.0, 1.5, 0.0),
    );
    let aside = |pose: &Pose| Pose::translation(1.1 * DRIFT, 0.0, 0.0) * *pose;
    let far = moved(&body, 4.1 * DRIFT);
    type Case<'a> = (&'a dyn Shape, Pose, &'a DeformingMesh, &'a dyn Shape, Pose);
    let cases: [Case<'_>; 5] = [
        (&ground, low, &far, &ground, low),
        (&ground, low, &body, &ground, aside(&low)),
        (&ground, low, &body, &wider, low),
        (&other, high, &far, &other, high),
        (&other, high, &body, &other, aside(&high)),
    ];
    for (k, (two, pos, deformed, other, at)) in cases.into_iter().enumerate() {
        let mut kept: Vec<Kept> = Vec::new();
        update(&pos, &body, two, &mut kept);
        let expected = fresh(&at, deformed, other, &kept);
        update(&at, deformed, other, &mut kept);
        assert_eq!(told(&kept), told(&expected), "case {k}");
    }
}

/// Where on which triangle of a mesh a point is.
fn place(mesh: &DeformingMesh, fid: u32, point: Vector) -> impl Fn(&DeformingMesh) -> Vector {
    let id = mesh.triangle_of(PackedFeatureId(fid)).expect("a triangle");
    let triangle = mesh.triangle(id).expect("a triangle");
    let (_, location) = triangle.project_local_point_and_get_location(point, false);
    let [a, b, c] = location.barycentric_coordinates().expect("a place");
    move |mesh| {
        let triangle = mesh.triangle(id).expect("a triangle");
        triangle.a * a + triangle.b * b + triangle.c * c
    }
}

/// Contacts are looked for anew just when one has moved too far, though bodies may have bent by more.
#[test]
fn what_bends_away_from_contacts_may_go_farther() {
    let mut rng = poses::rng(43);
    let start = support::mesh(support::bumpy(), &mut rng);
    let [body, other] = [(); 2].map(|()| start.with_lasting_contacts(DRIFT).expect("a mesh"));
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let rotation = support::pose(1.0, &mut rng).rotation;
    let turned = Pose::from_parts(support::vector([0.0, 1.2, 0.0]), rotation);
    let cases: [(Option<&DeformingMesh>, Pose); 2] = [
        (None, Pose::translation(0.0, -1.2, 0.0)),
        (Some(&other), turned),
    ];
    for (k, (mesh, pos)) in cases.into_iter().enumerate() {
        for aside in [0.0, 0.5] {
            let [mut lasted, mut were_lost] = [0; 2];
            for step in 1..40 {
                let two: &dyn Shape = mesh.map_or(&ground, |mesh| mesh);
                let mut kept: Vec<Kept> = Vec::new();
                update(&pos, &body, two, &mut kept);
                let before = told(&kept);
                assert!(deepest(&kept) < 0.0, "case {k}: they touch");
                let bent = 0.1 * DRIFT * step as Real;
                let deformed = moved(&body, bent);
                let deformed2 = mesh.map(|mesh| moved(mesh, bent));
                let two: &dyn Shape = match &deformed2 {
                    Some(mesh) => mesh,
                    None => &ground,
                };
                let at = Pose::translation(aside * DRIFT, 0.0, 0.0) * pos;
                let ways = before.iter().map(|(p1, p2, _, [fid1, fid2])| {
                    let by1 = place(&body, *fid1, *p1)(&deformed) - *p1;
                    let by2 = match (mesh, &deformed2) {
                        (Some(was), Some(is)) => place(was, *fid2, *p2)(is) - *p2,
                        _ => Vector::ZERO,
                    };
                    (at.rotation * by2 - by1).length()
                });
                let farthest = aside * DRIFT + ways.fold(0.0, Real::max);
                update(&at, &deformed, two, &mut kept);
                let after = told(&kept);
                let anew = told(&fresh(&at, &deformed, two, &kept));
                let bounds = if mesh.is_some() { 2.0 * bent } else { bent };
                if farthest < 0.95 * DRIFT && bounds < 3.9 * DRIFT {
                    let same = after.iter().zip(&before).all(|(is, was)| is.3 == was.3);
                    assert!(same, "case {k}, step {step}: they went {farthest}");
                    assert_eq!(after.len(), before.len());
                    lasted += usize::from(bounds > DRIFT);
                } else if farthest > 1.05 * DRIFT || bounds > 4.1 * DRIFT {
                    assert_eq!(after, anew, "case {k}, step {step}: one went {farthest}");
                    were_lost += 1;
                }
            }
            // Aside, little is left for bending.
            let least = if aside > 0.0 { 0 } else { 2 };
            assert!(
                lasted >= least,
                "case {k}: {lasted} lasted beyond the drift of the body"
            );
            assert!(were_lost > 3, "case {k}: none went far");
        }
    }
}

/// Two sheets that nearly touch have one point, which does not stand for the others for long.
#[test]
fn what_does_not_touch_yet_is_looked_for_sooner() {
    let mut rng = poses::rng(59);
    let start = support::mesh(support::bumpy(), &mut rng);
    // Farther than half of the prediction.
    let drift = 0.8 * PREDICTION;
    let [body, other] = [(); 2].map(|()| start.with_lasting_contacts(drift).expect("a mesh"));
    let high = |up: Real| Pose::translation(0.0, up, 0.0);
    let apart = (0..400).map(|k| 3.0 - 0.005 * k as Real).find(|up| {
        let found = fresh(&high(*up), &body, &other, &[]);
        !found.is_empty() && deepest(&found) > 0.0 && deepest(&found) < 0.9 * PREDICTION
    });
    let up = apart.expect("a height at which they nearly touch");
    let mut kept: Vec<Kept> = Vec::new();
    update(&high(up), &body, &other, &mut kept);
    assert!(!kept.is_empty());
    let near = high(up - 0.6 * PREDICTION);
    let expected = fresh(&near, &body, &other, &kept);
    update(&near, &body, &other, &mut kept);
    assert_eq!(told(&kept), told(&expected));
}

#[test]
fn what_comes_near_is_seen() {
    let mut rng = poses::rng(47);
    let start = support::mesh(support::bumpy(), &mut rng);
    // However far bodies may drift.
    let [body, other] = [(); 2].map(|()| start.with_lasting_contacts(10.0).expect("a mesh"));
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let cases: [(&dyn Shape, Real); 2] = [(&ground, -1.0), (&other, 1.0)];
    for (two, up) in cases {
        let mut kept: Vec<Kept> = Vec::new();
        let mut seen = 0;
        for step in 0..400 {
            let pos = Pose::translation(0.0, up * (2.5 - 0.004 * step as Real), 0.0);
            update(&pos, &body, two, &mut kept);
            let found = fresh(&pos, &body, two, &[]);
            if !found.is_empty() && deepest(&found) < 0.5 * PREDICTION {
                assert!(!kept.is_empty(), "step {step}: {} apart", deepest(&found));
                seen += 1;
                break;
            }
        }
        assert_eq!(seen, 1, "they touch");
    }
}

#[test]
fn features_name_triangles_that_the_points_are_on() {
    let mut rng = poses::rng(53);
    let mesh = support::mesh(support::bumpy(), &mut rng);
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let other = support::mesh(support::bumpy(), &mut rng);
    let cases: [(&dyn Shape, Real); 2] = [(&ground, -1.2), (&other, 1.0)];
    for (two, height) in cases {
        let mut found: Vec<Kept> = Vec::new();
        update(&Pose::translation(0.0, height, 0.0), &mesh, two, &mut found);
        let points: Vec<_> = found.iter().flat_map(|m| &m.points).collect();
        assert!(!points.is_empty());
        for point in points {
            let id = mesh.triangle_of(point.fid1).expect("a triangle");
            let triangle = mesh.triangle(id).expect("a triangle");
            let off = triangle
                .project_local_point(point.local_p1, false)
                .point
                .distance(point.local_p1);
            assert!(off < 1e-5, "{off} off triangle {id}");
        }
        assert_eq!(mesh.triangle_of(PackedFeatureId::UNKNOWN), None);
        let far = PackedFeatureId::face(mesh.triangle_count());
        assert_eq!(mesh.triangle_of(far), None);
    }
}
