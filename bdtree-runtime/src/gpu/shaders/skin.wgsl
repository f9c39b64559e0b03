// p' = p + U q of 64 vertices and LANES instances per workgroup (paper, eq. 1), then the instance's
// matrix; or the same of normals, which are turned and made unit vectors.
@group(0) @binding(1) var<storage, read> rest: array<f32>;
@group(0) @binding(2) var<storage, read> fields: array<f32>;
@group(2) @binding(0) var<storage, read_write> result: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) t: u32,
) {
    let linear = group.x + group.y * groups.x;
    let tiles = (params.count + 63u) / 64u;
    let first = 64u * (linear % tiles);
    let block = linear / tiles;
    if (block * LANES >= instance_count()) {
        return;
    }
    let moved = moved_by(t, first, block);
    let at = 3u * min(first + t, params.count - 1u);
    let x = add(splat(rest[at]), moved[0]);
    let y = add(splat(rest[at + 1u]), moved[1]);
    let z = add(splat(rest[at + 2u]), moved[2]);
    let turned = array<Lanes, 3>(
        turn(block, 0u, x, y, z),
        turn(block, 4u, x, y, z),
        turn(block, 8u, x, y, z),
    );
    let done = finish(block, turned);
    workgroupBarrier();
    stage(t, 0u, done[0]);
    stage(t, 1u, done[1]);
    stage(t, 2u, done[2]);
    workgroupBarrier();
    write_staged(t, block, first);
}

fn turn(block: u32, row: u32, x: Lanes, y: Lanes, z: Lanes) -> Lanes {
    return add(
        add(mul(row_of(block, row), x), mul(row_of(block, row + 1u), y)),
        mul(row_of(block, row + 2u), z),
    );
}
