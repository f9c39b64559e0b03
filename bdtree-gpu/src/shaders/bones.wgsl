// Bones carry vertices: p' = M (p + U q), M = Σ w_b T_b (SPEC 5.9). Rows of the bones' maps lie behind those of q,
// influences of the range's vertices behind the lists of modes.
const BONE_ROWS = 12u;

fn block_rows() -> u32 { return MATRIX_ROWS + params.mode_count + BONE_ROWS * params.bone_count; }

// M of a vertex, three rows of four.
fn blended(t: u32, first: u32, block: u32) -> array<Lanes, 12> {
    var m: array<Lanes, 12>;
    for (var k = 0u; k < 12u; k++) {
        m[k] = splat(0.0);
    }
    let own = params.influences + min(first + t, params.count - 1u);
    let entries = params.influences + params.count + 1u;
    let base = lists[params.influences];
    let end = lists[own + 1u] - base;
    for (var i = lists[own] - base; i < end; i++) {
        let weight = splat(bitcast<f32>(lists[entries + 2u * i]));
        let bone = lists[entries + 2u * i + 1u] & 0xffffu;
        let row = MATRIX_ROWS + params.mode_count + BONE_ROWS * bone;
        for (var k = 0u; k < 12u; k++) {
            m[k] = add(m[k], mul(weight, row_of(block, row + k)));
        }
    }
    return m;
}

// A row of M's linear part times a vector.
fn along(x: Lanes, y: Lanes, z: Lanes, v: array<Lanes, 3>) -> Lanes {
    return add(add(mul(x, v[0]), mul(y, v[1])), mul(z, v[2]));
}

fn carried(t: u32, first: u32, block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> {
    let m = blended(t, first, block);
    return array<Lanes, 3>(
        add(along(m[0], m[1], m[2], x), m[3]),
        add(along(m[4], m[5], m[6], x), m[7]),
        add(along(m[8], m[9], m[10], x), m[11]),
    );
}

// The direction of cof(A) (a × b) = A a × A b, A being M's linear part; of unit vectors, so that no product over- or
// underflows. Zero where A leaves nothing of a or b.
fn spanned(t: u32, first: u32, block: u32, a: array<Lanes, 3>, b: array<Lanes, 3>) -> array<Lanes, 3> {
    let m = blended(t, first, block);
    return cross_of(
        normalized(along(m[0], m[1], m[2], a), along(m[4], m[5], m[6], a), along(m[8], m[9], m[10], a)),
        normalized(along(m[0], m[1], m[2], b), along(m[4], m[5], m[6], b), along(m[8], m[9], m[10], b)),
    );
}
