// Radiosity: hemisphere rays from the listed faces read what their targets sent out last; infinite bounces over time.

#import lib/faces.wgsl
#import lib/reach.wgsl
#import lib/sweep.wgsl

// In: direct irradiance. Out: direct + indirect.
@res var<storage, read_write> face_irradiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= push.face_count { return; }
    // Without lights `light_direct` has not run.
    var words = vec2<u32>(0u);
    if frame.light_count > 0u { words = face_irradiance[id.x]; }
    if words.y == INVALID { return; }
    let face = load_face(vis_faces[id.x]);
    let normal = face_normal(face);
    var e = vec3<f32>(0.0);
    let start = face_point(face, r2(face.seed ^ 0x2545f491u, push.update), pcg(face.seed - push.update));
    if start.w == 0.0 {
        face_irradiance[id.x] = vec2<u32>(INVALID);
        return;
    }
    // A face that looks at a closed voxel may stand in a closed room.
    let asks = face.asks && !find_voxel(face.cell + vec3<i32>(side_normal(face.side))).found;
    for (var r = 0u; r < frame.bounce_rays; r++) {
        let index = push.update * frame.bounce_rays + r;
        let direction = cosine_direction(normal, r2(face.seed, index));
        let hit = trace(Start(start.xyz, normal, FACE_ERROR), direction, 1e6);
        if asks { ask_for_light(hit); }
        e += hit_radiance(hit, direction);
    }
    face_irradiance[id.x] = pack_irradiance(unpack_irradiance(words) + e * (3.14159265 / f32(frame.bounce_rays)));
}
