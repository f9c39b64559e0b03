// Writes deformed positions and normals over those of meshes that lie in one of Bevy's vertex buffers, a thread per vertex.

struct Job {
    // Of each instance.
    vertex_count: u32,
    instance_count: u32,
    // Words from one vertex of the buffer to the next, and from its start to its position and normal.
    stride: u32,
    position: u32,
    normal: u32,
    // The instance in the deformed buffers that is the first here.
    first_instance: u32,
    // Of each instance the word of the buffer at which its vertices begin.
    places: array<u32>,
}

@group(0) @binding(0) var<storage, read> job: Job;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> normals: array<f32>;
@group(0) @binding(3) var<storage, read_write> vertices: array<f32>;

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
    let source = 3u * ((job.first_instance + instance) * job.vertex_count + vertex);
    let place = job.places[instance] + vertex * job.stride;
    for (var k = 0u; k < 3u; k++) {
        vertices[place + job.position + k] = positions[source + k];
        vertices[place + job.normal + k] = normals[source + k];
    }
}
