// Layout 1: all modes of all vertices. A chunk of modes of 64 vertices is read in runs of memory.
const CHUNK = 8u;
const STRIDE = 25u; // odd: no two threads of a bank

fn moved_by(t: u32, first: u32, block: u32, side: u32) -> array<Lanes, 3> {
    var x = splat(0.0);
    var y = splat(0.0);
    var z = splat(0.0);
    let m = params.mode_count;
    let vertices = min(64u, params.count - first);
    for (var mode = 0u; mode < m; mode += CHUNK) {
        let modes = min(CHUNK, m - mode);
        let width = 3u * modes;
        let step_vertex = 64u / width;
        let step_number = 64u % width;
        var vertex = t / width;
        var number = t % width;
        workgroupBarrier();
        while (vertex < vertices) {
            staged[vertex * STRIDE + number] = fields[3u * (((first + vertex) * SIDES + side) * m + mode) + number];
            vertex += step_vertex;
            number += step_number;
            if (number >= width) {
                number -= width;
                vertex += 1u;
            }
        }
        workgroupBarrier();
        for (var j = 0u; j < modes; j++) {
            let q = row_of(block, MATRIX_ROWS + mode + j);
            let at = t * STRIDE + 3u * j;
            x = add(x, mul(splat(staged[at]), q));
            y = add(y, mul(splat(staged[at + 1u]), q));
            z = add(z, mul(splat(staged[at + 2u]), q));
        }
    }
    return array<Lanes, 3>(x, y, z);
}
