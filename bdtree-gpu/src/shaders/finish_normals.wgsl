const SIDES = 2u;

fn local(t: u32, first: u32, block: u32) -> array<Lanes, 3> {
    let a = moved(t, first, block, 0u);
    let b = moved(t, first, block, 1u);
    return spanned(t, first, block, a, b);
}

fn finish(block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> {
    return normalized(turn(block, 0u, x), turn(block, 4u, x), turn(block, 8u, x));
}
