// Vertices stay where modes put them.
fn block_rows() -> u32 { return MATRIX_ROWS + params.mode_count; }

fn carried(t: u32, first: u32, block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> { return x; }

fn spanned(t: u32, first: u32, block: u32, a: array<Lanes, 3>, b: array<Lanes, 3>) -> array<Lanes, 3> {
    return cross_of(a, b);
}
