// Of listed vertices only: the others have their normals from fields.
@group(0) @binding(3) var<storage, read> vertices: array<u32>;

fn vertex_at(place: u32) -> u32 { return vertices[place]; }

fn write(t: u32, block: u32, first: u32) {
    if (first + t >= params.count) {
        return;
    }
    let instance_count = instance_count();
    for (var lane = 0u; lane < LANES; lane++) {
        let instance = block * LANES + lane;
        if (instance < instance_count) {
            let base = 3u * (instance * params.total + vertex_at(first + t));
            for (var k = 0u; k < 3u; k++) {
                result[base + k] = staged[192u * lane + 3u * t + k];
            }
        }
    }
}
