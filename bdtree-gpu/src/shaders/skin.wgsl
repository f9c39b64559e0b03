// p' = p + U q of 64 vertices and LANES instances per workgroup (paper, eq. 1), then the instance's
// matrix; or the same of two tangents, whose cross product is turned and made a unit vector.
@group(0) @binding(1) var<storage, read> rest: array<f32>;
@group(0) @binding(2) var<storage, read> fields: array<f32>;
@group(2) @binding(0) var<storage, read_write> result: array<f32>;

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
    let done = finish(block, local(t, first, block));
    workgroupBarrier();
    stage_all(t, done);
    workgroupBarrier();
    write_staged(t, block, first);
}

// A vector of each vertex, as deformed, before the instance's matrix.
fn moved(t: u32, first: u32, block: u32, side: u32) -> array<Lanes, 3> {
    let by = moved_by(t, first, block, side);
    let at = 3u * (min(first + t, params.count - 1u) * SIDES + side);
    return array<Lanes, 3>(
        add(splat(rest[at]), by[0]),
        add(splat(rest[at + 1u]), by[1]),
        add(splat(rest[at + 2u]), by[2]),
    );
}

// A row of the instance's matrix times a vector.
fn turn(block: u32, row: u32, x: array<Lanes, 3>) -> Lanes {
    return add(
        add(mul(row_of(block, row), x[0]), mul(row_of(block, row + 1u), x[1])),
        mul(row_of(block, row + 2u), x[2]),
    );
}
