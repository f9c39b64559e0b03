const SIDES = 1u;

fn local(t: u32, first: u32, block: u32) -> array<Lanes, 3> {
    return carried(t, first, block, moved(t, first, block, 0u));
}

fn finish(block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> {
    return array<Lanes, 3>(
        add(turn(block, 0u, x), row_of(block, 3u)),
        add(turn(block, 4u, x), row_of(block, 7u)),
        add(turn(block, 8u, x), row_of(block, 11u)),
    );
}
