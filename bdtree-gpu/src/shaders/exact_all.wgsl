// Of all vertices.
fn vertex_at(place: u32) -> u32 { return params.first + place; }

fn write(t: u32, block: u32, first: u32) { write_staged(t, block, first); }
