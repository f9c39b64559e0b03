fn bdtree_tangent(vertex: u32, side: u32, instance: u32) -> vec3<f32> {
    let at = 3u * (2u * vertex + side);
    let t = vec3(bdtree_tangents[at], bdtree_tangents[at + 1u], bdtree_tangents[at + 2u]);
    return t + bdtree_turned_by(vertex, side, instance);
}

// As in the compute passes: scaled first, so that no square over- or underflows.
fn bdtree_unit(v: vec3<f32>) -> vec3<f32> {
    let largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if (largest >= 0x1p-126f && largest <= 0x1p125f) {
        let scaled = v * (1.0 / largest);
        return scaled * (1.0 / sqrt(dot(scaled, scaled)));
    }
    return vec3(0.0);
}

fn bdtree_normal(vertex: u32, instance: u32) -> vec3<f32> {
    let a = bdtree_tangent(vertex, 0u, instance);
    let b = bdtree_tangent(vertex, 1u, instance);
    return bdtree_unit(bdtree_linear(instance, BDTREE_SPANNED));
}
