// Rasterises the G-buffer: world normal towards the camera, albedo, emission, motion (depth is fixed-function).

struct View {
    // From a position relative to the camera to clip space.
    clip: mat4x4f,
    position: vec3f,
    // From a position relative to the camera to x, y and w in clip space of the last frame.
    past_x: vec4f,
    past_y: vec4f,
    past_w: vec4f,
}

struct Material {
    base_color: vec3f,
    first_texel: u32,
    emission: vec3f,
    // width | height << 16; 0 without a texture.
    texture_size: u32,
}

var<immediate> view: View;
@group(0) @binding(0) var<storage, read> materials: array<Material>;
// sRGB RGBA8, row by row, all textures in a row.
@group(0) @binding(1) var<storage, read> texels: array<u32>;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) from_camera: vec3f,
    @location(1) @interpolate(flat) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) @interpolate(flat) material: u32,
    // x, y and w in clip space, now and in the last frame.
    @location(4) now: vec3f,
    @location(5) past: vec3f,
}

// Position and face normal in object space; from the instance: the columns of object to world, now
// and in the last frame, and the material.
@vertex
fn corner(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) x_axis: vec3f,
    @location(4) y_axis: vec3f,
    @location(5) z_axis: vec3f,
    @location(6) translation: vec3f,
    @location(7) past_x_axis: vec3f,
    @location(8) past_y_axis: vec3f,
    @location(9) past_z_axis: vec3f,
    @location(10) past_translation: vec3f,
    @location(11) material: u32,
) -> Corner {
    let from_camera = mat3x3f(x_axis, y_axis, z_axis) * position + (translation - view.position);
    // Cofactors carry normals under any scale; a mirrored instance turns its triangles around.
    let cofactors = mat3x3f(cross(y_axis, z_axis), cross(z_axis, x_axis), cross(x_axis, y_axis));
    let facing = select(1.0, -1.0, dot(x_axis, cofactors[0]) < 0.0);
    let world_normal = facing * normalize(cofactors * normal);
    let past_linear = mat3x3f(past_x_axis, past_y_axis, past_z_axis);
    let past = vec4f(past_linear * position + (past_translation - view.position), 1.0);
    let past_clip = vec3f(dot(view.past_x, past), dot(view.past_y, past), dot(view.past_w, past));
    let clip = view.clip * vec4f(from_camera, 1.0);
    return Corner(clip, from_camera, world_normal, uv, material, clip.xyw, past_clip);
}

fn linear_from_srgb(color: vec3f) -> vec3f {
    let curve = pow((color + 0.055) / 1.055, vec3f(2.4));
    return select(curve, color / 12.92, color <= vec3f(0.04045));
}

fn texel(material: Material, at: vec2i) -> vec3f {
    let size = vec2i(vec2u(material.texture_size & 0xffffu, material.texture_size >> 16u));
    let wrapped = ((at % size) + size) % size;
    let packed = texels[material.first_texel + u32(wrapped.y * size.x + wrapped.x)];
    return linear_from_srgb(unpack4x8unorm(packed).rgb);
}

// Bilinear, repeating, without mips.
fn texture_color(material: Material, uv: vec2f) -> vec3f {
    let size = vec2f(vec2u(material.texture_size & 0xffffu, material.texture_size >> 16u));
    let at = fract(uv) * size - 0.5;
    let base = vec2i(floor(at));
    let blend = at - floor(at);
    let top = mix(texel(material, base), texel(material, base + vec2i(1, 0)), blend.x);
    let bottom = mix(texel(material, base + vec2i(0, 1)), texel(material, base + vec2i(1, 1)), blend.x);
    return mix(top, bottom, blend.y);
}

struct Surface {
    @location(0) normal: vec4f,
    @location(1) albedo: vec4f,
    @location(2) emission: vec4f,
    // Where it was less where it is, parts of the image, y down.
    @location(3) motion: vec2f,
}

const MAX_ALBEDO = 0.95;

@fragment
fn surface(in: Corner) -> Surface {
    let material = materials[in.material];
    let front = dot(in.normal, in.from_camera) < 0.0;
    var albedo = material.base_color;
    if material.texture_size != 0u {
        albedo *= texture_color(material, in.uv);
    }
    return Surface(
        vec4f(select(-in.normal, in.normal, front), 1.0),
        vec4f(min(albedo, vec3f(MAX_ALBEDO)), 1.0),
        vec4f(select(vec3f(0.0), material.emission, front), 1.0),
        (in.past.xy / in.past.z - in.now.xy / in.now.z) * vec2f(0.5, -0.5),
    );
}
