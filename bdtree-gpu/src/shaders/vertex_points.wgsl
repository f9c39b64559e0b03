fn bdtree_moved(vertex: u32, instance: u32) -> vec3<f32> {
    let at = 3u * vertex;
    let p = vec3(bdtree_rest[at], bdtree_rest[at + 1u], bdtree_rest[at + 2u]);
    return p + bdtree_moved_by(vertex, 0u, instance);
}
