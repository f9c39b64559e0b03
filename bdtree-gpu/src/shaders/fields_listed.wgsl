// Layout 2: each vertex has fields of the modes of its list only; the others are not even looked at.
@group(0) @binding(3) var<storage, read> lists: array<u32>;

// The mode of entry `k` of the lists: two to a word.
fn listed_mode(k: u32) -> u32 {
    let word = lists[params.list_base + k / 2u];
    return (word >> (16u * (k % 2u))) & 0xffffu;
}

fn moved_by(t: u32, first: u32, block: u32, side: u32) -> array<Lanes, 3> {
    var x = splat(0.0);
    var y = splat(0.0);
    var z = splat(0.0);
    if (first + t < params.count) {
        // Records of two words: first entry, and where the list begins; the next record ends it.
        let record = 2u * (first + t);
        let start = lists[record];
        let list = lists[record + 1u];
        let modes = lists[record + 2u] - start;
        let fields_start = SIDES * (start - params.entry_base) + side * modes;
        for (var k = 0u; k < modes; k++) {
            let q = row_of(block, MATRIX_ROWS + listed_mode(list + k));
            let at = 3u * (fields_start + k);
            x = add(x, mul(splat(fields[at]), q));
            y = add(y, mul(splat(fields[at + 1u]), q));
            z = add(z, mul(splat(fields[at + 2u]), q));
        }
    }
    return array<Lanes, 3>(x, y, z);
}
