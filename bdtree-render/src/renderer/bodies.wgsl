// Bodies of a crowd and the floor below them, behind common.wgsl. y is up.

struct Light {
    // The lowest corner of the box that `open_sky` is known in, and 1 over its sizes.
    low: vec4<f32>,
    per_size: vec4<f32>,
    // The floor's colour, and its height.
    floor: vec4<f32>,
    // Where its middle is (x, z), and how far from there it begins to fade.
    middle: vec4<f32>,
    // What it fades into.
    background: vec4<f32>,
}

@group(1) @binding(0) var<uniform> light: Light;
@group(1) @binding(1) var sky: texture_3d<f32>;
@group(1) @binding(2) var smooth_sky: sampler;

// How much of the sky is seen from a point through all that is above it, 0 to 1.
fn open_sky(p: vec3<f32>) -> f32 {
    return textureSampleLevel(sky, smooth_sky, (p - light.low.xyz) * light.per_size.xyz, 0.0).r;
}

struct OnBody {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) smoothness: f32,
    // Red, green, blue, and how much of the sky is seen: triangles are smaller than what that varies over.
    @location(3) colour: vec4<f32>,
}

@vertex
fn body_vertex(
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) smoothness: f32,
    @location(3) colour: vec4<f32>,
) -> OnBody {
    var out: OnBody;
    out.clip = globals.view_projection * vec4(position, 1.0);
    out.world = position;
    out.normal = normal * smoothness;
    out.smoothness = smoothness;
    out.colour = vec4(linear(colour.rgb), open_sky(position));
    return out;
}

// Plastic: matt below a clear, shiny surface, which reflects the sky where it is seen from the side.
@fragment
fn body_fragment(in: OnBody) -> @location(0) vec4<f32> {
    let toward_eye = globals.eye.xyz - in.world;
    let normal = seen_normal(toward_eye, in.normal, in.smoothness);
    let view = normalize(toward_eye);
    let open = in.colour.w;
    let key = max(dot(normal, globals.light.xyz), 0.0);
    let above = 0.5 + 0.5 * normal.y;
    let head = max(dot(normal, view), 0.0);
    let diffuse = 0.06 * head + open * (0.10 + 0.36 * above) + (0.15 + 0.85 * open) * 0.62 * key;
    let half_way = normalize(globals.light.xyz + view);
    // To the power of 32: on a processor that draws, pow takes longer than all other sums here.
    let straight = max(dot(normal, half_way), 0.0);
    let to_2 = straight * straight;
    let to_8 = to_2 * to_2 * to_2 * to_2;
    let gloss = 0.3 * to_8 * to_8 * to_8 * to_8;
    let grazing = (1.0 - head) * (1.0 - head);
    let sheen = 0.16 * grazing * grazing * above;
    let colour = in.colour.rgb * diffuse + vec3(open * (gloss + sheen));
    return vec4(encoded(colour), 1.0);
}

struct OnFloor {
    @builtin(position) clip: vec4<f32>,
    @location(0) world: vec3<f32>,
}

// Beyond this many times the distance where it begins to fade there is nothing left of the floor.
const FADED: f32 = 3.0;

@vertex
fn floor_vertex(@builtin(vertex_index) vertex: u32) -> OnFloor {
    let corner = vec2(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
    let at = light.middle.xy + corner * (FADED * light.middle.z);
    var out: OnFloor;
    out.world = vec3(at.x, light.floor.w, at.y);
    out.clip = globals.view_projection * vec4(out.world, 1.0);
    return out;
}

@fragment
fn floor_fragment(in: OnFloor) -> @location(0) vec4<f32> {
    let away = length(in.world.xz - light.middle.xy) / light.middle.z;
    let part = clamp((away - 1.0) / (FADED - 1.0), 0.0, 1.0);
    let fade = part * part * (3.0 - 2.0 * part);
    let colour = mix(linear(light.floor.rgb), linear(light.background.rgb), fade);
    return vec4(encoded(colour * mix(0.16, 1.0, open_sky(in.world))), 1.0);
}
