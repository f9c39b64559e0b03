// M of the vertex, its rows (see bones.wgsl).
var<private> bdtree_blended: array<vec4<f32>, 3>;

fn bdtree_block_rows() -> u32 { return 12u + bdtree_params.mode_count + 12u * bdtree_params.bone_count; }

fn bdtree_blend(vertex: u32, instance: u32) {
    let own = bdtree_params.influences + vertex;
    let entries = bdtree_params.influences + bdtree_params.count + 1u;
    var m = array<vec4<f32>, 3>(vec4(0.0), vec4(0.0), vec4(0.0));
    for (var i = bdtree_lists[own]; i < bdtree_lists[own + 1u]; i++) {
        let weight = bitcast<f32>(bdtree_lists[entries + 2u * i]);
        let bone = bdtree_lists[entries + 2u * i + 1u] & 0xffffu;
        let row = 12u + bdtree_params.mode_count + 12u * bone;
        for (var r = 0u; r < 3u; r++) {
            m[r] += weight * vec4(
                bdtree_row(instance, row + 4u * r),
                bdtree_row(instance, row + 4u * r + 1u),
                bdtree_row(instance, row + 4u * r + 2u),
                bdtree_row(instance, row + 4u * r + 3u),
            );
        }
    }
    bdtree_blended = m;
}

// M's linear part times a vector.
fn bdtree_along(v: vec3<f32>) -> vec3<f32> {
    var x: vec3<f32>;
    for (var r = 0u; r < 3u; r++) {
        let row = bdtree_blended[r];
        x[r] = row.x * v.x + row.y * v.y + row.z * v.z;
    }
    return x;
}

fn bdtree_carried(p: vec3<f32>) -> vec3<f32> {
    return bdtree_along(p) + vec3(bdtree_blended[0].w, bdtree_blended[1].w, bdtree_blended[2].w);
}
