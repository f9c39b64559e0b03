//! Deformed meshes are drawn with every kind of material and pass: pictures are those of meshes that the processor deformed.

use bdtree_bevy::{DeformingMesh, DrawDeformed};
use bdtree_build::input::RawMesh;
use bdtree_fixtures::bake;
use bdtree_runtime::Model;
use bevy::material::{AlphaMode, OpaqueRendererMethod};
use bevy::shader::{Shader, ShaderRef};
use bevy_app::App;
use bevy_asset::{Asset, Assets, Handle, RenderAssetUsages, uuid_handle};
use bevy_camera::Camera3d;
use bevy_camera::visibility::NoFrustumCulling;
use bevy_color::Color;
use bevy_core_pipeline::prepass::{
    DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass,
};
use bevy_ecs::prelude::*;
use bevy_image::Image;
use bevy_math::{Vec2, Vec3};
use bevy_mesh::{Indices, Mesh, Mesh3d, VertexAttributeValues};
use bevy_pbr::{
    ExtendedMaterial, Material, MaterialExtension, MaterialPlugin, MeshMaterial3d, StandardMaterial,
};
use bevy_reflect::TypePath;
use bevy_render::render_resource::{AsBindGroup, Extent3d, TextureDimension, TextureFormat};
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;

use crate::drawing::{Body, add_model, deformed_mesh, scene_with};
use crate::support::{self, picture::Picture};

/// Vertices along an edge of the sheet.
const SIDE: usize = 33;

const NORMALS: Handle<Shader> = uuid_handle!("0f4a5a0e-9c1b-4d39-8f1e-6f2f4f9d7a01");
const TANGENTS: Handle<Shader> = uuid_handle!("0f4a5a0e-9c1b-4d39-8f1e-6f2f4f9d7a02");

/// A material of a program: normals as colors.
#[derive(Asset, TypePath, AsBindGroup, Debug, Clone)]
struct ShowNormals {}

impl Material for ShowNormals {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Handle(NORMALS)
    }
}

/// An extension of Bevy's material: tangents as colors.
#[derive(Asset, TypePath, AsBindGroup, Debug, Clone)]
struct ShowTangents {}

impl MaterialExtension for ShowTangents {
    fn fragment_shader() -> ShaderRef {
        ShaderRef::Handle(TANGENTS)
    }
}

type Extended = ExtendedMaterial<StandardMaterial, ShowTangents>;

/// A fragment shader that shows what stands at a location of Bevy's vertex shader as a color.
fn shows(location: u32) -> Shader {
    let source = format!(
        "@fragment fn fragment(@location({location}) shown: vec3<f32>) -> @location(0) vec4<f32> {{
             return vec4(0.5 + 0.5 * normalize(shown), 1.0);
         }}"
    );
    Shader::from_wgsl(source, format!("shows-{location}.wgsl"))
}

/// A square sheet across z.
fn sheet() -> Model {
    let at = |k: usize| 2.0 * k as f64 / (SIDE - 1) as f64 - 1.0;
    let positions: Vec<[f64; 3]> = (0..SIDE * SIDE)
        .map(|i| [at(i % SIDE), at(i / SIDE), 0.0])
        .collect();
    let mut triangles = Vec::new();
    for y in 0..SIDE - 1 {
        for x in 0..SIDE - 1 {
            let corner = |i: usize, j: usize| ((y + j) * SIDE + x + i) as u32;
            triangles.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
            triangles.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
        }
    }
    let mesh = RawMesh {
        name: "sheet".into(),
        positions,
        triangles,
        ..RawMesh::default()
    };
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 3))
}

fn body(model: &Model, share: f32) -> Body {
    Body {
        model: model.clone(),
        deformation: bdtree_bevy::Deformation {
            q: [3.0, -2.0, 2.5, 2.0].map(|q| share * q).to_vec(),
            joints: Vec::new(),
        },
        at: Transform::default(),
    }
}

fn vectors(mesh: &Mesh, attribute: bevy_mesh::MeshVertexAttribute) -> Vec<Vec3> {
    match mesh.attribute(attribute.id) {
        Some(VertexAttributeValues::Float32x3(values)) => {
            values.iter().copied().map(Vec3::from_array).collect()
        }
        _ => panic!("no {}", attribute.name),
    }
}

/// Texture coordinates along the sheet's edges, and the tangents that they and the positions of the mesh make: the mean of
/// the triangles' directions of growing u, perpendicular to the normal.
fn textured(mesh: Mesh) -> Mesh {
    let uv = |i: usize| Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) / (SIDE - 1) as f32;
    let positions = vectors(&mesh, Mesh::ATTRIBUTE_POSITION);
    let normals = vectors(&mesh, Mesh::ATTRIBUTE_NORMAL);
    let Some(Indices::U32(corners)) = mesh.indices() else {
        panic!("no indices");
    };
    let mut sums = vec![(Vec3::ZERO, Vec3::ZERO); positions.len()];
    for triangle in corners.as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(|v| v as usize);
        let (e, f) = (positions[b] - positions[a], positions[c] - positions[a]);
        let (s, t) = (uv(b) - uv(a), uv(c) - uv(a));
        let along_u = (e * t.y - f * s.y) / s.perp_dot(t);
        let along_v = (f * s.x - e * t.x) / s.perp_dot(t);
        for vertex in [a, b, c] {
            sums[vertex].0 += along_u.normalize();
            sums[vertex].1 += along_v.normalize();
        }
    }
    let tangents: Vec<[f32; 4]> = (sums.iter().zip(&normals))
        .map(|((u, v), normal)| {
            let tangent = u.reject_from_normalized(*normal).normalize();
            let side = normal.cross(tangent).dot(*v).signum();
            tangent.extend(side).to_array()
        })
        .collect();
    let uvs: Vec<[f32; 2]> = (0..positions.len()).map(|i| uv(i).to_array()).collect();
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, uvs)
        .with_inserted_attribute(Mesh::ATTRIBUTE_TANGENT, tangents)
}

/// Slanted facets, so that light falls on a normal map as its tangents lie.
fn bumps() -> Image {
    let size = 64_usize;
    let pixel = |i: usize| {
        let (x, y) = (i % size / 8, i / size / 8);
        let slope = if (x + y).is_multiple_of(2) { 0.7 } else { -0.7 };
        let normal = Vec3::new(slope, 0.2 * slope, 1.0).normalize();
        let color = (normal * 0.5 + 0.5) * 255.0;
        [color.x as u8, color.y as u8, color.z as u8, 255]
    };
    let data: Vec<u8> = (0..size * size).flat_map(pixel).collect();
    let side = size as u32;
    let extent = Extent3d {
        width: side,
        height: side,
        depth_or_array_layers: 1,
    };
    let (format, usage) = (TextureFormat::Rgba8Unorm, RenderAssetUsages::default());
    Image::new(extent, TextureDimension::D2, data, format, usage)
}

/// Who deforms.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Gpu,
    Processor,
    /// The processor, with the tangents of the sheet at rest.
    ProcessorButTangents,
}

struct Sheets {
    app: App,
    model: Model,
}

impl Sheets {
    fn new() -> Self {
        let mut app = scene_with(Vec3::new(0.3, 0.4, 3.2), Vec3::ZERO, |app| {
            app.add_plugins((
                MaterialPlugin::<ShowNormals>::default(),
                MaterialPlugin::<Extended>::default(),
            ));
        });
        let mut shaders = app.world_mut().resource_mut::<Assets<Shader>>();
        shaders.insert(&NORMALS, shows(1)).unwrap();
        shaders.insert(&TANGENTS, shows(4)).unwrap();
        let model = sheet();
        Self { app, model }
    }

    fn material<M: Material>(&mut self, material: M) -> MeshMaterial3d<M> {
        let mut materials = self.app.world_mut().resource_mut::<Assets<M>>();
        MeshMaterial3d(materials.add(material))
    }

    fn add(&mut self, mesh: Mesh) -> Mesh3d {
        Mesh3d(
            self.app
                .world_mut()
                .resource_mut::<Assets<Mesh>>()
                .add(mesh),
        )
    }

    /// A picture of two sheets, one behind the other.
    fn picture<M: Material>(&mut self, by: By, look: &MeshMaterial3d<M>) -> Picture {
        let rest = textured(deformed_mesh(&body(&self.model, 0.0)));
        let rest_tangents = rest.attribute(Mesh::ATTRIBUTE_TANGENT).unwrap().clone();
        let template = self.add(rest);
        let handle = add_model(self.app.world_mut(), &self.model);
        let mut entities = Vec::new();
        for (share, z) in [(1.0, 0.0), (-1.0, -1.0)] {
            let body = body(&self.model, share);
            let at = Transform::from_xyz(0.4 * z, 0.0, z);
            let entity = if by == By::Gpu {
                let mesh = DeformingMesh(handle.clone());
                let world = self.app.world_mut();
                let entity = world.spawn((mesh, template.clone(), body.deformation, at));
                entity.id()
            } else {
                let mut mesh = textured(deformed_mesh(&body));
                if by == By::ProcessorButTangents {
                    mesh.insert_attribute(Mesh::ATTRIBUTE_TANGENT, rest_tangents.clone());
                }
                let mesh = self.add(mesh);
                self.app
                    .world_mut()
                    .spawn((mesh, at, NoFrustumCulling))
                    .id()
            };
            let look = (look.clone(), DrawDeformed);
            self.app.world_mut().entity_mut(entity).insert(look);
            entities.push(entity);
        }
        support::settle(&mut self.app);
        let picture = support::take(&mut self.app);
        for entity in entities {
            self.app.world_mut().despawn(entity);
        }
        picture
    }

    /// The GPU's picture, which is the processor's but for so many pixels that differ by more than so many levels.
    fn assert_alike<M: Material>(
        &mut self,
        name: &str,
        look: &MeshMaterial3d<M>,
        (levels, most): (u8, usize),
    ) -> Picture {
        let found = self.picture(By::Gpu, look);
        let expected = self.picture(By::Processor, look);
        found.save(&format!("materials-{name}"));
        expected.save(&format!("materials-{name}-expected"));
        let off = found.differing(&expected, levels);
        assert!(off <= most, "{name}: {off} pixels differ");
        assert!(found.covered() > 10_000, "{name}");
        found
    }
}

fn standard() -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgb(0.85, 0.45, 0.15),
        perceptual_roughness: 0.5,
        double_sided: true,
        cull_mode: None,
        ..Default::default()
    }
}

#[test]
fn materials_of_programs_and_of_every_pass_are_drawn() {
    let mut sheets = Sheets::new();
    let world = sheets.app.world_mut();
    let mut cameras = world.query_filtered::<Entity, With<Camera3d>>();
    let camera = cameras.single(world).unwrap();
    world.entity_mut(camera).insert((
        DepthPrepass,
        NormalPrepass,
        MotionVectorPrepass,
        DeferredPrepass,
        Msaa::Off,
    ));
    let own = sheets.material(ShowNormals {});
    sheets.assert_alike("normals", &own, (3, 20));
    let see_through = sheets.material(StandardMaterial {
        base_color: Color::srgba(0.85, 0.45, 0.15, 0.5),
        unlit: true,
        alpha_mode: AlphaMode::Blend,
        ..standard()
    });
    sheets.assert_alike("blend", &see_through, (3, 20));
    let deferred = sheets.material(StandardMaterial {
        opaque_render_method: OpaqueRendererMethod::Deferred,
        ..standard()
    });
    sheets.assert_alike("deferred", &deferred, (3, 20));
}

#[test]
fn tangents_follow_the_deformation() {
    // The mean over a vertex's triangles is weighted otherwise here.
    const ALMOST: (u8, usize) = (8, 100);
    let mut sheets = Sheets::new();
    let shown = sheets.material(Extended {
        base: standard(),
        extension: ShowTangents {},
    });
    let found = sheets.assert_alike("tangents", &shown, ALMOST);
    let stiff = sheets.picture(By::ProcessorButTangents, &shown);
    assert!(found.differing(&stiff, 8) > 5000);

    let mut images = sheets.app.world_mut().resource_mut::<Assets<Image>>();
    let bumpy = StandardMaterial {
        normal_map_texture: Some(images.add(bumps())),
        ..standard()
    };
    let bumpy = sheets.material(bumpy);
    let found = sheets.assert_alike("bumps", &bumpy, ALMOST);
    let stiff = sheets.picture(By::ProcessorButTangents, &bumpy);
    assert!(found.differing(&stiff, 8) > 1000);
}
