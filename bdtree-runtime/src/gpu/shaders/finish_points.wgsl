fn finish(block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> {
    return array<Lanes, 3>(
        add(x[0], row_of(block, 3u)),
        add(x[1], row_of(block, 7u)),
        add(x[2], row_of(block, 11u)),
    );
}
