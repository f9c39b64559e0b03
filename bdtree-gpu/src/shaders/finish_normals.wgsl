const SIDES = 2u;

fn local(t: u32, first: u32, block: u32) -> array<Lanes, 3> {
    let a = moved(t, first, block, 0u);
    let b = moved(t, first, block, 1u);
    return array<Lanes, 3>(
        sub(mul(a[1], b[2]), mul(a[2], b[1])),
        sub(mul(a[2], b[0]), mul(a[0], b[2])),
        sub(mul(a[0], b[1]), mul(a[1], b[0])),
    );
}

fn finish(block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> {
    return normalized(turn(block, 0u, x), turn(block, 4u, x), turn(block, 8u, x));
}
