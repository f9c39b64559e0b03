//! Placements as matrices, and arguments of other libraries: arrays of both precisions, and through mint glam's
//! and nalgebra's types, there and back.

use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    Ball, Capsule, Contact, Cuboid, PoseError, Quat, Ray, Transform, Vec3, Workspace,
};
use nalgebra::{Matrix4, Point3, Quaternion, UnitQuaternion, Vector3};
use rand::RngExt;

/// How far two placements are from each other: rotations without their sign, lengths relatively.
fn apart(a: &Transform, b: &Transform) -> f64 {
    let cosine: f64 = (a.rotation.iter().zip(&b.rotation))
        .map(|(a, b)| a * b)
        .sum();
    let sign = cosine.signum();
    let turned = (a.rotation.iter().zip(&b.rotation)).map(|(a, b)| (a - sign * b).abs());
    let moved = (a.translation.iter().zip(&b.translation)).map(|(a, b)| (a - b).abs());
    let scaled = (a.scale / b.scale - 1.0).abs();
    turned.chain(moved).fold(scaled, f64::max)
}

/// Placements about every axis, each component of the quaternion the largest one in turn.
fn placements() -> Vec<Transform> {
    let mut rng = poses::rng(2);
    let mut all: Vec<Transform> = (0..200)
        .map(|_| {
            let place = poses::random_transform(5.0, &mut rng);
            place.with_scale(10_f64.powf(rng.random_range(-6.0..6.0)))
        })
        .collect();
    for k in 0..4 {
        let mut rotation = [0.0; 4];
        rotation[k] = 1.0;
        all.push(Transform::new([1.0, 2.0, 3.0], rotation));
    }
    all
}

#[test]
fn columns_lead_back_to_the_placement() {
    for place in placements() {
        let columns = place.to_columns();
        let back = Transform::from_columns(columns).expect("a placement");
        assert!(apart(&place, &back) < 1e-14, "{place:?} {back:?}");
        // A column is what becomes of an axis.
        let turn = Transform {
            translation: [0.0; 3],
            scale: 1.0,
            ..place
        };
        for (k, column) in columns.iter().take(3).enumerate() {
            let mut axis = [0.0; 3];
            axis[k] = 1.0;
            let moved = turn.after(Transform::from_translation(axis)).expect("both");
            for (x, y) in moved.translation.iter().zip(column) {
                assert!((x * place.scale - y).abs() <= 1e-15 * place.scale * 8.0);
            }
            assert_eq!(column[3], 0.0);
        }
        let [x, y, z] = place.translation;
        assert_eq!(columns[3], [x, y, z, 1.0]);
    }
    assert_eq!(
        Transform::from_columns(Transform::IDENTITY.to_columns()),
        Ok(Transform::IDENTITY)
    );
    assert_eq!(Transform::default(), Transform::IDENTITY);
}

#[test]
fn matrices_that_are_no_placements_are_refused() {
    let place = poses::random_transform(2.0, &mut poses::rng(3));
    let sound = place.to_columns();
    let changed = |column: usize, row: usize, change: &dyn Fn(f64) -> f64| {
        let mut columns = sound;
        columns[column][row] = change(columns[column][row]);
        Transform::from_columns(columns)
    };
    let scale = place.scale;
    for axis in 0..3 {
        // Mirrors, and scales one axis by more than a thousandth.
        for factor in [-1.0, 0.0, 1.01, 0.99, 3.0] {
            let mut columns = sound;
            columns[axis] = columns[axis].map(|x| factor * x);
            assert_eq!(
                Transform::from_columns(columns),
                Err(PoseError::Matrix),
                "{factor}"
            );
        }
        // Shears.
        let mut columns = sound;
        for row in 0..3 {
            columns[axis][row] += 0.01 * sound[(axis + 1) % 3][row];
        }
        assert_eq!(Transform::from_columns(columns), Err(PoseError::Matrix));
        // Projects.
        assert_eq!(changed(axis, 3, &|_| 1e-9), Err(PoseError::Projection));
        for bad in [f64::NAN, f64::INFINITY, 1e30] {
            assert_eq!(
                changed(axis, axis, &|_| bad),
                Err(PoseError::Matrix),
                "{bad}"
            );
        }
        // Within a thousandth it is taken for a rotation.
        let close = changed(axis, axis, &|x| x + 1e-5 * scale).expect("nearly one");
        assert!(apart(&close, &place) < 1e-3);
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(changed(3, 1, &|_| bad), Err(PoseError::Matrix), "{bad}");
    }
    assert_eq!(changed(3, 3, &|_| 2.0), Err(PoseError::Projection));
    assert_eq!(
        Transform::from_columns([[0.0; 4]; 4]),
        Err(PoseError::Projection)
    );
    let rows = [0, 1, 2, 3].map(|row| sound.map(|column| column[row]));
    let exchanged = Transform::from_columns(rows).expect_err("rows for columns");
    let text = exchanged.to_string();
    assert!(text.contains("are rows and columns exchanged?"), "{text}");
    let mut zero = Transform::IDENTITY.to_columns();
    zero[..3].fill([0.0; 4]);
    assert_eq!(Transform::from_columns(zero), Err(PoseError::Matrix));
    let text = PoseError::Matrix.to_string();
    assert_eq!(
        text,
        "the matrix is not a rotation with one positive scale and a translation"
    );
}

/// One library's types there and back: exact in f64, in f32 rounded to nearest.
macro_rules! there_and_back {
    (
        $test:ident,
        $number:ty,
        $vector:ty,
        $point:ty,
        $quaternion:ty,
        $matrix:ty,
        $rotated:expr
    ) => {
        #[test]
        fn $test() {
            let rotated: fn($quaternion, [$number; 3]) -> [$number; 3] = $rotated;
            type MintVector = mint::Vector3<$number>;
            type MintPoint = mint::Point3<$number>;
            type MintQuaternion = mint::Quaternion<$number>;
            type MintMatrix = mint::ColumnMatrix4<$number>;
            let exact = size_of::<$number>() == 8;
            for place in placements() {
                let [x, y, z] = place.translation.map(|x| x as $number);
                let rounded = [x, y, z].map(f64::from);
                assert!(!exact || rounded == place.translation);

                let theirs: $vector = MintVector::from(Vec3(place.translation)).into();
                assert_eq!([theirs[0], theirs[1], theirs[2]], [x, y, z]);
                assert_eq!(Vec3::from(Into::<MintVector>::into(theirs)), Vec3(rounded));

                let theirs: $point = MintPoint::from(Vec3(place.translation)).into();
                assert_eq!([theirs[0], theirs[1], theirs[2]], [x, y, z]);
                assert_eq!(Vec3::from(Into::<MintPoint>::into(theirs)), Vec3(rounded));

                let [i, j, k, w] = place.rotation.map(|x| x as $number);
                let theirs: $quaternion = MintQuaternion::from(Quat(place.rotation)).into();
                // Their product with a vector is our rotation of it.
                let turn = Transform::new([0.0; 3], [i, j, k, w]);
                let moved = turn
                    .after(Transform::from_translation(rounded))
                    .expect("both");
                let own = rotated(theirs, [x, y, z]).map(f64::from);
                let most = if exact { 1e-13 } else { 1e-5 };
                for k in 0..3 {
                    assert!((moved.translation[k] - own[k]).abs() < most);
                }
                assert_eq!(
                    Quat::from(Into::<MintQuaternion>::into(theirs)),
                    Quat([i, j, k, w].map(f64::from))
                );

                let theirs: $matrix = MintMatrix::from(place).into();
                let back =
                    Transform::try_from(Into::<MintMatrix>::into(theirs)).expect("a placement");
                assert!(apart(&place, &back) < most, "{place:?} {back:?}");
            }
            let mut mirrored = Transform::IDENTITY.to_columns();
            mirrored[0][0] = -1.0;
            let mirrored = MintMatrix::from(mirrored.map(|column| column.map(|x| x as $number)));
            assert_eq!(Transform::try_from(mirrored), Err(PoseError::Matrix));
        }
    };
}

there_and_back!(
    glam_in_f64,
    f64,
    glam::DVec3,
    glam::DVec3,
    glam::DQuat,
    glam::DMat4,
    |q: glam::DQuat, x| (q * glam::DVec3::from(x)).to_array()
);
there_and_back!(
    glam_in_f32,
    f32,
    glam::Vec3,
    glam::Vec3,
    glam::Quat,
    glam::Mat4,
    |q: glam::Quat, x| (q * glam::Vec3::from(x)).to_array()
);
there_and_back!(
    nalgebra_in_f64,
    f64,
    Vector3<f64>,
    Point3<f64>,
    Quaternion<f64>,
    Matrix4<f64>,
    |q, x| UnitQuaternion::new_unchecked(q)
        .transform_vector(&Vector3::from(x))
        .into()
);
there_and_back!(
    nalgebra_in_f32,
    f32,
    Vector3<f32>,
    Point3<f32>,
    Quaternion<f32>,
    Matrix4<f32>,
    |q, x| UnitQuaternion::new_unchecked(q)
        .transform_vector(&Vector3::from(x))
        .into()
);

/// Whatever the arguments are made of, the question is the same.
#[test]
fn queries_take_arguments_of_every_kind() {
    let mesh = bake::bumpy_sphere(6, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 5));
    let asset = model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset
        .pose(&[0.5, -0.5], Transform::IDENTITY, &mut memory)
        .expect("a pose");
    let mut workspace = Workspace::new();
    let mut query = pose.query(&mut workspace);
    // Exact in f32, so all mean the same point.
    let (x, n) = ([0.75, 0.25, -0.5], [0.5_f64; 4]);
    let (y, m) = (x.map(|x: f64| x as f32), n.map(|n| n as f32));
    let same = Cuboid::new(x, [0.5; 3]).rotated(n);
    assert_eq!(same, Cuboid::new(y, [0.5_f32; 3]).rotated(m));
    assert_eq!(
        same,
        Cuboid::new(mint::Point3::from(x), Vec3([0.5; 3])).rotated(Quat(n))
    );
    let turned: mint::Quaternion<f32> = glam::Quat::from_array(m).into();
    assert_eq!(
        same,
        Cuboid::new(mint::Vector3::from(y), [0.5; 3]).rotated(turned)
    );
    assert_eq!(Ball::new(x, 1.0), Ball::new(mint::Point3::from(y), 1.0));
    assert_eq!(Capsule::new(x, y, 1.0), Capsule::new(y, x, 1.0));
    assert_eq!(Ray::new(x, y), Ray::new(y, mint::Vector3::from(x)));
    let place = Transform::new(mint::Vector3::from(y), turned);
    assert_eq!(place, Transform::new(x, n));
    assert_eq!(place, Transform::new(y, m));
    let near = query.project_point(x, 9.0).expect("near");
    assert!(near.is_some());
    assert_eq!(query.project_point(y, 9.0), Ok(near));
    assert_eq!(query.project_point(mint::Point3::from(x), 9.0), Ok(near));
    let mut contacts: Vec<Contact> = Vec::new();
    query.contacts(same, &mut contacts).expect("a box");
    assert!(!contacts.is_empty());
    assert_eq!(<[f64; 3]>::from(Vec3(x)), x);
    assert_eq!(<[f64; 4]>::from(Quat(n)), n);
}
