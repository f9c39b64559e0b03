// The sum over modes of field `side` of a vertex's SIDES.
fn bdtree_NAME(vertex: u32, side: u32, instance: u32) -> vec3<f32> {
    let m = bdtree_params.mode_count;
    var sum = vec3(0.0);
    for (var j = 0u; j < m; j++) {
        let at = 3u * ((vertex * SIDES + side) * m + j);
        sum += vec3(FIELDS[at], FIELDS[at + 1u], FIELDS[at + 2u]) * bdtree_row(instance, 12u + j);
    }
    return sum;
}
