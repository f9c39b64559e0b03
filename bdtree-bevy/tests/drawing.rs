//! Meshes that the GPU deforms look like meshes that the processor deformed.

use bdtree_bevy::{BdtModel, BdtreePlugin, Deformation, DeformingMesh};
use bdtree_fixtures::bake;
use bdtree_runtime::{Instance, JointMatrix, Model, SkeletonPose, TriangleId, VertexId};
use bevy_app::App;
use bevy_asset::{Assets, Handle, RenderAssetUsages};
use bevy_camera::visibility::NoFrustumCulling;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_light::DirectionalLightShadowMap;
use bevy_math::{Affine3A, Mat4, Vec3};
use bevy_mesh::{Indices, Mesh, Mesh3d, Meshable, PrimitiveTopology};
use bevy_transform::components::Transform;

use crate::support::{self, material, picture::Picture};

/// One entity of a scene.
pub(crate) struct Body {
    pub(crate) model: Model,
    pub(crate) deformation: Deformation,
    pub(crate) at: Transform,
}

/// The mesh as the processor deforms it: `Pose::deformed`, and normals that are the sums of the triangles around a vertex.
pub(crate) fn deformed_mesh(body: &Body) -> Mesh {
    let mut instance = Instance::new(&body.model).unwrap();
    let asset = body.model.asset();
    if !body.deformation.q.is_empty() {
        instance.set_q(&body.deformation.q).unwrap();
    }
    if !body.deformation.joints.is_empty() {
        let rows = |m: &Affine3A| -> JointMatrix {
            let m = Mat4::from(*m).transpose().to_cols_array_2d();
            [0, 1, 2].map(|r| m[r].map(f64::from))
        };
        let joints: Vec<_> = body.deformation.joints.iter().map(rows).collect();
        instance.set_joints(&joints).unwrap();
    }
    let pose = instance.pose();
    let vertex = |i| Vec3::from_array(pose.deformed(VertexId(i)).unwrap().map(|x| x as f32));
    let positions: Vec<Vec3> = (0..asset.vertex_count() as u32).map(vertex).collect();
    let mut normals = vec![Vec3::ZERO; positions.len()];
    let mut indices = Vec::new();
    for id in 0..asset.triangle_count() as u32 {
        let corners = asset.triangle(TriangleId(id)).unwrap().map(|v| v.0);
        let [a, b, c] = corners.map(|v| positions[v as usize]);
        for v in corners {
            normals[v as usize] += (b - a).cross(c - a);
        }
        indices.extend(corners);
    }
    let normals: Vec<Vec3> = normals.iter().map(|n| n.normalize_or_zero()).collect();
    Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::default(),
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_indices(Indices::U32(indices))
}

/// Ground, light and camera.
pub(crate) fn scene(eye: Vec3, at: Vec3) -> App {
    scene_with(eye, at, |_| {})
}

/// The same with other plugins.
pub(crate) fn scene_with(eye: Vec3, at: Vec3, add: impl FnOnce(&mut App)) -> App {
    let mut app = support::app(320, 240, &bdtree_fixtures::golden::folder());
    app.add_plugins(BdtreePlugin);
    add(&mut app);
    // What takes longest on a processor alone.
    app.insert_resource(DirectionalLightShadowMap { size: 512 });
    support::start(&mut app);
    let world = app.world_mut();
    support::camera(world, eye, at);
    support::sun(world, Vec3::new(2.0, 5.0, 3.0));
    let plane = bevy_shape::Plane3d::default().mesh().size(20.0, 20.0);
    let ground = support::solid(world, plane, Color::srgb(0.6, 0.6, 0.6));
    world.spawn((ground, Transform::from_xyz(0.0, -1.2, 0.0)));
    app
}

pub(crate) fn add_model(world: &mut World, model: &Model) -> Handle<BdtModel> {
    world
        .resource_mut::<Assets<BdtModel>>()
        .add(BdtModel::from(model.clone()))
}

pub(crate) const ORANGE: Color = Color::srgb(0.85, 0.45, 0.15);

/// Who deforms.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Gpu,
    Processor,
}

/// A picture of bodies, which then are gone.
fn picture(app: &mut App, bodies: &[Body], by: By) -> Picture {
    let orange = material(app.world_mut(), ORANGE);
    let mut entities = Vec::new();
    for body in bodies {
        let world = app.world_mut();
        let common = (body.at, orange.clone());
        entities.push(match by {
            By::Gpu => {
                let model = add_model(world, &body.model);
                let deformation = body.deformation.clone();
                world
                    .spawn((common, DeformingMesh(model), deformation))
                    .id()
            }
            By::Processor => {
                let mesh = deformed_mesh(body);
                let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh);
                world.spawn((common, Mesh3d(mesh), NoFrustumCulling)).id()
            }
        });
    }
    support::settle(app);
    let picture = support::take(app);
    for entity in entities {
        app.world_mut().despawn(entity);
    }
    picture
}

/// Bodies that the GPU deforms look as those that the processor deforms, and not as bodies at rest.
fn assert_alike(name: &str, eye: Vec3, at: Vec3, bodies: &[Body]) {
    let mut app = scene(eye, at);
    let drawn = picture(&mut app, bodies, By::Gpu);
    let expected = picture(&mut app, bodies, By::Processor);
    drawn.save(&format!("drawing-{name}"));
    expected.save(&format!("drawing-{name}-expected"));
    // Sums in another order move corners by less than a thousandth of a pixel, which edges of triangles may show.
    let off = drawn.differing(&expected, 3);
    assert!(off <= 20, "{off} pixels differ");
    let rest: Vec<Body> = bodies
        .iter()
        .map(|body| Body {
            model: body.model.clone(),
            deformation: Deformation::default(),
            at: body.at,
        })
        .collect();
    let at_rest = picture(&mut app, &rest, By::Processor);
    let moved = drawn.differing(&at_rest, 3);
    assert!(moved > 1000, "{moved} pixels differ from those at rest");
}

#[test]
fn vibration_modes_are_drawn() {
    let model = bake::elastic("torus", 6, 8, &[]);
    let bodies: Vec<Body> = (0..6)
        .map(|k| {
            let mut q = vec![0.0; 6];
            q[k] = 0.5;
            Body {
                model: model.clone(),
                deformation: Deformation {
                    q,
                    joints: Vec::new(),
                },
                at: Transform::from_xyz(
                    2.6 * (k % 3) as f32 - 2.6,
                    0.0,
                    2.6 * (k / 3) as f32 - 1.3,
                )
                .with_scale(Vec3::splat(0.8)),
            }
        })
        .collect();
    assert_alike("modes", Vec3::new(0.0, 5.0, 6.0), Vec3::ZERO, &bodies);
}

#[test]
fn morph_targets_are_drawn() {
    let (mesh, basis) = bake::face_with_shapes();
    let model = bake::baked(&mesh, &basis);
    let mode_count = model.asset().mode_count();
    let bodies: Vec<Body> = (0..3)
        .map(|k| {
            let mut q = vec![0.0; mode_count];
            for j in (k..mode_count).step_by(3) {
                q[j] = 0.5;
            }
            Body {
                model: model.clone(),
                deformation: Deformation {
                    q,
                    joints: Vec::new(),
                },
                at: Transform::from_xyz(2.0 * k as f32 - 2.0, 0.0, 0.0)
                    .with_scale(Vec3::splat(10.0)),
            }
        })
        .collect();
    assert_alike("morphs", Vec3::new(0.5, 0.5, 5.0), Vec3::ZERO, &bodies);
}

#[test]
fn bones_are_drawn() {
    let tube = support::models::baked("skinned_tube.glb", 0);
    let bar = Model::from_bytes(&bdtree_fixtures::skin::skinned_bar()).unwrap();
    let mut bodies = Vec::new();
    for k in 0..3 {
        let mut pose = SkeletonPose::new(&tube).unwrap();
        pose.play(k, 0.4).unwrap();
        bodies.push(Body {
            model: tube.clone(),
            deformation: Deformation {
                q: pose.q().to_vec(),
                joints: support::models::joints(&pose),
            },
            at: Transform::from_xyz(-3.0, 0.0, 2.0 * k as f32 - 3.0),
        });
        let mut pose = SkeletonPose::new(&bar).unwrap();
        pose.play(0, 0.3 * k as f64 + 0.2).unwrap();
        bodies.push(Body {
            model: bar.clone(),
            deformation: Deformation {
                q: pose.q().to_vec(),
                joints: support::models::joints(&pose),
            },
            at: Transform::from_xyz(0.5, -1.0, 2.0 * k as f32 - 5.0).with_scale(Vec3::splat(0.5)),
        });
    }
    assert_alike(
        "bones",
        Vec3::new(-0.5, 6.0, 11.0),
        Vec3::new(-0.5, 0.0, 0.0),
        &bodies,
    );
}
