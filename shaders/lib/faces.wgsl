// The faces chosen for lighting: `vis_faces` holds light brick 20 | voxel 9 | side 3.

#import lib/hdda.wgsl
#import lib/random.wgsl
#import shared/bricks.wgsl

@res var<storage, read> light_bricks: array<LightBrick>;
@res var<storage, read> vis_faces: array<u32>;

struct Face {
    voxel: Voxel,
    // Window cell of the voxel.
    cell: vec3<i32>,
    side: u32,
    plane: Plane,
    // Weight of the new value.
    alpha: f32,
    // Whether its rays may ask for light.
    asks: bool,
    // Stays with the face wherever the window is.
    seed: u32,
}

fn load_face(item: u32) -> Face {
    let brick = light_bricks[item >> 12u];
    let origin = ((vec3<u32>(brick.position) >> vec3<u32>(0u, 10u, 20u)) & vec3<u32>(1023u)) * BRICK_VOXELS;
    let local = (item >> 3u) & 511u;
    let cell = origin + vec3<u32>(local & 7u, (local >> 3u) & 7u, local >> 6u);
    let voxel = brick_voxel(brick.base, world_bricks[brick.base], cell);
    let side = item & 7u;
    let seed = hash3(cell + frame.seed_origin) ^ (side * 0x85ebca6bu);
    return Face(voxel, vec3<i32>(cell), side, voxel_plane(voxel, side), brick.alpha,
                (brick.position & ASKS) != 0u, pcg(seed));
}

// Whether some of another side's surface is in front of the face's plane, which p is on: a wall on a floor. A slab's top is
// behind the plane of its edge and hides nothing of it.
fn rises_above(face: Face, side: u32, p: vec3<f32>) -> bool {
    let axis = face.side >> 1u;
    let mask = voxel_mask(face.voxel, side);
    // The set lines of the mask along the face's axis.
    let columns = (mask | (mask >> 8u)) & 0xffu;
    let rows = (mask | (mask >> 1u) | (mask >> 2u) | (mask >> 3u)) & 0x1111u;
    let row_bits = (rows | (rows >> 3u) | (rows >> 6u) | (rows >> 9u)) & 15u;
    let lines = select(row_bits, (columns | (columns >> 4u)) & 15u, axis_u(side >> 1u) == axis);
    if (face.side & 1u) == 1u { return f32(firstLeadingBit(lines)) * 0.25 + 0.125 > p[axis] - 0.02; }
    return f32(firstTrailingBit(lines)) * 0.25 + 0.125 < p[axis] + 0.02;
}

// The side of the face's voxel that p (in the voxel) lies behind: in its solid, or beyond a sheet that the middle of the
// face's coverage is in front of. Of several, the one that the middle is nearest to the front of. NONE: p is in the open.
fn hiding_side(face: Face, p: vec3<f32>, middle: vec3<f32>) -> u32 {
    var hider = NONE;
    var foremost = -1e9;
    for (var side = 0u; side < 6u; side++) {
        if (side >> 1u) == (face.side >> 1u) || !has_side(face.voxel, side) { continue; }
        let plane = voxel_plane(face.voxel, side);
        if dot(plane.normal, p) > plane.offset + 0.002 || !rises_above(face, side, p) { continue; }
        // Half a coverage cell off the surface: its own cell may be the first that the other side leaves open.
        if !covers(face.voxel, side, p) && !covers(face.voxel, side, p + 0.12 * face.plane.normal) { continue; }
        let before = dot(plane.normal, middle) - plane.offset;
        if before > foremost && (before > 0.02 || !before_opposite(face.voxel, side, p)) {
            hider = side;
            foremost = before;
        }
    }
    return hider;
}

// Mirrors a point of the face's plane at another side's plane, along the face: a coverage cell is at least half visible,
// so what is hidden of it has its mirror image in the open.
fn mirrored(face: Face, side: u32, p: vec3<f32>) -> vec3<f32> {
    let plane = voxel_plane(face.voxel, side);
    let along = plane.normal - face.plane.normal * dot(plane.normal, face.plane.normal);
    let slope = dot(plane.normal, along);
    if slope < 0.05 { return p; }
    return p + along * ((0.01 - 2.0 * (dot(plane.normal, p) - plane.offset)) / slope);
}

// A point a little above the face's surface, inside its coverage and outside the solid; grid space. w = 0: none was found
// (what the face covers is hidden in the solid, or nearly so).
fn face_point(face: Face, u: vec2<f32>, seed: u32) -> vec4<f32> {
    let axis = face.side >> 1u;
    let corner = vec3<f32>(face.cell);
    if at_run_time(frame.hit_model, face.side) == 1u { return vec4<f32>(corner + cube_point(face, u), 1.0); }
    let mask = voxel_mask(face.voxel, face.side);
    let middle = on_plane(face.plane, axis, mask_middle(mask));
    let lift = face.plane.normal * 0.02;
    var place = u;
    for (var attempt = 0u; attempt < 6u; attempt++) {
        var p = on_plane(face.plane, axis, covered_place(mask, place));
        place = r2(seed, attempt);
        var hider = hiding_side(face, p + lift, middle);
        if hider != NONE {
            p = mirrored(face, hider, p);
            hider = hiding_side(face, p + lift, middle);
        }
        if hider != NONE || any(p < vec3<f32>(-0.05)) || any(p > vec3<f32>(1.05)) { continue; }
        let lifted = corner + p + lift;
        let cell = vec3<i32>(floor(lifted));
        if any(cell != face.cell) {
            let other = find_voxel(cell);
            if other.found && inside_solid(other, lifted - vec3<f32>(cell), NONE) { continue; }
        }
        return vec4<f32>(corner + clamp(p, vec3<f32>(0.0), vec3<f32>(1.0)) + face.plane.normal * 0.002, 1.0);
    }
    return vec4<f32>(0.0);
}

// Maps the unit square to the set cells of a coverage mask, evenly.
fn covered_place(mask: u32, u: vec2<f32>) -> vec2<f32> {
    if mask == 0xffffu || mask == 0u { return u; }
    let count = f32(countOneBits(mask));
    let pick = u.x * count;
    var rest = mask;
    for (var skip = u32(pick); skip > 0u; skip--) { rest &= rest - 1u; }
    let bit = firstTrailingBit(rest);
    return (vec2<f32>(f32(bit & 3u), f32(bit >> 2u)) + vec2<f32>(fract(pick), u.y)) * 0.25;
}

fn cube_point(face: Face, u: vec2<f32>) -> vec3<f32> {
    let axis = face.side >> 1u;
    var p = vec3<f32>(0.0);
    p[axis_u(axis)] = u.x;
    p[axis_v(axis)] = u.y;
    p[axis] = f32(face.side & 1u);
    return p + 0.001 * side_normal(face.side);
}

// The normal that a face is lit with.
fn face_normal(face: Face) -> vec3<f32> {
    if at_run_time(frame.hit_model, face.side) == 1u { return side_normal(face.side); }
    return face.plane.normal;
}
