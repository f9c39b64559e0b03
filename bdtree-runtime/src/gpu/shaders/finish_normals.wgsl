fn finish(block: u32, x: array<Lanes, 3>) -> array<Lanes, 3> {
    return normalized(x[0], x[1], x[2]);
}
