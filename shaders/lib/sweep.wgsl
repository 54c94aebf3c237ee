// What the passes of a lighting sweep share.

struct LightPush {
    face_count: u32,
    brick_count: u32,
    // Number of the sweep over time.
    update: u32,
}
var<immediate> push: LightPush;

// Irradiance on its way between the lighting passes; INVALID in the second word: no point of the face could be lit.
const INVALID: u32 = 0xffffffffu;

fn pack_irradiance(e: vec3<f32>) -> vec2<u32> {
    let c = min(e, vec3<f32>(65000.0));
    return vec2<u32>(pack2x16float(c.xy), pack2x16float(vec2<f32>(c.z, 0.0)));
}

fn unpack_irradiance(words: vec2<u32>) -> vec3<f32> {
    return vec3<f32>(unpack2x16float(words.x), unpack2x16float(words.y).x);
}
