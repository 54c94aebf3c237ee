// Averages the new radiance of the listed faces into the world, rounding stochastically: an average in nine bits would
// stick (accuracy, "Rounding of the running average"). One workgroup a brick; what changed tells the host how fast the
// brick's average must be.

#import shared/limits.wgsl
#import shared/bricks.wgsl
#import lib/brick.wgsl
#import lib/random.wgsl
#import lib/sweep.wgsl

@res var<storage, read> light_bricks: array<LightBrick>;
@res var<storage, read> vis_faces: array<u32>;
@res var<storage, read> face_irradiance: array<vec2<u32>>;
@res var<storage, read_write> world_bricks: array<u32>;
@res var<storage, read_write> light_changes: array<LightChange>;

fn brick_word(address: u32) -> u32 { return world_bricks[address]; }

// Of each thread's faces: sum of differences, of radiance and of squared differences.
var<workgroup> sums: array<vec3<f32>, 64>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let brick = light_bricks[group.x];
    var end = push.face_count;
    if group.x + 1u < push.brick_count { end = light_bricks[group.x + 1u].first_face; }
    let block_mask = world_bricks[brick.base];
    var sum = vec3<f32>(0.0);
    for (var index = brick.first_face + thread; index < end; index += 64u) { sum += store(brick, block_mask, index); }
    sums[thread] = sum;
    for (var reach = 32u; reach > 0u; reach >>= 1u) {
        workgroupBarrier();
        if thread < reach { sums[thread] += sums[thread + reach]; }
    }
    if thread == 0u {
        let faces = f32(max(end - brick.first_face, 1u));
        light_changes[group.x] = LightChange(sums[0].x / faces, sums[0].y / faces, sqrt(sums[0].z) / faces);
    }
}

// Averages one face. Returns what it adds to the sums.
fn store(brick: LightBrick, block_mask: u32, index: u32) -> vec3<f32> {
    let words = face_irradiance[index];
    if words.y == INVALID { return vec3<f32>(0.0); }
    let item = vis_faces[index];
    let cell = (vec3<u32>(item) >> vec3<u32>(3u, 6u, 9u)) & vec3<u32>(7u);
    let voxel = brick_voxel(brick.base, block_mask, cell);
    let side = item & 7u;

    let e = unpack_irradiance(words);
    let sent = voxel_albedo(voxel, side) * e * 0.318309886 + voxel_emission(voxel, side);
    let address = light_address(voxel, side);
    let word = world_bricks[address];
    let known = rgb9e5_decode(word);
    let seed = pcg(item ^ pcg((brick.position & ~ASKS) ^ (push.update * 0x9e3779b9u)));
    let rounding = vec3<f32>(unit_float(pcg(seed)), unit_float(pcg(seed + 1u)), unit_float(pcg(seed + 2u)));
    world_bricks[address] = rgb9e5_encode(mix(known, sent, select(brick.alpha, 1.0, word == UNLIT)), rounding);
    let difference = dot(sent - known, vec3<f32>(1.0));
    return vec3<f32>(difference, 0.5 * dot(sent + known, vec3<f32>(1.0)), difference * difference);
}
