// Direct irradiance of the listed faces: every light, from jittered points on the face, with its shadow.

#import lib/faces.wgsl
#import lib/lights.wgsl
#import lib/shadows.wgsl
#import lib/sweep.wgsl

@res var<storage, read> lights: array<Light>;
@res var<storage, read_write> face_irradiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= push.face_count { return; }
    let face = load_face(vis_faces[id.x]);
    let normal = face_normal(face);
    var e = vec3<f32>(0.0);
    var samples = 0u;
    let light_count = at_run_time(frame.light_count, id.x);
    let sample_count = at_run_time(frame.direct_samples, id.x);
    for (var s = 0u; s < sample_count && light_count > 0u; s++) {
        let index = push.update * sample_count + s;
        let p = face_point(face, r2(face.seed ^ 0x68bc21ebu, index), pcg(face.seed + index));
        if p.w == 0.0 { continue; }
        samples++;
        for (var k = 0u; k < light_count; k++) {
            let sample = sample_light(lights[k], p.xyz, face.seed + k, index);
            let cosine = dot(normal, sample.direction);
            if cosine <= 0.0 || sample.strength <= 0.0 { continue; }
            if !light_arrives(lights[k], sample, p.xyz, normal) { continue; }
            e += lights[k].color * (sample.strength * cosine);
        }
    }
    face_irradiance[id.x] = pack_irradiance(e / f32(max(samples, 1u)));
    if samples == 0u && light_count > 0u { face_irradiance[id.x] = vec2<u32>(INVALID); }
}

