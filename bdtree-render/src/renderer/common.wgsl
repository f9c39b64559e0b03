// What all shaders begin with. Depth is reversed: 1 at the near distance, 0 infinitely far away.

struct Globals {
    view_projection: mat4x4<f32>,
    // The eye, and the distance before which nothing is seen.
    eye: vec4<f32>,
    // Forward, and 1 where the target wants colours encoded as sRGB by us.
    forward: vec4<f32>,
    // Towards the light.
    light: vec4<f32>,
    // Towards the picture's upper edge.
    up: vec4<f32>,
    // Width and height of the picture in pixels.
    size: vec4<f32>,
    // The upward normal of the ground, and its height along it.
    ground: vec4<f32>,
    // Of shadows on the ground.
    shadow: vec4<f32>,
    // From a shadow to what throws it, a unit above the ground.
    shadow_light: vec4<f32>,
}

@group(0) @binding(0) var<uniform> globals: Globals;

fn linear(colour: vec3<f32>) -> vec3<f32> {
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3(2.4));
    return select(high, low, colour <= vec3(0.04045));
}

fn encoded(colour: vec3<f32>) -> vec3<f32> {
    if globals.forward.w == 0.0 {
        return colour;
    }
    let low = colour * 12.92;
    let high = 1.055 * pow(max(colour, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055;
    return select(high, low, colour <= vec3(0.0031308));
}

// What a matt surface of this colour (linear) sends to the eye.
fn lit(colour: vec3<f32>, normal: vec3<f32>, toward_eye: vec3<f32>) -> vec3<f32> {
    let key = max(dot(normal, globals.light.xyz), 0.0);
    let sky = 0.5 + 0.5 * dot(normal, globals.up.xyz);
    let head = max(dot(normal, toward_eye), 0.0);
    let half_way = normalize(globals.light.xyz + toward_eye);
    let shine = 0.04 * pow(max(dot(normal, half_way), 0.0), 32.0);
    return colour * (0.12 + 0.20 * sky + 0.20 * head + 0.52 * key) + vec3(shine);
}

// The unit normal of what is seen of a mesh, toward the eye: between that of the triangle and `mean`, the vertices' times
// how smooth the mesh is there. In fragment shaders only.
fn seen_normal(toward_eye: vec3<f32>, mean: vec3<f32>, smoothness: f32) -> vec3<f32> {
    // Of small numbers: positions are far from 0 compared with a pixel's differences.
    let view = normalize(toward_eye);
    let side = cross(dpdx(toward_eye), dpdy(toward_eye));
    let size = length(side);
    var facet = view;
    if size > 0.0 {
        facet = side / size;
    }
    // Both sides are lit.
    facet *= select(1.0, -1.0, dot(facet, view) < 0.0);
    let turned = mean * select(1.0, -1.0, dot(mean, facet) < 0.0);
    let blend = (1.0 - smoothness) * facet + turned;
    if length(blend) > 0.0 {
        return normalize(blend);
    }
    return facet;
}
