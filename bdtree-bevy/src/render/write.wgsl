// Writes deformed positions, normals and tangents over those of meshes that lie in one of Bevy's vertex buffers, a thread per
// vertex.

struct Job {
    // Of each instance.
    vertex_count: u32,
    instance_count: u32,
    // Words from one vertex of the buffer to the next, and from its start to its position, its normal and its tangent.
    stride: u32,
    position: u32,
    normal: u32,
    // NONE: tangents are left as they are.
    tangent: u32,
    // The instance in the deformed buffers that is the first here.
    first_instance: u32,
    // Of each instance the word of the buffer at which its vertices begin.
    places: array<u32>,
}

@group(0) @binding(0) var<storage, read> job: Job;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> normals: array<f32>;
@group(0) @binding(3) var<storage, read_write> vertices: array<f32>;
// Of each vertex the word at which its pairs begin, and one behind the last; then the pairs: a vertex and its share.
@group(0) @binding(4) var<storage, read> around: array<u32>;

const NONE = 0xffffffffu;

fn position_of(first: u32, vertex: u32) -> vec3<f32> {
    let at = 3u * (first + vertex);
    return vec3(positions[at], positions[at + 1u], positions[at + 2u]);
}

// The tangent that the triangles around a vertex carry along, perpendicular to the normal; zero where there is none.
fn carried(first: u32, vertex: u32, normal: vec3<f32>) -> vec3<f32> {
    let own = position_of(first, vertex);
    var sum = vec3(0.0);
    for (var at = around[vertex]; at < around[vertex + 1u]; at += 2u) {
        sum += bitcast<f32>(around[at + 1u]) * (position_of(first, around[at]) - own);
    }
    let whole = length(sum);
    let flat = sum - dot(sum, normal) * normal;
    let size = length(flat);
    // Also where something is no number.
    if !(size > 1e-4 * whole) {
        return vec3(0.0);
    }
    return flat / size;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let thread = (group.y * groups.x + group.x) * 64u + local;
    let instance = thread / job.vertex_count;
    if instance >= job.instance_count {
        return;
    }
    let vertex = thread % job.vertex_count;
    let first = (job.first_instance + instance) * job.vertex_count;
    let source = 3u * (first + vertex);
    let place = job.places[instance] + vertex * job.stride;
    for (var k = 0u; k < 3u; k++) {
        vertices[place + job.position + k] = positions[source + k];
        vertices[place + job.normal + k] = normals[source + k];
    }
    if job.tangent == NONE {
        return;
    }
    let normal = vec3(normals[source], normals[source + 1u], normals[source + 2u]);
    let tangent = carried(first, vertex, normal);
    if any(tangent != vec3(0.0)) {
        // The fourth number, the side of the bitangent, stays: triangles keep their orientation.
        for (var k = 0u; k < 3u; k++) {
            vertices[place + job.tangent + k] = tangent[k];
        }
    }
}
