fn bdtree_normal(vertex: u32, instance: u32) -> vec3<f32> {
    return vec3(0.0);
}
