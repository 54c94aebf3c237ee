// Averages the new radiance of the listed faces into the world, rounding stochastically: an average in nine bits would
// stick (accuracy, "Rounding of the running average").

#import shared/limits.wgsl
#import shared/bricks.wgsl
#import lib/brick.wgsl
#import lib/random.wgsl
#import lib/sweep.wgsl

@res var<storage, read> light_bricks: array<LightBrick>;
@res var<storage, read> vis_faces: array<u32>;
@res var<storage, read> face_irradiance: array<vec2<u32>>;
@res var<storage, read_write> world_bricks: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= push.face_count { return; }
    let words = face_irradiance[id.x];
    if words.y == INVALID { return; }
    let item = vis_faces[id.x];
    let brick = light_bricks[item >> 12u];
    let cell = (vec3<u32>(item) >> vec3<u32>(3u, 6u, 9u)) & vec3<u32>(7u);
    let voxel = brick_voxel(brick.base, world_bricks[brick.base], cell);
    let side = item & 7u;

    let e = unpack_irradiance(words);
    let sent = voxel_albedo(voxel, side) * e * 0.318309886 + voxel_emission(voxel, side);
    let address = light_address(voxel, side);
    let radiance = mix(rgb9e5_decode(world_bricks[address]), sent, brick.alpha);
    let seed = pcg(item ^ pcg((brick.position & ~ASKS) ^ (push.update * 0x9e3779b9u)));
    let rounding = vec3<f32>(unit_float(pcg(seed)), unit_float(pcg(seed + 1u)), unit_float(pcg(seed + 2u)));
    world_bricks[address] = rgb9e5_encode(radiance, rounding);
}
