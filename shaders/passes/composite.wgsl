// What the host would draw: direct light, and what the surfaces make of the indirect.

struct CompositePush {
    // Rendered region in pixels: where it begins in the images, and its size.
    origin: vec2<u32>,
    size: vec2<u32>,
    // 1: the output is a debug view, and is shown as it is.
    shows_output: u32,
}
var<immediate> push: CompositePush;

@res var albedo_image: texture_2d<f32>;
@res var direct_image: texture_2d<f32>;
@res var output_image: texture_storage_2d<rgba16float, read>;
@res var composite_image: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= push.size) { return; }
    let pixel = push.origin + id.xy;
    let output = textureLoad(output_image, pixel).xyz;
    let direct = textureLoad(direct_image, pixel, 0).xyz;
    let albedo = textureLoad(albedo_image, pixel, 0).xyz;
    let lit = direct + albedo * output * 0.318309886;
    textureStore(composite_image, pixel, vec4<f32>(select(lit, output, push.shows_output == 1u), 1.0));
}
