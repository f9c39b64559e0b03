// Meshes, spheres and lines, behind common.wgsl.

struct Look {
    colour: vec4<f32>,
}

@group(1) @binding(0) var<uniform> look: Look;

struct OnMesh {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) smoothness: f32,
}

@vertex
fn mesh_vertex(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) smoothness: f32,
) -> OnMesh {
    var out: OnMesh;
    out.clip = globals.view_projection * vec4(position, 1.0);
    out.world = position;
    // Weighed here: of a crease's normal nothing comes into the triangles beside it.
    out.normal = normal * smoothness;
    out.smoothness = smoothness;
    return out;
}

@fragment
fn mesh_fragment(in: OnMesh) -> @location(0) vec4<f32> {
    let toward_eye = globals.eye.xyz - in.world;
    let normal = seen_normal(toward_eye, in.normal, in.smoothness);
    let colour = lit(linear(look.colour.rgb), normal, normalize(toward_eye));
    return vec4(encoded(colour), 1.0);
}

// The mesh pressed flat onto the ground, away from the light: its shadow.
@vertex
fn shadow_vertex(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    let above = dot(globals.ground.xyz, position) - globals.ground.w;
    return globals.view_projection * vec4(position - above * globals.shadow_light.xyz, 1.0);
}

@fragment
fn shadow_fragment() -> @location(0) vec4<f32> {
    return vec4(encoded(linear(globals.shadow.rgb)), 1.0);
}

struct OnSphere {
    @builtin(position) clip: vec4<f32>,
    // Once for every sample, so that rims and intersections are as smooth as edges of triangles.
    @location(0) @interpolate(perspective, sample) to_point: vec3<f32>,
    @location(1) @interpolate(flat) sphere: vec4<f32>,
    @location(2) @interpolate(flat) colour: vec4<f32>,
}

// A square that just covers the sphere as the eye sees it; `sphere` is center and radius.
@vertex
fn sphere_vertex(
    @builtin(vertex_index) vertex: u32,
    @location(0) sphere: vec4<f32>,
    @location(1) colour: vec4<f32>,
) -> OnSphere {
    let to_center = sphere.xyz - globals.eye.xyz;
    let distance = length(to_center);
    let radius = sphere.w;
    let corner = vec2(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
    var out: OnSphere;
    out.sphere = sphere;
    out.colour = colour;
    out.to_point = vec3(0.0);
    // From within a sphere nothing of it is seen.
    out.clip = vec4(0.0, 0.0, 2.0, 1.0);
    if distance > radius * 1.0001 {
        let toward = to_center / distance;
        var other = vec3(0.0, 1.0, 0.0);
        if abs(toward.y) > 0.9 {
            other = vec3(1.0, 0.0, 0.0);
        }
        let x = normalize(cross(toward, other));
        let y = cross(x, toward);
        let reach = distance * radius / sqrt((distance - radius) * (distance + radius));
        out.to_point = to_center + (corner.x * x + corner.y * y) * reach;
        out.clip = globals.view_projection * vec4(globals.eye.xyz + out.to_point, 1.0);
    }
    return out;
}

struct SpherePixel {
    @location(0) colour: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn sphere_fragment(in: OnSphere) -> SpherePixel {
    let ray = normalize(in.to_point);
    let to_center = in.sphere.xyz - globals.eye.xyz;
    let radius = in.sphere.w;
    let along = dot(to_center, ray);
    // From where the ray is nearest to the center: small numbers, also for small spheres.
    let aside = to_center - along * ray;
    let square = radius * radius - dot(aside, aside);
    if square < 0.0 {
        discard;
    }
    let half = sqrt(square);
    let normal = (-aside - half * ray) / radius;
    let hit = (along - half) * ray;
    let near = globals.eye.w;
    let depth = dot(hit, globals.forward.xyz);
    if depth < near {
        discard;
    }
    // Translucent spheres are as glass: clear in the middle, solid at the rim.
    let rim = 1.0 - max(dot(normal, -ray), 0.0);
    let alpha = mix(in.colour.a, 1.0, 0.6 * rim * rim * rim * step(in.colour.a, 0.999));
    let colour = lit(linear(in.colour.rgb), normal, -ray);
    var out: SpherePixel;
    out.colour = vec4(encoded(colour), alpha);
    out.depth = near / depth;
    return out;
}

struct OnLine {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) colour: vec4<f32>,
}

// A rectangle of `width` pixels along the line, half of that longer at both ends so that lines join.
@vertex
fn line_vertex(
    @builtin(vertex_index) vertex: u32,
    @location(0) first: vec3<f32>,
    @location(1) last: vec3<f32>,
    @location(2) colour: vec4<f32>,
    @location(3) width: f32,
) -> OnLine {
    let near = globals.eye.w;
    var a = globals.view_projection * vec4(first, 1.0);
    var b = globals.view_projection * vec4(last, 1.0);
    var out: OnLine;
    out.colour = colour;
    out.clip = vec4(0.0, 0.0, 2.0, 1.0);
    if max(a.w, b.w) <= near {
        return out;
    }
    // What is behind the eye has no place in the picture.
    if a.w < near {
        a = mix(a, b, (near - a.w) / (b.w - a.w));
    } else if b.w < near {
        b = mix(b, a, (near - b.w) / (a.w - b.w));
    }
    let pixels = 0.5 * globals.size.xy;
    let run = b.xy / b.w * pixels - a.xy / a.w * pixels;
    var along = vec2(1.0, 0.0);
    if length(run) > 0.0 {
        along = normalize(run);
    }
    let aside = vec2(-along.y, along.x) * (f32(vertex & 1u) * 2.0 - 1.0);
    let is_last = (vertex >> 1u) == 1u;
    let beyond = along * select(-1.0, 1.0, is_last);
    let end = select(a, b, is_last);
    let offset = 0.5 * width * (aside + beyond) / pixels;
    out.clip = end + vec4(offset * end.w, 0.0, 0.0);
    return out;
}

@fragment
fn line_fragment(in: OnLine) -> @location(0) vec4<f32> {
    return vec4(encoded(linear(in.colour.rgb)), in.colour.a);
}
