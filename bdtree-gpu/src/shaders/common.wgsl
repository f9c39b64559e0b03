// What all passes share. A pass is this, one of lanes_*.wgsl, one of *bones.wgsl, and its own text.
struct Params {
    // Vertices of this range, and the first of them.
    count: u32,
    first: u32,
    // Vertices of the mesh.
    total: u32,
    mode_count: u32,
    // Where entries of this range begin, and mode lists (see fields_listed.wgsl) or corners.
    entry_base: u32,
    list_base: u32,
    // Bones, and where influences begin (see bones.wgsl).
    bone_count: u32,
    influences: u32,
}

@group(0) @binding(0) var<uniform> params: Params;

// Rows of an instance before its q: three rows of a matrix, of four numbers each.
const MATRIX_ROWS = 12u;

// Fields on their way in, points on their way out: both are read and written in whole runs of memory.
var<workgroup> staged: array<f32, 1600>;

// What a workgroup does: 64 vertices from `first` on in its range, and a block of LANES instances.
struct Work {
    first: u32,
    block: u32,
}

fn work_of(group: vec3<u32>, groups: vec3<u32>) -> Work {
    let linear = group.x + group.y * groups.x;
    let tiles = (params.count + 63u) / 64u;
    return Work(64u * (linear % tiles), linear / tiles);
}

fn stage_all(t: u32, done: array<Lanes, 3>) {
    stage(t, 0u, done[0]);
    stage(t, 1u, done[1]);
    stage(t, 2u, done[2]);
}

fn cross_of(a: array<Lanes, 3>, b: array<Lanes, 3>) -> array<Lanes, 3> {
    return array<Lanes, 3>(
        sub(mul(a[1], b[2]), mul(a[2], b[1])),
        sub(mul(a[2], b[0]), mul(a[0], b[2])),
        sub(mul(a[0], b[1]), mul(a[1], b[0])),
    );
}

// What to multiply a vector with, one after the other, to make its length 1: two factors, so that no
// length over- or underflows. Zeros for the zero vector, and for what is subnormal, above 2^125 or no number.
fn unit_factors(x: Part, y: Part, z: Part) -> array<Part, 2> {
    let largest = max(max(abs(x), abs(y)), abs(z));
    let some = (largest >= Part(0x1p-126f)) & (largest <= Part(0x1p125f));
    let scale = select(Part(0.0), Part(1.0) / largest, some);
    let u = x * scale;
    let v = y * scale;
    let w = z * scale;
    let square = u * u + v * v + w * w;
    return array<Part, 2>(scale, select(Part(0.0), Part(1.0) / sqrt(square), some));
}

// Writes the staged points of tile `first ..` of a range, instance by instance.
fn write_staged(t: u32, block: u32, first: u32) {
    let floats = 3u * min(64u, params.count - first);
    let instance_count = instance_count();
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = block * LANES + lane;
        if (instance < instance_count) {
            let base = 3u * (instance * params.total + params.first + first);
            for (var i = t; i < floats; i += 64u) {
                result[base + i] = staged[192u * lane + i];
            }
        }
    }
}
