// Lists the voxels of each queued brick (and of one voxel around it) that a triangle touches.
// One workgroup a brick, one triangle a thread.

#import lib/triangles.wgsl

struct VoxelMarkPush {
    first_brick: u32,
}
var<immediate> push: VoxelMarkPush;

// Workgroups of `voxelize`: x counts the items.
@res var<storage, read_write> voxel_args: array<atomic<u32>, 4>;
@res var<storage, read_write> voxel_items: array<u32>;
@res var<storage, read_write> voxel_states: array<u32>;

var<workgroup> touched: array<atomic<u32>, 32>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    if thread < 32u { atomicStore(&touched[thread], 0u); }
    if thread == 0u {
        atomicStore(&voxel_args[1], 1u);
        atomicStore(&voxel_args[2], 1u);
    }
    workgroupBarrier();

    let brick = batch_bricks[push.first_brick + group.x];
    for (var i = thread; i < brick.triangle_count; i += 64u) {
        mark(load_triangle(brick.first_triangle + i, place_in_group(brick)));
    }
    workgroupBarrier();

    for (var i = thread; i < APRON_COUNT; i += 64u) {
        voxel_states[group.x * APRON_COUNT + i] = 0u;
        if ((atomicLoad(&touched[i >> 5u]) >> (i & 31u)) & 1u) != 0u {
            voxel_items[atomicAdd(&voxel_args[0], 1u)] = (group.x << 10u) | i;
        }
    }
}

fn mark(t: Triangle) {
    let low = vec3<i32>(clamp(floor(min(min(t.a, t.b), t.c)), vec3<f32>(-1.0), vec3<f32>(9.0)));
    let high = vec3<i32>(clamp(floor(max(max(t.a, t.b), t.c)), vec3<f32>(-2.0), vec3<f32>(8.0)));
    for (var z = low.z; z <= high.z; z++) {
        for (var y = low.y; y <= high.y; y++) {
            for (var x = low.x; x <= high.x; x++) {
                let cell = vec3<i32>(x, y, z);
                if overlaps_cube(t, vec3<f32>(cell) + 0.5, 0.5) {
                    let index = apron_index(cell);
                    atomicOr(&touched[index >> 5u], 1u << (index & 31u));
                }
            }
        }
    }
}
