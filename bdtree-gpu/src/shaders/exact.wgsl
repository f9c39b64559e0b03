// Unit normals of the deformed triangles around each vertex, weighted by area, from the positions
// that the pass before wrote.
@group(0) @binding(1) var<storage, read> starts: array<u32>;
// Of each triangle around a vertex the two other corners, in its order.
@group(0) @binding(2) var<storage, read> corners: array<u32>;
@group(2) @binding(0) var<storage, read> points: array<f32>;
@group(2) @binding(1) var<storage, read_write> result: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) t: u32,
) {
    let work = work_of(group, groups);
    let first = work.first;
    let block = work.block;
    if (block * LANES >= instance_count()) {
        return;
    }
    var x = splat(0.0);
    var y = splat(0.0);
    var z = splat(0.0);
    if (first + t < params.count) {
        let own = vertex_at(first + t);
        let end = starts[first + t + 1u] - params.entry_base;
        let p = point(block, own);
        for (var k = starts[first + t] - params.entry_base; k < end; k++) {
            let b = point(block, corners[2u * k]);
            let c = point(block, corners[2u * k + 1u]);
            let e = array<Lanes, 3>(sub(b[0], p[0]), sub(b[1], p[1]), sub(b[2], p[2]));
            let f = array<Lanes, 3>(sub(c[0], p[0]), sub(c[1], p[1]), sub(c[2], p[2]));
            x = add(x, sub(mul(e[1], f[2]), mul(e[2], f[1])));
            y = add(y, sub(mul(e[2], f[0]), mul(e[0], f[2])));
            z = add(z, sub(mul(e[0], f[1]), mul(e[1], f[0])));
        }
    }
    let done = normalized(x, y, z);
    stage_all(t, done);
    workgroupBarrier();
    write(t, block, first);
}

fn point(block: u32, vertex: u32) -> array<Lanes, 3> {
    let at = 3u * (block * LANES * params.total + vertex);
    return array<Lanes, 3>(gather(at), gather(at + 1u), gather(at + 2u));
}
