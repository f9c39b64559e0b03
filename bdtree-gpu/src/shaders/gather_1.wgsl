fn gather(at: u32) -> Lanes { return points[at]; }
