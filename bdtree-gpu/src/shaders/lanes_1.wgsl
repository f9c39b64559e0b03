// One instance per thread, for few instances of a large mesh.
alias Part = f32;
alias Lanes = f32;
const LANES = 1u;

@group(1) @binding(0) var<storage, read> instances: array<f32>;

fn instance_count() -> u32 { return u32(instances[0]); }

// Row `row` of the block that `instance` is one of: its number.
fn row_of(instance: u32, row: u32) -> Lanes {
    let block = instance / 8u;
    return instances[8u * (1u + block * block_rows() + row) + instance % 8u];
}

fn splat(x: f32) -> Lanes { return x; }
fn add(x: Lanes, y: Lanes) -> Lanes { return x + y; }
fn sub(x: Lanes, y: Lanes) -> Lanes { return x - y; }
fn mul(x: Lanes, y: Lanes) -> Lanes { return x * y; }

fn normalized(x: Lanes, y: Lanes, z: Lanes) -> array<Lanes, 3> {
    let f = unit_factors(x, y, z);
    return array<Lanes, 3>(x * f[0] * f[1], y * f[0] * f[1], z * f[0] * f[1]);
}

fn stage(t: u32, k: u32, x: Lanes) { staged[3u * t + k] = x; }
