// One deformed vertex of one instance, for a vertex shader of the caller's.
struct BdtreeParams {
    count: u32,
    first: u32,
    total: u32,
    mode_count: u32,
    entry_base: u32,
    list_base: u32,
    bone_count: u32,
    influences: u32,
}

struct BdtreeVertex {
    // World position less the origin of the instances.
    position: vec3<f32>,
    // Unit normal in world axes; zero where there is none.
    normal: vec3<f32>,
}

@group(BDTREE_GROUP) @binding(0) var<uniform> bdtree_params: BdtreeParams;
@group(BDTREE_GROUP) @binding(1) var<storage, read> bdtree_rest: array<f32>;
@group(BDTREE_GROUP) @binding(2) var<storage, read> bdtree_fields: array<f32>;
@group(BDTREE_GROUP) @binding(3) var<storage, read> bdtree_lists: array<u32>;
@group(BDTREE_GROUP) @binding(4) var<storage, read> bdtree_tangents: array<f32>;
@group(BDTREE_GROUP) @binding(5) var<storage, read> bdtree_tangent_fields: array<f32>;
@group(BDTREE_GROUP) @binding(6) var<storage, read> bdtree_tangent_lists: array<u32>;
@group(BDTREE_GROUP) @binding(7) var<storage, read> bdtree_instances: array<f32>;

fn bdtree_row(instance: u32, row: u32) -> f32 {
    let block = instance / 8u;
    return bdtree_instances[8u * (1u + block * bdtree_block_rows() + row) + instance % 8u];
}

fn bdtree_linear(instance: u32, v: vec3<f32>) -> vec3<f32> {
    var x: vec3<f32>;
    for (var k = 0u; k < 3u; k++) {
        x[k] = bdtree_row(instance, 4u * k) * v.x + bdtree_row(instance, 4u * k + 1u) * v.y
            + bdtree_row(instance, 4u * k + 2u) * v.z;
    }
    return x;
}

fn bdtree_vertex(vertex: u32, instance: u32) -> BdtreeVertex {
    let offset = vec3(bdtree_row(instance, 3u), bdtree_row(instance, 7u), bdtree_row(instance, 11u));
    bdtree_blend(vertex, instance);
    let p = bdtree_carried(bdtree_moved(vertex, instance));
    return BdtreeVertex(bdtree_linear(instance, p) + offset, bdtree_normal(vertex, instance));
}
