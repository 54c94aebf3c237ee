// Hierarchical DDA over groups (32 voxels), bricks (8), blocks (4) and voxels (Museth, Hierarchical Digital Differential
// Analyzer, SIGGRAPH 2014), with hits on stored planes inside their coverage masks.

#import lib/world.wgsl
#import lib/surface.wgsl
#import lib/sky.wgsl

const MISS: u32 = 0u;
const HIT: u32 = 1u;

struct Hit {
    // MISS or HIT.
    kind: u32,
    // Distance in voxels.
    t: f32,
    // Address of the radiance, or NONE: black.
    light: u32,
    // Side of the hit voxel.
    side: u32,
    cell: vec3<i32>,
    // Whether other rays to the same place may go through.
    translucent: bool,
}

// Where a ray starts.
struct Start {
    // Grid space.
    point: vec3<f32>,
    // Of the surface there, or zero: none.
    normal: vec3<f32>,
    // How far, in voxels, the point may be off the surface that the planes describe.
    error: f32,
}

// From a pixel, whose surface is the host's own.
const PIXEL_ERROR: f32 = 0.02;
// From a face, whose plane is a mean, or from a probe, which stands for the pixels around it.
const FACE_ERROR: f32 = 0.25;

// Bound on the cells that a ray visits: every voxel on the longest way through the largest window (64 groups a side).
const MAX_STEPS: u32 = 6144u;
// Cells that the last ray visited.
var<private> trace_steps: u32;

// Traces along a unit `direction` up to `t_max` voxels.
fn trace(start: Start, direction: vec3<f32>, t_max: f32) -> Hit {
    trace_steps = 0u;
    let origin = start.point;
    let d = select(direction, vec3<f32>(1e-7), abs(direction) < vec3<f32>(1e-7));
    let inverse = 1.0 / d;
    let forward = vec3<i32>(d > vec3<f32>(0.0));

    let to_low = (frame.bounds_min - origin) * inverse;
    let to_high = (frame.bounds_max - origin) * inverse;
    let enter3 = min(to_low, to_high);
    let exit3 = max(to_low, to_high);
    let t_end = min(min(exit3.x, exit3.y), min(exit3.z, t_max));
    var t = max(max(enter3.x, enter3.y), max(enter3.z, 0.0));
    if t >= t_end { return Hit(MISS, t_max, NONE, 0u, vec3<i32>(0), false); }

    let inside = t == 0.0;
    let top = vec3<i32>(frame.extent * GROUP_VOXELS) - 1;
    var cell = clamp(vec3<i32>(floor(origin + d * t)), vec3<i32>(0), top);
    let start_cell = select(vec3<i32>(-1), cell, inside);
    // A ray from outside enters the bounds through the farthest of the three planes that it has to cross.
    var entry_axis = select(select(2u, 1u, enter3.y > enter3.z), 0u, enter3.x > max(enter3.y, enter3.z));
    // Per axis: the ray left the last occupied voxel in front of its plane.
    var front = vec3<bool>(false);
    // Per axis: it went through the plane there, which lets light through: not to be asked again just behind it.
    var through = vec3<bool>(false);

    var group = vec3<i32>(-1);
    var group_low = 0u;
    var group_high = 0u;
    var group_entries = 0u;
    var brick_cell = vec3<i32>(-1);
    var brick = 0u;
    var block_mask = 0u;
    var block_cell = vec3<i32>(-1);
    var block = Block();

    // Where the ray is: the smallest cell that is all empty, or the voxel, and where it leaves it.
    var low = vec3<i32>(0);
    var size = 0;
    var t_exit = t;
    var exit_axis = entry_axis;
    var voxel = Voxel();
    var best_t = 0.0;
    var best_side = NONE;
    // Rays that run together walk to their next voxels together and look at them together (Aila and Laine, Understanding
    // the Efficiency of Ray Traversal on GPUs, HPG 2009); and look for their light together, in the end.
    loop {
        loop {
            if trace_steps > 0u {
                t = max(t_exit, t);
                entry_axis = exit_axis;
                let p = vec3<i32>(floor(origin + d * t));
                var next = clamp(p, low, low + size - 1);
                next[exit_axis] = select(low[exit_axis] - 1, low[exit_axis] + size, forward[exit_axis] == 1);
                cell = next;
            }
            trace_steps++;
            voxel = Voxel();
            if trace_steps > MAX_STEPS || any(cell < vec3<i32>(0)) || any(cell > top) || t > t_end { break; }
            let g = cell >> vec3<u32>(5u);
            if any(g != group) {
                group = g;
                let address = group_address(vec3<u32>(g));
                group_low = world_grid[address];
                group_high = world_grid[address + 1u];
                group_entries = world_grid[address + 2u];
            }
            size = 32;
            if (group_low | group_high) != 0u {
                size = 8;
                let b = cell >> vec3<u32>(3u);
                let bit = child_bit(vec3<u32>(b));
                if mask_has(group_low, group_high, bit) {
                    if any(b != brick_cell) {
                        brick_cell = b;
                        brick = world_grid[group_entries + mask_rank(group_low, group_high, bit)];
                        block_mask = world_bricks[brick];
                    }
                    let c = cell >> vec3<u32>(2u);
                    if any(c != block_cell) {
                        block_cell = c;
                        block = brick_block(brick, block_mask, block_index(vec3<u32>(cell)));
                    }
                    size = 4;
                    if (block.low | block.high) != 0u {
                        size = 1;
                        voxel = block_voxel(block, vec3<u32>(cell));
                    }
                }
            }
            low = cell & vec3<i32>(-size);
            let exits = (vec3<f32>(low + forward * size) - origin) * inverse;
            t_exit = exits.z;
            exit_axis = 2u;
            if exits.x < exits.y && exits.x < exits.z {
                t_exit = exits.x;
                exit_axis = 0u;
            } else if exits.y < exits.z {
                t_exit = exits.y;
                exit_axis = 1u;
            }
            if voxel.found { break; }
            front = vec3<bool>(false);
            through = vec3<bool>(false);
        }
        if !voxel.found { break; }

        if at_run_time(frame.hit_model, u32(cell.x)) != 0u {
            if any(cell != start_cell) {
                best_side = entry_axis * 2u + select(0u, 1u, d[entry_axis] < 0.0);
                best_t = t;
                break;
            }
            continue;
        }
        let first = inside && trace_steps == 1u;
        let base = vec3<f32>(cell);
        let p_in = origin + d * t - base;
        let p_out = origin + d * t_exit - base;
        var best_order = 1e9;
        for (var axis = 0u; axis < 3u; axis++) {
            let side = axis * 2u + select(0u, 1u, d[axis] < 0.0);
            let was = front[axis];
            let passed = through[axis];
            front[axis] = false;
            through[axis] = false;
            if !has_side(voxel, side) { continue; }
            let plane = voxel_plane(voxel, side);
            let facing = dot(plane.normal, d);
            if facing >= 0.0 { continue; }
            let s0 = dot(plane.normal, p_in) - plane.offset;
            let s1 = dot(plane.normal, p_out) - plane.offset;
            front[axis] = s1 > 0.0;
            if passed && s0 < 0.0 {
                through[axis] = true;
                continue;
            }
            if s1 > 0.0 || (s0 < select(-0.05, 1e-4, first) && !was) { continue; }
            let t_cross = t - max(s0, 0.0) / facing;
            let p_cross = origin + d * t_cross - base;
            if !covers(voxel, side, p_cross) {
                through[axis] = is_translucent(voxel);
                continue;
            }
            if t < START_REACH && (is_behind_start(voxel, side, plane, origin - base, start)
                || is_beyond_edge(voxel, side, plane, p_cross, origin - base)) { continue; }
            // True crossings come before those within the tolerance.
            let order = t_cross + select(0.0, 64.0, s0 < 0.0 && !was);
            if order < best_order {
                best_order = order;
                best_t = t_cross;
                best_side = side;
            }
        }
        if best_side != NONE { break; }
    }
    if best_side == NONE || best_t >= t_max { return Hit(MISS, t_max, NONE, 0u, vec3<i32>(0), false); }
    var light = NONE;
    if at_run_time(frame.hit_model, best_side) != 0u {
        light = cube_light(voxel, best_side, d);
    } else if is_lit(voxel, best_side) {
        light = light_address(voxel, best_side);
    } else {
        light = closed_face_light(voxel, cell, best_side, voxel_plane(voxel, best_side), origin + d * best_t, d);
    }
    return Hit(HIT, best_t, light, best_side, cell, is_translucent(voxel));
}

// Planes within this distance of the start (voxels) are checked for being the start's own surface.
const START_REACH: f32 = 2.0;

// Whether a plane that faces the start (`p` in the plane's voxel) is the back of the start's own surface: what opposes
// the start's normal and is not far enough in front of it. A sheet's back is that at any angle, for a sheet that bends
// in the voxel has its start off both mean planes.
fn is_behind_start(v: Voxel, side: u32, plane: Plane, p: vec3<f32>, start: Start) -> bool {
    let along = dot(plane.normal, start.normal);
    let height = dot(plane.normal, p) - plane.offset;
    if along > -0.1 || height >= 0.25 { return false; }
    // Parallel to the start's surface: as exact as the start.
    if along < -0.9995 { return height < start.error; }
    return along < -0.9 || is_sheet(v, side, plane);
}

// Cube hits: the entered side if it is lit, else the own side that looks at the ray most.
fn cube_light(v: Voxel, side: u32, d: vec3<f32>) -> u32 {
    if is_lit(v, side) { return light_address(v, side); }
    var best = NONE;
    var best_cosine = 0.0;
    for (var k = 0u; k < 6u; k++) {
        let cosine = -dot(side_normal(k), d);
        if is_lit(v, k) && cosine > best_cosine {
            best = light_address(v, k);
            best_cosine = cosine;
        }
    }
    return best;
}

// Radiance that arrives at a traced ray's origin.
fn hit_radiance(hit: Hit, direction: vec3<f32>) -> vec3<f32> {
    if hit.kind == MISS { return sky_radiance(direction); }
    if hit.light == NONE { return vec3<f32>(0.0); }
    return rgb9e5_decode(world_bricks[hit.light]);
}
