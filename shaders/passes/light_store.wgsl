// Averages the new radiance of the listed faces into the world, rounding stochastically: an average in nine bits would
// stick (accuracy, "Rounding of the running average").

#import shared/limits.wgsl
#import shared/bricks.wgsl
#import lib/pack.wgsl
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
    // The list is in the order of the light words: the block follows from the voxel, the rank from the place.
    let local = (item >> 3u) & 511u;
    let block = ((local >> 2u) & 1u) | (((local >> 5u) & 1u) << 1u) | (((local >> 8u) & 1u) << 2u);
    let block_mask = world_bricks[brick.base];
    var before = brick.first_face;
    var record = brick.base + 1u;
    for (var b = 0u; b < block; b++) {
        if ((block_mask >> b) & 1u) == 0u { continue; }
        before += (world_bricks[record + 3u] >> 16u) & 511u;
        record += BLOCK_WORDS;
    }
    let light = world_bricks[record + 3u];
    let count = (light >> 16u) & 511u;
    let rank = id.x - before;
    let address = brick.base + (light & 0xffffu) + rank;

    var emission = vec3<f32>(0.0);
    var albedo_run = address - rank + count;
    if (light >> 31u) != 0u {
        emission = rgb9e5_decode(world_bricks[address + count]);
        albedo_run += count;
    }
    let albedo = albedo_decode((world_bricks[albedo_run + (rank >> 1u)] >> ((rank & 1u) * 16u)) & 0xffffu);
    let e = unpack_irradiance(words);
    let radiance = mix(rgb9e5_decode(world_bricks[address]), albedo * e * 0.318309886 + emission, brick.alpha);
    let seed = pcg(item ^ pcg(brick.position ^ (push.update * 0x9e3779b9u)));
    let rounding = vec3<f32>(unit_float(pcg(seed)), unit_float(pcg(seed + 1u)), unit_float(pcg(seed + 2u)));
    world_bricks[address] = rgb9e5_encode(radiance, rounding);
}
