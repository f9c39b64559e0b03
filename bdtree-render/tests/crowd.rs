//! Crowds by their pictures: what is left out is not seen, batches do not show, shapes are where they should be.

use bdtree_fixtures::bake::{baked, bumpy_sphere, smooth_basis};
use bdtree_fixtures::{bones, golden, poses};
use bdtree_render::{Body, Camera, Crowd, CrowdPicture, Floor, Gpu, RenderError, Shot, Sphere};
use bdtree_runtime::{Asset, BoneMatrices, Model, Transform};

const SIZE: [u32; 2] = [160, 96];
const WHITE: [u8; 4] = [255; 4];
const GREEN: [u8; 3] = [20, 160, 40];

/// Of a radius of about 1, and of another number of vertices.
fn models() -> [Model; 2] {
    [(6, 3), (9, 2)].map(|(rings, modes)| {
        let mesh = bumpy_sphere(rings, 1);
        baked(&mesh, &smooth_basis(&mesh, modes, 2))
    })
}

fn crowd(models: &[Model], batch_bytes: u64) -> Crowd {
    let gpu = Gpu::offscreen().expect("a graphics adapter: Mesa's lavapipe will do");
    Crowd::new(gpu, models, batch_bytes).expect("room")
}

/// Looks along −z; the picture is about 6 high and 10 wide at z = 0.
fn camera() -> Camera {
    Camera {
        eye: [0.0, 0.0, 15.0].into(),
        target: [0.0; 3].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov_y_rad: 0.4,
    }
}

fn at(translation: [f64; 3]) -> Transform {
    Transform {
        translation,
        ..Transform::IDENTITY
    }
}

/// Bodies of both assets in and around the picture, before and behind it.
struct Scattered {
    models: [Model; 2],
    qs: Vec<Vec<f32>>,
    places: Vec<Transform>,
}

impl Scattered {
    fn new(count: usize) -> Self {
        let models = models();
        let mut rng = poses::rng(3);
        let placed = (0..count).map(|k| {
            let place = poses::random_transform(9.0, &mut rng);
            let q = poses::random_q(models[k % 2].asset(), 0.1, &mut rng);
            let place = Transform {
                scale: 0.2 + 0.02 * (k % 20) as f64,
                ..place
            };
            (q, place)
        });
        let (qs, places) = placed.unzip();
        Self { models, qs, places }
    }

    fn bodies(&self) -> Vec<Body<'_>> {
        let all = self.qs.iter().zip(&self.places).enumerate();
        let colour = |k: usize| [(40 * k) as u8, (90 * k) as u8, (170 * k) as u8];
        all.map(|(k, (q, place))| Body::new(k % 2, q, *place, colour(k)))
            .collect()
    }
}

fn shot<'s>(bodies: &'s [Body<'s>], spheres: &'s [Sphere]) -> Shot<'s> {
    Shot {
        floor: Some(Floor {
            height: -2.5,
            middle: [0.0, 0.0],
            radius: 8.0,
            colour: [200, 190, 180],
        }),
        bodies,
        spheres,
        ..Shot::new(SIZE, camera())
    }
}

fn seen(picture: &CrowdPicture, point: [f32; 3]) -> [u8; 4] {
    let [x, y] = camera().project(point, SIZE).expect("in front");
    picture.image.pixel(x as u32, y as u32).expect("within")
}

#[test]
fn what_stays_on_the_device_is_the_same_picture() {
    let scattered = Scattered::new(12);
    let bodies = scattered.bodies();
    let mut crowd = crowd(&scattered.models, Crowd::BATCH_BYTES);
    let picture = crowd.picture(&shot(&bodies, &[])).expect("a picture");
    crowd.picture(&shot(&[], &[])).expect("another picture");
    let made = crowd.texture(&shot(&bodies, &[])).expect("a texture");
    let copied = crowd.gpu().read_back(&made.texture).expect("a copy");
    assert_eq!(copied.pixels(), picture.image.pixels());
    assert!(made.times.draw > 0.0 && made.times.read_back == 0.0);
}

#[test]
fn what_is_outside_is_left_out_and_what_reaches_in_is_drawn() {
    let models = models();
    let mut crowd = crowd(&models, Crowd::BATCH_BYTES);
    let q = vec![0.0; models[0].asset().mode_count()];
    // The picture's right edge is at x = 5 or so, its eye at z = 15.
    let right = 15.0 * 0.2_f64.tan() * f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let mut picture = |x: f64, z: f64| {
        let bodies = [Body::new(0, &q, at([x, 0.0, z]), GREEN)];
        let shot = Shot {
            floor: None,
            ..shot(&bodies, &[])
        };
        let picture = crowd.picture(&shot).expect("a picture");
        let marked = picture.image.pixels().iter().filter(|p| **p != WHITE);
        (picture.drawn, picture.triangles, marked.count())
    };
    let whole = models[0].asset().triangle_count() as u64;
    for (x, z) in [(right + 2.5, 0.0), (-right - 2.5, 0.0), (0.0, 18.0)] {
        assert_eq!(picture(x, z), (0, 0, 0), "{x} {z}");
    }
    for x in [0.0, right - 0.5, right + 0.4, -right - 0.4] {
        let (drawn, triangles, marked) = picture(x, 0.0);
        assert_eq!((drawn, triangles), (1, whole), "{x}");
        assert!(marked > 20, "{x}: {marked} pixels");
    }
}

#[test]
fn a_tree_leaves_out_what_its_sphere_does_not() {
    let models = models();
    let asset = models[0].asset();
    let mut crowd = crowd(&models, Crowd::BATCH_BYTES);
    let q = vec![0.0; asset.mode_count()];
    let mut memory = vec![0.0; asset.pose_len()];
    let frustum = camera().frustum(SIZE, [0.0; 3]).expect("a frustum");
    // Away from the edge step by step: in the end the sphere still reaches in, and no triangle does.
    let mut by_tree = 0;
    for step in 0..200 {
        let place = at([5.0 + 0.01 * f64::from(step), 0.0, 0.0]);
        let pose = asset.pose(&q, place, &mut memory).expect("a pose");
        let sphere = pose.bounding_sphere().expect("a sphere");
        let outside = sphere.state(&frustum) == bdtree_runtime::FrustumState::Outside;
        if step % 10 != 0 {
            continue;
        }
        let bodies = [Body::new(0, &q, place, GREEN)];
        let picture = crowd.picture(&shot(&bodies, &[])).expect("a picture");
        assert_eq!(picture.culled_by_sphere, usize::from(outside), "{step}");
        assert_eq!(
            picture.drawn + picture.culled_by_tree + picture.culled_by_sphere,
            1
        );
        by_tree += picture.culled_by_tree;
    }
    assert!(by_tree > 0, "the root's sphere is larger than the body");
}

#[test]
fn culling_and_batches_do_not_show() {
    let scattered = Scattered::new(90);
    let bodies = scattered.bodies();
    let spheres = [Sphere {
        center: [0.5, 0.5, 3.0],
        radius: 0.4,
        colour: [255, 0, 0, 90],
    }];
    let culled = shot(&bodies, &spheres);
    let whole = Shot {
        culls: false,
        ..culled
    };
    let mut crowds = [Crowd::BATCH_BYTES, 0, 20_000].map(|bytes| crowd(&scattered.models, bytes));
    let first = crowds[0].picture(&whole).expect("a picture");
    assert_eq!((first.drawn, first.batches), (90, 2));
    for (crowd, batches) in crowds.iter_mut().zip([2, 90, 10]) {
        for shot in [&whole, &culled, &culled] {
            let picture = crowd.picture(shot).expect("a picture");
            assert!(picture.image == first.image, "the pictures differ");
            let least = if shot.culls { 2 } else { batches };
            assert!(picture.batches >= least, "{} batches", picture.batches);
            let left_out = picture.culled_by_sphere + picture.culled_by_tree;
            assert_eq!(picture.drawn + left_out, 90);
            assert_eq!(left_out > 10, shot.culls, "{left_out}");
        }
    }
    // One body of each asset; 20 kB.
    let one = |model: &Model| 24 * model.asset().vertex_count() as u64;
    let least: u64 = scattered.models.iter().map(one).sum();
    let [_, single, few] = crowds.map(|crowd| crowd.memory());
    assert!(single.batches >= least && single.batches < least + 4000);
    assert!(few.batches <= 20_000, "{} bytes", few.batches);
    assert!(few.assets > 0 && few.pictures > 0 && few.total() > few.assets);
}

#[test]
fn red_spheres_are_where_they_are_put() {
    let models = models();
    let mut crowd = crowd(&models, Crowd::BATCH_BYTES);
    let q = vec![0.0; models[0].asset().mode_count()];
    let bodies = [Body::new(0, &q, at([0.0; 3]), GREEN)];
    let red = |center| Sphere {
        center,
        radius: 0.15,
        colour: [255, 0, 0, 255],
    };
    // Before the body, behind it, beside it.
    let spheres = [
        red([0.0, 0.0, 2.0]),
        red([0.5, 0.3, -2.0]),
        red([3.0, 1.0, 0.0]),
    ];
    let picture = crowd.picture(&shot(&bodies, &spheres)).expect("a picture");
    let is_red = |[r, g, b, _]: [u8; 4]| r > 120 && g < 90 && b < 90;
    let found: Vec<bool> = spheres
        .iter()
        .map(|s| is_red(seen(&picture, s.center)))
        .collect();
    assert_eq!(found, [true, false, true]);
    let [r, g, b, _] = seen(&picture, [0.5, 0.3, 0.0]);
    assert!(g > r && g > b, "the body is green: {r} {g} {b}");
    let red = picture
        .image
        .pixels()
        .iter()
        .filter(|p| is_red(**p))
        .count();
    assert!((10..60).contains(&red), "{red} pixels");
}

#[test]
fn far_from_zero_a_picture_is_the_same() {
    let scattered = Scattered::new(12);
    let mut crowd = crowd(&scattered.models, Crowd::BATCH_BYTES);
    let bodies = scattered.bodies();
    let near = crowd.picture(&shot(&bodies, &[])).expect("a picture");
    let origin = [f64::from(1 << 24), 0.0, -f64::from(1 << 22)];
    let moved: Vec<Body<'_>> = bodies
        .iter()
        .map(|body| {
            let placement = Transform {
                translation: [0, 1, 2].map(|k| body.placement.translation[k] + origin[k]),
                ..body.placement
            };
            Body { placement, ..*body }
        })
        .collect();
    let far = Shot {
        origin,
        ..shot(&moved, &[])
    };
    let far = crowd.picture(&far).expect("a picture");
    let differ = (near.image.pixels().iter().zip(far.image.pixels()))
        .filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 8));
    assert!(differ.count() < 40);
    assert_eq!(near.drawn, far.drawn);
}

#[test]
fn bones_move_bodies() {
    let bytes = std::fs::read(golden::folder().join("skinned.bdt")).expect("a golden file");
    let model = Model::from_bytes(&bytes).expect("opens");
    let asset: &Asset<'_> = model.asset();
    let mut crowd = crowd(std::slice::from_ref(&model), Crowd::BATCH_BYTES);
    let q = vec![0.0; asset.mode_count()];
    let matrices = bones::random_matrices(asset, 1, &mut poses::rng(4));
    let middle = asset.origin();
    let own = Body::new(0, &q, at(middle.map(|x| -x)), GREEN);
    let moved = Body {
        bones: BoneMatrices::Skinning(&matrices),
        ..own
    };
    let images = [own, moved].map(|body| {
        let bodies = [body];
        crowd.picture(&shot(&bodies, &[])).expect("a picture").image
    });
    assert!(images[0] != images[1], "bones are drawn");
}

#[test]
fn bodies_that_cannot_be_drawn_are_named() {
    let models = models();
    let mut crowd = crowd(&models, Crowd::BATCH_BYTES);
    let q = vec![0.0; models[0].asset().mode_count()];
    let sound = Body::new(0, &q, at([0.0; 3]), GREEN);
    let mut refused = |body| {
        let bodies = [sound, body];
        match crowd.picture(&shot(&bodies, &[])) {
            Err(RenderError::Body { body: 1, reason }) => reason,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(Body { asset: 2, ..sound }), "asset 2 of 2");
    assert!(refused(Body { q: &[], ..sound }).contains('q'));
    let nowhere = at([f64::NAN; 3]);
    assert!(
        !refused(Body {
            placement: nowhere,
            ..sound
        })
        .is_empty()
    );
    let picture = crowd.picture(&shot(&[], &[])).expect("an empty picture");
    assert_eq!((picture.drawn, picture.batches), (0, 0));
    assert_ne!(seen(&picture, [0.0, -2.5, 0.0]), WHITE, "its floor");
    assert_eq!(seen(&picture, [0.0, 2.0, 0.0]), WHITE);
}

#[test]
fn far_bodies_may_have_fewer_triangles() {
    let mesh = bumpy_sphere(40, 1);
    let model = baked(&mesh, &smooth_basis(&mesh, 2, 2));
    let mut crowd = crowd(std::slice::from_ref(&model), Crowd::BATCH_BYTES);
    let q = vec![0.0; model.asset().mode_count()];
    let bodies = [at([-1.5, 0.0, 0.0]), at([30.0, 0.0, -120.0])];
    let bodies = bodies.map(|place| Body::new(0, &q, place, GREEN));
    let whole = shot(&bodies, &[]);
    let pictures = [0.0, 0.5, 4.0].map(|coarser_by| {
        let shot = Shot {
            coarser_by,
            ..whole
        };
        crowd.picture(&shot).expect("a picture")
    });
    let [all, some, few] = &pictures;
    assert_eq!(all.triangles, 2 * model.asset().triangle_count() as u64);
    assert!(few.triangles < some.triangles && some.triangles < all.triangles);
    // Half a pixel shows at edges alone.
    let differ = (all.image.pixels().iter().zip(some.image.pixels()))
        .filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 40));
    assert!(differ.count() < 80);
}
