// Every packer and its inverse, one value of each a thread.

#import lib/pack.wgsl

struct PackInput {
    color: vec3<f32>,
    side: u32,
    // Rounding of the colour and dither of the albedo.
    random: vec3<f32>,
    albedo: vec3<f32>,
    normal: vec3<f32>,
    centroid: vec3<f32>,
}

struct PackOutput {
    color: vec3<f32>,
    color_word: u32,
    albedo: vec3<f32>,
    albedo_word: u32,
    fine_albedo: vec3<f32>,
    fine_albedo_word: u32,
    normal: vec3<f32>,
    plane_word: u32,
    offset: f32,
    mask_bit: u32,
}

@res var<storage, read> pack_inputs: array<PackInput>;
@res var<storage, read_write> pack_outputs: array<PackOutput>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&pack_inputs) { return; }
    let value = pack_inputs[id.x];
    let color_word = rgb9e5_encode(value.color, value.random);
    let albedo_word = albedo_encode(value.albedo, value.random);
    let fine_albedo_word = fine_albedo_encode(value.albedo);
    let plane_word = plane_encode(value.side, value.normal, value.centroid);
    let plane = plane_decode(value.side, plane_word);
    pack_outputs[id.x] = PackOutput(rgb9e5_decode(color_word), color_word, albedo_decode(albedo_word), albedo_word,
                                    fine_albedo_decode(fine_albedo_word), fine_albedo_word,
                                    plane.normal, plane_word, plane.offset, mask_bit(value.side >> 1u, value.centroid));
}
