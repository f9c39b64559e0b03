// The sum over the modes that the vertex lists of field `side` of its SIDES.
fn bdtree_NAME(vertex: u32, side: u32, instance: u32) -> vec3<f32> {
    let start = LISTS[2u * vertex];
    let list = LISTS[2u * vertex + 1u];
    let modes = LISTS[2u * vertex + 2u] - start;
    var sum = vec3(0.0);
    for (var k = 0u; k < modes; k++) {
        let word = LISTS[bdtree_params.list_base + (list + k) / 2u];
        let j = (word >> (16u * ((list + k) % 2u))) & 0xffffu;
        let at = 3u * (SIDES * start + side * modes + k);
        sum += vec3(FIELDS[at], FIELDS[at + 1u], FIELDS[at + 2u]) * bdtree_row(instance, 12u + j);
    }
    return sum;
}
