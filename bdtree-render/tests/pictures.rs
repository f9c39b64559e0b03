//! Pictures by their content: what is where, what hides what, what is refused.

use bdtree_render::{Camera, Image, Line, Mesh, RenderError, Scene, Sphere, Studio, normals};

const WHITE: [u8; 4] = [255; 4];
const SIZE: [u32; 2] = [240, 160];

/// Looks along −z at a box of [−1, 1]³ so that one unit at z = 0 is about `scale` pixels.
fn camera() -> Camera {
    Camera {
        eye: [0.0, 0.0, 10.0].into(),
        target: [0.0; 3].into(),
        up: [0.0, 1.0, 0.0].into(),
        fov_y_rad: 0.4,
    }
}

fn sphere(center: [f32; 3], radius: f32, colour: [u8; 4]) -> Sphere {
    Sphere {
        center,
        radius,
        colour,
    }
}

fn picture(studio: &mut Studio, meshes: &[&Mesh], spheres: &[Sphere], lines: &[Line]) -> Image {
    let scene = Scene {
        ground: None,
        background: WHITE,
        meshes,
        spheres,
        lines,
    };
    studio.picture(SIZE, &camera(), &scene).expect("a picture")
}

/// The pixel where a point is seen.
fn seen(image: &Image, point: [f32; 3]) -> [u8; 4] {
    let [x, y] = camera().project(point, SIZE).expect("in front");
    image.pixel(x as u32, y as u32).expect("within the picture")
}

fn is_mostly(pixel: [u8; 4], channel: usize) -> bool {
    let others = (0..3).filter(|k| *k != channel);
    others
        .into_iter()
        .all(|k| i32::from(pixel[channel]) > i32::from(pixel[k]) + 40)
}

#[test]
fn a_sphere_covers_its_disc_and_nothing_else() {
    let mut studio = Studio::open().expect("a graphics adapter: Mesa's lavapipe will do");
    let center = [0.5, -0.3, 0.0];
    let image = picture(
        &mut studio,
        &[],
        &[sphere(center, 0.8, [255, 0, 0, 255])],
        &[],
    );
    // By rays of our own: the pixel's middle hits the sphere or not, rims (mixed pixels) aside.
    let (mut inside, mut mixed) = (0, 0);
    let per_slope = 0.5 * SIZE[1] as f32 / 0.2_f32.tan();
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let ray = [
                (x as f32 + 0.5 - 0.5 * SIZE[0] as f32) / per_slope,
                (0.5 * SIZE[1] as f32 - y as f32 - 0.5) / per_slope,
                -1.0,
            ];
            let n = ray.iter().map(|c| c * c).sum::<f32>().sqrt();
            let to = [center[0], center[1], center[2] - 10.0];
            let along = (0..3).map(|k| to[k] * ray[k] / n).sum::<f32>();
            let aside = (to.iter().map(|c| c * c).sum::<f32>() - along * along).sqrt();
            let pixel = image.pixel(x, y).expect("within");
            // A pixel at this distance is about 0.025 wide.
            if aside < 0.8 - 0.03 {
                inside += 1;
                assert!(is_mostly(pixel, 0), "{x} {y}: {pixel:?}");
            } else if aside > 0.8 + 0.03 {
                assert_eq!(pixel, WHITE, "{x} {y}");
            } else if pixel != WHITE && !is_mostly(pixel, 0) {
                mixed += 1;
            }
        }
    }
    assert!(inside > 2000, "{inside} pixels");
    assert!(mixed > 20, "{mixed} pixels of the rim are smoothed");
}

#[test]
fn what_is_near_hides_what_is_far_and_glass_does_not() {
    let mut studio = Studio::open().expect("a graphics adapter");
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let corners = [
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ];
    let mut mesh = studio.mesh(&corners, &triangles).expect("a mesh");
    mesh.set_colour([0, 200, 0]);
    mesh.write(&studio.gpu.queue, &corners, &normals(&corners, &triangles));
    let spheres = |alpha| {
        [
            sphere([-0.6, 0.0, 1.0], 0.3, [255, 0, 0, alpha]),
            sphere([0.6, 0.0, -1.0], 0.3, [0, 0, 255, alpha]),
            // Half of it stands out of the mesh.
            sphere([0.0, 0.6, 0.0], 0.2, [0, 0, 255, alpha]),
        ]
    };
    let image = picture(&mut studio, &[&mesh], &spheres(255), &[]);
    assert!(
        is_mostly(seen(&image, [-0.6, 0.0, 1.3]), 0),
        "before the mesh"
    );
    assert!(
        is_mostly(seen(&image, [0.5, 0.0, 0.0]), 1),
        "behind the mesh"
    );
    assert!(is_mostly(seen(&image, [0.0, 0.6, 0.2]), 2), "in the mesh");
    assert!(
        is_mostly(seen(&image, [0.0, -0.6, 0.0]), 1),
        "the mesh alone"
    );
    assert_eq!(seen(&image, [-1.4, 0.0, 0.0]), WHITE);

    let glass = picture(&mut studio, &[&mesh], &spheres(100), &[]);
    let [r, g, b, _] = seen(&glass, [-0.6, 0.0, 1.3]);
    assert!(r > 60 && g > 60 && b < 60, "red over green: {r} {g} {b}");
    assert_eq!(seen(&glass, [0.5, 0.0, 0.0]), seen(&image, [0.5, 0.0, 0.0]));

    let red = Line {
        ends: [[-1.4, -0.6, 0.5], [1.4, -0.6, 0.5]],
        colour: [255, 0, 0, 255],
        width: 2.0,
    };
    let lined = picture(&mut studio, &[&mesh], &[], &[red]);
    let at = |x: f32| {
        let [px, py] = camera().project([x, -0.6, 0.5], SIZE).expect("in front");
        // Its middle may lie in the row above or below.
        (-1..=1).any(|d| {
            let pixel = lined
                .pixel(px as u32, (py as i64 + d) as u32)
                .expect("within");
            is_mostly(pixel, 0)
        })
    };
    assert!(at(-1.2) && at(0.0) && at(1.2));
}

#[test]
fn lines_are_as_wide_as_asked_over_glass_and_cut_at_the_eye() {
    let mut studio = Studio::open().expect("a graphics adapter");
    let glass = sphere([0.0; 3], 1.2, [0, 0, 255, 120]);
    let line = |ends, width| Line {
        ends,
        colour: [255, 0, 0, 255],
        width,
    };
    let middle = [SIZE[0] / 2, SIZE[1] / 2];
    for width in [1.0, 3.0, 8.0] {
        let behind = line([[-1.0, 0.0, -1.5], [1.0, 0.0, -1.5]], width);
        let image = picture(&mut studio, &[], &[], &[behind]);
        let column = (0..SIZE[1]).map(|y| image.pixel(middle[0], y).expect("within"));
        let red: f32 = column.map(|[_, g, ..]| 1.0 - f32::from(g) / 255.0).sum();
        assert!((red - width).abs() < 0.3, "{width}: {red} pixels");
        let over = picture(&mut studio, &[], &[glass], &[behind]);
        let is_red = |y| over.pixel(middle[0], y) == Some([255, 0, 0, 255]);
        assert!(width < 3.0 || is_red(middle[1]), "{width}");
    }
    // From behind the eye to the middle of the picture: from its edge to there.
    let passing = line([[0.0, -3.0, 20.0], [0.0, 0.0, 0.0]], 4.0);
    let image = picture(&mut studio, &[], &[], &[passing]);
    let is_red = |y: u32| is_mostly(image.pixel(SIZE[0] / 2, y).expect("within"), 0);
    assert!((SIZE[1] / 2 + 4..SIZE[1]).all(is_red));
    assert!(!(0..SIZE[1] / 2 - 4).any(is_red));
    let away = line([[0.0, -3.0, 20.0], [0.0, 3.0, 11.0]], 4.0);
    let image = picture(&mut studio, &[], &[], &[away]);
    assert!(image.pixels().iter().all(|p| *p == WHITE), "behind the eye");
}

#[test]
fn both_sides_of_a_triangle_are_lit_and_a_turned_one_is_darker() {
    let mut studio = Studio::open().expect("a graphics adapter");
    let mut shade = |corners: [[f32; 3]; 3], triangle: [u32; 3]| {
        let mesh = studio.mesh(&corners, &[triangle]).expect("a mesh");
        mesh.write(&studio.gpu.queue, &corners, &normals(&corners, &[triangle]));
        seen(&picture(&mut studio, &[&mesh], &[], &[]), [0.0, 0.0, 0.0])
    };
    let facing = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let front = shade(facing, [0, 1, 2]);
    let back = shade(facing, [0, 2, 1]);
    assert_eq!(front, back);
    let turned = shade(
        [[-0.2, -1.0, 3.0], [0.2, -1.0, -3.0], [0.0, 1.0, 0.0]],
        [0, 1, 2],
    );
    assert!(front[0] > 150, "{front:?}");
    assert!(turned[0] + 30 < front[0], "{turned:?} and {front:?}");
}

#[test]
fn the_sides_of_a_cube_are_flat_and_a_bend_is_smooth() {
    let mut studio = Studio::open().expect("a graphics adapter");
    // Two squares that meet at x = 0, both turned away from the eye by so much.
    let mut shades = |angle: f32| {
        let (s, c) = angle.to_radians().sin_cos();
        let corner = |x: f32, y| [x * c, y, -x.abs() * s];
        let mut corners = Vec::new();
        for x in [-1.0, 0.0, 1.0] {
            corners.extend([corner(x, -1.0), corner(x, 1.0)]);
        }
        let triangles = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
        let mesh = studio.mesh(&corners, &triangles).expect("a mesh");
        let normals = normals(&corners, &triangles);
        mesh.write(&studio.gpu.queue, &corners, &normals);
        let image = picture(&mut studio, &[&mesh], &[], &[]);
        [-0.9, -0.5, -0.1, 0.1, 0.5, 0.9].map(|x| i32::from(seen(&image, corner(x, 0.1))[1]))
    };
    // A highlight moves a little over a flat side, since the eye is near.
    let folded = shades(45.0);
    for side in folded.chunks(3) {
        let most = side.iter().max().zip(side.iter().min());
        assert!(most.is_some_and(|(a, b)| a - b <= 8), "{folded:?}");
    }
    assert!((folded[2] - folded[3]).abs() > 20, "{folded:?}");
    let bent = shades(15.0);
    assert!((bent[2] - bent[3]).abs() < 6, "{bent:?}");
    assert!((bent[0] - bent[5]).abs() > 10, "{bent:?}");
}

#[test]
fn a_flat_side_is_even_up_to_its_edge() {
    let mut studio = Studio::open().expect("a graphics adapter");
    // A side of 3 x 3 squares that another folds away from at each edge: only the corners of the middle square are smooth.
    let mut corners = Vec::new();
    let at = |k: usize| k as f32 / 3.0 - 0.5;
    for (i, j) in (0..16).map(|n| (n % 4, n / 4)) {
        corners.push([at(i), at(j), 0.0]);
    }
    let mut triangles = Vec::new();
    for (i, j) in (0..9).map(|n| (n % 3, n / 3)) {
        let v = 4 * j + i;
        triangles.extend([[v, v + 1, v + 5], [v, v + 5, v + 4]]);
    }
    let edge = [0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4];
    for v in edge {
        let [x, y, _] = corners[v as usize];
        corners.push([x, y, -1.0]);
    }
    for k in 0..12 {
        let next = (k + 1) % 12;
        let [a, b] = [edge[k as usize], edge[next as usize]];
        triangles.extend([[a, 16 + k, 16 + next], [a, 16 + next, b]]);
    }
    let mesh = studio.mesh(&corners, &triangles).expect("a mesh");
    let normals = normals(&corners, &triangles);
    mesh.write(&studio.gpu.queue, &corners, &normals);
    let image = picture(&mut studio, &[&mesh], &[], &[]);
    let shades = (0..81).map(|n| {
        let [x, y] = [n % 9, n / 9].map(|k| (k as f32 - 4.0) / 9.0);
        i32::from(seen(&image, [x, y, 0.0])[1])
    });
    let (low, high) = shades.fold((255, 0), |(low, high), s| (low.min(s), high.max(s)));
    assert!(high - low <= 8, "{low} to {high}");
}

#[test]
fn the_same_scene_is_the_same_picture() {
    let spheres: Vec<Sphere> = (0..200)
        .map(|i| {
            let at = |k: u32| ((i * 37 + k * 101) % 97) as f32 / 48.5 - 1.0;
            sphere(
                [at(1), at(2), at(3)],
                0.3,
                [i as u8, 90, 200, if i % 2 == 0 { 255 } else { 120 }],
            )
        })
        .collect();
    let png = |image: &Image| {
        let mut bytes = Vec::new();
        image.write_png(&mut bytes).expect("memory takes all");
        bytes
    };
    let mut studio = Studio::open().expect("a graphics adapter");
    let first = png(&picture(&mut studio, &[], &spheres, &[]));
    assert_eq!(first, png(&picture(&mut studio, &[], &spheres, &[])));
    let mut other = Studio::open().expect("a graphics adapter");
    assert_eq!(first, png(&picture(&mut other, &[], &spheres, &[])));
    assert_eq!(first[..8], *b"\x89PNG\r\n\x1a\n");
}

#[test]
fn pictures_and_meshes_beyond_the_device_are_refused() {
    let mut studio = Studio::open().expect("a graphics adapter");
    let scene = Scene {
        ground: None,
        background: WHITE,
        meshes: &[],
        spheres: &[],
        lines: &[],
    };
    for size in [[0, 10], [10, 0], [1 << 20, 10], [10, u32::MAX]] {
        let error = studio
            .picture(size, &camera(), &scene)
            .expect_err("too large");
        assert!(
            matches!(error, RenderError::TooLarge { unit: "pixels", .. }),
            "{error}"
        );
    }
    let limit = studio.gpu.device.limits().max_buffer_size;
    let error = studio
        .mesh(&vec![[0.0; 3]; (limit / 12) as usize + 1], &[])
        .expect_err("too large");
    assert!(
        error.to_string().starts_with("positions of vertices: "),
        "{error}"
    );
    // The device is as good as before.
    let image = studio
        .picture([8, 4], &camera(), &scene)
        .expect("a picture");
    assert!(image.pixels().iter().all(|p| *p == WHITE));
}

#[test]
fn a_lost_device_is_an_error() {
    let mut studio = Studio::open().expect("a graphics adapter");
    let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = studio.mesh(&triangle, &[[0, 1, 2]]).expect("a mesh");
    studio.gpu.device.destroy();
    let scene = Scene {
        ground: None,
        background: WHITE,
        meshes: &[&mesh],
        spheres: &[sphere([0.0; 3], 1.0, [9, 9, 9, 255])],
        lines: &[],
    };
    let error = studio.picture(SIZE, &camera(), &scene).expect_err("lost");
    assert!(error.to_string().contains("lost"), "{error}");
    let error = studio.mesh(&triangle, &[[0, 1, 2]]).expect_err("lost");
    assert!(error.to_string().contains("lost"), "{error}");
}

#[test]
fn numbers_that_are_none_draw_nothing() {
    let mut studio = Studio::open().expect("a graphics adapter");
    let spheres = [
        sphere([f32::NAN, 0.0, 0.0], 1.0, WHITE.map(|_| 9)),
        sphere([0.0; 3], f32::NAN, [9, 9, 9, 255]),
        sphere([0.0; 3], f32::INFINITY, [9, 9, 9, 255]),
        sphere([0.0; 3], -1.0, [9, 9, 9, 255]),
        // The eye is in it.
        sphere([0.0, 0.0, 9.0], 2.0, [9, 9, 9, 255]),
    ];
    let mesh = studio.mesh(&[[0.0; 3]; 3], &[[0, 1, 2]]).expect("a mesh");
    mesh.write(&studio.gpu.queue, &[[f32::NAN; 3]; 3], &[[f32::NAN; 3]; 3]);
    let image = picture(&mut studio, &[&mesh], &spheres, &[]);
    assert!(image.pixels().iter().all(|p| *p == WHITE));
}
