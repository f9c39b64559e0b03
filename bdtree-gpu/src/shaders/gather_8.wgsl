// The same number of eight instances' points; beyond the last instance any.
fn gather(at: u32) -> Lanes {
    let s = 3u * params.total;
    return Lanes(
        Part(points[at], points[at + s], points[at + 2u * s], points[at + 3u * s]),
        Part(points[at + 4u * s], points[at + 5u * s], points[at + 6u * s], points[at + 7u * s]),
    );
}
