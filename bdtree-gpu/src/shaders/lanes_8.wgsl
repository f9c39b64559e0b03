// Eight instances per thread: what is read of a vertex serves all of them.
alias Part = vec4<f32>;
struct Lanes { a: Part, b: Part }
const LANES = 8u;

@group(1) @binding(0) var<storage, read> instances: array<vec4<f32>>;

fn instance_count() -> u32 { return u32(instances[0].x); }

// Row `row` of block `block`: one number of eight instances.
fn row_of(block: u32, row: u32) -> Lanes {
    let at = 2u * (1u + block * block_rows() + row);
    return Lanes(instances[at], instances[at + 1u]);
}

fn splat(x: f32) -> Lanes { return Lanes(Part(x), Part(x)); }
fn add(x: Lanes, y: Lanes) -> Lanes { return Lanes(x.a + y.a, x.b + y.b); }
fn sub(x: Lanes, y: Lanes) -> Lanes { return Lanes(x.a - y.a, x.b - y.b); }
fn mul(x: Lanes, y: Lanes) -> Lanes { return Lanes(x.a * y.a, x.b * y.b); }

fn normalized(x: Lanes, y: Lanes, z: Lanes) -> array<Lanes, 3> {
    let f = unit_factors(x.a, y.a, z.a);
    let g = unit_factors(x.b, y.b, z.b);
    return array<Lanes, 3>(
        Lanes(x.a * f[0] * f[1], x.b * g[0] * g[1]),
        Lanes(y.a * f[0] * f[1], y.b * g[0] * g[1]),
        Lanes(z.a * f[0] * f[1], z.b * g[0] * g[1]),
    );
}

// The numbers of thread `t` at component `k` of each lane's 64 points.
fn stage(t: u32, k: u32, x: Lanes) {
    let at = 3u * t + k;
    staged[at] = x.a.x;
    staged[at + 192u] = x.a.y;
    staged[at + 384u] = x.a.z;
    staged[at + 576u] = x.a.w;
    staged[at + 768u] = x.b.x;
    staged[at + 960u] = x.b.y;
    staged[at + 1152u] = x.b.z;
    staged[at + 1344u] = x.b.w;
}
