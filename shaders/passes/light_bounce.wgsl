// Radiosity: hemisphere rays from the listed faces read what their targets sent out last; infinite bounces over time. Or
// one bounce: they look what light their targets get straight.

#import lib/faces.wgsl
#import lib/lights.wgsl
#import lib/reach.wgsl
#import lib/sweep.wgsl

@res var<storage, read> lights: array<Light>;
// In: direct irradiance. Out: direct + indirect.
@res var<storage, read_write> face_irradiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= push.face_count { return; }
    // Without lights `light_direct` has not run.
    var words = vec2<u32>(0u);
    if at_run_time(frame.light_count, id.x) > 0u { words = face_irradiance[id.x]; }
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
    let rays = at_run_time(frame.bounce_rays, id.x);
    for (var r = 0u; r < rays; r++) {
        let index = push.update * rays + r;
        let direction = cosine_direction(normal, r2(face.seed, index));
        let hit = trace(Start(start.xyz, normal, FACE_ERROR), direction, 1e6);
        if asks { ask_for_light(hit); }
        // Another line where a setting allows one bounce (build.rs).
        e += hit_radiance(hit, direction);
    }
    face_irradiance[id.x] = pack_irradiance(unpack_irradiance(words) + e * (3.14159265 / f32(rays)));
}

// What a hit sends of the light that comes to it straight: by one of the lights, for all of them.
fn sent_directly(hit: Hit, origin: vec3<f32>, direction: vec3<f32>, seed: u32, index: u32) -> vec3<f32> {
    if hit.kind == MISS { return sky_radiance(direction); }
    let voxel = find_voxel(hit.cell);
    if !has_side(voxel, hit.side) { return vec3<f32>(0.0); }
    var sent = vec3<f32>(0.0);
    if is_lit(voxel, hit.side) { sent = voxel_emission(voxel, hit.side); }
    let light_count = at_run_time(frame.light_count, hit.side);
    if light_count == 0u { return sent; }
    let chosen = min(u32(unit_float(pcg(seed ^ pcg(index))) * f32(light_count)), light_count - 1u);
    let light = lights[chosen];
    let plane = voxel_plane(voxel, hit.side);
    let p = origin + direction * hit.t + plane.normal * 0.02;
    let sample = sample_light(light, p, seed + chosen, index);
    let cosine = dot(plane.normal, sample.direction);
    if cosine <= 0.0 || sample.strength <= 0.0 { return sent; }
    if trace(Start(p, plane.normal, FACE_ERROR), sample.direction, sample.reach).kind == HIT { return sent; }
    let e = light.color * (sample.strength * cosine * f32(light_count));
    return sent + voxel_albedo(voxel, hit.side) * e * 0.318309886;
}
